"""The GPS receivers: the first, and a second one that may stand beside it.

    gps    its fixes count
    gps2   its fixes count while the first has said none for FAILOVER, or is stuck: the last of the
           first's fixes are one place to the bit, those of the second are not

While both speak and are further apart than their noise explains, nothing says which of them is
right: what counts is taken to be as uncertain as they are apart, the nth in a row n times as much,
and its speed and course teach nothing.
Their error is one and no noise: 1 + 1/4 + 1/9 + ... stays below 1.65, so all of them together
teach no more than two fixes would, and the gate for fixes judges them (R9).

Each receiver is judged by all that it said itself, counted or not: a place of before a dive that
either says again does not count, nor one of the second that is no news. Without a second receiver
every fix is passed on as it came.

What does not live here: sentences (protocol.nmea), what a fix proves (engine), the gate
(navigation).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import replace

from links.base import Rx
from mission.navigation.fixes import Receiver, metres
from protocol.messages import Fix, FrameFault
from protocol.nmea import NmeaDecoder

GPS, GPS2 = "gps", "gps2"
RECEIVERS = (GPS, GPS2)
FAILOVER = 5.0  # s without a fix of the first
TOLD = 10.0, 3  # s, fixes in a row: for so long the second counts, or they disagree, untold
_STUCK = 5  # fixes in a row
_SIGMAS, _LEAST, _FASTEST = 6.0, 3.0, 4.0  # of each noise; m, of a plain receiver's; m/s


class Receivers:
    def __init__(self) -> None:
        self._decoders = {name: NmeaDecoder() for name in RECEIVERS}
        self._last: dict[str, deque[Fix]] = {name: deque(maxlen=_STUCK) for name in RECEIVERS}
        self._said = {name: Receiver() for name in RECEIVERS}
        self._second = False  # it has ever said a fix
        self._doubts = 0  # in a row
        self._apart = 0.0  # m, when last in doubt
        self._stands_in: tuple[float, float] | None = None  # s: since when, and last

    @property
    def trouble(self) -> str:
        """Why the first does not count as it should, as far as it lasts; "" if it does. While
        nothing is said, as it was."""
        seconds, doubts = TOLD
        if self._doubts >= doubts:
            return f"the two receivers say places {self._apart:.0f} m apart"
        if self._stands_in is None or self._stands_in[1] - self._stands_in[0] < seconds:
            return ""
        how = "is stuck" if _stuck(self._last[GPS]) else "says no fix"
        return f"the first receiver {how}: the second counts"

    def receive(self, rx: Rx) -> list[Fix | FrameFault]:
        """What counts of it."""
        heard = self._decoders[rx.link].receive(rx.data, rx.t)
        return list(self._counted(rx.link, heard)) if heard else []

    def next_timer(self) -> float | None:
        first: float | None = None
        for decoder in self._decoders.values():
            due = decoder.next_timer()
            if due is not None and (first is None or due < first):
                first = due
        return first

    def flush(self, now: float) -> list[tuple[str, list[Fix | FrameFault]]]:
        """The same of what was waiting until now, by link."""
        return [
            (link, list(self._counted(link, decoder.flush(now))))
            for link, decoder in self._decoders.items()
            if (due := decoder.next_timer()) is not None and due <= now
        ]

    def _counted(self, link: str, heard: list[Fix | FrameFault]) -> Iterator[Fix | FrameFault]:
        for one in heard:
            if not isinstance(one, Fix):
                yield one
            elif self._is_news(link, one) and self._counts(link, one.t):
                since = one.t if self._stands_in is None else self._stands_in[0]
                self._stands_in = (since, one.t) if link == GPS2 else None
                yield self._doubted(link, one)

    def _is_news(self, link: str, fix: Fix) -> bool:
        """By what the same receiver said before; all is, as long as there is no second."""
        said = self._said[link]
        said.take(fix)
        self._second |= link == GPS2
        if not said.stale:
            self._last[link].append(fix)
        return not self._second or (said.fresh if link == GPS2 else not said.stale)

    def _counts(self, link: str, now: float) -> bool:
        first, second = (self._last[name] for name in RECEIVERS)
        alive = bool(first) and now - first[-1].t <= FAILOVER
        beside = bool(second) and now - second[-1].t <= FAILOVER
        failed = not alive or (beside and _stuck(first) and not _stuck(second))
        return failed is (link == GPS2) or (link == GPS and not beside)

    def _doubted(self, link: str, fix: Fix) -> Fix:
        """As uncertain as it is from the other's place, if that is too far; more each time."""
        self._apart = apart = self._between(link, fix)
        self._doubts = self._doubts + 1 if apart else 0
        if not apart:
            return fix
        accuracy = max(fix.accuracy, apart * self._doubts)
        return replace(fix, accuracy=accuracy, speed=None, course=None)

    def _between(self, link: str, fix: Fix) -> float:
        """m, from the other's place of the same time; 0 where noise explains it."""
        others = self._last[GPS if link == GPS2 else GPS2]
        if not others or fix.t - others[-1].t > FAILOVER or _stuck(others):
            return 0.0
        other = others[-1]
        apart = metres(fix.latitude, fix.longitude, other.latitude, other.longitude)
        noise = sum(_SIGMAS * max(one.accuracy, _LEAST) for one in (fix, other))
        return apart if apart > noise + _FASTEST * (fix.t - other.t) else 0.0


def _stuck(fixes: deque[Fix]) -> bool:
    places = {(fix.latitude, fix.longitude) for fix in fixes}
    return len(fixes) == _STUCK and len(places) == 1
