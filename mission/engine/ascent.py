"""Surfacing, proved and not assumed (R7): the ascent of the surface leg and of the emergency.

    the vehicle's ways in turn, 10 s each:  W -> X0 and U12 -> X0 alone (let go) -> W ...
    upside down, behind them:               D12 for 5 s, at most once a minute

A way that makes the depth fall, from its turn's begin or, where it sank on, from the deepest since,
is kept for as long as it does, over two turns of it and three (waves swing as high in each), and
said once more when it no longer does: the board may have lost it. One under which a vehicle that
sank has just turned round has another turn. Behind a push the wrong way a vehicle sinks on before
it rises, and letting go then has two turns. Full thrust has two when it comes round again: by a
depth that comes 12 s late what one way lifts is seen in the turn of the next. Where no depth tells,
it has one more each time it comes round, up to four: what is heavy sinks in the turns of the
others. What sank when it was let go at the surface has the two, or the four, at once. An unknown
depth counts as not falling. Where the attitude is doubtful too, any push may lead down: each time
the vehicle is let go that lasts twice as long, up to 160 s, and then 10 s again, since what is
heavy needs the pushes. A depth that was known in the turn of full thrust and is not at its end does
not cut that short: it may follow late. It never gives up. Where it begins depends on what is known:
with X0 and U12 where the depth is not believed or the vehicle sinks from rest (as built, W first
goes on diving), by letting go where the vehicle is upside down. Whether the surface is reached is
seen by the vehicle's state.

What does not live here: which ways a vehicle has (protocol.vehicles), the surface (vehicle_state).
"""

from __future__ import annotations

import math
from typing import Self

from mission.model import Action
from mission.model.copies import copied
from protocol.messages import UPWARD, Order, Setpoint

TURN = 10.0  # s each way is given (R7)
LOOK = 1.0  # s between two depths of which the deepest is taken: not the noise of hundreds
FALL = 0.3  # m in that time: 0.03 m/s, twice the noise of the difference of two depths
SANK = 0.6  # m deeper than at its begin, and it has sunk on: else it has to be higher than then
ROUND = 0.1  # m less than the deepest: what had sunk a metre has turned round
DOWNWARD = Setpoint(heave=1.0)  # lifts a vehicle that is upside down
OVERTURNED_TURN = 5.0  # s that DOWNWARD is given (R7)
OVERTURNED_PAUSE = 60.0  # s from one DOWNWARD to the next (R7)
LONGER = 5  # times that letting go comes round, each twice as long: 10 s to 160 s (R7)
BLIND = 4  # turns of full thrust at most that no depth tells of (R7)
SEEN = 6.0  # s behind a lift at the surface, and what proves the surface counts again (R7)
WORD = 1.0  # s that an operator's W has for itself before the next way; once a turn
DEEPER = 1.0  # m, and DOWNWARD is given up (R7); behind another way, letting go has two turns

Way = Setpoint | Order


