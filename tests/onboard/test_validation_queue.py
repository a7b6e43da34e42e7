"""However long a mission takes to be judged, X and W leave, and everybody else is served."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine, Iterator
from pathlib import Path

import pytest
from served import LINES, PATIENCE, Running, asked, read_now, running, silent_board, soon

from links.base import Rx
from mission.analysis.replay.replay import replay
from mission.model import Chart
from mission.model.regions import EMERGENCY, IDLE
from mission.model.vehicle import Vehicle
from mission.onboard.blackbox import read_parts
from mission.onboard.runtime import mission_validator
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.rate_limiter import BREAK
from mission.onboard.serve.validation_queue import MISSED, ValidationQueue
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


class Pi:
    """A queue whose first read is always judged, and a runtime that knows X and W alone."""

    def __init__(self, **tolerances: str) -> None:
        self.region, self.passed = IDLE, list[Rx]()
        self.jobs: list[Coroutine[None, None, None]] = []
        self.queue = ValidationQueue(self._pass_on, self.jobs.append, tolerances)

    @property
    def engine(self) -> Pi:
        return self

    def foresee(self, rx: Rx) -> tuple[str, ...]:
        return ("a line",) if rx.data.startswith(b"@AW") else ()

    def hear(self, t: float, data: bytes, address: str = "a:1") -> None:
        runtime: Runtime = self  # type: ignore[assignment]
        self.queue.hear(Rx(t, "topside", data, address), runtime)

    def heard(self) -> list[tuple[float, bytes]]:
        said, self.passed = self.passed, []
        return [(rx.t, rx.data.strip(b"\xff")) for rx in said if rx.data.strip(b"\xff")]

    def _pass_on(self, rx: Rx) -> None:
        self.passed.append(rx)
        if b"@ZA" in rx.data and rx.data.endswith(b"$"):
            self.region = EMERGENCY


@pytest.fixture
def judging() -> Iterator[Pi]:
    """From 0.0 on the line of ``a:1``."""
    pi = Pi()
    pi.hear(0.0, b"@AW")
    yield pi
    for job in pi.jobs:
        job.close()


def test_an_order_overtakes_what_is_held_once_and_what_stood_before_it_is_dropped(
    judging: Pi,
) -> None:
    judging.hear(0.1, b"@DU$")
    assert judging.heard() == []
    judging.hear(0.2, b"@AC$@ZAX0$@NI$")
    order, *held = judging.heard()
    assert order == (0.2, b"@ZAX0$")
    assert held == [(0.0, b"@AW"), (0.1, b"@DU$"), (0.2, b"@NI$")]


def test_an_order_in_the_read_of_a_last_line_leaves_and_nothing_is_held(judging: Pi) -> None:
    """A link that stalled brings both at once."""
    judging.hear(1.0, b"@AW1,1,a$@ZAX0$@DU$", "b:2")
    assert judging.heard()[0] == (1.0, b"@ZAX0$@DU$")
    assert ("topside", "b:2") not in judging.queue.held


def test_an_order_that_comes_in_pieces_overtakes_with_the_last_of_them(judging: Pi) -> None:
    for t, piece in ((0.1, b"@"), (0.2, b"ZA"), (0.3, b"F"), (0.4, b"@ZAW"), (0.5, b"F0")):
        judging.hear(t, piece)
    assert judging.heard() == []
    judging.hear(0.6, b"$@ZA")
    judging.hear(0.7, b"WF$")
    assert judging.heard()[0] == (0.7, b"@ZAWF$")


@pytest.mark.parametrize("nested", ["on", "off"])
@pytest.mark.parametrize("held", [True, False])
def test_an_order_within_a_line_of_a_mission_is_none_where_lines_are_frames(
    nested: str, held: bool
) -> None:
    pi = Pi(aw_nested=nested)
    if held:
        pi.hear(0.0, b"@AW0301ZAF5$")
    pi.hear(0.1, b"@AW0302@ZAWF$")
    passed = pi.heard()
    pi.hear(0.2, b"@ZAX0$")
    for job in pi.jobs:
        job.close()
    assert passed[:1] == ([] if nested == "on" else [(0.1, b"@ZAWF$")])
    assert pi.heard()[0] == (0.2, b"@ZAX0$")


def test_what_is_held_goes_on_as_soon_as_another_stops_the_vehicle(judging: Pi) -> None:
    judging.hear(0.1, b"@MMF5$")
    judging.hear(0.2, b"@DU$", "b:2")
    assert judging.heard() == [(0.2, b"@DU$")]
    judging.hear(0.3, b"@ZAX0$", "b:2")
    assert judging.heard() == [(0.3, b"@ZAX0$"), (0.0, b"@AW"), (0.1, b"@MMF5$")]
    judging.hear(0.4, b"@MMF5$")
    assert judging.heard() == [(0.4, b"@MMF5$")], "at once from then on"


def test_a_verdict_lets_go_only_what_was_held_for_it(judging: Pi) -> None:
    judging.hear(0.1, b"@ZAX0$", "b:2")
    judging.region = IDLE
    judging.hear(0.2, b"@AW again")
    judging.heard()
    asyncio.run(judging.jobs[0])
    assert judging.heard() == []
    asyncio.run(judging.jobs[1])
    assert judging.heard() == [(0.2, b"@AW again")]


def test_of_what_comes_while_there_is_no_runtime_its_orders_alone_wait_for_the_next_one() -> None:
    queue = Pi().queue
    queue.miss(Rx(1.0, "topside", b"@AA$@ZAX0$@MMF5$", "a:1"))
    queue.miss(Rx(1.1, "modem", b"#\x02\x0c\x00\x01@AQ$@ZAWF$"))
    queue.miss(Rx(1.2, "topside", b"@AC$", "b:2"))
    assert queue.take_missed(0.5) == [
        Rx(0.5, "topside", BREAK + b"@ZAX0$", "a:1"),
        Rx(0.5, "modem", BREAK + b"@ZAWF$"),
    ]
    assert queue.take_missed(0.6) == [], "they are heard once"


def test_an_order_in_two_reads_is_one_while_there_is_no_runtime_and_as_that_begins() -> None:
    queue = Pi().queue
    for data in (b"@AA$@ZA", b"X0$@AC$", b"@NI$@Z"):
        queue.miss(Rx(1.0, "topside", data, "a:1"))
    queue.miss(Rx(1.0, "topside", b"no order, and no frame", "b:2"))
    assert queue.take_missed(0.5) == [
        Rx(0.5, "topside", BREAK + b"@ZAX0$", "a:1"),
        Rx(0.5, "topside", b"@Z", "a:1"),
    ]
    assert queue.take_missed(0.6) == []


def test_of_many_orders_while_there_is_no_runtime_the_newest_wait() -> None:
    queue = Pi().queue
    for i in range(MISSED + 5):
        queue.miss(Rx(1.0, "topside", b"@ZAX0$", f"a:{i}"))
    queue.miss(Rx(1.0, "topside", b"@ZAX0$" * (MISSED - 1) + b"@ZAWF$", "b:2"))
    kept = queue.take_missed(0.5)
    assert len(kept) == MISSED == 16
    assert {rx.address for rx in kept} == {"b:2"}
    assert kept[-1].data == BREAK + b"@ZAWF$"
