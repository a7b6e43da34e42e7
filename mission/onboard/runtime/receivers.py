"""The GPS receivers: the first, and a second one that may stand beside it.

    gps    its fixes count
    gps2   its fixes count while the first has said none for FAILOVER, or is stuck: the last of the
           first's fixes are one place to the bit, those of the second are not

While both speak and are further apart than their noise explains, nothing says which of them is
right: what counts is taken to be as uncertain as they are apart, so that it may teach little, and
the gate for fixes judges it (R9). Without a second receiver every fix is passed on as it came.

What does not live here: sentences (protocol.nmea), what a fix proves (engine), the gate
(navigation).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import replace

from links.base import Rx
from mission.navigation.fixes import metres
from protocol.messages import Fix, FrameFault
from protocol.nmea import NmeaDecoder

GPS, GPS2 = "gps", "gps2"
RECEIVERS = (GPS, GPS2)
FAILOVER = 5.0  # s without a fix of the first
BESIDE = 2.0  # s between two fixes that are compared
_STUCK = 5  # fixes in a row
_SIGMAS, _LEAST, _FASTEST = 6.0, 3.0, 4.0  # of each noise; m, of a plain receiver's; m/s


class Receivers:
    def __init__(self) -> None:
        self._decoders = {name: NmeaDecoder() for name in RECEIVERS}
        self._last: dict[str, deque[Fix]] = {name: deque(maxlen=_STUCK) for name in RECEIVERS}

    def receive(self, rx: Rx) -> list[Fix | FrameFault]:
        """What counts of it."""
        return list(self._counted(rx.link, self._decoders[rx.link].receive(rx.data, rx.t)))

    def next_timer(self) -> float | None:
        dues = (decoder.next_timer() for decoder in self._decoders.values())
        return min((due for due in dues if due is not None), default=None)

    def flush(self, now: float) -> list[tuple[str, list[Fix | FrameFault]]]:
        """The same of what was waiting until now, by link."""
        return [
            (link, list(self._counted(link, decoder.flush(now))))
            for link, decoder in self._decoders.items()
            if (due := decoder.next_timer()) is not None and due <= now
        ]

    def _counted(self, link: str, heard: list[Fix | FrameFault]) -> Iterator[Fix | FrameFault]:
        for one in heard:
            if isinstance(one, Fix):
                self._last[link].append(one)
                if self._counts(link, one.t):
                    yield self._doubted(link, one)
            else:
                yield one

    def _counts(self, link: str, now: float) -> bool:
        first, second = (self._last[name] for name in RECEIVERS)
        alive = bool(first) and now - first[-1].t <= FAILOVER
        beside = bool(second) and now - second[-1].t <= FAILOVER
        failed = not alive or (beside and _stuck(first) and not _stuck(second))
        return failed is (link == GPS2) or (link == GPS and not beside)

    def _doubted(self, link: str, fix: Fix) -> Fix:
        """As uncertain as it is from the other's place, where that is too far."""
        others = self._last[GPS if link == GPS2 else GPS2]
        if not others or fix.t - others[-1].t > BESIDE or _stuck(others):
            return fix
        other = others[-1]
        apart = metres(fix.latitude, fix.longitude, other.latitude, other.longitude)
        noise = sum(_SIGMAS * max(one.accuracy, _LEAST) for one in (fix, other))
        if apart <= noise + _FASTEST * (fix.t - other.t):
            return fix
        return replace(fix, accuracy=max(fix.accuracy, apart))


def _stuck(fixes: deque[Fix]) -> bool:
    places = {(fix.latitude, fix.longitude) for fix in fixes}
    return len(fixes) == _STUCK and len(places) == 1
