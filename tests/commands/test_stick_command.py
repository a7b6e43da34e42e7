"""The stick by hand: what a hand becomes, and that whatever is lost ends the way of the vehicle."""

from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from click.testing import CliRunner
from served import PATIENCE, Running, read_now, running, silent_board, soon

from mission.cli import main
from mission.model import STOPPED
from mission.topside.helm import ENDS, LEVEL, NEUTRAL, PERIOD_S, Helm, Push, mains, verticals
from mission.topside.joystick import SILENT_S, Joystick, Layout
from mission.topside.keyboard import FIRST_S, NEXT_S, Keyboard, Switch, Wish
from mission.topside.stick import LOST_S, Lost, Seen, Stick
from protocol.framing import Frame
from protocol.messages import Ack, Manual, SetOutput, StateReport, Status, StoreReport, Telemetry
from protocol.topside import TopsideCodec, encode
from protocol.vehicles import frame_types

UP, DOWN, RIGHT, LEFT = (b"\x1b[" + letter for letter in (b"A", b"B", b"C", b"D"))
STOPPED_S = 2.0  # R6
SLACK_S = 1.5  # the machine may have other things to do


def said(helm: Helm, seconds: float, begin: float = 0.0) -> list[tuple[float, bytes]]:
    """Every word of so long, with the time it left, to a twentieth."""
    steps = [begin + n / 100 for n in range(round(seconds * 100))]
    return [(round(round((t - begin) * 20) / 20, 2), word) for t in steps for word in helm.words(t)]


# --- what the line shows ---------------------------------------------------------------------------


@pytest.mark.parametrize(("refusal", "first"), [("AO: no lamp; 35 s ago", 0), ("AO: no lamp", 1)])
def test_what_was_refused_before_stands_behind_what_comes_back_now(
    refusal: str, first: int
) -> None:
    """A narrow terminal shows no more than the beginning."""
    seen = Seen(status=Status(None, None, Telemetry(0.0, depth=1.5, heading=6.2831)))
    seen.store = StoreReport("ready", 1, 1, "", "", refusal)
    parts = seen.line(0.0).split("  ")
    order = [parts.index("1.5 m deep"), parts.index(refusal)]
    assert order[first] < order[1 - first]
    assert "heading 0" in parts


# --- what a hand becomes -------------------------------------------------------------------------


def test_a_push_is_said_every_fifth_of_a_second_and_ends_with_neutral_twice() -> None:
    helm = Helm()
    helm.hold(Push(surge=0.25))
    assert said(helm, 1.0) == [(t, b"@MMF3$") for t in (0.0, 0.2, 0.4, 0.6, 0.8)]
    helm.hold(None)
    assert said(helm, 3.0, 1.0) == [(0.0, NEUTRAL), (0.2, NEUTRAL)], "and nothing of verticals"
    assert (PERIOD_S, ENDS) == (0.2, 2)
    assert helm.is_silent


@pytest.mark.parametrize(
    ("push", "along", "up"),
    [
        (Push(surge=1.0), b"@MMF12$", LEVEL),
        (Push(surge=-0.5), b"@MMB6$", LEVEL),
        (Push(turn=1.0), b"@MRR5$", LEVEL),
        (Push(turn=-0.01), b"@MRL1$", LEVEL),
        (Push(heave=0.5), NEUTRAL, b"@MMU6$"),
        (Push(heave=-1.0), NEUTRAL, b"@MMD12$"),
        (Push(surge=0.4, turn=0.5), b"@MRR3$", LEVEL),
        (Push(surge=0.5, turn=0.4, heave=0.1), b"@MMF6$", b"@MMU1$"),
        (Push(), NEUTRAL, LEVEL),
    ],
)
def test_each_direction_has_its_word_and_every_word_is_one_a_vehicle_takes(
    push: Push, along: bytes, up: bytes
) -> None:
    assert (mains(push), verticals(push)) == (along, up)
    taken = TopsideCodec().receive(along + up, 0.0)
    assert [type(word) for word in taken] == [Manual, Manual]
    assert not any(isinstance(word, Frame) for word in taken)


