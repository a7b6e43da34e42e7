"""Data in a vehicle's frames beside the motion: outputs that can be set, readings that come in.

    Channel   led_pct       set by legs and by @AO, under a name and bounds of the vehicle file
    Source    metal_pct     read by guards, under a name of the vehicle file

A row of VEHICLES has its channels and sources. What does not live here: names, bounds and safe
states of one vehicle (mission.model.vehicle), who may set an output and when
(mission.engine.outputs).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from protocol.messages import Telemetry

Levels = Mapping[str, float]  # by channel


@dataclass(frozen=True, slots=True)
class Channel:
    """A number in a frame, ``low``..``high`` in ``unit`` ("": a switch or a code).

    ``rest``: its level while nothing sets it. ``whole``: whole numbers only. ``choices``: if there
    are any, these levels only. ``needed``: what the vehicle needs it for; no mission may set it.
    ``excludes``: axes of a setpoint that it would work against; while one of them is in use the
    channel is at rest. ``final``: its effect cannot be undone.
    """

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    rest: float = 0.0
    whole: bool = True
    needed: str = ""
    excludes: tuple[str, ...] = ()
    choices: tuple[float, ...] = ()
    final: bool = False

    def fault(self, value: float) -> str:
        """Return why the frame cannot carry ``value``, "" if it can."""
        if not self.low <= value <= self.high:
            return f"{value:.9g} is outside {self.low:.9g} to {self.high:.9g}"
        if self.whole and value != int(value):
            return f"{value:.9g} is not a whole number"
        if self.choices and value not in self.choices:
            return f"{value:.9g} is none of {', '.join(f'{c:g}' for c in self.choices)}"
        return ""


def _of_board(name: str) -> Callable[[Telemetry], float | None]:
    def read(report: Telemetry) -> float | None:
        return next((value for channel, value in report.board if channel == name), None)

    return read


@dataclass(frozen=True, slots=True)
class Source:
    """A number of a report, in ``unit``; ``read`` returns it, None if it is not reported."""

    name: str
    unit: str
    meaning: str
    read: Callable[[Telemetry], float | None]


def of_board(name: str, unit: str, meaning: str) -> Source:
    """Return the source of a value that ``Telemetry.board`` has under the same name."""
    return Source(name, unit, meaning, _of_board(name))


def at_rest(channels: tuple[Channel, ...]) -> Levels:
    return {channel.name: channel.rest for channel in channels}


def told(
    values: Mapping[str, object], flags: tuple[str, ...], sources: tuple[Source, ...]
) -> tuple[tuple[str, float], ...]:
    """Return the values that a frame has for ``sources``, without those that are missing or
    doubtful (a flag ``name:reason``)."""
    doubtful = {flag.partition(":")[0] for flag in flags}
    names = (source.name for source in sources if source.name not in doubtful)
    read = ((name, values.get(name)) for name in names)
    return tuple((name, float(v)) for name, v in read if isinstance(v, int | float))
