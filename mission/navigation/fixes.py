"""Judge GPS fixes as evidence of the surface, and as a place to start from.

- A place that the receiver has sent lately, to the last bit, is not new. A stuck receiver repeats
  one place, two in turn or a few, with or without pauses, under water too.
- A receiver that wanders under water sends a new place each second. So fixes are evidence of the
  surface only if nothing contradicts them, and if the receiver behaves for some seconds as one at
  the surface.
- Some receivers repeat from a buffer, after a dive, places of before it. These are *stale* until a
  new place comes.

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

FIX_DEPTH = 0.8  # m: the surface's 0.5 m and three sigma of a depth; deeper, no fix counts (R7)
SETTLED = 5.0  # s of fixes that behave as at the surface
_REMEMBERED = 32  # places
_NEWS = 4  # new places that such a run needs
RECENT = 20.0  # s since the first of them at most: a receiver without new places is stuck (R7)
_SILENT = 60.0  # s without a fix, after which a repeated place is stale
_GAP = 8.0  # s between fixes at most: waves wash over the antenna; longer means under water (R7)
_HDOP, _SATELLITES = 5.0, 4
_FASTEST = 4.0  # m/s over ground: a current, the thrusters and a wave together
HOME_OF = 5  # fixes (R9)
_SCATTER, _HOME_HDOP = 10.0, 3.0  # m from their median; (R9)
_LEAP = 15.0  # m more than that between two fixes: six sigma of an ordinary receiver


class Receiver:
    __slots__ = ("_fresh_at", "_good", "_last", "_news", "_places", "_since", "fresh", "stale")

    def __init__(self) -> None:
        self.fresh = False  # the last fix is a place that was not sent lately
        self.stale = False  # the receiver repeats places of before it was silent
        self._places: dict[tuple[float, float], None] = {}  # oldest first
        self._last: Fix | None = None
        self._fresh_at = 0.0
        self._good = False  # the last fix, by its own figures
        self._since = 0.0  # begin of the run of fixes as at the surface; times of its new places
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
        """Return for how many s the fixes have been as at the surface; 0 if they are not."""
        last = self._last
        if last is None or now - last.t > _GAP or len(self._news) < _NEWS:
            return 0.0
        if now - self._news[0] > RECENT:  # it got stuck
            return 0.0
        return last.t - self._since

    def at_surface(self, now: float) -> bool:
        """Whether the vehicle is at the surface, by the fixes alone."""
        return self.settled(now) >= SETTLED

    def no_news(self, now: float) -> float | None:
        """Return the s since the last new place, None if there never was one. A stuck receiver
        keeps sending under water."""
        return None if self._last is None else now - self._fresh_at

    @property
    def last_at(self) -> float:
        """Time of the last fix, s; -inf if there never was one."""
        return -math.inf if self._last is None else self._last.t

    @property
    def news_at(self) -> float:
        """Time of the last new place, s; -inf if there never was one."""
        return -math.inf if self._last is None else self._fresh_at

    def _follows(self, fix: Fix) -> bool:
        last = self._last
        if last is None or fix.t - last.t > _GAP:
            return False
        way = metres(last.latitude, last.longitude, fix.latitude, fix.longitude)
        return way <= _LEAP + _FASTEST * (fix.t - last.t)


def _good(fix: Fix) -> bool:
    """Whether the fix's own figures are good; a figure that it lacks counts neither way."""
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
    """Whether a home may be taken from the fix. The vehicle's own position has no HDOP."""
    own = fix.accuracy == math.inf
    return own or (fix.hdop is not None and fix.hdop <= _HOME_HDOP)


def metres(lat_a: float, lon_a: float, lat_b: float, lon_b: float) -> float:
    """Return the distance (m) between two near points (rad) on a sphere: good to 0.5 %, for
    plausibility only."""
    north = lat_b - lat_a
    east = math.remainder(lon_b - lon_a, 2.0 * math.pi) * math.cos(0.5 * (lat_a + lat_b))
    return EARTH * math.hypot(north, east)