def test_a_hand_that_moves_nothing_says_nothing() -> None:
    helm = Helm()
    helm.hold(Push())
    assert said(helm, 5.0) == []


def test_what_moves_is_said_before_what_does_not() -> None:
    """A neutral word in front would keep the push from taking over an emergency (R6)."""
    helm = Helm()
    helm.hold(Push(heave=0.5))
    assert [word for _, word in said(helm, 0.1)] == [b"@MMU6$", NEUTRAL]


def test_an_axis_that_is_let_go_is_told_so_while_the_other_goes_on() -> None:
    helm = Helm()
    helm.hold(Push(surge=0.5, heave=0.5))
    said(helm, 0.2)
    helm.hold(Push(surge=0.5))
    assert [word for _, word in said(helm, 0.2, 0.2)] == [b"@MMF6$", LEVEL]
    helm.hold(None)
    assert {word for _, word in said(helm, 1.0, 0.4)} == {LEVEL, NEUTRAL}


def test_a_dead_man_that_is_held_without_a_push_keeps_the_vehicle_neutral() -> None:
    helm = Helm()
    helm.hold(Push(turn=0.5))
    said(helm, 0.2)
    helm.hold(Push())
    assert said(helm, 0.5, 0.2) == [(0.0, NEUTRAL), (0.2, NEUTRAL), (0.4, NEUTRAL)]


def test_behind_a_stop_nothing_moves_until_the_hand_has_let_go() -> None:
    helm = Helm()
    helm.hold(Push(surge=0.5))
    said(helm, 0.3)
    helm.drop()
    helm.hold(Push(surge=0.5))
    assert said(helm, 3.0, 0.3) == []
    helm.hold(None)
    assert said(helm, 3.0, 4.0) == []
    helm.hold(Push(surge=0.5))
    assert said(helm, 0.1, 8.0) == [(0.0, b"@MMF6$")]


def test_a_key_is_held_while_it_repeats_and_no_longer() -> None:
    keys = Keyboard(6)
    keys.press(UP, 0.0)
    assert keys.push(FIRST_S - 0.01) == Push(surge=0.5)
    for at in (0.5, 0.53, 0.56):
        keys.press(UP, at)
    assert keys.push(0.56 + NEXT_S - 0.01) == Push(surge=0.5)
    assert keys.push(0.56 + NEXT_S) is None


@pytest.mark.parametrize("key", [b" ", b"x", b"q", b"\x1b", b"z", b"+"])
def test_any_other_key_lets_go(key: bytes) -> None:
    keys = Keyboard()
    keys.press(LEFT, 0.0)
    keys.press(key, 0.1)
    assert keys.push(0.1) is None


def test_keys_that_come_together_are_each_read() -> None:
    keys = Keyboard(3)
    assert keys.press(b"7+" + DOWN, 0.0) == []
    assert keys.push(0.0) == Push(surge=-8 / 12)
    assert keys.press(b"\x1b[5~xq", 0.0) == [Wish.STOP, Wish.QUIT]
    assert keys.press(b"-" * 20, 0.0) == []
    assert keys.gear == 1


SWITCHES = {
    b"l": (Switch("lamp", 80.0),),
    b"s": (Switch("side_speed", 300.0, 0.0), Switch("side", 7.0, 0.0)),
}
ASIDE = [SetOutput("side_speed", 300.0), SetOutput("side", 7.0)]
BACK = [SetOutput("side_speed", 0.0), SetOutput("side", 0.0)]


def test_a_letter_sets_its_output_once_and_moves_nothing() -> None:
    keys = Keyboard(3, SWITCHES)
    assert keys.press(b"l", 0.0) == [SetOutput("lamp", 80.0)]
    assert keys.push(0.0) is None
    assert keys.let_go(9.0) == []


def test_what_is_held_by_a_letter_is_set_once_and_given_back_when_it_is_let_go() -> None:
    keys = Keyboard(3, SWITCHES)
    assert keys.press(b"s", 0.0) == ASIDE
    assert keys.press(b"s", 0.5) == [], "it repeats"
    assert keys.let_go(0.5 + NEXT_S - 0.01) == []
    assert keys.push(0.5 + NEXT_S - 0.01) == Push(aside=True)
    assert keys.let_go(0.5 + NEXT_S) == BACK
    assert keys.let_go(9.0) == [], "once"
    assert keys.press(b"s", 9.0) == ASIDE


