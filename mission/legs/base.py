"""What a leg type is: one row, and the pilot that steers while such a leg is active.

    LegType --begin(kind, set, view)--> Pilot --setpoint(view)--> Setpoint
                                              --finished(view)--> the edge END

A pilot sees a View and nothing else: no engine, no clock. It changes only by being asked, with the
view of that instant, and can be cloned, so that the engine's snapshot holds it.

What does not live here: when a new setpoint is worth a frame (engine), R7's ascent (ascent).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, Self

from mission.model import Axis, Estimate, LegKind, Place
from protocol.messages import Setpoint

Point = tuple[float, float]  # m north and east of home


@dataclass(frozen=True, slots=True)
class View:
    """What a leg may know at ``now``. ``depth`` is None while it is not to be believed;
    ``place`` gives a place's point, None where it cannot be known."""

    now: float
    estimate: Estimate | None
    depth: float | None
    place: Callable[[Place], Point | None]


@dataclass(frozen=True, slots=True)
class Track:
    """Metres to the point the leg goes to, and off its line (positive to starboard).

    ``bearing`` is the line's direction, ``ahead`` the direction to the point, in rad.
    """

    distance: float
    cross_track: float
    bearing: float
    ahead: float


class Pilot(Protocol):
    def setpoint(self, view: View) -> Setpoint: ...

    def finished(self, view: View) -> bool: ...

    def track(self, view: View) -> Track | None:
        """Where it stands against the leg's line; None where there is none, or not known."""
        ...

    def clone(self) -> Self: ...


@dataclass(frozen=True, slots=True)
class LegType:
    """``steers``: axes the pilot sets itself. ``needs``: sensors beyond those of its setpoints.

    ``gives``: guard variables that only such a leg has. ``ends``: it can be done by itself (END).
    ``makes_way``: without surge it goes nowhere. ``ascends``: it is R7's ascent, which the engine
    steers. ``depths`` lists those it may steer to.
    """

    name: str
    kind: type[LegKind]
    begin: Callable[[Any, Setpoint, View], Pilot] | None = None
    steers: frozenset[Axis] = frozenset()
    needs: frozenset[str] = frozenset()
    gives: frozenset[str] = frozenset()
    ends: bool = False
    makes_way: bool = False
    ascends: bool = False
    fault: Callable[[Any], str] = lambda kind: ""  # what is wrong with its figures, or ""
    depths: Callable[[Any], tuple[float, ...]] = lambda kind: ()


def wrap(angle: float) -> float:
    """Into [-pi, pi]."""
    return math.remainder(angle, 2.0 * math.pi)
