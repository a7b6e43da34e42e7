"""Many pages, a thin link, a whole day: what is shown stays true, and nothing grows."""

from __future__ import annotations

import itertools
import json
import random
from collections import deque
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from console_world import Page, cockpit
from served import soon

from mission.console.board import Board
from mission.console.clock import VehicleClock
from mission.console.vehicle import FRAME
from mission.model.past import NAMES, ROWS
from mission.onboard.serve.monitor import EVENTS as WAITING
from mission.onboard.serve.monitor import TRACK as THINNED
from mission.onboard.serve.monitor import Monitor
from mission.topside.monitor import EVENTS, Watched, wish

BYTES_S, LATENCY_S = 1500.0, 2.0  # 12 kbit/s, one way
LOST, AGAIN_S = 0.2, 1.0  # TCP says it again, and what follows waits
STEP_S, STEPS = 0.05, 6000
BEGAN = 1000.0
DRAWS = range(3)
DAY_S, EVERY_S = 86_400, 20  # 4320 frames


class Way:
    """Bytes one way, in their order: so thin, so long, so bad."""

    def __init__(self, seed: int) -> None:
        self._waiting: deque[tuple[float, bytes]] = deque()
        self._free, self._draw = 0.0, random.Random(seed)

    def send(self, data: bytes, now: float) -> None:
        again = AGAIN_S if self._draw.random() < LOST else 0.0
        self._free = max(self._free, now) + len(data) / BYTES_S + again
        self._waiting.append((self._free + LATENCY_S, data))

    def take(self, now: float) -> bytes:
        found = b""
        while self._waiting and self._waiting[0][0] <= now:
            found += self._waiting.popleft()[1]
        return found


def seen(t: float) -> dict[str, Any]:
    """A state of which all is new, as large as the real one."""
    told = {name: round(t + n / 7, 3) for n, name in enumerate(NAMES)}
    more = {f"value_{n:02}": round(t + n / 7, 3) for n in range(40 - len(told))}
    return {"report_at": round(t, 2), **told, **more}


class Probe:
    """The link's own: 20 bytes, asked for and answered, and again."""

    def __init__(self, seed: int) -> None:
        self._down, self._up = Way(seed), Way(seed + 100)
        self._asked: float | None = None
        self.took: list[float] = []

    def step(self, now: float) -> None:
        if self._asked is None:
            self._asked = now
            self._down.send(b"?" * 20, now)
        if heard := self._down.take(now):
            self._up.send(heard, now)
        if self._up.take(now):
            self.took.append(now - self._asked)
            self._asked = None


class Behind:
    """A vehicle, seen on one page behind such a link. ``ages``: told and true, of each frame on the
    page; ``on_screen``: true, at every step."""

    def __init__(self, seed: int) -> None:
        self._down, self._up = Way(seed), Way(seed + 100)
        self._monitor, self.watched, self._board = Monitor(), Watched(), Board()
        self._clock, self._shown = VehicleClock(), dict[str, Any]()
        self.ages, self.on_screen = list[tuple[float, float]](), list[float]()
        for n in range(WAITING):  # what happened before anybody looked
            self._happens(float(n))
            self._monitor.past.take(seen(float(n)))
        self._monitor.connected("console", 0.0)
        self._monitor.receive("console", wish(most=FRAME, past="before"), 0.0)
        self._board.come("page", 0.0)

    def _happens(self, t: float) -> None:
        self._monitor.event(f"{t:.1f} s info: on to the next row of the survey: the last is done")
        self._monitor.track.add(t, 60.0 + t * 1e-5, 25.0, 3.0)

    def step(self, now: float) -> None:
        t = BEGAN + now  # the vehicle's own, which nobody on the boat knows
        if round(now / STEP_S) % 20 == 0:
            self._happens(t)
        self._monitor.receive("console", self._up.take(now), now)
        if "console" in self._monitor.due(now):
            self._down.send(self._monitor.frame("console", seen(t), t, now), now)
        _, answers = self.watched.receive(self._down.take(now), now)
        if answers:
            self._up.send(answers, now)
        if self.watched.at is not None:
            self._clock.hear(self.watched.at)
            if self._board.is_due("page", now):
                self._show(t, now)
        if self._shown:
            self.on_screen.append(t - self._shown["report_at"])

    def _show(self, t: float, now: float) -> None:
        told = {**self.watched.state, "wall": int(now)}
        if frame := self._board.frame("page", self.watched, told, self._clock.now(now), now):
            said = json.loads(frame)
            self._board.answer("page", said["n"], now)
            self._shown |= said["state"]
            at = self._shown["report_at"]
            self.ages.append((said["t"] - at, t - at))


