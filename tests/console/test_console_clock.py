"""The age of what is shown is the vehicle's, also where the way is long and thin."""

from __future__ import annotations

import socket
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from console_world import Page, console_of, monitor_of
from served import running, silent_board

from mission.console.clock import KEPT_S, VehicleClock

BYTES_S, LATENCY_S = 1500.0, 1.0  # 12 kbit/s


def test_what_was_long_on_its_way_is_known_to_be_old() -> None:
    clock = VehicleClock()
    clock.hear((100.0, 10.1))  # 0.1 s on its way
    clock.hear((101.0, 14.0))  # 3 s
    assert abs(clock.now(14.0) - 103.9) < 1e-9


def test_it_goes_on_between_two_frames_and_begins_anew_with_the_vehicle() -> None:
    clock = VehicleClock(2.0)
    assert clock.now(5.0) == 0.0
    clock.hear((100.0, 10.0))
    assert clock.now(11.0) == 102.0
    clock.hear((0.5, 12.0))
    assert clock.now(12.0) == 0.5


def test_a_clock_that_drifts_is_followed() -> None:
    clock = VehicleClock()
    for minute in range(10):  # the vehicle's is 1 % slow
        clock.hear((59.4 * minute, 60.0 * minute + 0.01))
    assert abs(clock.now(540.0) - 59.4 * 9) < 0.03 * KEPT_S


@contextmanager
def thin(port: int) -> Iterator[int]:
    """A way to a port of this computer: so many bytes a second, so late."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        over = threading.Event()

        def carry(source: socket.socket, sink: socket.socket) -> None:
            waiting: deque[tuple[float, bytes]] = deque()
            free = time.monotonic()
            source.settimeout(0.02)
            while not over.is_set():
                try:
                    if len(waiting) < 8 and not (data := source.recv(256)):
                        return
                    if len(waiting) < 8:
                        free = max(free, time.monotonic()) + len(data) / BYTES_S
                        waiting.append((free + LATENCY_S, data))
                except TimeoutError:
                    pass
                except OSError:
                    return
                while waiting and waiting[0][0] <= time.monotonic():
                    sink.sendall(waiting.popleft()[1])

        def meet() -> None:
            listening.settimeout(0.1)
            while not over.is_set():
                try:
                    near, _ = listening.accept()
                except TimeoutError:
                    continue
                far = socket.create_connection(("127.0.0.1", port))
                opened.extend((near, far))
                for ends in ((near, far), (far, near)):
                    carriers.append(threading.Thread(target=carry, args=ends))
                    carriers[-1].start()

        opened: list[socket.socket] = []
        carriers: list[threading.Thread] = []
        meeting = threading.Thread(target=meet)
        meeting.start()
        try:
            yield int(listening.getsockname()[1])
        finally:
            over.set()
            for thread in (meeting, *carriers):
                thread.join()
            for end in opened:
                end.close()


def test_behind_a_thin_link_the_age_that_is_told_is_true(tmp_path: Path) -> None:
    with (
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}", monitor="tcp://127.0.0.1:0") as pi,
        thin(int(monitor_of(pi).rpartition(":")[2])) as port,
        console_of(pi.url, tmp_path, f"tcp://127.0.0.1:{port}") as (console, _),
        console.socket("frames") as frames,
    ):
        page = Page(frames)
        page.until(lambda s: s.get("state") == "idle/empty", "the state")
        assert pi.server is not None
        lags = []
        for _ in range(15):
            page.take()
            lags.append(pi.server.now() - page.t)
        assert max(lags) < LATENCY_S + 2.0
        assert max(lags) - min(lags) < 1.0  # it does not grow
