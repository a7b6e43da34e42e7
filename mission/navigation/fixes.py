"""Judges GPS fixes as evidence of the surface, and as a place to start from.

A place that it has said lately, to the last bit, is no news: a receiver that got stuck says one
place, two in turn or a few, with or without pauses, under water too. And one that wanders under
water says a new place each second: only where nothing contradicts it, and it behaves for some
seconds as a receiver at the surface does, may it speak of the surface at all. Places of before a
dive that are said again after it (some receivers' buffers do) are *stale* until a new one comes.

What does not live here: what contradicts a fix (engine, navigation), the sentences (protocol.nmea).
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from typing import Self

from mission.model import Position
from mission.model.copies import copied
from mission.navigation.geodesy import EARTH
from protocol.messages import Fix

FIX_DEPTH = 0.8  # m: the surface's 0.5 m and three sigma of a depth; deeper, a fix is none (R7)
SETTLED = 5.0  # s of fixes that behave as at the surface
_REMEMBERED = 32  # places
_NEWS = 4  # new places within such a run
RECENT = 20.0  # s ago that the first of them may be: a receiver without any is stuck (R7)
_SILENT = 60.0  # s without a fix: what is said again after it is stale
_GAP = 8.0  # s between fixes: waves wash over the antenna; longer, and it is under water (R7)
_HDOP, _SATELLITES = 5.0, 4
_FASTEST = 4.0  # m/s over ground: a current, the thrusters and a wave together
HOME_OF = 5  # fixes (R9)
_SCATTER, _HOME_HDOP = 10.0, 3.0  # m of them; (R9)
_LEAP = 15.0  # m beside that between two fixes: six sigma of a plain receiver


class Receiver:
    __slots__ = ("_fresh_at", "_good", "_last", "_news", "_places", "_since", "fresh", "stale")

    def __init__(self) -> None:
        self.fresh = False  # the last fix said a place that it had not said lately
        self.stale = False  # it says again what it said before it was silent
        self._places: dict[tuple[float, float], None] = {}  # oldest first
        self._last: Fix | None = None
        self._fresh_at = 0.0
        self._good = False  # by what the last one says of itself
        self._since = 0.0  # of the run of fixes as at the surface, and its last new places: when
        self._news: tuple[float, ...] = ()

    def clone(self) -> Self:
        return copied(self)

    def take(self, fix: Fix) -> None:
        place = fix.latitude, fix.longitude
        self.fresh = place not in self._places
        silent = self._last is not None and fix.t - self._last.t >= _SILENT
        self.stale = not self.fresh and (self.stale or silent)
        if self.fresh:
            self._fresh_at = fix.t
            self._places[place] = None
            if len(self._places) > _REMEMBERED:
                del self._places[next(iter(self._places))]
        good = _good(fix)
        if not (good and self._good and self._follows(fix)):
            self._since, self._news = fix.t, ()
        if good and self.fresh:
            self._news = (*self._news[1 - _NEWS :], fix.t)
        self._last, self._good = fix, good

    def settled(self, now: float) -> float:
        """s for which its fixes have behaved as at the surface; 0 where they do not."""
        last = self._last
        if last is None or now - last.t > _GAP or len(self._news) < _NEWS:
            return 0.0
        if now - self._news[0] > RECENT:  # it got stuck
            return 0.0
        return last.t - self._since

    def at_surface(self, now: float) -> bool:
        """By its fixes alone."""
        return self.settled(now) >= SETTLED

    def no_news(self, now: float) -> float | None:
        """s since it last said a new place: one that got stuck goes on under water. None if there
        never was one."""
        return None if self._last is None else now - self._fresh_at

    @property
    def last_at(self) -> float:
        """s, of the last fix; -inf if there never was one."""
        return -math.inf if self._last is None else self._last.t

    @property
    def news_at(self) -> float:
        """s, when it last said a new place; -inf if there never was one."""
        return -math.inf if self._last is None else self._fresh_at

    def _follows(self, fix: Fix) -> bool:
        last = self._last
        if last is None or fix.t - last.t > _GAP:
            return False
        way = metres(last.latitude, last.longitude, fix.latitude, fix.longitude)
        return way <= _LEAP + _FASTEST * (fix.t - last.t)


def _good(fix: Fix) -> bool:
    """What it says of itself; what it does not speak of counts neither way."""
    return (
        (fix.hdop is None or fix.hdop <= _HDOP)
        and (fix.satellites is None or fix.satellites >= _SATELLITES)
        and (fix.speed is None or fix.speed <= _FASTEST)
    )


def home_of(fixes: Sequence[Fix]) -> Position | None:
    """R9: the median of five consecutive good fixes within 10 m, else None."""
    if len(fixes) < HOME_OF or not all(_starts(f) for f in fixes):
        return None
    latitude = statistics.median(f.latitude for f in fixes)
    longitude = statistics.median(f.longitude for f in fixes)
    if any(metres(latitude, longitude, f.latitude, f.longitude) > _SCATTER for f in fixes):
        return None
    return Position(math.degrees(latitude), math.degrees(longitude))


def _starts(fix: Fix) -> bool:
    """What the vehicle itself says of its place, at a proved surface, has no HDOP."""
    own = fix.accuracy == math.inf
    return own or (fix.hdop is not None and fix.hdop <= _HOME_HDOP)


def metres(lat_a: float, lon_a: float, lat_b: float, lon_b: float) -> float:
    """Between two near points, in rad, on a sphere: good to 0.5 %, for plausibility only."""
    north = lat_b - lat_a
    east = math.remainder(lon_b - lon_a, 2.0 * math.pi) * math.cos(0.5 * (lat_a + lat_b))
    return EARTH * math.hypot(north, east)
