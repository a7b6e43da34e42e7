"""Every row of every document that travels to a board: a person's words lead to it, through the Pi or
straight to a port that is free, and it is read on the wire of the simulated board."""

from __future__ import annotations

import functools
import json
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import pytest
from every_output import with_every_output
from from_code.rows import BY_HAND, DOWN, NOBODY, RELAYED, SAID, TO_BOARDS, another, written
from programs import run
from served import read_now, silent_board
from test_other_vehicles import CORE

from links import open_link
from links.simulated.link import START
from mission.authoring.prepare import prepare, prepare_text
from mission.model import Tx
from mission.model.shipped import missions_folder
from mission.model.vehicle import Vehicle
from mission.topside.words import command
from mission.verification.rig.program import FillableStore, Program
from mission.verification.rig.rig import Rig
from mission.verification.rig.vehicle import simulated
from mission.verification.simulation.flight import fly
from protocol.examples import examples
from protocol.fields import BinaryFrame, Number, Raw
from protocol.framing import Frame
from protocol.tolerances import Tolerances
from protocol.topside import encode
from protocol.vehicles import VEHICLES, frame_types, link
from protocol.vehicles.channels import Channel
from protocol.vehicles.motorcan import CanFrame
from protocol.vehicles.robot import COMMANDS

WIRES = {  # what the board of a codec hears
    "auv": ("auv.to_stm32",),
    "coreboard": ("coreboard.pc_to_main",),
    "mainboard": ("coreboard.can", "coreboard.main_to_sensor"),
    "motorcan": ("coreboard.can",),
    "rov": ("rov.down",),
    "robot": ("robot.down",),
}
KEYS = {"coreboard": {"angle_error_deg": "5"}}  # what is said by its file alone
STICK = (b"@MMF6$", b"@MMB6$", b"@MRR3$", b"@MRL3$", b"@MMU6$", b"@MMD6$")
WORDS: Mapping[str, tuple[Mapping[str, Any], ...]] = {  # relayed to the AUV's STM32
    "RS": ({"switches": "OOOOOOC"}, {"switches": "OOOOOCO"}),
    "RI": ({},),
    "D": ({"mode": "S", "servo": 1, "angle": -15}, {"mode": "A", "servo": 2, "angle": 3}),
    "MD": ({"mode": "S", "servo": 1, "angle": 22}, {"mode": "A", "servo": 2, "angle": 3}),
    "MT": ({"thruster": 1, "gear": 5}, {"thruster": 5, "gear": 12}),
    "MM": ({"dir": "F", "speed": 1}, {"dir": "U", "speed": 12}),
    "MR": ({"dir": "L", "speed": 1}, {"dir": "U", "speed": 5}),
    "MS": ({"speed": 1, "angle": 90}, {"speed": 100, "angle": 180}),
    "MP": ({"force": 1, "angle": 90}, {"force": 100, "angle": 180}),
}
WORDS_TO_STM32: Mapping[str, Mapping[str, int]] = {
    **{code: {"gear": 3} for code in "FBLRUD"},
    "S": {"depth_m": 4},
    "E": {"altitude_m": 5},
    "H": {"heading_deg": -20},
    "A": {"pitch_deg": 5, "roll_deg": -3},
    "V": {"speed_mps": 1},
    **{code: {} for code in "XW"},
}
ATTITUDE = """mission nose vehicle auv-documented
home 30.2874595 120.1535765
safety radius 400 time 20min depth 10 voltage 10
assume current 0.1
nose: depth 3 heading 0 gear 4 pitch -5 roll 0 for 20s
up: surface until fix timeout 3min
"""
Heard = Mapping[tuple[str, str], set[str]]  # by frame and row: its values


def read(sent: list[Tx], name: str) -> Iterator[tuple[str, str, str]]:
    """Frame, row and value of all that the board of this codec could read on its wire."""
    for wire in WIRES[name]:
        framer = link(wire).framer(Tolerances())
        for tx in sent:
            for item in framer.receive(tx.data, tx.t):
                if isinstance(item, Frame):
                    yield from _rows_in(item.type.name, item.values())


