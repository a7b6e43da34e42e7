"""The GPS receivers: the first, and an optional second one.

    gps    its fixes count
    gps2   its fixes count while the first has sent none for FAILOVER, or is stuck: the last fixes
           of the first are one position to the bit, those of the second are not

If both send fixes that are further apart than their noise explains, nobody knows which receiver is
right. Then the standard deviation of a fix that counts is the distance between the two, of the nth
such fix in a row n times that distance, and its speed and course are dropped. The error is a bias,
not noise: 1 + 1/4 + 1/9 + ... stays below 1.65, so all these fixes together weigh no more than two
fixes, and the innovation gate judges them (R9).

Each receiver is judged by all its own fixes, counted or not. A position from before a dive that a
receiver repeats does not count; of the second receiver, only new positions count. Without a second
receiver every fix is passed on as it came.

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
TOLD = 10.0, 3  # s, fixes in a row: a shorter failover or disagreement is not reported
_STUCK = 5  # fixes in a row
_SIGMAS, _LEAST, _FASTEST = 6.0, 3.0, 4.0  # of each noise; m, least noise; m/s


class Receivers:
    def __init__(self) -> None:
        self._decoders = {name: NmeaDecoder() for name in RECEIVERS}
        self._last: dict[str, deque[Fix]] = {name: deque(maxlen=_STUCK) for name in RECEIVERS}
        self._said = {name: Receiver() for name in RECEIVERS}
        self._second = False  # it has ever sent a fix
        self._doubts = 0  # in a row
        self._apart = 0.0  # m, when last in doubt
        self._stands_in: tuple[float, float] | None = None  # s: since when, and last

    @property
    def trouble(self) -> str:
        """Why the first does not count as it should, once that lasts; "" if it counts. It changes
        only with new fixes."""
        seconds, doubts = TOLD
        if self._doubts >= doubts:
            return f"the two receivers say places {self._apart:.0f} m apart"
        if self._stands_in is None or self._stands_in[1] - self._stands_in[0] < seconds:
            return ""
        how = "is stuck" if _stuck(self._last[GPS]) else "says no fix"
        return f"the first receiver {how}: the second counts"

    def receive(self, rx: Rx) -> list[Fix | FrameFault]:
        """Decode the bytes; return the fixes that count, and the faults."""
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
        """Like ``receive``, for sentences that have waited long enough, by link."""
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
        """Whether the fix is new for this receiver; without a second receiver every fix is."""
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
        """The fix, more uncertain if it is too far from the other receiver's; more so each time."""
        self._apart = apart = self._between(link, fix)
        self._doubts = self._doubts + 1 if apart else 0
        if not apart:
            return fix
        accuracy = max(fix.accuracy, apart * self._doubts)
        return replace(fix, accuracy=accuracy, speed=None, course=None)

    def _between(self, link: str, fix: Fix) -> float:
        """Distance to the other receiver's fix of the same time, m; 0 if noise explains it."""
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
