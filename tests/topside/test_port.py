"""One program's ways over an operator's port: what is pressed goes before all else."""

from __future__ import annotations

import os
import threading
import time
import tty
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import pytest
from served import PATIENCE

from links import open_link
from mission.topside.console import BrokenOff
from mission.topside.orders import order
from mission.topside.port import Port
from mission.topside.sources import from_frames
from mission.topside.upload import OperatorError, clear
from protocol.messages import Order
from protocol.topside import EMERGENCIES

X, W, LOOK = EMERGENCIES[Order.STOP], EMERGENCIES[Order.SURFACE], b"@AE$"


@dataclass
class Water:
    """A modem's serial port behind which nobody answers."""

    device: str
    heard: bytearray = field(default_factory=bytearray)

    @property
    def url(self) -> str:
        return f"modem+serial://{self.device}?range=800&rate=600"

    def comes(self, word: bytes, times: int = 1) -> None:
        until(lambda: self.heard.count(word) >= times)


def until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.fixture
def water() -> Iterator[Water]:
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    found, over = Water(os.ttyname(theirs)), threading.Event()
    os.set_blocking(ours, False)

    def listen() -> None:
        while not over.wait(0.005):
            try:
                found.heard += os.read(ours, 500)
            except BlockingIOError:
                continue

    listening = threading.Thread(target=listen)
    listening.start()
    yield found
    over.set()
    listening.join()
    os.close(ours)
    os.close(theirs)


def pressed(port: Port, which: Order, told: list[str]) -> threading.Thread:
    number = port.press(urgent=True)

    def say() -> None:
        try:
            told.append(port.say(order(which), number, urgent=True, tell=told.append))
        except OperatorError as error:
            told.append(type(error).__name__)

    thread = threading.Thread(target=say, daemon=True)
    thread.start()
    return thread


def test_an_order_breaks_off_the_look_that_has_the_port(water: Water) -> None:
    source = from_frames(water.url)
    assert source.port is not None
    threading.Thread(target=source.run, daemon=True).start()
    water.comes(LOOK)
    pressed(source.port, Order.STOP, [])
    water.comes(X)
    assert water.heard.count(LOOK) == 1
    source.stopped.set()


def test_no_look_is_said_while_an_order_is(water: Water) -> None:
    port = Port(water.url)
    port.press(urgent=True)
    with pytest.raises(BrokenOff):
        port.look(clear())
    time.sleep(0.1)
    assert not water.heard


def test_an_order_is_tried_until_another_program_lets_go_of_the_port(water: Water) -> None:
    other, told = open_link("other", f"serial://{water.device}"), list[str]()
    pressed(Port(water.url), Order.STOP, told)
    until(lambda: any("NOT sent so far" in words for words in told))
    other.close()
    water.comes(X)


def test_a_newer_order_breaks_an_older_one_off_and_the_older_is_said_no_more(water: Water) -> None:
    port, told = Port(water.url), list[str]()
    older = pressed(port, Order.STOP, told)
    water.comes(X)
    pressed(port, Order.SURFACE, [])
    water.comes(W)
    older.join(PATIENCE)
    assert told == ["BrokenOff"]
    assert water.heard.rindex(X) < water.heard.index(W)


def test_nothing_else_that_is_pressed_breaks_an_order_off_or_waits_behind_it(water: Water) -> None:
    port = Port(water.url)
    pressed(port, Order.STOP, [])
    with pytest.raises(OperatorError, match="not said"):
        port.press(urgent=False)
    water.comes(X)


def test_what_is_no_order_does_not_wait_for_another_program(water: Water) -> None:
    other, port = open_link("other", f"serial://{water.device}"), Port(water.url)
    number = port.press(urgent=False)
    with pytest.raises(OperatorError, match="in use by another program"):
        port.say(clear(), number, urgent=False, tell=print)
    other.close()
    assert port.press(urgent=False) > number, "it is over"