def _rows_in(frame: str, values: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    if frame == "robot.DOWN":
        yield frame, f"{values['address']}:{values['command']}", str(values["user"])
    elif frame == "auv.ZA":
        yield frame, values["code"], ""
    else:
        yield frame, "", ""
        yield from ((frame, name, str(value)) for name, value in values.items())


class Person:
    """A boat beside a Pi that runs, and a simulated vehicle on its wire, in virtual time."""

    def __init__(self, vehicle: Vehicle) -> None:
        program = Program(vehicle, FillableStore(), START.timestamp())
        self.rig = Rig(simulated(vehicle, 1), program)
        program.boot(0.0)
        self.rig.send(program.navigate(0.0))
        self.rig.join()
        self.rig.run_until(4.0)

    def says(self, raw: bytes, lasts: float = 0.15) -> None:
        self.rig.send(self.rig.say("topside", "boat", raw))
        self.rig.run_until(self.rig.now + lasts)

    @property
    def sent(self) -> list[Tx]:
        return [e for e in self.rig.events if isinstance(e, Tx) and e.link == "vehicle"]


def with_all(name: str) -> Vehicle:
    vehicle = with_every_output(name)
    return replace(vehicle, wire={**vehicle.wire, **KEYS.get(name, {})})


def levels(channel: Channel) -> tuple[float, ...]:
    """All of a few, at the last what it is at rest; else its ends."""
    if not channel.whole or channel.high - channel.low > 8:
        return channel.high, channel.low
    every = channel.choices or tuple(range(int(channel.low), int(channel.high) + 1))
    return (*every, channel.rest) if channel.rest == channel.rest else every


@functools.cache
def heard(name: str) -> Heard:
    """What the board reads of all that a person says to this vehicle, in words and by missions."""
    found = defaultdict[tuple[str, str], set[str]](set)
    for sent in (_by_words(name), *_by_missions(name)):
        for frame, row, value in read(sent, name):
            found[frame, row].add(value)
    return found


def _by_words(name: str) -> list[Tx]:
    person = Person(with_all(name))
    for word, every in WORDS.items() if name == "auv" else ():
        for values in every:
            person.says(encode(command(word, values)), 1.0)
    for channel in sorted(VEHICLES[name].channels, key=lambda c: bool(c.excludes)):
        for level in levels(channel):
            if channel.excludes:  # what holds the vehicle works under the stick
                person.says(b"@MMF0$", 0.02)
            said = command("AO", {"name": channel.name, "value": level})
            person.says(encode(said), 0.4 if name == "auv" else 0.12)
    for word in STICK:
        person.says(word)
    for order in ("X", "W"):
        person.says(encode(command("ZA", {"code": order})), 1.0)
    return person.sent


def _by_missions(name: str) -> Iterator[list[Tx]]:
    if name == "auv":
        ready = prepare(missions_folder() / "shakedown.yaml")
        yield _to_vehicle(fly(ready.mission, ready.vehicle, seed=3).sent)
        ready = prepare_text(ATTITUDE, "nose")
        yield _to_vehicle(fly(ready.mission, ready.vehicle, seed=3).sent)
    if name == "coreboard":
        ready = prepare_text(CORE, "core")
        yield _to_vehicle(fly(ready.mission, ready.vehicle, seed=3).sent)


def _to_vehicle(sent: Any) -> list[Tx]:
    return [tx for tx in sent if tx.link == "vehicle"]


def alone(frame: str, row: str) -> bool:
    """The docs say why no word and no mission leads to it."""
    return row in NOBODY.get(frame, {}) or written(frame, row) == BY_HAND


@pytest.mark.parametrize(("frame", "row"), SAID)
def test_a_row_to_a_board_is_said_by_words_and_missions_and_read_on_its_wire(
    frame: str, row: str
) -> None:
    values = heard(TO_BOARDS[frame])[frame, row]
    if alone(frame, row):
        assert len(values) <= 1, "the docs' excuse would hide a way that there is"
    elif frame in ("auv.ZA", "robot.DOWN") or not row:
        assert values
    else:
        assert len(values) > 1


def test_every_word_that_is_relayed_is_said() -> None:
    assert set(WORDS) == set(RELAYED)


@pytest.mark.parametrize("flag", ["hold_heading", "hold_depth"])
def test_the_flags_of_the_rov_are_read_set_and_at_rest(flag: str) -> None:
    assert heard("rov")["rov.DOWN", flag] == {"0", "1"}


@pytest.mark.parametrize(("frame", "row"), [r for r in SAID if r[0] in DOWN])
def test_a_row_to_a_board_is_said_straight_to_a_free_port_and_read_there(
    frame: str, row: str
) -> None:
    """Whatever nobody says through the Pi, too."""
    values = example_of(frame, row)
    given = [f"{name}={json.dumps(value)}" for name, value in values.items()]
    with port_of(frame) as (url, take):
        ran = run("send", "--port", url, frame, *given)
        assert ran.exit_code == 0, ran.stderr
        data = take()
    found = {(f, r): v for f, r, v in read([Tx(0.0, "vehicle", data, "")], DOWN[frame])}
    assert (frame, row) in found
    if row in values:
        assert found[frame, row] == str(values[row])


def example_of(frame: str, row: str) -> dict[str, Any]:
    """Its values in the example of its frame, with another one in this row."""
    if frame == "robot.DOWN":
        address, _, code = row.partition(":")
        known = next(c for c in COMMANDS if (c.address, c.command) == (int(address), int(code)))
        items = {item.name: item.high for item in known.items}
        return {"address": known.address, "command": known.command, **items}
    if frame == "auv.ZA":
        return {"code": row, **WORDS_TO_STM32[row]}
    kind = frame_types()[frame]
    raw = next(e.raw for e in examples() if e.type == frame)
    table = kind.table if isinstance(kind, CanFrame) else kind
    assert isinstance(table, BinaryFrame)
    values = {k: v for k, v in kind.decode(raw).items() if k != "flags"}
    item = next(f for f in table.fields if isinstance(f, Number | Raw) and f.name == row)
    return {**values, row: another(item, values[row])}


@contextmanager
def port_of(frame: str) -> Iterator[tuple[str, Any]]:
    if isinstance(frame_types()[frame], CanFrame):
        pytest.importorskip("can", reason="python-can is not installed")
        bus = open_link("board", "can://row?interface=virtual")
        try:
            yield (
                "can://row?interface=virtual",
                lambda: b"".join(rx.data for rx in bus.receive(0.0)),
            )
        finally:
            bus.close()
        return
    with silent_board() as (master, device):
        yield f"serial://{device}", lambda: read_now(master)
