"""However long a mission takes to be judged, X and W leave, and everybody else is served."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from served import LINES, PATIENCE, Running, asked, read_now, running, silent_board, soon

from links.base import Rx
from mission.analysis.replay.replay import replay
from mission.model import Chart
from mission.model.vehicle import Vehicle
from mission.onboard.blackbox import read_parts
from mission.onboard.runtime import mission_validator
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.validation_queue import ValidationQueue
from protocol.messages import MissionLine
from protocol.topside import encode

FRAMES = [encode(MissionLine(len(LINES), i + 1, line)) for i, line in enumerate(LINES)]


class Thinking:
    """A judge that takes as long as the test wants."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.begun, self.over = threading.Event(), threading.Event()
        self.threads: list[str] = []
        self._really = mission_validator.judge
        monkeypatch.setattr(mission_validator, "judge", self._judge)

    def _judge(self, lines: tuple[str, ...], vehicle: Vehicle) -> Chart:
        self.threads.append(threading.current_thread().name)
        self.begun.set()
        assert self.over.wait(PATIENCE)
        return self._really(lines, vehicle)


@pytest.fixture
def thinking(monkeypatch: pytest.MonkeyPatch) -> Iterator[Thinking]:
    made = Thinking(monkeypatch)
    yield made
    made.over.set()


def boxes(pi: Running) -> list[Path]:
    assert pi.ready is not None
    return [Path(pi.ready.black_box)]


def test_orders_of_anybody_leave_and_others_are_served_while_a_mission_is_judged(
    tmp_path: Path, thinking: Thinking
) -> None:
    with silent_board() as (master, device), running(tmp_path, f"serial://{device}") as pi:
        with pi.boat() as boat, pi.boat() as other:
            for frame in FRAMES[:-1]:
                assert asked(boat, frame) == b"@ACK_AWW$"
            boat.sendall(FRAMES[-1])
            assert thinking.begun.wait(PATIENCE)
            assert asked(other, b"@DU$").startswith(b"@VS")
            for who, order in ((other, b"@ZAX0$"), (boat, b"@ZAWF$")):
                who.sendall(order)
                heard = bytearray()

                def left(order: bytes = order, heard: bytearray = heard) -> bool:
                    heard.extend(read_now(master))
                    return order in heard

                soon(left, order.decode())
            thinking.over.set()
            told = asked(boat, b"@NI$", until=b"@ACK_NI\x23$")
            assert told.endswith(b"@ACK_AWN$@ACK_NI\x23$"), "in idle only"
            assert len(thinking.threads) == 1
            assert thinking.threads != [pi.thread.name]
        assert pi.store.content.lines == ()
    assert all(replay(list(read_parts(box))).identical for box in boxes(pi))


def test_a_mission_that_is_judged_is_stored_and_what_came_after_it_is_heard(
    tmp_path: Path, thinking: Thinking
) -> None:
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        with pi.boat() as boat:
            boat.sendall(b"".join(FRAMES) + b"@AQ$")
            assert thinking.begun.wait(PATIENCE)
            boat.sendall(b"@NI$")
        soon(lambda: pi.has_told("is gone"), "it hangs up")
        assert pi.server is not None
        thinking.over.set()
        soon(lambda: pi.store.content.lines == tuple(LINES), "stored")
        soon(lambda: not pi.server.validation.gone, "and let go")
        with pi.boat() as boat:
            assert asked(boat, b"@AQ$").startswith(b"@AR,ready")
    assert all(replay(list(read_parts(box))).identical for box in boxes(pi))


def test_an_order_that_overtook_is_not_given_again(thinking: Thinking) -> None:
    passed: list[bytes] = []
    jobs = []

    class Foreseeing:
        def foresee(self, rx: Rx) -> tuple[str, ...]:
            return ("a line",)

    queue = ValidationQueue(lambda rx: passed.append(rx.data), jobs.append)
    runtime: Runtime = Foreseeing()  # type: ignore[assignment]
    queue.hear(Rx(0.0, "topside", b"@AW", "a:1"), runtime)
    queue.hear(Rx(0.1, "topside", b"@DU$@ZAX0$@NI$", "a:1"), runtime)
    assert [data.strip(b"\xff") for data in passed] == [b"@ZAX0$"]
    held = queue.held["topside", "a:1"]
    assert b"ZAX0" not in b"".join(rx.data for rx in held)
    assert held[1].data.startswith(b"@DU$")
    assert held[1].data.endswith(b"@NI$")
    jobs[0].close()
