"""A vehicle is a codec with its row, a vehicle file, and a simulated board: this file has all three
of a toy that nobody else knows, and it is seen everywhere."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from contracts import keep

from links.simulated.board_faults import LINE, OF_BOARDS
from links.simulated.boards import BOARDS
from links.simulated.firmware.boards import WaterBoard
from links.simulated.firmware.ins import Place
from links.simulated.firmware.stm32 import level_pwm
from links.simulated.plant import NEUTRAL_PWM, Plant
from mission.analysis.replay.replay import replay
from mission.authoring.prepare import Prepared, Unreadable, check_prepared, prepare
from mission.cli import main
from mission.model.shipped import load_vehicle, missions_folder
from mission.onboard.doctor.boards import board
from mission.onboard.runtime.records import TX, ListRecorder
from mission.verification.campaign.draw import Subject, draw
from mission.verification.simulation.flight import fly
from protocol.checksum import sum256
from protocol.codec import Received
from protocol.fields import I8, U16LE, BinaryFrame, Check, Const
from protocol.framing import Frame, LinkRow
from protocol.messages import Order, Setpoint, Telemetry
from protocol.reference import reference
from protocol.tolerances import Tolerances
from protocol.vehicles import VEHICLES, VehicleRow, codec, frame_types, line_rate, silent
from protocol.vehicles.adapter import SilentBoard, fraction, refuse
from protocol.vehicles.keys import Keys, Wire, baud, read_wire
from protocol.vehicles.stick import stick_keys

# --- the codec, and its row ----------------------------------------------------------------

KEYS: Keys = (baud(57_600), *stick_keys("surge", "turn", "heave"))
SUM, END = Check(sum256, "B"), Const(b"\n")
THRUSTS = tuple(I8(f"{axis}_pct", -100, 100) for axis in ("surge", "turn", "down"))
DOWN = BinaryFrame(
    "sled.DOWN", "the sled's manual", (Const(b">S"), *THRUSTS, SUM, END), command=True
)
UP = BinaryFrame(
    "sled.UP",
    "the sled's manual",
    (Const(b"<S"), U16LE("depth_cm"), U16LE("heading_ddeg", 0, 3599), SUM, END),
)
SLED_LINKS = (LinkRow("sled.down", lambda _: (DOWN,)), LinkRow("sled.up", lambda _: (UP,)))


def telemetry(frame: Frame) -> Received:
    values = frame.values()
    heading = math.radians(values["heading_ddeg"] / 10.0)
    return Telemetry(frame.t, values["depth_cm"] / 100.0, heading=heading)


class SledCodec(SilentBoard):
    period, silence = 0.05, 0.5  # s

    def __init__(
        self, dialect: str, tolerances: Tolerances, scale: tuple[float, float], wire: Wire
    ) -> None:
        super().__init__(SLED_LINKS[1].framer(tolerances), telemetry, wire or read_wire(KEYS, {}))

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        if setpoint is Order.STOP:
            setpoint = Setpoint()
        if setpoint is Order.SURFACE:
            setpoint = Setpoint(heave=-1.0)
        none = "the sled controls thrust alone"
        refuse(setpoint, heading=none, depth=none, altitude=none, pitch=none, roll=none)
        given = (
            ("surge", setpoint.surge),
            ("turn", setpoint.turn),
            ("down", setpoint.heave or 0.0),
        )
        return [DOWN.encode({f"{axis}_pct": round(100 * fraction(axis, v)) for axis, v in given})]


ROW: VehicleRow = silent(
    "sled",
    SledCodec,
    KEYS,
    links=SLED_LINKS,
    examples=(
        ("sled.DOWN", DOWN.encode({"surge_pct": 50, "turn_pct": 0, "down_pct": -20})),
        ("sled.UP", UP.encode({"depth_cm": 250, "heading_ddeg": 900})),
    ),
)

# --- its simulated board -------------------------------------------------------------------


class SledBoard(WaterBoard):
    hears, period, silence = SLED_LINKS[0], 0.1, 0.5

    def take(self, values: Mapping[str, Any]) -> None:
        self.values = values

    def control(self, plant: Plant, now: float) -> tuple[int, ...]:
        told = self.values if self.awake(now) else {}
        surge, turn, down = (told.get(f"{a}_pct", 0) * 0.12 for a in ("surge", "turn", "down"))
        return level_pwm(surge + turn, surge - turn, -down, (NEUTRAL_PWM, NEUTRAL_PWM))

    def report(self, plant: Plant, place: Place, now: float) -> bytes:
        _, _, yaw, depth = self._pose(plant, now)
        tenths = round(yaw % 360.0 * 10) % 3600
        body = b"<S" + max(0, round(depth * 100)).to_bytes(2, "little")
        body += tenths.to_bytes(2, "little")
        return body + bytes([sum(body) & 0xFF]) + b"\n"


# --- its vehicle file, and a mission ----------------------------------------------------------

ROV = (missions_folder() / "vehicles" / "rov.yaml").read_text(encoding="utf-8")
MISSION = (
    "start without fix\nsafety radius 150 time 20min depth 20\nassume current 0\n"
    "dive: down 6 until depth > 3 timeout 30\nout: up 0 gear 4 for 30\nhome_up: surface timeout 3min\n"
)


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setitem(BOARDS, "sled", SledBoard)
    monkeypatch.setitem(OF_BOARDS, "sled", LINE)
    with VEHICLES.registered(ROW):
        yield


@pytest.fixture
def sled(tmp_path: Path) -> Path:
    begin, _, rest = ROV.partition("outputs:")
    text = begin + "limits:" + rest.partition("limits:")[2]
    begin, _, rest = text.partition("outer_loop:")
    text = begin + "speed_by_gear:" + rest.partition("speed_by_gear:")[2]
    text = text.replace("  heading: true              # by", "  heading: false  # not by")
    text = text.replace("  depth: true                # by", "  depth: false  # not by")
    for old, new in (("rov\n", "sled\n"), ("attitude: true", "attitude: false")):
        text = text.replace(old, new)
    text = text.replace("temperature: true", "temperature: false")
    path = tmp_path / "sled.yaml"
    path.write_text(text)
    return path


def prepared(folder: Path, sled: Path, text: str = MISSION) -> Prepared:
    (folder / "m.mission").write_text(text)
    return prepare(folder / "m.mission", str(sled))


def test_its_file_is_read_and_its_line_has_its_rate(sled: Path) -> None:
    assert load_vehicle(sled).codec == "sled"
    assert line_rate("sled") == 57_600
    assert isinstance(codec("sled", "documented", {}), SledCodec)


def test_its_frames_are_in_the_reference_and_in_the_commands_that_speak_them() -> None:
    assert {"sled.DOWN", "sled.UP"} <= set(frame_types())
    text = reference()
    assert "### sled.DOWN" in text
    assert "3e5332" in text.replace(" ", "").lower()
    values = '{"surge_pct": 50, "turn_pct": 0, "down_pct": 0}'
    ran = CliRunner().invoke(main, ["encode", "sled.DOWN", values, "--hex"])
    assert ran.output.startswith("3e5332")
    raw = UP.encode({"depth_cm": 250, "heading_ddeg": 900}).hex()
    ran = CliRunner().invoke(main, ["decode", "--link", "sled.up", "--hex", "-"], input=raw)
    assert "depth_cm                          250" in ran.output


def test_a_mission_is_proved_for_it_or_refused_by_what_it_lacks(tmp_path: Path, sled: Path) -> None:
    assert check_prepared(prepared(tmp_path, sled)).ok
    with pytest.raises(Unreadable, match="sled cannot follow depth"):
        prepared(tmp_path, sled, "start without fix\na: depth 3 for 20\n")


@pytest.mark.proof
def test_it_is_flown_on_its_own_board_recorded_and_replayed_to_the_bit(
    tmp_path: Path, sled: Path
) -> None:
    ready, recorder = prepared(tmp_path, sled), ListRecorder()
    flight = fly(ready.mission, ready.vehicle, seed=2, recorder=recorder)
    assert flight.outcome == "completed"
    assert [leg.name for leg in flight.legs][:2] == ["dive", "out"]
    assert flight.max_depth > 2.5
    sent = [record.payload for record in recorder.of(TX)]
    assert any(b">S" in data for data in sent)
    assert replay(recorder.records).identical


def test_every_command_takes_it(tmp_path: Path, sled: Path) -> None:
    path = tmp_path / "m.mission"
    path.write_text(MISSION)
    svg = tmp_path / "m.svg"
    for words in (["check"], ["graph", "-o", str(svg)], ["plan", "-o", str(svg)], ["convert"]):
        given = [] if words[0] == "convert" else ["--vehicle", str(sled)]
        ran = CliRunner().invoke(main, [*words, str(path), *given])
        assert ran.exit_code == 0, (words, ran.output)


def test_the_campaign_draws_flights_of_it_with_what_can_fail_of_it(
    tmp_path: Path, sled: Path
) -> None:
    made = replace(prepared(tmp_path, sled).mission, vehicle="sled")
    plans = [draw(0, n, [Subject(tmp_path / "m.mission", made, 120.0)], 0.0) for n in range(40)]
    drawn = {fault.name for plan in plans for fault in plan.settings.faults}
    assert drawn
    assert drawn <= set(LINE)
    assert any(plan.incidents for plan in plans)


def test_it_keeps_the_contract_of_vehicles() -> None:
    keep("vehicles", ROW)


def test_the_doctor_has_words_for_it(sled: Path) -> None:
    found = board(load_vehicle(sled))
    assert "sled" in found.name
    assert found.switch


def test_a_second_one_with_its_links_is_refused() -> None:
    twin = silent("twin", SledCodec, KEYS, links=SLED_LINKS[:1])
    with pytest.raises(ValueError, match=r"twin: the link sled\.down is there already"):
        VEHICLES.register(twin)
