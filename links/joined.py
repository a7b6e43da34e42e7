"""A CAN bus and a serial line as one link, for a vehicle with a board on each.

    record of a CAN frame (identifier up to 7FF)  -->  bus
    all else                                      -->  line  -->  receive

What others say on the bus is taken from it and dropped: records and the line's bytes in one stream
could not be told apart. What does not live here: what the boards say (protocol).
"""

from __future__ import annotations

import select

from links.base import Link, Rx

_MOST = 0x07  # the first byte of a record at most


def is_of_bus(data: bytes) -> bool:
    """Whether what is sent goes to the bus, not to the line."""
    return bool(data) and data[0] <= _MOST


class JoinedLink:
    def __init__(self, name: str, bus: Link, line: Link) -> None:
        self.name, self._bus, self._line = name, bus, line
        self._both: select.epoll | None = None
        ends = [end.fileno() for end in (bus, line)]
        if min(ends) >= 0:
            self._both = select.epoll(len(ends))
            for fd in ends:
                self._both.register(fd, select.EPOLLIN)

    def fileno(self) -> int:
        """Readable where either is; -1 where one of them has to be asked."""
        return -1 if self._both is None or self._both.closed else self._both.fileno()

    def receive(self, now: float) -> list[Rx]:
        self._bus.receive(now)
        return self._line.receive(now)

    def send(self, data: bytes, now: float, address: str = "") -> None:
        end = self._bus if is_of_bus(data) else self._line
        end.send(data, now, address)

    def next_event(self) -> float | None:
        return None

    def close(self) -> None:
        if self._both is not None:
            self._both.close()
        self._bus.close()
        self._line.close()