@pytest.mark.parametrize(("key", "says"), [(b" ", []), (UP, []), (b"q", [Wish.QUIT])])
def test_any_other_key_gives_back_what_a_letter_held(key: bytes, says: list[Wish]) -> None:
    keys = Keyboard(3, SWITCHES)
    keys.press(b"s", 0.0)
    assert keys.press(key, 0.1) == [*BACK, *says]


def test_an_output_that_is_held_takes_the_stick_without_moving() -> None:
    helm = Helm()
    helm.hold(Push(aside=True))
    assert said(helm, 0.5) == [(0.0, NEUTRAL), (0.2, NEUTRAL), (0.4, NEUTRAL)]
    helm.hold(None)
    assert len(said(helm, 2.0, 0.6)) == ENDS


@pytest.mark.parametrize("output", ["f=lamp:1", "x=lamp:1", "7=lamp:1", "l=lamp", "ll=lamp:1"])
def test_a_letter_that_is_the_sticks_own_and_words_that_say_nothing_are_refused(
    output: str,
) -> None:
    ran = CliRunner().invoke(main, ["stick", "--output", output])
    assert ran.exit_code == 2
    assert output in ran.stderr


def event(value: int, kind: int, number: int) -> bytes:
    return struct.pack("=IhBB", 0, value, kind, number)


def test_a_pad_moves_only_while_its_dead_man_is_held() -> None:
    pad = Joystick(Layout(), 0.5)
    pad.receive(event(-32767, 2, 1), 0.0)
    assert pad.push(0.0) is None
    pad.receive(event(1, 1, 4), 0.1)
    assert pad.push(0.1) == Push(surge=0.5)
    pad.receive(event(16384, 2, 0) + event(32767, 2, 4), 0.2)
    push = pad.push(0.2)
    assert push is not None
    assert (round(push.turn, 2), push.heave) == (0.25, -0.5)
    pad.receive(event(0, 1, 4), 0.3)
    assert pad.push(0.3) is None


def test_a_dead_man_that_was_held_at_the_opening_has_to_be_pressed_again() -> None:
    pad = Joystick(Layout(), 1.0)
    pad.receive(event(1, 0x81, 4) + event(-32767, 0x82, 1), 0.0)
    assert pad.push(0.0) is None
    pad.receive(event(1, 1, 4), 1.0)
    assert pad.push(1.0) == Push(surge=1.0)


def test_events_that_are_cut_are_read_whole_and_noise_of_the_middle_is_none() -> None:
    pad = Joystick(Layout(), 1.0)
    for byte in event(1, 1, 4) + event(-3000, 2, 1) + event(20000, 2, 0):
        pad.receive(bytes([byte]), 0.0)
    push = pad.push(0.0)
    assert push is not None
    assert (push.surge, round(push.turn, 2)) == (0.0, 0.61)


def test_a_pad_that_is_silent_for_long_is_taken_for_lost() -> None:
    pad = Joystick(Layout(), 1.0)
    pad.receive(event(1, 1, 4) + event(-32767, 2, 1), 0.0)
    assert pad.push(SILENT_S) is not None
    assert pad.push(SILENT_S + 0.1) is None
    pad.receive(event(-30000, 2, 1), 20.0)
    assert pad.push(20.0) is None


# --- over real bytes: a terminal, serve, a board's wire ------------------------------------------


class Wire:
    """What the board hears, each piece with its time."""

    def __init__(self, master: int) -> None:
        self._master, self._over = master, threading.Event()
        self.heard: list[tuple[float, bytes]] = []
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        while not self._over.wait(0.005):
            if data := read_now(self._master):
                self.heard.append((time.monotonic(), data))

    @property
    def bytes(self) -> bytes:
        return b"".join(data for _, data in self.heard)

    def last(self, word: bytes) -> float:
        return max(t for t, data in self.heard if word in data)

    def first(self, word: bytes, behind: float) -> float:
        return min(t for t, data in self.heard if word in data and t > behind)

    def close(self) -> None:
        self._over.set()
        self._thread.join()


