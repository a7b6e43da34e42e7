"""The way between laptop and Pi: a cable that can be pulled, a radio that can be lost."""

from __future__ import annotations

import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from urllib.parse import urlsplit


class Cable:
    """Carries TCP to ``url``, each way in ``delay`` s. ``pull``: nothing passes any more, and nobody
    is told; ``lose``: all connections end at once, and none is made; ``plug``: both are over."""

    def __init__(self, url: str, delay: float = 0.0) -> None:
        self._delay = delay
        self._way: deque[tuple[float, socket.socket, bytes]] = deque()
        to = urlsplit(url)
        self._to = (str(to.hostname), int(to.port or 0))
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.url = f"tcp://127.0.0.1:{self._listening.getsockname()[1]}"
        self._selector = selectors.DefaultSelector()
        self._is_pulled = self._is_lost = self._is_over = False
        self._selector.register(self._listening, selectors.EVENT_READ)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def pull(self) -> None:
        self._is_pulled = True

    def lose(self) -> None:
        self._is_lost = True

    def plug(self) -> None:
        self._is_pulled = self._is_lost = False

    def close(self) -> None:
        self._is_over = True
        self._thread.join()
        for key in list(self._selector.get_map().values()):
            key.fileobj.close()  # type: ignore[union-attr]
        self._selector.close()

    def _run(self) -> None:
        while not self._is_over:
            if self._is_lost:
                self._end_all()
            for key, _ in self._selector.select(0.02):
                if key.fileobj is self._listening:
                    self._accept()
                elif not self._is_pulled:
                    self._carry(key.fileobj, key.data)  # type: ignore[arg-type]
            while self._way and self._way[0][0] <= time.monotonic():
                _, far, data = self._way.popleft()
                with suppress(OSError):
                    far.sendall(data)
            if self._is_pulled:
                threading.Event().wait(0.02)  # what waits, waits

    def _accept(self) -> None:
        near, _ = self._listening.accept()
        if self._is_lost:
            near.close()
            return
        far = socket.create_connection(self._to)
        self._selector.register(near, selectors.EVENT_READ, far)
        self._selector.register(far, selectors.EVENT_READ, near)

    def _carry(self, near: socket.socket, far: socket.socket) -> None:
        data = b""
        with suppress(OSError):
            data = near.recv(65536)
        if data:
            self._way.append((time.monotonic() + self._delay, far, data))
        else:
            self._end(near, far)

    def _end(self, *both: socket.socket) -> None:
        for one in both:
            with suppress(KeyError, ValueError):  # closed with the other end in the same round
                self._selector.unregister(one)
            one.close()

    def _end_all(self) -> None:
        for key in list(self._selector.get_map().values()):
            if key.fileobj is not self._listening:
                self._end(key.fileobj)  # type: ignore[arg-type]


@contextmanager
def cable(url: str, delay: float = 0.0) -> Iterator[Cable]:
    made = Cable(url, delay)
    try:
        yield made
    finally:
        made.close()
