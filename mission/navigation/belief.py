"""Compare the depth with other evidence of vertical motion.

A clogged port, a drift, an offset or a jump gives a depth that is fresh, in range and never twice
the same. The depth is contradicted by one of these over the last ``WINDOW`` seconds:

    stands    the verticals push (as reported, or by the set in force) and the depth does not move
    altimeter the altitude changes evenly while the depth stands and no main thruster is on: quickly
              within the window, or slowly in all the time since. Where depth and fixes show that
              the vehicle floats, only an altitude that falls quickly counts: it drifts over slopes
    leaps     the depth jumps, and stays at the new value
    rate      the depth changes faster than any vehicle moves
    offset    fixes come as at the surface, nothing pushes down, and the depth is 0.8 m or more off
              0. It also stands, or does not fall though the verticals push up; and it does not move
              as a vehicle does

The ground under the vehicle and the surface above it explain a depth that stands, so that is no
contradiction. Fixes do not explain it: under water a receiver may make them up.

A contradicted depth is believed again in one of two ways. Either way it must have moved: 0.1 m on a
clogged port is no proof of the surface.

    movement  it has moved the way the verticals move the vehicle
    surface   it shows the surface through ``AGREES`` seconds of fixes

- After a leap or a rate: by the surface only. Such a depth moves as it should, so movement proves
  its changes but not its zero.
- After an offset: by movement, too, if fixes have come all that time (nothing rises by metres at
  the surface, so the receiver was wrong), or once they have ended (the vehicle is under water, and
  as deep as reported but for the offset).
- After it stood under a push upward: where fixes come, as after an offset while they come. Without
  fixes, either way: the vehicle is under water and as heavy as its thrusters can just hold, or the
  port is clogged, and movement tells which.

What does not live here: a sensor by itself (health), what follows (engine, limits). What cannot
be detected this way: docs/navigation.md.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple, Self

from mission.model import CONTRADICTED, NEARS_GROUND, Vertical
from mission.model.copies import copied
from mission.navigation.fixes import FIX_DEPTH, Receiver

WINDOW = 14.0  # s: eight reports of the AUV
STANDS = 0.4  # m between the means of the window's halves: 7 s apart, or 8 s by reports of 2 s
AGREES = 10.0  # s of fixes as at the surface that make a shallow depth believed again
_OFFSET_TIME = 30.0  # s of such fixes that contradict a depth off 0
_LIFTED = 8.0  # s of push upward in that time: then the depth need not stand
_PUSHES, _HARD = 0.55, 0.75  # share of full thrust that is a push: if short of the depth; always
_SHORT = 0.5  # m short of the depth asked for, where the verticals report their thrust
_UNREPORTED = 1.0  # m short, where they do not report: a depth hold may stay that far off
_NEUTRAL, _STILL = 0.1, 0.1  # share of full thrust that counts as off: verticals, mains
_GROUND, _LIES = 1.0, 60.0  # m of altitude within the last s: the vehicle may lie on the ground
_STEP = 3.0  # m: ground may rise by as much between two echoes, beside what the vehicle sinks ...
_FAR = 2.0  # m: ... if by more, the altimeter hears itself, until it reports more than this
_UNEVEN = 0.7  # m by which depth + altitude may differ then: no ground sinks with the vehicle
_FIXES_GO = 3.0  # s without a new place: the antenna is under water
_HAD = 60.0  # s without a new place at most, for fixes to count as ended just now
_BODY = 1.25  # m/s: no vehicle is faster up or down
_CLOSING = 1.7  # m between the halves: 1 m, and a slope of 30 % under a drift of 0.3 m/s
_SLOWLY = 3.0  # m in any time, while no main is on: a drift of 0.2 m/s over a slope of 15 m
_DRIFT = 0.02  # m/s more after a minute: a drift of 0.4 m/s over a slope of 5 %
_EVENLY = 1.0, 0.4  # m/s and m: a larger change between two reports is a step of the ground
_ALL_ALONG = 1.5  # change over the window by that of the halves: 2 if even, 1 if a step
_AT_REST = 45.0  # s since the depth moved: a slow altimeter has followed by then
_MOVED = 0.5  # m that a depth must have moved to be believed again
_FOLLOWS = 1.0  # m between the halves that count as motion of the vehicle ...
_SINKS = 2.0  # m ... or downward in any time, while nothing pushes and no fixes come
_LATELY = 300.0  # s since the fixes ended, at most: 1 cm/s makes 2 m in that time
_LAPSE = 3.5  # s since the report before, at most: in a longer gap the stick may have driven
EVERY, GAP = 0.9, 6.5  # s between two reports that are used: the least, the most

UNPUSHED = Vertical(None, None)


class _Sample(NamedTuple):
    t: float
    depth: float
    altitude: float | None


class DepthBelief:
    """Whether the depth is contradicted by the reports so far.

    ``reason`` says why ("" while it is not). ``follows``: the contradicted depth has moved as the
    vehicle does, so its sensor has an offset and is not clogged."""

    def __init__(self) -> None:
        self.reason, self.follows = "", False
        self._moves = False  # movement alone may end the contradiction
        self._by_fixes = False  # the fixes contradict the depth ...
        self._is_offset = False  # ... and nothing else does
        self._samples: tuple[_Sample, ...] = ()
        self._way, self._pushed_at = 0, -math.inf  # the push that must move it (1 down), and when
        self._along = 0  # the push that moves it if nothing is in its way
        self._lapsed_at = -math.inf  # of a report without push that did not end the push
        self._calm_at = self._still_at = math.inf  # since when nothing pushes down; no main is on
        self._moved_at = self._grounded_at = -math.inf
        self._heard_from = math.inf, -math.inf  # m, depth + altitude of near grounds: least, most
        self._echo: tuple[float, float] | None = None  # s, m: the last altitude
        self._stepped = False  # the ground came near by a step that no vehicle sinks
        self._ground_from: tuple[float, float] | None = None  # s, m: begin of a slow change
        self._doubted_at = -math.inf
        self._low = self._high = math.nan  # least and greatest mean of the depth since then
        self._sinks_from = math.inf  # the least mean since a slow descent may have begun
        self._afloat, self._lifted = (math.inf, math.inf), 0.0  # afloat since s, at m; s of lift

    def clone(self) -> Self:
        return copied(self)

    def leap(self, t: float, by: float) -> None:
        """Contradict a depth that has jumped by ``by`` metres and stays: it is not clogged."""
        self._contradict(t, f"it leapt by {by:.1f} m", moves=False)
        self._low, self._moves, self.follows = -math.inf, False, False
        self._sinks_from = math.inf
        self._by_fixes = self._is_offset = False

    def take(
        self,
        t: float,
        depth: float,
        altitude: float | None,
        mains: float,
        push: Vertical,
        receiver: Receiver,
    ) -> None:
        """Take a report: ``depth`` and ``altitude`` in m (None: no new altitude), ``mains`` the
        greatest share of full thrust of the main thrusters, ``push`` what moves it vertically."""
        samples = self._samples
        since = t - samples[-1].t if samples else math.inf
        if since < EVERY:
            return
        if since > GAP:
            samples, self._pushed_at, self._moved_at, self.follows = (), t, t, False
            self._sinks_from = math.inf
            self._calm_at = self._still_at = math.inf
        kept = [s for s in samples if s.t >= t - WINDOW - 1e-6]
        self._samples = (*kept, _Sample(t, depth, altitude))
        self._notice(t, depth, altitude, mains, push, receiver)
        halves = self._halves(t)
        if halves is None:
            return
        before, after = halves
        if abs(after - before) >= STANDS:
            self._moved_at = t
        if self.reason:
            self._reconsider(t, after, after - before, receiver)
        else:
            self._doubt(t, after, after - before, receiver)
            if self.reason:
                self._low = self._high = after  # a change right after it counts as moved

    # --- what is going on ----------------------------------------------------------------------

    def _notice(
        self,
        t: float,
        depth: float,
        altitude: float | None,
        mains: float,
        push: Vertical,
        receiver: Receiver,
    ) -> None:
        quiet = receiver.no_news(t)
        if altitude is not None:
            self._notice_ground(t, altitude)
        gone = quiet is not None and _FIXES_GO < quiet <= _HAD and abs(depth) < FIX_DEPTH
        if way := (along := self._push(depth, push, gone)):
            at_ground = t - self._grounded_at <= _LIES
            if (at_ground and not gone) if way > 0 else depth < FIX_DEPTH:
                way = 0
        self._along = along
        lapses = not way and self._way != 0 and t - self._lapsed_at > WINDOW  # only one in it
        lapses = lapses and len(self._samples) > 1 and t - self._samples[-2].t <= _LAPSE
        self._lapsed_at = t if lapses else self._lapsed_at
        if way != self._way and not lapses:
            self._way, self._pushed_at = way, t
        down = push.asked is not None and push.asked > depth
        pushes_down = down if push.down is None else push.down > _NEUTRAL
        self._calm_at = math.inf if pushes_down else min(self._calm_at, t)
        self._still_at = math.inf if mains > _STILL else min(self._still_at, t)

    def _notice_ground(self, t: float, altitude: float) -> None:
        """Note whether the vehicle may lie on the ground. An altimeter that reports so little all
        the way down hears itself. So does one whose altitude falls faster than a vehicle sinks,
        by more than a step of the ground. Means, since waves move a vehicle on the ground."""
        if altitude > _FAR:
            self._stepped = False
        elif self._echo is not None:
            at, above = self._echo
            self._stepped |= above - altitude > _STEP + _BODY * (t - at)
        self._echo = t, altitude
        if altitude > _GROUND:
            self._grounded_at, self._heard_from = -math.inf, (math.inf, -math.inf)
            return
        samples, least, most = self._samples, *self._heard_from
        half = len(samples) // 2
        before = _mean([s.depth for s in samples[:half]])
        after = _mean([s.depth for s in samples[half:]])
        if abs(after - before) >= 2.0 * STANDS:  # a dive, not a crawl, waves or noise
            heard = [(s.depth, s.altitude) for s in samples if s.altitude is not None]
            ground = _mean([under + above for under, above in heard if above <= _GROUND])
            least, most = min(least, ground), max(most, ground)
            self._heard_from = least, most
        real = not self._stepped and most - least <= _UNEVEN
        self._grounded_at = t if real else -math.inf

    def _push(self, depth: float, push: Vertical, gone: bool) -> int:
        """Return the way of a push that must move the depth: 1 down, -1 up, 0 if it may stand.
        ``gone``: the depth reads as at the surface, and fixes have ended."""
        down, asked = push
        if down is not None and abs(down) >= _HARD:
            return 1 if down > 0.0 else -1
        if asked is None or (down is not None and abs(down) < _PUSHES):
            return 0
        off = asked - depth
        if abs(off) <= (_UNREPORTED if down is None and not gone else _SHORT):
            return 0
        way = 1 if off > 0.0 else -1
        return way if down is None or down * way > 0.0 else 0

    def _halves(self, t: float) -> tuple[float, float] | None:
        """Means of the depth in the older and the newer half; None before the window is full."""
        samples = self._samples
        if samples[0].t > t - WINDOW + 2.0:
            return None
        middle = t - 0.5 * WINDOW
        older = [s.depth for s in samples if s.t < middle - 1e-6]
        newer = [s.depth for s in samples if s.t > middle + 1e-6]
        if not older or not newer:
            return None
        return _mean(older), _mean(newer)

    # --- doubt -----------------------------------------------------------------------------------

    def _doubt(self, t: float, depth: float, moved: float, receiver: Receiver) -> None:
        whole = t - WINDOW + 1e-6
        if abs(moved) > _BODY * 0.5 * WINDOW:
            rate = abs(moved) / (0.5 * WINDOW)
            self._contradict(t, f"{rate:.1f} m/s up or down, which no body has", moves=False)
        elif self._is_off(t, depth, moved, receiver):
            self._contradict(t, f"fixes come and it says {depth:.1f} m", moves=False)
            self._by_fixes = self._is_offset = True
        elif abs(moved) >= STANDS:
            return
        elif self._way and self._pushed_at <= whole:
            way = "down" if self._way > 0 else "up"
            says = f"the verticals push {way} and it stands at {depth:.1f} m"
            quiet = receiver.no_news(t)
            under = quiet is None or quiet > _FIXES_GO
            self._contradict(t, says, moves=self._way > 0 or under)
            self._by_fixes = not self._moves
        elif (
            self._still_at <= whole
            and t - self._moved_at >= _AT_REST
            and (by := self._ground(t, abs(depth) < FIX_DEPTH and receiver.settled(t) >= AGREES))
        ):
            way = NEARS_GROUND if by > 0.0 else "the ground goes"
            says = f"{way} by {abs(by):.1f} m and it stands at {depth:.1f} m"
            self._contradict(t, says, moves=True)

    def _is_off(self, t: float, depth: float, moved: float, receiver: Receiver) -> bool:
        """Whether fixes come as at the surface, nothing pushes down, and the depth is not 0 and
        does not fall. A vehicle that moves up or down is not at the surface, whatever the fixes."""
        floats = self._floats(t, moved, receiver)
        if not floats or depth < self._afloat[1] - STANDS:
            self._afloat, self._lifted = (t, depth if floats else math.inf), 0.0
            return False
        self._lifted += (self._way < 0) * (t - self._samples[-2].t)
        lasts = t - self._afloat[0] >= _OFFSET_TIME
        stands = abs(moved) < STANDS or self._lifted >= _LIFTED
        off = min(abs(depth), abs(depth - moved)) >= FIX_DEPTH  # in both halves, against noise
        return lasts and off and stands

    def _floats(self, t: float, moved: float, receiver: Receiver) -> bool:
        calm = self._calm_at < math.inf
        return calm and receiver.settled(t) > 0.0 and not self._travels(moved)

    def _ground(self, t: float, afloat: bool) -> float:
        """Return by how many m the ground evenly came nearer (negative: receded); 0: it did not."""
        seen = [(s.t, s.altitude) for s in self._samples if s.altitude is not None]
        older = [a for at, a in seen if at < t - 0.5 * WINDOW]
        newer = [a for at, a in seen if at >= t - 0.5 * WINDOW]
        if len(older) < 2 or len(newer) < 2:
            self._ground_from = None
            return 0.0
        nearer = _mean(older) - _mean(newer)
        way, (rate, noise) = math.copysign(1.0, nearer), _EVENLY
        for (at, a), (bt, b) in itertools.pairwise(seen):
            if not -noise <= (a - b) * way <= rate * (bt - at) + noise:
                self._ground_from = None
                return 0.0
        all_along = (seen[0][1] - seen[-1][1]) * way >= _ALL_ALONG * abs(nearer)
        if all_along and (nearer >= _CLOSING or (nearer <= -_CLOSING and not afloat)):
            return nearer
        return self._slowly(t, _mean(newer), afloat)

    def _slowly(self, t: float, altitude: float, afloat: bool) -> float:
        """Return by how many m the ground came nearer since the depth stands and no main is on; 0
        if by too little, or if the vehicle floats. 5 cm/s are 3 m in a minute."""
        begun = self._ground_from
        if afloat or begun is None or begun[0] < max(self._moved_at, self._still_at):
            self._ground_from = t, altitude
            return 0.0
        nearer = begun[1] - altitude
        lasts = t - begun[0]
        slope = _DRIFT * max(lasts - 60.0, 0.0)
        return nearer if abs(nearer) >= _SLOWLY + slope and lasts >= WINDOW else 0.0

    def _contradict(self, t: float, why: str, *, moves: bool) -> None:
        if not self.reason:
            self.reason, self._moves, self._doubted_at = f"{CONTRADICTED}: {why}", moves, t
            self._by_fixes = self._is_offset = False
            self._low, self._high, self.follows = math.inf, -math.inf, False
            self._sinks_from = math.inf

    # --- belief ----------------------------------------------------------------------------------

    def _reconsider(self, t: float, mean: float, moved: float, receiver: Receiver) -> None:
        if self._samples[0].t < self._doubted_at:
            return
        self._low, self._high = min(self._low, mean), max(self._high, mean)
        if self._moves_along(moved) or self._sinks(t, mean, moved, receiver):
            self.follows = True
        elif abs(moved) < STANDS and self._way and self._pushed_at <= t - WINDOW + 1e-6:
            self.follows = False
        made_up = self._by_fixes and receiver.settled(t) >= WINDOW  # nothing rises at the surface
        quiet = receiver.no_news(t)
        gone = self._is_offset and quiet is not None and quiet > _FIXES_GO  # it has gone under
        if self.follows and (self._moves or made_up or gone):
            self.reason = ""
        shallow = abs(mean) < FIX_DEPTH and self._high - self._low >= _MOVED
        if shallow and receiver.settled(t) >= AGREES:
            self.reason = ""

    def _moves_along(self, moved: float) -> bool:
        """Whether it moves the way the verticals push, or either way where nothing pushes. Ground
        that an altimeter reports explains only a depth that stands."""
        calm = self._way == 0 and self._calm_at <= self._samples[0].t
        way = self._way or self._along
        return self._travels(moved) and (moved * way > 0.0 or calm)

    def _sinks(self, t: float, mean: float, moved: float, receiver: Receiver) -> bool:
        """Whether it sinks slowly, as a vehicle that is hardly too heavy: under 1 m a window."""
        calm = self._way == 0 and self._calm_at < math.inf and abs(moved) < _FOLLOWS
        quiet = receiver.no_news(t)
        lately = quiet is None or quiet <= _LATELY  # later it may be on deck
        at_rest = calm and receiver.settled(t) <= 0.0 and lately
        self._sinks_from = min(self._sinks_from, mean) if at_rest else math.inf
        return at_rest and mean - self._sinks_from >= _SINKS

    def _travels(self, moved: float) -> bool:
        """Whether it moves as a vehicle does: by a metre, and without a step."""
        return abs(moved) >= _FOLLOWS and all(
            abs(b.depth - a.depth) <= _BODY * (b.t - a.t) + STANDS
            for a, b in itertools.pairwise(self._samples)
        )


def _mean(values: list[float]) -> float:
    """The mean; NaN if there are no values."""
    return sum(values) / len(values) if values else math.nan
