"""A CAN bus and a serial line as one link: each gets its own bytes, and both wake the reader."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from served import running, silent_board, soon

from links import LinkAddressError, check_url, open_link
from links.base import LinkAbsent, LinkClosed, Rx
from links.joined import RETRY_S, JoinedLink, open_whole
from mission.model.shipped import load_vehicle
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve import ports
from mission.onboard.serve import serve as shell
from protocol.messages import Setpoint
from protocol.vehicles import codec, link


class End:
    """One of the two, on a pipe."""

    def __init__(self) -> None:
        self.out, self.into = os.pipe()
        os.set_blocking(self.out, False)
        self.said: list[bytes] = []
        self.closed = self.is_gone = False

    def fileno(self) -> int:
        return self.out

    def receive(self, now: float) -> list[Rx]:
        self._check()
        try:
            return [Rx(now, "vehicle", os.read(self.out, 100))]
        except BlockingIOError:
            return []

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._check()
        self.said.append(data)

    def _check(self) -> None:
        if self.is_gone:
            raise LinkClosed("it went away")

    def next_event(self) -> float | None:
        return None

    def close(self) -> None:
        if not self.closed:
            os.close(self.out)
            os.close(self.into)
        self.closed = True


def test_force_and_torque_go_to_the_bus_and_the_rest_to_the_line() -> None:
    bus, line = End(), End()
    both = JoinedLink("vehicle", lambda: bus, lambda: line)
    for frame in codec("mainboard", "documented", {}).encode(Setpoint(surge=0.5)):
        both.send(frame, 0.0)
    assert [data[:2] for data in bus.said] == [b"\x00\x01", b"\x00\x02"]
    assert len(line.said) == 1
    (told,) = link("coreboard.main_to_sensor").framer().receive(line.said[0], 0.0)
    assert told.values()["depth"] == 1  # type: ignore[union-attr]
    both.close()
    assert bus.closed
    assert line.closed
    assert both.fileno() == -1


@pytest.mark.parametrize("speaks", [0, 1])
def test_who_waits_for_it_wakes_for_either_and_hears_the_line_alone(speaks: int) -> None:
    ends = End(), End()
    both = JoinedLink("vehicle", *(lambda end=end: end for end in ends))  # type: ignore[misc]
    assert not select.select([both.fileno()], [], [], 0.0)[0]
    os.write(ends[speaks].into, b"\x00\x01\x00")
    assert select.select([both.fileno()], [], [], 1.0)[0]
    assert [rx.data for rx in both.receive(1.0)] == [b"\x00\x01\x00"][:speaks]
    assert not select.select([both.fileno()], [], [], 0.0)[0], "nothing is left to be read"
    both.close()


def test_a_bus_may_name_the_line_of_its_sensor_board_and_one_of_them_is_enough_to_open(
    tmp_path: Path,
) -> None:
    bus = "can://test?interface=virtual"
    with silent_board() as (_, device):
        made = open_whole("vehicle", f"{bus}&sensors={device}")
        assert isinstance(made, JoinedLink)
        made.close()
        alone = f"can://none0?sensors={device}"
        open_link("vehicle", alone).close()
        with pytest.raises(LinkAbsent, match="none0"):
            open_whole("vehicle", alone)
        open_link("vehicle", f"serial://{device}").close()  # it was left as it was
    gone = tmp_path / "gone"
    open_link("vehicle", f"{bus}&sensors={gone}").close()
    with pytest.raises(LinkAbsent, match="gone"):
        open_whole("vehicle", f"{bus}&sensors={gone}")
    with pytest.raises(LinkAbsent):
        open_link("vehicle", f"can://none0?sensors={gone}")
    with pytest.raises(LinkAddressError, match="baud"):
        check_url(f"{bus}&sensors=/dev/ttyUSB1&baud=fast")


# --- an end that is away -------------------------------------------------------------------------

TO_BUS, TO_LINE = b"\x00\x01\x00", b"\xffline"


class Plug:
    """One of the two as it is opened: an end each time, or an error while it is out."""

    def __init__(self) -> None:
        self.ends: list[End] = []
        self.is_out = False

    def __call__(self) -> End:
        if self.is_out:
            raise LinkAbsent("it is out")
        self.ends.append(End())
        return self.ends[-1]

    @property
    def said(self) -> list[bytes]:
        return self.ends[-1].said

    def pull(self) -> None:
        self.is_out = self.ends[-1].is_gone = True


def until(link: JoinedLink, now: float, is_so: Callable[[], bool]) -> float:
    """Looks as often as the link asks for it; returns when it was so."""
    for _ in range(1000):
        due = link.next_event()
        now = now if due is None else max(now, due)
        link.receive(now)
        if is_so():
            return now
        time.sleep(0.001)  # a thread opens it
    raise AssertionError("it never was so")


@pytest.mark.parametrize("lost", [0, 1], ids=["bus", "line"])
def test_an_end_that_is_lost_is_opened_again_while_the_other_goes_on(lost: int) -> None:
    plugs, words = (Plug(), Plug()), (TO_BUS, TO_LINE)
    gone, stays = plugs[lost], plugs[1 - lost]
    both = JoinedLink("vehicle", *plugs)
    gone.pull()
    for word in words * 2:
        both.send(word, 1.0)
    assert (gone.said, stays.said) == ([], [words[1 - lost]] * 2)
    assert both.away is not None
    os.write(stays.ends[-1].into, b"?")
    assert select.select([both.fileno()], [], [], 1.0)[0]
    assert len(both.receive(1.0)) == lost ^ 1
    assert until(both, 1.0, lambda: str(both.away) == "it is out") >= 1.0 + RETRY_S
    gone.is_out = False
    now = until(both, 3.0, lambda: len(gone.ends) == 2 and both.next_event() is None)
    assert both.away is not None, "nothing was sent by it yet"
    both.send(words[lost], now)
    assert (gone.said, both.away) == ([words[lost]], None)
    os.write(gone.ends[-1].into, b"?")
    assert select.select([both.fileno()], [], [], 1.0)[0]
    both.close()


@pytest.mark.parametrize("lost", [0, 1], ids=["bus", "line"])
def test_an_end_that_is_lost_is_found_though_time_begins_anew(lost: int) -> None:
    """Behind a fault of the program the engine counts from 0 again, and the link lives on."""
    plugs = Plug(), Plug()
    both = JoinedLink("vehicle", *plugs)
    plugs[lost].pull()
    for word in (TO_BUS, TO_LINE) * 2:
        both.send(word, 3600.0)
    assert both.away is not None
    plugs[lost].is_out = False
    now = 0.0
    while len(plugs[lost].ends) < 2 and now < 10.0 * RETRY_S:
        now += 0.1  # the other end has something to say so often
        both.receive(now)
        time.sleep(0.005)  # a thread opens it
    assert len(plugs[lost].ends) == 2
    both.close()


def test_it_is_closed_when_both_are_gone() -> None:
    bus, line = Plug(), Plug()
    both = JoinedLink("vehicle", bus, line)
    bus.pull()
    both.send(TO_BUS, 1.0)
    line.pull()
    with pytest.raises(LinkClosed):
        both.receive(1.0)
    both.close()
    with pytest.raises(LinkAbsent):
        JoinedLink("vehicle", bus, line)
    line.is_out = False
    JoinedLink("vehicle", bus, line).close()


def test_what_a_thread_opens_for_a_link_that_was_closed_is_closed() -> None:
    bus, line = Plug(), Plug()
    both = JoinedLink("vehicle", bus, line)
    line.pull()
    both.receive(1.0)
    line.is_out = False
    both.receive(1.0 + RETRY_S)  # from here on a thread opens it
    both.close()
    for _ in range(1000):
        if len(line.ends) == 2 and line.ends[-1].closed:
            break
        time.sleep(0.001)
    assert [end.closed for end in (*bus.ends, *line.ends)] == [True] * 3


def test_the_shipped_vehicle_speaks_to_both() -> None:
    assert load_vehicle("mainboard").codec == "mainboard"


def test_an_end_that_is_away_is_back_behind_a_fault_of_the_program_however_long_that_had_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bus, line = Plug(), Plug()
    really = ports.open_link
    monkeypatch.setattr(
        ports,
        "open_link",
        lambda name, url: JoinedLink(name, bus, line) if name == "vehicle" else really(name, url),
    )
    monkeypatch.setattr(shell, "REBIRTH_S", 0.1)
    passed: list[float] = []
    clocks = SimpleNamespace(time=time.time, monotonic=lambda: time.monotonic() + sum(passed))
    monkeypatch.setattr(shell, "time", clocks)
    with running(tmp_path, "serial:///dev/none", kind="mainboard") as pi:
        passed.append(3600.0)
        bus.pull()
        soon(lambda: pi.has_told("it went away"), "lost")
        with monkeypatch.context() as patch:
            patch.setattr(Runtime, "handle_timer", lambda *_: 1 // 0)
            soon(lambda: pi.has_told("a fault of the program"), "the fault")
        soon(lambda: len(list((tmp_path / "log").iterdir())) == 2, "another engine")
        bus.is_out = False
        soon(lambda: len(bus.ends) == 2, "back", within=20.0)
