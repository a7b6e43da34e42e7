"""Surfacing, proved and not assumed (R7): the ascent of the surface leg and of the emergency.

    the vehicle's ways in turn, 10 s each:  W -> X0 and U12 -> X0 alone (let go) -> W ...
    upside down, after the last of them:    D12 for 5 s, at most once a minute

It begins with the first way; with X0 and U12 if the depth is not believed or the vehicle sinks from
rest (as built, W first goes on diving); by letting go if the vehicle is upside down. It never gives
up. An unknown depth counts as not falling. VehicleState sees whether the surface is reached.

A way is kept as long as the depth falls under it, from the turn's start, or from the deepest since
if the vehicle sank on. The fall must show over two and three turns too: waves are about as high in
each. When the depth no longer falls the way is sent once more: the board may have lost it. Under a
way in which a vehicle that sank has just turned round, one more turn follows.

Longer turns:
- Letting go has two turns after a push that led down: the vehicle sinks on before it rises.
- Full thrust has two turns from its second time on: by a depth that comes 12 s late, a rise shows
  in the turn of the next way. While the depth is unknown, full thrust has one turn more each time,
  up to four: a heavy vehicle sinks in the turns of the others. A depth that was known in its turn
  and is unknown at its end does not cut this short: it may follow late.
- A vehicle that sank when it was let go at the surface has these two, or four, turns at once.
- If depth and attitude are both unknown, any push may lead down: each letting go lasts twice as
  long as the last, up to 160 s, then 10 s again, since a heavy vehicle needs the pushes.

What does not live here: which ways a vehicle has (protocol.vehicles), the surface (vehicle_state).
"""

from __future__ import annotations

import math
from typing import Self

from mission.model import Action
from mission.model.copies import copied
from protocol.messages import UPWARD, Order, Setpoint

TURN = 10.0  # s each way is given (R7)
LOOK = 1.0  # s between the depths whose deepest is taken: of hundreds it would be noise
FALL = 0.3  # m in a turn: 0.03 m/s, twice the noise of the difference of two depths
SANK = 0.6  # m deeper than at its start: a rise counts from the deepest, else from the start
ROUND = 0.1  # m less than the deepest: a vehicle that had sunk a metre has turned round
DOWNWARD = Setpoint(heave=1.0)  # lifts a vehicle that is upside down
OVERTURNED_TURN = 5.0  # s that DOWNWARD is given (R7)
OVERTURNED_PAUSE = 60.0  # s from one DOWNWARD to the next (R7)
LONGER = 5  # turns of letting go, each twice as long as the last: 10 s to 160 s (R7)
BLIND = 4  # turns of full thrust at most while the depth is unknown (R7)
SEEN = 6.0  # s after a lift at the surface until what proves the surface counts again (R7)
WORD = 1.0  # s from an operator's W to the next way; once a turn
DEEPER = 1.0  # m deeper: DOWNWARD is given up (R7); after another way, letting go has two turns

Way = Setpoint | Order


