"""The data of one run of the program that a story collects: legs, margins, rows, sentences.

What does not live here: how they are collected (story).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from mission.analysis.repeats import Again, Commands, Refusals, Rows, Words
from mission.model.shown import clock, duration

SAME_AGAIN_S = 60.0  # an alarm or a refusal that repeats within this time is one row
UNITS = {"depth": "m", "radius": "m", "time": "s", "voltage": "V"}  # of the limits


@dataclass(slots=True)
class Leg:
    path: str
    entered: float
    left: float | None = None
    because: str = "it was flown when the recording ended"

    def row(self, end: float) -> tuple[str, ...]:
        """Return a row of the table of legs. ``end``: of the recording."""
        lasted = round((end if self.left is None else self.left) - self.entered, 1)
        leg = self.path.partition("/")[2]
        return leg, clock(self.entered), duration(lasted), self.because


@dataclass(slots=True)
class Least:
    """The smallest margin to a limit (m, s or V), and when it occurred."""

    left: float
    t: float
    bound: float

    def row(self, name: str) -> tuple[str, ...]:
        """Return a row of the table of limits."""
        unit = UNITS[name]
        return name, f"{self.bound:g} {unit}", f"{self.left:z.1f} {unit}", clock(self.t)


@dataclass(slots=True)
class Told:
    """The data of one run of the program, as they are collected."""

    legs: list[Leg] = field(default_factory=list)
    commands: Commands = field(default_factory=Commands)
    again: Again = field(default_factory=Again)
    refusals: Refusals = field(default_factory=lambda: Refusals(SAME_AGAIN_S))
    alarms: Rows = field(default_factory=lambda: Rows(SAME_AGAIN_S))
    words: Words = field(default_factory=Words)
    least: dict[str, Least] = field(default_factory=dict)
    says: list[str] = field(default_factory=list)
    commanders: dict[str, None] = field(default_factory=dict)