class Person:
    """At a terminal in which the stick runs."""

    def __init__(self, *words: str) -> None:
        self._master, slave = os.openpty()
        os.set_blocking(self._master, False)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "mission", "stick", *words],
            stdin=slave, stdout=slave, stderr=slave, start_new_session=True,
        )  # fmt: skip
        os.close(slave)
        self.seen = b""
        soon(lambda: b"answer" in self.look(), "the line of the stick")

    def look(self) -> bytes:
        with suppress(OSError):
            self.seen += os.read(self._master, 65536)
        return self.seen

    def type(self, keys: bytes) -> None:
        os.write(self._master, keys)

    def hold(self, key: bytes, seconds: float) -> None:
        end = time.monotonic() + seconds
        self.hold_until(key, lambda: time.monotonic() >= end)

    def hold_until(self, key: bytes, holds: Callable[[], bool]) -> None:
        end = time.monotonic() + PATIENCE
        while not holds():
            assert time.monotonic() < end, "held for long enough"
            self.type(key)
            time.sleep(0.03)
            self.look()

    def hang_up(self) -> None:
        os.close(self._master)
        self._master = -1

    def ended(self) -> int:
        soon(lambda: self.look() is not None and self.process.poll() is not None, "its end")
        return int(self.process.returncode)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        if self._master >= 0:
            os.close(self._master)


@contextmanager
def steering(
    folder: Path, *words: str, kind: str = "auv"
) -> Iterator[tuple[Person, Wire, Running]]:
    with silent_board() as (master, device), running(folder, f"serial://{device}", kind=kind) as pi:
        wire = Wire(master)
        person = Person("--to", pi.url, *words)
        try:
            yield person, wire, pi
        finally:
            person.close()
            wire.close()


def stops_in_time(wire: Wire) -> None:
    """X within R6's 2 s of the last word of the stick."""
    moved = max(wire.last(b"@MMF"), 0.0)
    soon(lambda: any(b"@ZAX0$" in data and t > moved for t, data in wire.heard), "X")
    assert wire.first(b"@ZAX0$", moved) - moved <= STOPPED_S + SLACK_S


def test_a_key_that_is_held_moves_the_vehicle_and_one_let_go_stops_it(tmp_path: Path) -> None:
    with steering(tmp_path) as (person, wire, _):
        person.hold_until(UP, lambda: wire.bytes.count(b"@MMF3$") >= 6)
        soon(lambda: wire.bytes.count(NEUTRAL) == 2, "neutral twice")
        held = wire.last(b"@MMF3$") - wire.first(b"@MMF3$", 0.0)
        assert wire.bytes.count(b"@MMF3$") <= 2 + held / PERIOD_S
        person.look()
        assert b"@MMF3$" in person.seen
        stops_in_time(wire)
        person.type(b"q")
        assert person.ended() == 0
        assert wire.bytes.count(NEUTRAL) == 2


def test_a_side_move_goes_on_while_its_key_is_held_and_ends_with_it(tmp_path: Path) -> None:
    outputs = ("--output", "s=side_speed:300/0", "--output", "s=side:7/0")
    aside, still = (frame_types()["robot.DOWN"].encode({"address": 1, "command": code})
                    for code in (7, 0))  # fmt: skip
    with steering(tmp_path, *outputs, kind="robot") as (person, wire, _):
        person.hold_until(b"s", lambda: wire.bytes.count(aside) >= 3)
        soon(lambda: still in wire.bytes.rpartition(aside)[2], "its end")
        end = wire.last(aside)
        soon(lambda: b"side 0: set" in person.look(), "the answer")
        time.sleep(PERIOD_S)
        assert wire.last(aside) == end