class Ascent:
    """One ascent. ``ways``: the vehicle's, in their order. ``upward``: begin with X0 and U12.
    ``sank``: the vehicle sank when it was let go at the surface. ``push``: the way that holds it up
    there, in place of X0 and U12. Depths count for their change alone; None: not even the change is
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
            "_risen_to",
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
        self._downward: tuple[Way, ...] = ()  # ways that led deeper, upside down
        self._dark, self._let_go = False, 0  # depth and attitude unknown; times let go then
        self._kept = False  # the way in use has made the depth fall
        self._heard = False  # an operator has sent W in this turn
        self._turned = False  # this turn follows since it had turned round; now it has to rise
        self._before: float | None = None  # the deepest of the turn before, if of the same way
        self._least: tuple[float | None, ...] = ()  # the shallowest of each of its last turns
        self._begin_turn(now, depth)
        first = ways[0]
        if overturned:
            first = Order.STOP
        elif (depth is None or upward) and UPWARD in ways:
            first = push or UPWARD
        self._at = ways.index(first) if first in ways else 0
        self.way: Way = ways[self._at]
        # the way that has longer turns
        self.push = push or (UPWARD if UPWARD in ways else Order.SURFACE)
        self._pushes = int(self.way == self.push)
        if sank and self._pushes:
            self._begin_long(now, depth)
        self._overturned_at, self._lifted_at = now - OVERTURNED_PAUSE, -math.inf

    @property
    def pushes_up(self) -> bool:
        """Whether a thruster pushes the vehicle up in this way."""
        return self.way is Order.SURFACE or self.way == UPWARD

    def lifts(self, now: float, depth: float | None, unsure: bool) -> tuple[Action, ...]:
        """Return full thrust for a vehicle at the surface that sinks when it is let go, if it was
        let go and did not rise by that. ``unsure``: it may be upside down; then no push begins."""
        sinks = self.way is Order.STOP and not self._kept and not unsure
        if not (sinks and self.push in self._ways):
            return ()
        self._at = self._ways.index(self.push)
        self.way, self._lifted_at = self.push, now
        self._begin_long(now, depth)
        return (Action(self.way, f"{self.why}: let go it would sink again"),)

    def is_up(self, now: float) -> bool:
        """Whether what proves the surface was seen after the last lift, not before it."""
        return now >= self._lifted_at + SEEN

    def first(self) -> tuple[Action, ...]:
        return (Action(self.way, self.why),)

    def hear(self, now: float) -> bool:
        """Note an operator's W that is not the way in use. Return whether to send it: once a turn.
        The turn then lasts ``WORD`` s more at least, or the next way would replace W on the line.
        """
        first, self._heard = not self._heard, True
        if first:
            self._turn = min(max(self._turn, now + WORD - self._since), self._longest)
        return first

    def doubt(self) -> None:
        """Note that the line was disconnected: an operator's W of this turn may be lost."""
        self._heard = False

    def act(
        self, now: float, depth: float | None, overturned: bool, doubtful: bool = False
    ) -> tuple[Action, ...]:
        """Return what is due: nothing while the way in use is being tried, or works. ``doubtful``:
        it is not known whether the vehicle is upside down."""
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
        """Whether the vehicle rises, or had sunk and has turned round."""
        start, deepest = self._start_depth, self._deepest
        if fallen is None or start is None or deepest is None:
            return False
        sank = deepest - start
        rises = fallen >= FALL + (0.0 if sank > SANK else sank)
        if self._before is not None and self._before - (deepest - fallen) < 2.0 * FALL:
            rises = False  # noise may look like a rise over one turn, but not over two
        rises = rises and self._gains()
        self._kept = self._kept or rises
        self._turned = not rises and not self._turned and sank > DEEPER and fallen >= ROUND
        return rises or self._turned

    def _gains(self) -> bool:
        """Whether this turn is shallower than the one before by FALL, and than the one before that
        by twice as much: waves are about as high in each turn."""
        least = self._reached()
        return all(
            then is None or least is None or then - least >= FALL * turns
            for turns, then in enumerate(reversed(self._least), 1)
        )

    def _reached(self) -> float | None:
        """The shallowest depth of the turn: from its deepest on if the vehicle sank by a metre in
        it, or a late depth did. From before, nothing of it was reached by this turn."""
        start, deepest = self._start_depth, self._deepest
        sank = start is not None and deepest is not None and deepest - start > DEEPER
        return self._risen_to if sank else self._shallowest

    def _pushes_on(self, overturned: bool) -> bool:
        """Whether full thrust continues: nothing shows if it lifts, and it has turns left."""
        sure = not overturned and not (self._dark and self._start_depth is None)
        return sure and self.way == self.push and self._turn < self._pushes * TURN

    def _lengthen(self) -> None:
        self._turn += TURN
        self._longest = self._turn + WORD

    def _change(self, now: float, depth: float | None, overturned: bool) -> None:
        """Begin the turn of the next way."""
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
        """Note whether depth and attitude are unknown. Once one is known, the turn has its ordinary
        length again."""
        if self._dark and not dark:
            self._turn = min(self._turn, TURN)
        self._dark = dark

    def _next(self, depth: float | None, overturned: bool) -> int:
        """Return the index of the next way. Upside down, ways that led deeper are left out; if the
        depth is unknown too, only letting go is left, since any push may lead deeper."""
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
        """Begin another turn of the way in use."""
        before, least = self._deepest, (*self._least[-1:], self._reached())
        self._begin_turn(now, depth)
        self._before, self._least = before, least

    def _begin_turn(self, now: float, depth: float | None, turn: float | None = None) -> None:
        self._before, self._least, self._heard = None, (), False
        self._since = self._looked = now
        self._turn = TURN if turn is None else turn
        self._longest = self._turn + WORD
        self._start_depth = self._deepest = self._shallowest = self._risen_to = depth

    def _begin_long(self, now: float, depth: float | None) -> None:
        """Begin the long turn of full thrust, for a vehicle that sank when it was let go."""
        self._pushes = BLIND
        self._begin_turn(now, depth, TURN if depth is None else 2.0 * TURN)

    def _fallen(self, now: float, depth: float | None) -> float | None:
        """m of rise from the deepest of the turn's depths, ``LOOK`` s apart; None: not known."""
        if self._start_depth is None:
            self._start_depth = self._deepest = self._shallowest = self._risen_to = depth
            return None
        if depth is None or self._deepest is None or self._shallowest is None:
            return None
        if now >= self._looked + LOOK:
            if self._risen_to is None or depth > self._deepest:
                self._risen_to = depth
            self._looked, self._deepest = now, max(self._deepest, depth)
            self._shallowest = min(self._shallowest, depth)
            self._risen_to = min(self._risen_to, depth)
        return self._deepest - depth

    def _has_led_deeper(self, depth: float | None) -> bool:
        """Whether this turn has led a metre deeper than its shallowest. It counts from there, since
        a vehicle that was rising may go on at first."""
        least = self._shallowest
        return depth is not None and least is not None and depth - least > DEEPER

    def _may_push_down(self, now: float) -> bool:
        """Whether DOWNWARD is next: after the last of the ways, once a minute."""
        last = self._at == len(self._ways) - 1 and self.way != DOWNWARD
        return last and now >= self._overturned_at + OVERTURNED_PAUSE

    def next_timer(self) -> float:
        return self._since + self._turn

    def clone(self) -> Self:
        return copied(self)
