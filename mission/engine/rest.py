"""Detects a vehicle that sinks although everything is stopped, in any state (R7).

    idle, waiting   over 2 m, and 0.5 m deeper than it has been since it came to rest, in reports
                    over at least a second; the same in a leg that waits at the surface
    surfaced        the same over 1 m: after an ascent, a vehicle that sinks is known sooner
    stopped         over 2 m, and 20 s since X or since it last rose by another 0.5 m: X is also
                    sent to keep a diver safe, so buoyancy alone acts first
    idle, waiting   as in stopped, if it was under way before and no depth was believed when it
                    came to rest: it may have sunk unseen, and lie on the bottom

    anywhere        2 m deeper than it has been, by a depth whose zero alone is contradicted and
                    which moves as the vehicle does

An unknown depth tells nothing: the vehicle may be on deck. A depth that jumps farther than a
vehicle can sink starts the detection again.

What does not live here: what follows (engine).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from mission.model.copies import copied
from mission.navigation.fixes import RECENT, SETTLED, Receiver
from protocol.messages import Order, Setpoint

if TYPE_CHECKING:
    from mission.engine.vehicle_state import VehicleState

DEEP = 2.0  # m
DEEP_AGAIN = 1.0  # m, in surfaced
ENDED, UNSEEN = 8.0, 60.0  # s without a fix; s from being let go, in which that counts (R7)
SUNK = 0.5  # m deeper than it has been: five sigmas of a depth
RISEN = 0.5  # m: it rises as long as it comes up by so much again and again, each time within ...
RISE_TIME = 20.0  # ... s
_LASTS = 1.0  # s, and two reports
_SMOOTH = 6.0  # s: filter time of the depth whose least is remembered
_LONGEST = 10.0  # s: a longer time without a depth does not count; the filter starts again
_FASTER = 1.5  # times the greatest descent rate, and ...
_JUMP = 0.5  # ... m: more than that from one report to the next is no descent


@dataclass(frozen=True, slots=True)
class Hold:
    """The thrust that holds up, at the surface, a vehicle that sinks when it is let go."""

    way: Setpoint | Order
    since: float  # s
    said_at: float  # s; the last time


class Rest:
    """Watches the depths in states in which everything is stopped."""

    __slots__ = (
        "_depth",
        "_doubted",
        "_fastest",
        "_from",
        "_highest",
        "_odd",
        "_shallowest",
        "_since",
        "_smooth",
        "_sunk_at",
        "_t",
        "unseen",
    )

    def __init__(self, fastest: float) -> None:
        """``fastest``: m/s, the vehicle's greatest descent rate."""
        self._fastest = fastest
        self.begin()

    def clone(self) -> Self:
        return copied(self)

    def begin(self, shallowest: float = math.nan, *, unseen: bool = False) -> None:
        """Start again in another state: depths seen before do not count. ``shallowest``: m, if an
        ascent has proved the surface, by depth or fixes. ``unseen``: it was under way, and no depth
        is believed; this holds until a depth shows that it is not deep."""
        self.unseen = unseen
        self._t = self._since = -math.inf
        self._depth = self._smooth = self._from = math.nan
        self._shallowest = shallowest
        self._sunk_at: float | None = None
        self._doubted: tuple[float, float] | None = None  # s, m: a depth whose zero is unknown
        self._highest = math.inf  # m, the least such depth
        self._odd: tuple[float, float] | None = None  # s, m: a jump to there, seen once

    def take(self, t: float, depth: float | None, deep: float = DEEP) -> None:
        """Take a report. ``depth``: None if not believed; ``deep``: m, sinking counts beyond it."""
        if depth is None:
            return  # the depth before still counts
        since, change = t - self._t, abs(depth - self._depth)
        there = self._odd is not None and abs(depth - self._odd[1]) < change  # still at the jump
        sinks = self._follows(since, change) and not there  # False for the first depth
        if not (sinks or math.isnan(self._depth) or self._jumped(t, depth)):
            return  # a single one may be an outlier
        self._odd = None
        if not sinks:
            before = self._shallowest if math.isnan(self._depth) else math.nan
            self.begin(depth if math.isnan(before) else min(before, depth), unseen=self.unseen)
        if not sinks:
            self._smooth = self._from = depth
            self._since = t
        elif since > _LONGEST:
            self._smooth = depth
            self._since += since  # it may have risen meanwhile
        else:
            self._smooth += (depth - self._smooth) * min(since / _SMOOTH, 1.0)
        self._shallowest = min(self._shallowest, self._smooth)
        self._t, self._depth = t, depth
        self.unseen = self.unseen and depth > deep
        if not (depth > deep and depth > self._shallowest + SUNK):
            self._sunk_at = None
        elif self._sunk_at is None:
            self._sunk_at = t

    def _follows(self, since: float, change: float) -> bool:
        return change <= _FASTER * self._fastest * max(since, 1.0) + _JUMP

    def _jumped(self, t: float, depth: float) -> bool:
        """Whether the depth has stayed at a jump's end for a second, in two reports."""
        odd = self._odd
        if odd is None or not self._follows(t - odd[0], abs(depth - odd[1])):
            self._odd = t, depth
            return False
        return t - odd[0] >= _LASTS

    def follow(self, t: float, depth: float | None) -> None:
        """Take a report of a depth that is not believed but moves as the vehicle does. None (there
        is none) starts this again."""
        before = self._doubted
        if depth is None or before is None or t - before[0] > _LONGEST:
            self._doubted, self._highest = None if depth is None else (t, depth), math.inf
        else:
            smooth = before[1] + (depth - before[1]) * min((t - before[0]) / _SMOOTH, 1.0)
            self._doubted = t, smooth
        if self._doubted is not None:
            self._highest = min(self._highest, self._doubted[1])

    @property
    def is_dark(self) -> bool:
        """Whether no depth was believed since it came to rest."""
        return math.isnan(self._depth)

    @property
    def was_up(self) -> bool:
        """Whether the depth last believed since it came to rest was not deep."""
        return self._depth <= DEEP

    @property
    def goes_down(self) -> str:
        """Why it is taken to sink by a depth that is not believed, in words; "" if it is not."""
        sunk = 0.0 if self._doubted is None else self._doubted[1] - self._highest
        if sunk < DEEP:
            return ""
        return f"it sinks though everything is stopped, by {sunk:.1f} m of a depth that is off"

    @property
    def sinks(self) -> str:
        """Why it is taken to sink, in words; "" if it is not."""
        if self._sunk_at is None or self._t - self._sunk_at < _LASTS:
            return ""
        return f"it sinks though everything is stopped, {self._depth:.1f} m deep"

    def stays_down(self) -> str:
        """Why it is taken to stay deep, in words; "" if it is not. Call this with every report, or
        it notices too late that a rise is over."""
        if self._depth <= self._from - RISEN:
            self._from, self._since = self._depth, self._t
        if self._t - self._since < RISE_TIME or not self._depth > DEEP:
            return ""
        return f"it does not rise though everything is stopped, {self._depth:.1f} m deep"


def fixes_end(receiver: Receiver, since: float, quiet: float = ENDED) -> tuple[float, str]:
    """When the fixes from ``since`` (s) on have ended or will end, and which ones, in words: no fix
    for ``quiet`` s, or no new place for RECENT s. inf if none came."""
    ends = [
        (at + ended, f"no {missing} for {ended:g} s")
        for missing, at, ended in (
            ("fix", receiver.last_at, quiet),
            ("new place", receiver.news_at, RECENT),
        )
        if at >= since - SETTLED
    ]
    return min(ends, default=(math.inf, ""))


def may_have_sunk(state: VehicleState, since: float) -> bool:
    """Whether the surface is shown only by a depth that may have frozen there: it repeats, and the
    fixes that came from ``since`` (s) on have ended."""
    return state.repeats and fixes_end(state.receiver, since, RECENT)[0] <= state.now