class Ascent:
    """``ways``: the vehicle's, in their order. ``upward``: it begins with X0 and U12; ``sank``: out
    of the surface where it was let go; ``push``: of the ways, that which holds it up there, in the
    place of X0 and U12. A depth is taken for its change alone, and None where not even that is
    believed."""

    __slots__ = (
        *(
            "_at",
            "_before",
            "_deepest",
            "_dark",
            "_downward",
            "_heard",
            "_kept",
            "_least",
            "_let_go",
            "_lifted_at",
            "_longest",
            "_looked",
            "_overturned_at",
            "_pushes",
            "_shallowest",
            "_since",
            "_start_depth",
            "_turned",
            "_ways",
        ),
        *("_turn", "began", "push", "way", "why"),
    )

    def __init__(
        self,
        now: float,
        depth: float | None,
        why: str,
        ways: tuple[Way, ...],
        *,
        overturned: bool = False,
        upward: bool = False,
        sank: bool = False,
        push: Way | None = None,
    ) -> None:
        self.began, self.why, self._ways = now, why, ways
        self._turn = self._longest = TURN
        self._downward: tuple[Way, ...] = ()  # that led deeper, upside down
        self._dark, self._let_go = False, 0  # neither depth nor attitude; times let go so
        self._kept = False  # the way in use has made the depth fall
        self._heard = False  # an operator has said W in its turn
        self._turned = False  # it goes on since it had turned round, and has to rise by now
        self._before: float | None = None  # the deepest of the turn before, that was of this way
        self._least: tuple[float | None, ...] = ()  # the shallowest of each of its last turns
        self._begin_turn(now, depth)
        first = ways[0]
        if overturned:
            first = Order.STOP
        elif (depth is None or upward) and UPWARD in ways:
            first = push or UPWARD
        self._at = ways.index(first) if first in ways else 0
        self.way: Way = ways[self._at]
        # that has two turns later
        self.push = push or (UPWARD if UPWARD in ways else Order.SURFACE)
        self._pushes = int(self.way == self.push)
        if sank and self._pushes:
            self._begin_long(now, depth)
        self._overturned_at, self._lifted_at = now - OVERTURNED_PAUSE, -math.inf

    @property
    def pushes_up(self) -> bool:
        """A thruster holds it up; let go, it would not be held."""
        return self.way is Order.SURFACE or self.way == UPWARD

    def lifts(self, now: float, depth: float | None, unsure: bool) -> tuple[Action, ...]:
        """For what sinks when it is let go and is at the surface: full thrust, where it was let go
        and did not rise by that. ``unsure``: it may be upside down, and no push is begun then."""
        sinks = self.way is Order.STOP and not self._kept and not unsure
        if not (sinks and self.push in self._ways):
            return ()
        self._at = self._ways.index(self.push)
        self.way, self._lifted_at = self.push, now
        self._begin_long(now, depth)
        return (Action(self.way, f"{self.why}: let go it would sink again"),)

    def is_up(self, now: float) -> bool:
        """Whether what proves the surface was seen behind that thrust, not before it."""
        return now >= self._lifted_at + SEEN

    def first(self) -> tuple[Action, ...]:
        return (Action(self.way, self.why),)

    def hear(self, now: float) -> bool:
        """An operator has said W, which is not the way in use. True once a turn: it leaves, and the
        next way, due at once, would take its place on the line."""
        first, self._heard = not self._heard, True
        if first:
            self._turn = min(max(self._turn, now + WORD - self._since), self._longest)
        return first

    def doubt(self) -> None:
        """The line was away: nobody may have heard what operators have said in this turn."""
        self._heard = False

    def act(
        self, now: float, depth: float | None, overturned: bool, doubtful: bool = False
    ) -> tuple[Action, ...]:
        """What is due; nothing while the way in use is being tried, or works. ``doubtful``: it
        cannot be told whether it is upside down."""
        self._see(dark=depth is None and doubtful)
        fallen = self._fallen(now, depth)
        given_up = depth is None or self._start_depth is None or self._has_led_deeper(depth)
        if self.way == DOWNWARD and (given_up or not overturned):
            self._kept = False  # given up at once
        elif now < self.next_timer():
            return ()
        elif self._works(fallen):
            self._go_on(now, depth)
            return ()
        elif depth is None and self._pushes_on(overturned):
            self._lengthen()
            return ()
        seen = "is not known" if fallen is None else f"is {depth:.1f} m, no less"
        why = f"{self.why}: after {now - self._since:.3g} s the depth {seen}"
        if self._kept and not overturned:
            why = f"{why}: said again, since it was"
            self._go_on(now, depth)
        elif overturned and depth is not None and self._may_push_down(now):
            why = f"{why}, and the vehicle is upside down"
            self.way, self._overturned_at = DOWNWARD, now
            self._begin_turn(now, depth, OVERTURNED_TURN)
        else:
            self._change(now, depth, overturned)
        self._kept = False
        return (Action(self.way, why),)

    def _works(self, fallen: float | None) -> bool:
        """It rises; or it had sunk and has turned round."""
        start, deepest = self._start_depth, self._deepest
        if fallen is None or start is None or deepest is None:
            return False
        sank = deepest - start
        rises = fallen >= FALL + (0.0 if sank > SANK else sank)
        if self._before is not None and self._before - (deepest - fallen) < 2.0 * FALL:
            rises = False  # noise alone makes one turn's rise now and then, but not two turns'
        rises = rises and self._gains()
        self._kept = self._kept or rises
        self._turned = not rises and not self._turned and sank > DEEPER and fallen >= ROUND
        return rises or self._turned

    def _gains(self) -> bool:
        """The turn is shallower than the one before, and by twice as much than the one before that:
        waves swing about as high in each."""
        least = self._shallowest
        return all(
            then is None or least is None or then - least >= FALL * turns
            for turns, then in enumerate(reversed(self._least), 1)
        )

    def _pushes_on(self, overturned: bool) -> bool:
        """Nothing tells whether full thrust lifts it, and it has not had its turns."""
        sure = not overturned and not (self._dark and self._start_depth is None)
        return sure and self.way == self.push and self._turn < self._pushes * TURN

    def _lengthen(self) -> None:
        self._turn += TURN
        self._longest = self._turn + WORD

    def _change(self, now: float, depth: float | None, overturned: bool) -> None:
        """Begins the turn of the next way."""
        self._turned = False
        driven, turn = self._has_led_deeper(depth), TURN
        self._at = self._next(depth, overturned)
        self.way = self._ways[self._at]
        if self.way is Order.STOP and self._dark:
            turn, self._let_go = math.ldexp(TURN, self._let_go % LONGER), self._let_go + 1
        elif self.way is Order.STOP and driven:
            turn = 2.0 * TURN
        elif self.way == self.push:
            turn = 2.0 * TURN if self._pushes and depth is not None and not overturned else TURN
            self._pushes = min(self._pushes + 1, BLIND)
        self._begin_turn(now, depth, turn)

    def _see(self, *, dark: bool) -> None:
        """Where more is known than before, a turn is as long as ever."""
        if self._dark and not dark:
            self._turn = min(self._turn, TURN)
        self._dark = dark

    def _next(self, depth: float | None, overturned: bool) -> int:
        """The way behind the one that was tried. Upside down none that has led deeper there, and
        where no depth is known letting go alone: every push may be one."""
        ways, at = self._ways, self._at
        led = overturned and self._has_led_deeper(depth)
        self._downward = (*self._downward, *[self.way] * led) if overturned else ()
        turns = [(at + i) % len(ways) for i in range(1, len(ways) + 1)]
        if overturned and Order.STOP in ways:
            turns = [i for i in turns if ways[i] is Order.STOP or self._may_lift(ways[i], depth)]
        return turns[0]

    def _may_lift(self, way: Way, depth: float | None) -> bool:
        return depth is not None and way not in self._downward

    def _go_on(self, now: float, depth: float | None) -> None:
        """Another turn of the way in use."""
        before, least = self._deepest, (*self._least[-1:], self._shallowest)
        self._begin_turn(now, depth)
        self._before, self._least = before, least

    def _begin_turn(self, now: float, depth: float | None, turn: float | None = None) -> None:
        self._before, self._least, self._heard = None, (), False
        self._since = self._looked = now
        self._turn = TURN if turn is None else turn
        self._longest = self._turn + WORD
        self._start_depth = self._deepest = self._shallowest = depth

    def _begin_long(self, now: float, depth: float | None) -> None:
        """Of full thrust for what sank when it was let go."""
        self._pushes = BLIND
        self._begin_turn(now, depth, TURN if depth is None else 2.0 * TURN)

    def _fallen(self, now: float, depth: float | None) -> float | None:
        """m from the deepest of the turn's depths, ``LOOK`` apart, from the first known one on."""
        if self._start_depth is None:
            self._start_depth = self._deepest = self._shallowest = depth
            return None
        if depth is None or self._deepest is None or self._shallowest is None:
            return None
        if now >= self._looked + LOOK:
            self._looked, self._deepest = now, max(self._deepest, depth)
            self._shallowest = min(self._shallowest, depth)
        return self._deepest - depth

    def _has_led_deeper(self, depth: float | None) -> bool:
        """The turn so far, by a metre from its shallowest: what was rising may go on at first."""
        least = self._shallowest
        return depth is not None and least is not None and depth - least > DEEPER

    def _may_push_down(self, now: float) -> bool:
        """Behind the last of the ways."""
        last = self._at == len(self._ways) - 1 and self.way != DOWNWARD
        return last and now >= self._overturned_at + OVERTURNED_PAUSE

    def next_timer(self) -> float:
        return self._since + self._turn

    def clone(self) -> Self:
        return copied(self)
