"""What a leg type is: one row of one file, and the pilot that steers while such a leg is active.

    a file: its kind (a frozen dataclass of its parameters), its pilot, and the row, TYPE

    LegType --begin(kind, set, view)--> Pilot --setpoint(view)--> Setpoint
                                              --finished(view)--> the edge END

A pilot sees a View and nothing else: no engine, no clock. It changes only by being asked, with the
view of that instant, and can be cloned, so that the engine's snapshot holds it.

What does not live here: when a new setpoint is worth a frame (engine), R7's ascent (ascent).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random
from typing import Any, Protocol, Self

from mission.legs.pattern import Pattern
from mission.legs.pattern import Point as Point
from mission.legs.words import NO_HEAD, Head, LegClause, Misfit
from mission.model import Axis, Estimate, Leg, LegKind, Place
from protocol.messages import Setpoint

WAY = "heading 0 gear 8 depth 4"  # in trials: a set that any leg may hold which steers nothing


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


class Author(Protocol):
    """Who draws a random mission: words that its legs are made of, none of them the leg's own."""

    @property
    def rng(self) -> Random: ...

    def course(self) -> str: ...  # a heading, and a gear ahead

    def way(self) -> str: ...  # a depth, or nothing: as before

    def lean(self) -> str: ...  # a pitch or roll, where the vehicle has them, or nothing

    def depth(self) -> int: ...  # m, one that is allowed

    def place(self) -> str: ...

    def guard(self) -> str: ...

    def timeout(self, most: int = 300) -> str: ...  # s; it may say else, too


@dataclass(frozen=True, slots=True)
class LegType:
    """One row: all that there is to know of a leg type. ``kind`` in a callable's arguments is one
    of the row's own.

    In texts, ``name`` is its word, with a ``head`` behind it and ``clauses`` in canonical order.
    ``contradiction`` looks at the measures that were given (SI). ``until_fix`` is the field that
    the words ``until fix`` set; "" where they are none of its words. ``keeps``: it sets nothing.

    ``steers``: axes the pilot sets itself. ``needs``: sensors beyond those of its setpoints.
    ``gives``: guard variables that only such a leg has. ``ends``: it can be done by itself (END).
    ``makes_way``: without surge it goes nowhere. ``ascends``: it is R7's ascent, which the engine
    steers. ``makes_safe``: outputs that it does not name are safe in it. ``depths`` lists those it
    may steer to, ``fault`` says what is wrong with its figures.

    For the check, ``places`` are those that it names; ``corners`` those between which it stays
    while it is steered, m from home, of the named ones in m (none are named: none are asked for;
    ``straight``: those themselves; none: it may go anywhere, as fast as it goes);
    ``room`` the m that it takes about where it was entered; ``within`` its arrival radius, m.
    ``ends_at_last``: it is done at the last of its corners, not at any. ``encloses``: the places
    that it names are the corners of an area. ``pattern``: it is flown for what is seen along its
    rows, and may say what it is to ``achieve``; of the points that it names, and where it is
    entered.

    On pictures, ``shown`` is what it does beside holding its set and ``done`` how it ended.

    ``parts`` are the legs that one of it consists of, in turn (none: it is one itself); they stand
    in a group of its name. ``parts_fault`` says what keeps a leg from being parted.

    ``draws`` make random ones, each as often as it stands there; ``trials`` are bodies of missions
    for the campaign to fly with what they wait for withheld.
    """

    name: str
    kind: type[LegKind]
    description: str
    head: Head = NO_HEAD
    clauses: tuple[LegClause, ...] = ()
    contradiction: Callable[[Mapping[str, float]], Misfit | None] = lambda given: None
    until_fix: str = ""
    keeps: bool = False
    begin: Callable[[Any, Setpoint, View], Pilot] | None = None
    steers: frozenset[Axis] = frozenset()
    needs: frozenset[str] = frozenset()
    gives: frozenset[str] = frozenset()
    ends: bool = False
    makes_way: bool = False
    ascends: bool = False
    makes_safe: Callable[[Any], bool] = lambda kind: False
    fault: Callable[[Any], str] = lambda kind: ""
    depths: Callable[[Any], tuple[float, ...]] = lambda kind: ()
    places: Callable[[Any], tuple[Place, ...]] = lambda kind: ()
    corners: Callable[[Any, tuple[Point, ...]], tuple[Point, ...]] = lambda kind, named: ()
    room: Callable[[Any], float] = lambda kind: 0.0
    within: Callable[[Any], float] = lambda kind: 0.0
    ends_at_last: bool = False
    pattern: Callable[[Any, tuple[Point, ...], Point], Pattern] | None = None
    encloses: bool = False
    shown: Callable[[Any], str] = lambda kind: ""
    done: Callable[[Any], str] = lambda kind: "done"
    parts: Callable[[Leg], tuple[Leg, ...]] = lambda leg: ()
    parts_fault: Callable[[Leg], str] = lambda leg: ""
    draws: tuple[Callable[[Author], str], ...] = ()
    trials: tuple[str, ...] = ()

    @property
    def plain(self) -> bool:
        """Whether the leg holds its set and nothing else, until it is left."""
        return self.begin is None and not self.ascends

    @property
    def surveys(self) -> bool:
        return self.pattern is not None

    def awaits_fix(self, kind: LegKind) -> bool:
        """Whether only a position fix ends it."""
        return bool(self.until_fix) and bool(getattr(kind, self.until_fix))


def straight(kind: LegKind, named: tuple[Point, ...]) -> tuple[Point, ...]:
    """The corners of a leg that goes from place to place."""
    return named


def wrap(angle: float) -> float:
    """Into [-pi, pi]."""
    return math.remainder(angle, 2.0 * math.pi)