@pytest.fixture(scope="module")
def own() -> float:
    """s that an answer of 20 bytes takes at most, on the links of this test."""
    probes = [Probe(seed) for seed in DRAWS]
    for probe, step in itertools.product(probes, range(STEPS)):
        probe.step(step * STEP_S)
    return max(max(probe.took) for probe in probes)


@pytest.mark.parametrize("seed", DRAWS)
def test_behind_a_slow_and_bad_link_the_age_on_the_screen_is_true_and_bounded(
    seed: int, own: float
) -> None:
    page = Behind(seed)
    for step in range(STEPS):
        page.step(step * STEP_S)
    told_ages, true_ages = zip(*page.ages[20:], strict=True)
    least = LATENCY_S + 200 / BYTES_S  # what even the quickest frame takes nobody can know
    assert len(page.ages) > 250
    assert all(-0.01 <= true - told <= least + 1.0 for told, true in page.ages[20:])
    assert max(page.on_screen) <= own + 2.0
    half = len(true_ages) // 2
    assert max(true_ages[half:]) <= max(true_ages[:half]) + 2 * AGAIN_S  # it does not grow
    assert max(told_ages) > LATENCY_S  # and is not hidden
    assert page.watched.told >= WAITING + STEPS * STEP_S - 20  # and nothing is left out for it


def test_five_tabs_are_one_viewer_and_one_asker_for_the_vehicle(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, vehicle), ExitStack() as open_:
        assert pi.server is not None
        assert pi.server.viewing is not None
        monitor = pi.server.viewing.monitor
        pages = [Page(open_.enter_context(console.socket("frames"))) for _ in range(5)]
        for page in pages:
            page.until(lambda s: s.get("state"), "the state")
        soon(lambda: vehicle.commands.silence(0.0) is not None, "the line of commands")
        assert vehicle.board.pages == 5
        assert len(monitor.viewers) == 1


def test_a_tab_costs_a_frame_for_each_change_and_none_while_nothing_is_new() -> None:
    board, watched = Board(), Watched()
    watched.take({"n": 1, "t": 0.0, "state": {"depth": 3.0}}, 0.0)
    pages = [f"page {n}" for n in range(5)]
    for page in pages:
        board.come(page, 0.0)
    made = dict.fromkeys(pages, 0)
    for step in range(200):  # 10 s, twenty looks a second
        now = step * 0.05
        for page in pages:
            told = {**watched.state, "wall": int(now)}
            if board.is_due(page, now) and (line := board.frame(page, watched, told, now, now)):
                made[page] += 1
                board.answer(page, json.loads(line)["n"], now)
    assert made == dict.fromkeys(pages, 10)


@pytest.mark.proof
def test_a_day_of_frames_leaves_no_more_than_the_bounds() -> None:
    monitor, watched, board, clock = Monitor(), Watched(), Board(), VehicleClock()
    monitor.connected("console", 0.0)
    monitor.receive("console", wish(), 0.0)
    board.come("looks", 0.0)
    board.come("sleeps", 0.0)
    for t in range(0, DAY_S, EVERY_S):
        monitor.event(f"{t} s info: now here")
        monitor.track.add(t, 60.0 + t * 1e-7, 25.0, 3.0)
        line = monitor.frame("console", {"report_at": t, "depth": t % 7}, t, t)
        _, answers = watched.receive(line, t)
        monitor.receive("console", answers, t)
        clock.hear((float(t), float(t)))
        for page in ("looks", "sleeps"):
            if board.is_due(page, t):
                said = board.frame(page, watched, watched.state, clock.now(t), t)
                if page == "looks" and said:
                    board.answer(page, json.loads(said)["n"], t)
    assert watched.told == DAY_S // EVERY_S
    assert len(watched.events) == EVENTS
    assert len(monitor.track.points) <= THINNED
    assert len(watched.past.rows) <= ROWS
    assert watched.past.rows[0][0] == 0
    board.answer("sleeps", 1, DAY_S)
    said = json.loads(board.frame("sleeps", watched, watched.state, float(DAY_S), DAY_S))
    told = len(said["events"])
    assert said["gap"] + told >= DAY_S // EVERY_S - WAITING  # what it missed is counted, not kept
    assert told <= WAITING
