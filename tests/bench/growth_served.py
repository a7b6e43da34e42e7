"""One `serve` in a mission, with so many boats that ask or viewers who look on (bench_growth)."""

from __future__ import annotations

import os
import selectors
import socket
import statistics
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from bench_latency import Board, serving
from bench_viewers import NUMBER, fly_on, orders_of
from ports import free_port

from links.admission import PER_SECOND
from mission.topside.monitor import wish

MEASURED_S, SETTLE_S = 10, 3
TICKS = os.sysconf("SC_CLK_TCK")
Turn = Callable[[list[socket.socket]], None]
Hear = Callable[[socket.socket, bytes], None]
PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 2**20


def served(boats: int, viewers: int) -> tuple[float, float, float]:
    """% of a core, MB, and the median ms from an X of one more boat to its first byte at the board."""
    with tempfile.TemporaryDirectory() as name:
        board, folder, monitor = Board(), Path(name), free_port()
        most = f"?connections={boats + viewers + 8}&each={boats + viewers + 8}"
        (folder / "serve.yaml").write_text(
            f"links: {{monitor: 'tcp-listen://127.0.0.1:{monitor}{most}'}}\n"
        )
        words = (f"--config={folder / 'serve.yaml'}", f"--topside=tcp://127.0.0.1:0{most}")
        with serving(board, folder, *words) as (pid, address):
            fly_on(board, address)
            port = int(address.rpartition(":")[2])
            with asking(port, boats), looking_on(monitor, viewers):
                spent, memory = _watched(board, pid)
                orders = orders_of(board, address)
        board.close()
    return spent, memory, 1e3 * statistics.median(orders)


def _watched(board: Board, pid: int) -> tuple[float, float]:
    """A report every 2 s and a fix every second."""
    begun = spent = 0.0
    for second in range(SETTLE_S + MEASURED_S):
        if second == SETTLE_S:
            begun, spent = time.monotonic(), _spent(pid)
        board.fix()
        if second % 2 == 0:
            board.report(90.0)
        until = time.monotonic() + 1.0
        while (left := until - time.monotonic()) > 0:
            board.listen(left)
    share = 100 * (_spent(pid) - spent) / (time.monotonic() - begun)
    return share, int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * PAGE_MB


def _spent(pid: int) -> float:
    """s of processor, of another process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


@contextmanager
def asking(port: int, count: int) -> Iterator[None]:
    """So many boats, each of which asks how the vehicle is once a second."""

    def turn(sockets: list[socket.socket]) -> None:
        for one in sockets:
            one.sendall(b"@AE$")

    with _crowd(port, count, turn, lambda one, data: None):
        yield


@contextmanager
def looking_on(port: int, count: int) -> Iterator[None]:
    """So many viewers who wish for everything, and answer each frame at once."""
    heard: dict[socket.socket, bytes] = {}

    def answer(one: socket.socket, data: bytes) -> None:
        *lines, heard[one] = (heard.get(one, b"") + data).split(b"\n")
        for line in lines:
            if found := NUMBER.search(line):
                one.sendall(b'{"ack":%s}\n' % found[1])

    with _crowd(port, count, lambda sockets: None, answer, wish()):
        yield


@contextmanager
def _crowd(port: int, count: int, turn: Turn, hear: Hear, first: bytes = b"") -> Iterator[None]:
    """So many connections that say ``first``: ``turn`` once a second, ``hear`` of what comes. What
    breaks one of them is raised."""
    over = threading.Event()
    sockets = [_connected(port, first) for _ in range(count)]
    with ThreadPoolExecutor(1) as thread:
        talk = thread.submit(_talk, sockets, turn, hear, over)
        try:
            yield
        finally:
            over.set()
        talk.result()
    for one in sockets:
        one.close()


def _connected(port: int, first: bytes) -> socket.socket:
    """An address may connect ten times a second for long (links.admission)."""
    time.sleep(1.0 / PER_SECOND)
    one = socket.create_connection(("127.0.0.1", port))
    one.sendall(first)
    return one


def _talk(sockets: list[socket.socket], turn: Turn, hear: Hear, over: threading.Event) -> None:
    with selectors.DefaultSelector() as ready:
        for one in sockets:
            ready.register(one, selectors.EVENT_READ, one)
        due = time.monotonic()
        while not over.is_set():
            if time.monotonic() >= due:
                due += 1.0
                turn(sockets)
            for key, _ in ready.select(0.05):
                data = key.data.recv(65536)
                if not data:
                    raise ConnectionError("serve has closed a connection")
                hear(key.data, data)