def test_x_stops_everything_at_once(tmp_path: Path) -> None:
    with steering(tmp_path) as (person, wire, pi):
        person.hold(RIGHT, 0.5)
        person.type(b"x")
        soon(lambda: b"@ZAX0$" in wire.bytes, "X")
        soon(lambda: pi.has_told("emergency/stopped"), "the state")
        soon(lambda: b"@ZAX0$" in person.look(), "its line")
        time.sleep(2 * PERIOD_S)
        assert NEUTRAL not in person.look().rpartition(b"@ZAX0$")[2]
        person.hold(RIGHT, 0.5)
        soon(lambda: b"relay" in person.look() or b"manual" in person.look(), "why it is refused")
        assert wire.bytes.rpartition(b"@ZAX0$")[2].count(b"@MR") == 0


def test_behind_x_no_output_is_shown_as_it_was_set(tmp_path: Path) -> None:
    """An emergency has made it safe; and what is new stands where a narrow terminal shows it."""
    with steering(tmp_path, "--output", "l=lamp:80", kind="rov") as (person, _, pi):
        person.hold(UP, 0.5)
        person.type(b"l")
        soon(lambda: b"lamp 80: set" in person.look(), "the lamp")
        person.type(b"x")
        soon(lambda: pi.has_told("emergency/stopped"), "the state")
        soon(lambda: b"X acknowledged" in person.look(), "its line, of 80 characters")
        time.sleep(2 * PERIOD_S)
        assert b"lamp" not in person.look().rpartition(b"X acknowledged")[2]


def killed(person: Person) -> None:
    person.process.kill()


def hung_up(person: Person) -> None:
    person.hang_up()
    assert person.ended() != 0


def told_to_end(person: Person) -> None:
    person.process.send_signal(signal.SIGTERM)
    assert person.ended() != 0


def frozen(person: Person) -> None:
    person.process.send_signal(signal.SIGSTOP)


@pytest.mark.parametrize("lost", [killed, hung_up, told_to_end, frozen])
def test_whatever_becomes_of_the_terminal_the_vehicle_is_stopped(
    tmp_path: Path, lost: Callable[[Person], None]
) -> None:
    with steering(tmp_path) as (person, wire, _):
        person.hold(UP, 0.8)
        soon(lambda: b"@MMF3$" in wire.bytes, "the push")
        lost(person)
        stops_in_time(wire)


def test_ctrl_c_says_neutral_twice_and_gives_the_terminal_back(tmp_path: Path) -> None:
    with steering(tmp_path) as (person, wire, _):
        person.hold(UP, 0.8)
        person.process.send_signal(signal.SIGINT)
        assert person.ended() == 130
        soon(lambda: wire.bytes.count(NEUTRAL) >= 2, "neutral twice")
        assert wire.bytes.rpartition(b"@MMF3$")[2].count(NEUTRAL) == 2


