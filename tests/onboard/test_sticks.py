"""The stick on the vehicles of documents 002, 003 and 004, over the whole drive and their own bytes:
what it becomes, when it counts as let go, and that what a vehicle lacks changes nothing (R6, R14)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from test_other_vehicles import TEXTS, prepared

from links.base import Rx
from mission.model import MANUAL_DRIVING, MANUAL_WAITING, STOPPED, SURFACING, Step, Tx
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore
from mission.verification.rig.rehearsal import Cue
from mission.verification.simulation.flight import fly
from protocol.messages import Order, Setpoint
from protocol.tolerances import Tolerances
from protocol.vehicles import codec, link

NAMES = ("coreboard", "rov", "robot")
AHEAD = b"@MMF6$"
LACKED = (b"@MT1,5$", b"@MDS1,5$", b"@MS50,90$", b"@MP50,90$", b"@MRU3$", b"@DS1,5$", b"@RI$")


class Watched:
    """What the journal would have."""

    def __init__(self) -> None:
        self.notices: list[str] = []
        self.steps: list[Step] = []

    def step(self, step: Step) -> None:
        self.steps.append(step)

    def estimate(self, estimate: object) -> None:
        pass

    def notice(self, text: str) -> None:
        self.notices.append(text)


class Bench:
    """A runtime on a bench, with a boat, and what left for the board."""

    def __init__(self, name: str) -> None:
        self.vehicle = load_vehicle(name)
        self.codec = codec(*self.vehicle.speaks)
        self.journal = Watched()
        self.runtime = Runtime(Configuration(), self.vehicle, MemoryStore(), observer=self.journal)
        self.now = 0.0
        self.sent: list[Tx] = self.runtime.connected("topside", "boat", 0.0)

    def until(self, t: float) -> None:
        due = self.runtime.next_timer()
        while due is not None and due <= t:
            self.now = max(self.now, due)
            self.sent += self.runtime.handle_timer(self.now)
            due = self.runtime.next_timer()
        self.now = t

    def say(self, word: bytes) -> None:
        self.sent += self.runtime.receive(Rx(self.now, "topside", word, "boat"))

    def said_by(self, boat: str, word: bytes) -> list[bytes]:
        """What is answered to it."""
        out = self.runtime.receive(Rx(self.now, "topside", word, boat))
        return [tx.data for tx in out if tx.address == boat]

    def values(self, tx: Tx) -> Mapping[str, Any]:
        """What a frame to the board says."""
        (frame,) = link(f"{self.vehicle.codec}.down").frames(Tolerances())
        return frame.decode(tx.data)

    def to_board(self, since: float) -> list[Tx]:
        return [tx for tx in self.sent if tx.link == "vehicle" and tx.t >= since]

    def frames(self, command: Setpoint | Order) -> list[bytes]:
        return self.codec.encode(command)

    def come_to(self, state: str) -> None:
        """The state as its words lead there; one second passes."""
        words = {STOPPED: b"@ZAX0$", SURFACING: b"@ZAWF$", MANUAL_DRIVING: AHEAD}
        if word := words.get(state):
            self.say(word)
        self.until(self.now + (2.3 if state == MANUAL_WAITING else 0.0))


@pytest.mark.parametrize("name", NAMES)
def test_a_stick_takes_the_vehicle_over_in_frames_of_its_own_at_once(name: str) -> None:
    bench = Bench(name)
    bench.until(1.0)
    bench.say(AHEAD)
    assert bench.runtime.state == MANUAL_DRIVING
    bench.until(1.02)  # what was on the line has left
    ahead = bench.frames(Setpoint(surge=0.5))
    assert [tx.data for tx in bench.to_board(1.0)][-len(ahead) :] == ahead
    bench.until(1.5)
    assert {tx.data for tx in bench.to_board(1.02)} == set(ahead)
    assert not [tx for tx in bench.sent if tx.link == "vehicle" and tx.data.startswith(b"@")]
    assert all("@MM" in tx.reason for tx in bench.to_board(1.02))


@pytest.mark.parametrize("name", NAMES)
def test_600_ms_without_a_word_is_neutral_and_2_s_are_a_stop(name: str) -> None:
    bench = Bench(name)
    for i in range(10):  # held for 2 s, longer than any silence
        bench.until(1.0 + 0.2 * i)
        bench.say(AHEAD)
    last, neutral = bench.now, bench.frames(Order.STOP)
    bench.until(6.0)
    let_go = next(tx.t for tx in bench.to_board(1.0) if tx.data in neutral)
    assert let_go == pytest.approx(last + 0.6, abs=0.02)
    after = bench.to_board(last + 0.61)
    assert {tx.data for tx in after} == set(neutral)
    assert any("no M for 2 s: everything stopped" in tx.reason for tx in after)
    assert bench.runtime.state == MANUAL_WAITING


STATES = ("idle", MANUAL_DRIVING, STOPPED, SURFACING)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("word", LACKED)
def test_what_a_vehicle_lacks_changes_no_state_and_no_byte_and_is_told(
    name: str, state: str, word: bytes
) -> None:
    """Beside a twin to which nothing was said."""
    one, twin = Bench(name), Bench(name)
    for bench in (one, twin):
        bench.say(b"@AQ$")  # who asks for reports is sent one
        bench.until(1.0)
        bench.come_to(state)
        bench.until(1.25)
    one.say(word)
    (told,) = [tx for tx in one.sent if tx.t == 1.25 and tx.link == "topside"]
    for bench in (one, twin):
        bench.until(3.0)
    assert one.runtime.state == twin.runtime.state
    assert one.to_board(0.0) == twin.to_board(0.0)
    assert b"relay: this vehicle has no " in told.data
    assert one.journal.notices == [f"not relayed for topside boat: {told.reason}"]
    one.say(b"@AQ$")  # what `status` asks
    kind = b"relay" if word[1:2] in (b"R", b"D") else b"manual"
    assert kind + b": this vehicle has no " in one.sent[-1].data


@pytest.mark.parametrize("name", NAMES)
def test_an_emergency_is_taken_over_by_a_stick_that_moves_after_2_s_of_stillness(name: str) -> None:
    bench = Bench(name)
    bench.until(1.0)
    bench.say(b"@ZAWF$")
    bench.until(2.0)
    bench.say(AHEAD)
    assert bench.runtime.state != MANUAL_DRIVING
    bench.until(4.5)
    bench.say(b"@MMF0$")
    assert bench.runtime.state != MANUAL_DRIVING
    bench.until(7.0)
    bench.say(AHEAD)
    assert bench.runtime.state != MANUAL_DRIVING
    bench.until(7.2)
    bench.say(AHEAD)
    assert bench.runtime.state == MANUAL_DRIVING
    bench.until(7.25)
    assert bench.to_board(7.2)[-1].data == bench.frames(Setpoint(surge=0.5))[-1]


@pytest.mark.parametrize("name", NAMES)
def test_an_order_ends_the_stick_and_what_it_held_does_not_come_back(name: str) -> None:
    bench = Bench(name)
    for t in (1.0, 1.2):
        bench.until(t)
        bench.say(AHEAD)
    bench.say(b"@ZAX0$")
    bench.until(4.0)
    safe = bench.codec.take_outputs({o.channel: o.safe for o in bench.vehicle.outputs})
    motion = {tx.data for tx in bench.to_board(1.201)} - set(safe.values())  # R18: said with it
    assert motion == set(bench.frames(Order.STOP))
    assert bench.runtime.state == STOPPED


@pytest.mark.proof
@pytest.mark.parametrize("name", NAMES)
def test_a_mission_flies_on_when_the_stick_is_given_back_in_its_midst(
    name: str, tmp_path: Path
) -> None:
    ready = prepared(tmp_path, TEXTS[name])
    turn = b"@MRR3$"
    held = [Cue(6.0 + 0.2 * i, turn) for i in range(10)]
    flight = fly(ready.mission, ready.vehicle, seed=3, said=(*held, Cue(11.0, b"@AA$")))
    assert flight.outcome == "completed", flight.reason
    assert flight.at_surface
    turned = codec(*ready.vehicle.speaks).encode(Setpoint(turn=0.6))[-1]
    assert [tx for tx in flight.sent if tx.link == "vehicle" and tx.data == turned]
