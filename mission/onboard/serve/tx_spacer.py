"""The gap between two frames on a serial line, counted from when the first one really left.

    decided --(a disk that syncs, a busy Pi)--> left |==frame==|<- gap ->|==frame==|

The runtime plans with the times of its inputs. After a frame that left late the next one would
follow too closely, and the STM32 would take both for one burst and understand neither. So the
writer of the line keeps the gap, too: a frame that comes too early waits here. X and W drop the
frames that wait (R7).

Sans-IO: the caller gives the times. What does not live here: when a frame is due (frontseat).
"""

from __future__ import annotations

from collections import deque

from protocol.topside import EMERGENCIES

BITS_PER_BYTE = 10  # 8N1
BAUD = 9600
WAITING = 32  # frames; the frontseat has a queue of its own, so only a few ever wait
_ORDERS = frozenset(EMERGENCIES.values())


class TxSpacer:
    """``gap``: s, 0 where frames need none."""

    def __init__(self, gap: float, baud: float) -> None:
        self._gap, self._seconds_per_byte = gap, BITS_PER_BYTE / baud
        self._free = float("-inf")  # when the line is free
        self._waiting: deque[bytes] = deque(maxlen=WAITING)

    def leaving(self, data: bytes, now: float) -> list[bytes]:
        """Queue this frame; return the frames that leave now. ``due`` returns the rest."""
        if data in _ORDERS:
            self._waiting.clear()
        self._waiting.append(data)
        return self.due(now)

    def due(self, now: float) -> list[bytes]:
        """Return the frames that have waited long enough; all, if they need no gap."""
        out: list[bytes] = []
        while self._waiting and now >= self._free:
            frame = self._waiting.popleft()
            if self._gap:
                self._free = now + len(frame) * self._seconds_per_byte + self._gap
            out.append(frame)
        return out

    def clear(self) -> None:
        """Drop the frames that wait: they would be stale when the line is back."""
        self._waiting.clear()

    def next_event(self) -> float | None:
        return self._free if self._waiting else None