class Hearer:
    """A vehicle that answers any word with the same one, and keeps what it heard."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.url = f"tcp://127.0.0.1:{self._server.getsockname()[1]}"
        self.heard = bytearray()
        self.leaves = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        boat, _ = self._server.accept()
        boat.settimeout(0.01)
        with boat, suppress(OSError):
            while not self.leaves.is_set():
                with suppress(TimeoutError):
                    if not (data := boat.recv(4096)):
                        return
                    self.heard += data
                    boat.sendall(b"@ACK_AWW$")

    def close(self) -> None:
        self.leaves.set()
        self._thread.join()
        self._server.close()


class Hands:
    """A key that is held from the start, and a pad; pipes in place of their devices."""

    def __init__(self) -> None:
        self.terminal, self._keys = os.pipe()
        self.pad, self._events = os.pipe()
        self.vehicle = Hearer()

    def hold(self, end: Callable[[Hands], None]) -> None:
        """``end``: what happens once its output was heard."""
        stick = Stick(self.terminal, Keyboard(3, SWITCHES), lambda _: self._shown(end),
                      (self.pad, Joystick(Layout(), 1.0)))  # fmt: skip
        stick.steer(self.vehicle.url)

    def _shown(self, end: Callable[[Hands], None]) -> None:
        if self._keys >= 0:
            os.write(self._keys, b"s")
        if encode(ASIDE[1]) in self.vehicle.heard:
            end(self)

    def ctrl_c(self) -> None:
        raise KeyboardInterrupt

    def terminal_gone(self) -> None:
        self._keys = self._closed(self._keys)

    def pad_gone(self) -> None:
        self._events = self._closed(self._events)

    def link_gone(self) -> None:
        self.vehicle.leaves.set()

    def _closed(self, descriptor: int) -> int:
        if descriptor >= 0:
            os.close(descriptor)
        return -1

    def close(self) -> None:
        for descriptor in (self.terminal, self.pad, self._keys, self._events):
            self._closed(descriptor)
        self.vehicle.close()


@pytest.fixture
def hands() -> Iterator[Hands]:
    made = Hands()
    yield made
    made.close()


@pytest.mark.parametrize("end", [Hands.ctrl_c, Hands.terminal_gone, Hands.pad_gone])
def test_however_the_stick_ends_what_a_key_held_is_given_back(
    hands: Hands, end: Callable[[Hands], None]
) -> None:
    with pytest.raises((KeyboardInterrupt, Lost)):
        hands.hold(end)
    back = b"".join(map(encode, BACK))
    soon(lambda: back in hands.vehicle.heard, "given back")
    soon(lambda: hands.vehicle.heard.rpartition(back)[2].count(NEUTRAL) == ENDS, "and neutral")


def test_a_link_that_is_lost_gives_nothing_back_and_the_stick_says_so(hands: Hands) -> None:
    with pytest.raises(Lost, match="outputs stay as it last heard them"):
        hands.hold(Hands.link_gone)
    assert encode(BACK[1]) not in hands.vehicle.heard


def test_a_pad_steers_and_its_loss_ends_the_stick(tmp_path: Path) -> None:
    device = tmp_path / "js0"
    os.mkfifo(device)
    pad = os.open(device, os.O_RDWR)
    try:
        with steering(tmp_path / "pi", "--pad", str(device), "--gear", "12") as (person, wire, _):
            os.write(pad, event(-32767, 2, 1) + event(1, 1, 4))
            soon(lambda: b"@MMF12$" in wire.bytes, "the push")
            os.close(pad)
            pad = -1
            assert person.ended() == 1
            assert b"the pad is gone" in person.seen
            stops_in_time(wire)
    finally:
        if pad >= 0:
            os.close(pad)


class Radio:
    """A relay between boat and vehicle that can be cut."""

    def __init__(self, url: str) -> None:
        host, port = url.removeprefix("tcp://").split(":")
        self._there = socket.create_connection((host, int(port)), timeout=PATIENCE)
        self._server = socket.create_server(("127.0.0.1", 0))
        self.url = f"tcp://127.0.0.1:{self._server.getsockname()[1]}"
        self.cut = threading.Event()
        self._over = threading.Event()
        self.is_reset = False
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        here, _ = self._server.accept()
        for one in (here, self._there):
            one.settimeout(0.01)
        while not self._over.is_set():
            if self.cut.is_set():
                time.sleep(0.01)
                continue
            for one, other in ((here, self._there), (self._there, here)):
                with suppress(TimeoutError):
                    other.sendall(one.recv(4096))
        try:
            while here.recv(65536):
                pass
        except ConnectionResetError:
            self.is_reset = True
        except OSError:
            pass
        here.close()

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self._there.close()
        self._server.close()


def test_a_link_that_is_lost_ends_the_stick_and_what_waited_never_arrives(tmp_path: Path) -> None:
    with silent_board() as (master, device), running(tmp_path, f"serial://{device}") as pi:
        wire, radio = Wire(master), Radio(pi.url)
        person = Person("--to", radio.url)
        try:
            person.hold_until(UP, lambda: b"@MMF3$" in wire.bytes)
            radio.cut.set()
            cut = time.monotonic()
            person.hold(UP, 1.0)
            stops_in_time(wire)
            assert person.ended() == 1
            assert time.monotonic() - cut <= LOST_S + 2 * SLACK_S
            assert b"does not answer" in person.seen
            assert b"outputs" not in person.seen
        finally:
            person.close()
            radio.close()
            wire.close()
        assert radio.is_reset, "what the system still holds is dropped, not sent later"


class Mute:
    """A vehicle that may answer with ``acknowledges``, and leaves after ``stays`` X."""

    def __init__(self, stays: int, acknowledges: bytes = b"") -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.url = f"tcp://127.0.0.1:{self._server.getsockname()[1]}"
        self.heard: list[float] = []
        self._stays, self._acknowledges = stays, acknowledges
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        boat, _ = self._server.accept()
        asked = 0
        with boat, suppress(OSError):
            while len(self.heard) < self._stays and asked < 6:
                data = boat.recv(4096)
                self.heard += [time.monotonic()] * data.count(b"@ZAX0$")
                asked += sum(data.count(word) for word in (b"@DU$", b"@AQ$", b"@AE$"))
                boat.sendall(encode(Status(None, None, None)))
                if b"@ZAX0$" in data:
                    boat.sendall(self._acknowledges)

    def close(self) -> None:
        self._thread.join()
        self._server.close()


def lost_with(vehicle: Mute, keys: bytes) -> str:
    """What the stick says at the end."""
    ours, theirs = os.pipe()
    os.write(theirs, keys)
    try:
        with pytest.raises(Lost) as lost:
            Stick(ours, Keyboard(), lambda _: None).steer(vehicle.url)
    finally:
        vehicle.close()
        os.close(ours)
        os.close(theirs)
    return str(lost.value)


@pytest.mark.parametrize("answers", [b"", encode(Ack(0.0, "Z", "A", ord("N")))])
def test_x_is_said_every_second_until_it_is_acknowledged(answers: bytes) -> None:
    vehicle = Mute(3, answers)
    said = lost_with(vehicle, b"x")
    assert said.endswith("your X was NOT acknowledged: `auvmission stop`")
    gaps = [b - a for a, b in zip(vehicle.heard, vehicle.heard[1:], strict=False)]
    assert len(gaps) == 2
    assert all(gap > 0.9 for gap in gaps)


def test_an_x_that_is_acknowledged_is_said_no_more() -> None:
    vehicle = Mute(2, encode(Ack(0.0, "Z", "A", ord("Y"))))
    assert "NOT" not in lost_with(vehicle, b"x")
    assert len(vehicle.heard) == 1


def test_an_x_that_the_pi_has_is_said_no_more_though_its_board_is_silent() -> None:
    """Each X more would put off that it is brought up."""
    state = StateReport(STOPPED, "asker", *[None] * 9, alarms=0, setpoint="X", leg="")
    vehicle = Mute(3, encode(state))
    assert "NOT" not in lost_with(vehicle, b"x")
    assert len(vehicle.heard) == 1


def test_a_hand_that_moves_the_vehicle_again_ends_an_x_that_nobody_has_acknowledged() -> None:
    vehicle = Mute(2)
    ours, theirs = os.pipe()
    keys = iter([b"x", *[b""] * 3])

    def show(_: str) -> None:
        os.write(theirs, next(keys, UP))

    with pytest.raises(Lost, match="stops 2 s after the last word"):
        Stick(ours, Keyboard(), show).steer(vehicle.url)
    vehicle.close()
    os.close(ours)
    os.close(theirs)
    assert len(vehicle.heard) == 1


@pytest.mark.parametrize(
    ("keys", "becomes"), [(b"", "goes on with what it does"), (UP, "stops 2 s after the last word")]
)
def test_a_link_that_is_lost_stops_a_vehicle_that_was_moved_and_no_other(
    keys: bytes, becomes: str
) -> None:
    assert lost_with(Mute(1), keys).endswith(becomes)


def test_without_a_terminal_or_by_modem_there_is_no_stick() -> None:
    ran = CliRunner().invoke(main, ["stick", "--to", "modem+serial:///dev/null"])
    assert ran.exit_code == 2
    ran = subprocess.run(
        [sys.executable, "-m", "mission", "stick"],
        stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE, check=False,
    )  # fmt: skip
    assert ran.returncode == 2
    assert "needs a terminal" in ran.stderr
