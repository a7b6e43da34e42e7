"""A CAN bus and a serial line as one link, for a vehicle with a board on each.

    record of a CAN frame (identifier up to 7FF)  -->  bus
    all else                                      -->  line  -->  receive

The two ends, bus and line, are lost and reopened independently. If one is disconnected the other
continues, and bytes for the disconnected end are dropped. One end is enough to open the link; the
link closes when both are gone. A lost end counts as back once a send by it succeeds, because even
a bus that is down can be opened.

The link reads frames of other nodes from the bus and drops them: records and the line's bytes could
not be told apart in one stream. What does not live here: the boards' frames (protocol).
"""

from __future__ import annotations

import contextlib
import select
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

from links import open_link
from links.base import Link, LinkClosed, Rx

RETRY_S = 1.0
_LOOK_S = 0.1  # between two checks whether the thread has opened the end
_MOST = 0x07  # greatest first byte of a record


def is_of_bus(data: bytes) -> bool:
    """Whether sent data goes to the bus, not to the line."""
    return bool(data) and data[0] <= _MOST


def open_whole(name: str, url: str) -> Link:
    """Open a link as ``links.open_link`` does, but raise the error of an end that is missing."""
    link = open_link(name, url)
    if isinstance(link, JoinedLink) and link.away is not None:
        link.close()
        raise link.away
    return link


class _End:
    """One of the two ends. ``error``: why it is disconnected; None: it is not."""

    def __init__(self, open_it: Callable[[], Link], ready: select.epoll) -> None:
        self._open_it, self._ready = open_it, ready
        self._opening: Future[Link] | None = None
        self._due = 0.0
        self.link: Link | None = None
        self.error: OSError | None = None
        try:
            self._adopt(open_it())
        except OSError as error:
            self.error = error

    def receive(self, now: float) -> list[Rx]:
        try:
            if self.link is None:
                self._renew(now)
            return [] if self.link is None else self.link.receive(now)
        except OSError as error:
            self._lose(error, now)
            return []

    def send(self, data: bytes, now: float, address: str) -> None:
        if self.link is None:
            return
        try:
            self.link.send(data, now, address)
            self.error = None
        except OSError as error:
            self._lose(error, now)

    def next_event(self) -> float | None:
        return self._due if self.link is None else None

    def close(self) -> None:
        link, self.link = self.link, None
        if link is not None:
            with contextlib.suppress(OSError):
                link.close()
        if self._opening is not None:
            self._opening.add_done_callback(_close)

    def _adopt(self, link: Link) -> None:
        self.link = link
        if link.fileno() >= 0:
            self._ready.register(link.fileno(), select.EPOLLIN)

    def _renew(self, now: float) -> None:
        if now < self._due <= now + RETRY_S:  # later: the time restarted from 0, with a new engine
            return
        self._due = now + _LOOK_S
        if self._opening is None:
            self._opening = _by_thread(self._open_it)
        elif self._opening.done():
            opening, self._opening = self._opening, None
            self._adopt(opening.result())

    def _lose(self, error: OSError, now: float) -> None:
        self.close()
        self.error, self._due = error, now + RETRY_S


class JoinedLink:
    """The link of both ends. The constructor raises the bus's error if neither can be opened."""

    def __init__(
        self, name: str, open_bus: Callable[[], Link], open_line: Callable[[], Link]
    ) -> None:
        self.name, self._ready = name, select.epoll()
        self._bus, self._line = _End(open_bus, self._ready), _End(open_line, self._ready)
        if self._is_gone and self._bus.error is not None:
            self.close()
            raise self._bus.error

    @property
    def away(self) -> OSError | None:
        """Why an end is disconnected; None if none is."""
        return self._bus.error or self._line.error

    @property
    def _is_gone(self) -> bool:
        return self._bus.link is None and self._line.link is None

    def fileno(self) -> int:
        """A descriptor that is readable when either end is."""
        return -1 if self._ready.closed else self._ready.fileno()

    def receive(self, now: float) -> list[Rx]:
        self._bus.receive(now)
        heard = self._line.receive(now)
        self._check()
        return heard

    def send(self, data: bytes, now: float, address: str = "") -> None:
        end = self._bus if is_of_bus(data) else self._line
        end.send(data, now, address)
        self._check()

    def next_event(self) -> float | None:
        """When a disconnected end is next tried."""
        dues = (end.next_event() for end in (self._bus, self._line))
        return min((due for due in dues if due is not None), default=None)

    def close(self) -> None:
        self._bus.close()
        self._line.close()
        self._ready.close()

    def _check(self) -> None:
        if self._is_gone:
            raise LinkClosed(f"{self._bus.error}; {self._line.error}")


def _by_thread(open_it: Callable[[], Link]) -> Future[Link]:
    pool = ThreadPoolExecutor(1)
    opening = pool.submit(open_it)
    pool.shutdown(wait=False)
    return opening


def _close(opened: Future[Link]) -> None:
    if opened.exception() is None:
        opened.result().close()
