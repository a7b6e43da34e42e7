"""The transitions that every mission shares (design, the states; protocols R6-R8), as a table.

``always`` rows stand on every picture; the others only where the safety transitions are asked
for. ``machine.py`` builds what runs from the same states; a test compares the two.
"""

from __future__ import annotations

from dataclasses import dataclass

from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
)

REGIONS = ("idle", AUTONOMOUS, "manual", "emergency")
SUBSTATES = (
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACING,
    SURFACED,
)


@dataclass(frozen=True, slots=True)
class Shared:
    """``event`` is a word that any format can carry; ``history`` returns to the last leg."""

    source: str
    event: str
    target: str
    text: str
    always: bool = False
    history: bool = False


SHARED = (
    Shared(IDLE_EMPTY, "stored", IDLE_READY, "mission stored (@AW)", always=True),
    Shared(IDLE_READY, "clear", IDLE_EMPTY, "@AC", always=True),
    Shared(IDLE_READY, "start", AUTONOMOUS, "@AA", always=True),
    Shared("idle", "manual", MANUAL_DRIVING, "M command", always=True),
    Shared("idle", "stop", STOPPED, "X"),
    Shared("idle", "surface", SURFACING, "W"),
    Shared("idle", "limit", SURFACING, "hard depth, unexplained descent"),
    Shared(AUTONOMOUS, "end", IDLE_READY, "end of the mission, at the surface", always=True),
    Shared(AUTONOMOUS, "auto_off", IDLE_READY, "AUTO closed (@NS)"),
    Shared(AUTONOMOUS, "manual", MANUAL_DRIVING, "M command", always=True),
    Shared(AUTONOMOUS, "stop", STOPPED, "X", always=True),
    Shared(AUTONOMOUS, "surface", SURFACING, "W", always=True),
    Shared(AUTONOMOUS, "limit", SURFACING, "a limit", always=True),
    Shared(AUTONOMOUS, "silent", SURFACING, "no @SD for 5 s, 3 commands unanswered"),
    Shared(AUTONOMOUS, "blind", SURFACING, "depth invalid while submerged"),
    Shared(MANUAL_DRIVING, "released", MANUAL_WAITING, "2 s without M", always=True),
    Shared(MANUAL_WAITING, "manual", MANUAL_DRIVING, "M command", always=True),
    Shared("manual", "start", AUTONOMOUS, "@AA, into the interrupted leg", True, history=True),
    Shared(MANUAL_WAITING, "idle", IDLE_READY, "60 s without M, at the surface"),
    Shared(MANUAL_WAITING, "lost", SURFACING, "60 s without M, deeper or unknown"),
    Shared("manual", "stop", STOPPED, "X"),
    Shared("manual", "surface", SURFACING, "W"),
    Shared(STOPPED, "surface", SURFACING, "W", always=True),
    Shared(STOPPED, "clear", IDLE_EMPTY, "@AC"),
    Shared(SURFACING, "stop", STOPPED, "X", always=True),
    Shared(SURFACING, "surfaced", SURFACED, "depth below 0.5 m for 6 s, or a fix", always=True),
    Shared(SURFACED, "clear", IDLE_EMPTY, "@AC", always=True),
    Shared(SURFACED, "stop", STOPPED, "X"),
    Shared(SURFACED, "surface", SURFACING, "W"),
    Shared("emergency", "manual", MANUAL_DRIVING, "M command, after 2 s without one", always=True),
)


def region(path: str) -> str:
    return path.split("/")[0]


def shared(safety: bool) -> tuple[Shared, ...]:
    return SHARED if safety else tuple(row for row in SHARED if row.always)
