"""Validate an uploaded mission: its lines become a Chart, or are refused in one line of text (R3).

A verdict depends on the lines and the vehicle alone, so it can be found in advance:
``MissionValidator`` keeps the last one. A thread of ``serve`` finds it before the runtime receives
the line that completes the mission (validation_queue), so that the runtime does not block for
seconds; a replay validates again.

What does not live here: where the lines come from (staging, store), the rules (language, compiler,
check).
"""

from __future__ import annotations

from mission.model import Chart
from mission.model.diagnostics import Diagnostic, MissionErrors
from mission.model.vehicle import Vehicle
from mission.onboard.runtime.command_target import MissionRefused


class MissionValidator:
    """Validates missions of one vehicle. ``closed``: why none is accepted, "" if they may be."""

    def __init__(self, vehicle: Vehicle, closed: str = "") -> None:
        self._vehicle, self._closed = vehicle, closed
        self._last: tuple[tuple[str, ...], Chart | str] = ((), "there are no lines")

    def __call__(self, lines: tuple[str, ...]) -> Chart:
        """Return the chart. Raises MissionRefused with the first fault."""
        if self._closed:
            raise MissionRefused(self._closed)
        known, verdict = self._last
        if known != lines:
            verdict = _verdict(lines, self._vehicle)
            self._last = lines, verdict
        if isinstance(verdict, str):
            raise MissionRefused(verdict)
        return verdict


def _verdict(lines: tuple[str, ...], vehicle: Vehicle) -> Chart | str:
    """An error of the check itself refuses, too: no mission may crash the program."""
    try:
        return judge(lines, vehicle)
    except MissionRefused as refusal:
        return str(refusal)
    except Exception as error:
        return f"the check failed, a fault of the program: {type(error).__name__}: {error}"


def judge(lines: tuple[str, ...], vehicle: Vehicle) -> Chart:
    """Compile and check a mission. Raises MissionRefused with the first fault."""
    try:
        from mission.authoring.check import check_mission
        from mission.authoring.language import draft_script
        from mission.authoring.prepare import charted
    except ImportError as error:
        raise MissionRefused(f"missions cannot be judged: {error}") from error

    try:
        made = charted(draft_script(lines, vehicle), vehicle)
    except MissionErrors as error:
        raise MissionRefused(_said(error.diagnostics[0])) from None
    if made.chart is None:
        raise MissionRefused(_said(made.found[0]))
    report = check_mission(made.chart, vehicle)
    if not report.ok:
        raise MissionRefused(_said(report.refusals[0]))
    return made.chart


def _said(found: Diagnostic) -> str:
    return f"line {found.where.line}:{found.where.column}: {found.message}"
