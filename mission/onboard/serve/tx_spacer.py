"""The gap between two frames on a serial line, counted from when the first one really left.

    decided --(a disk that syncs, a busy Pi)--> left |==frame==|<- gap ->|==frame==|

The runtime reckons with the times of its inputs. A frame that left late would have the next one at
its heels, and the STM32 takes both for one burst and understands neither. So whoever writes to the
line keeps the gap, too: what comes too early waits here. X and W drop what waits (R7).

Sans-IO: times are given by who calls. What does not live here: when a frame is due (frontseat).
"""

from __future__ import annotations

from collections import deque

from protocol.topside import EMERGENCIES

BITS_PER_BYTE = 10  # 8N1
BAUD = 9600
WAITING = 32  # frames; the line has its own backlog, so more than a few never wait
_ORDERS = frozenset(EMERGENCIES.values())


class TxSpacer:
    """``gap``: s, 0 where frames need none."""

    def __init__(self, gap: float, baud: float) -> None:
        self._gap, self._seconds_per_byte = gap, BITS_PER_BYTE / baud
        self._free = float("-inf")  # from when on the line may be used
        self._waiting: deque[bytes] = deque(maxlen=WAITING)

    def leaving(self, data: bytes, now: float) -> list[bytes]:
        """What leaves now that this frame is to be sent; ``due`` has the rest."""
        if data in _ORDERS:
            self._waiting.clear()
        self._waiting.append(data)
        return self.due(now)

    def due(self, now: float) -> list[bytes]:
        """What has waited long enough; every frame, where none needs a gap."""
        out: list[bytes] = []
        while self._waiting and now >= self._free:
            frame = self._waiting.popleft()
            if self._gap:
                self._free = now + len(frame) * self._seconds_per_byte + self._gap
            out.append(frame)
        return out

    def clear(self) -> None:
        """Drops what waits: it would be out of date when the line is back."""
        self._waiting.clear()

    def next_event(self) -> float | None:
        return self._free if self._waiting else None
