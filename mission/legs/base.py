"""What a leg type is: one row of one file, and the pilot that steers while such a leg is active.

    a file: its kind (a frozen dataclass of its parameters), its pilot, and the row, TYPE

    LegType --begin(kind, set, view)--> Pilot --setpoint(view)--> Setpoint
                                              --finished(view)--> the edge END

A pilot gets a View and nothing else: no engine, no clock. It changes only when it is called, with
the view of that instant. It can be cloned, so that the engine's snapshot contains it.

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

WAY = "heading 0 gear 8 depth 4"  # in trials: a set for any leg that steers no axis itself


@dataclass(frozen=True, slots=True)
class View:
    """What a leg may know at ``now``. ``depth``: None while it is not believed; ``place`` returns a
    place's point, None if it is not known."""

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
        """The position against the leg's line; None if there is no line, or it is not known."""
        ...

    def clone(self) -> Self: ...


class Author(Protocol):
    """Draws the words of a random mission's legs, but not those that a leg type itself defines."""

    @property
    def rng(self) -> Random: ...

    def course(self) -> str: ...  # a heading, and a gear ahead

    def way(self) -> str: ...  # a depth, or nothing: it stays as before

    def lean(self) -> str: ...  # a pitch or roll, where the vehicle has them, or nothing

    def depth(self) -> int: ...  # m, one that is allowed

    def place(self) -> str: ...

    def guard(self) -> str: ...

    def timeout(self, most: int = 300) -> str: ...  # s; sometimes with an else


@dataclass(frozen=True, slots=True)
class LegType:
    """One row: everything about a leg type. A callable's argument ``kind`` is of the row's own
    ``kind``.

    In texts, ``name`` is its word, followed by ``head``, then by ``clauses`` in canonical order.
    ``contradiction`` checks the measures that were given (SI). ``until_fix``: the field that the
    words ``until fix`` set; "" if the type does not have these words. ``keeps``: it sets nothing.

    ``steers``: axes that the pilot sets itself. ``needs``: sensors beyond those of its setpoints.
    ``gives``: guard variables that only such a leg has. ``ends``: it can end by itself (END).
    ``makes_way``: without surge it goes nowhere. ``ascends``: it is R7's ascent, which the engine
    steers. ``makes_safe``: outputs that it does not name are made safe in it. ``depths``: those it
    may steer to. ``fault``: what is wrong with its parameters.

    For the check, ``places`` returns the places that it names, ``corners`` the points between which
    it stays while it is steered, m from home, from the named places in m. ``corners`` is not called
    if it names none; ``straight`` returns the places themselves; an empty result means that it may
    go anywhere, as fast as it goes. ``room``: m that it takes around where it was entered.
    ``within``: its arrival radius, m. ``ends_at_last``: it ends at the last of its corners, not at
    any. ``encloses``: its places are the corners of an area. ``pattern``: it is flown for what is
    seen along its rows, and may have aims (``achieve``); the arguments are the points that it names
    and the point where it is entered.

    On pictures, ``shown`` tells what it does beside holding its set, and ``done`` how it ended.

    ``parts``: the legs that one such leg consists of, in turn, in a group of its name (empty: it is
    one leg itself). ``parts_fault``: why a leg cannot be divided.

    ``draws``: make random legs, each as often as it is listed. ``trials``: bodies of missions that
    the campaign flies while it withholds what they wait for.
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
    """The angle in [-pi, pi]."""
    return math.remainder(angle, 2.0 * math.pi)
