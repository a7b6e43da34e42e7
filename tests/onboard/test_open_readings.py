"""What the documents leave open or boards change: each key changes the bytes that it names, and no
others; without it the document decides."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from test_other_vehicles import TEXTS

from mission.authoring.language import parse
from mission.model.shipped import load_vehicle
from mission.verification.simulation.flight import fly
from protocol.examples import MAIN_TO_PC, PC_TO_MAIN, ROV_UP, SENSOR_TO_MAIN, examples
from protocol.framing import Frame
from protocol.messages import Fix, Order, Setpoint, Status, Telemetry
from protocol.tolerances import Tolerances
from protocol.topside import ConsoleCodec, encode
from protocol.vehicles import codec, coreboard, frame_types, link


def decoded(name: str, raw: bytes, **tolerances: str) -> dict[str, object] | None:
    """None for what is no frame."""
    (item, *_) = link(name).framer(Tolerances.parse(tolerances)).receive(raw, 0.0) or [None]
    return item.values() if isinstance(item, Frame) else None


def report(raw: bytes, times: int = 1, name: str = "coreboard", **tolerances: str) -> Telemetry:
    board = codec(name, "documented", tolerances)
    told = [board.receive(raw, float(i))[0] for i in range(times)][-1]
    assert isinstance(told, Telemetry)
    return told


# --- 002 ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["main_to_pc", "sensor_to_main", "pc_to_main"])
def test_longitude_may_stand_first(name: str) -> None:
    frames = {"main_to_pc": MAIN_TO_PC, "sensor_to_main": SENSOR_TO_MAIN, "pc_to_main": PC_TO_MAIN}
    usual = decoded(f"coreboard.{name}", frames[name])
    other = decoded(f"coreboard.{name}", frames[name], place002="lon")
    if name == "pc_to_main":  # a latitude beyond 90 is a command that is refused
        assert usual is not None
        assert other is None
        return
    assert usual is not None
    assert other is not None
    assert (other["lat_deg"], other["lon_deg"]) == (usual["lon_deg"], usual["lat_deg"])
    same = {k: v for k, v in usual.items() if k not in ("lat_deg", "lon_deg", "flags")}
    assert same == {k: v for k, v in other.items() if k in same}


@pytest.mark.parametrize(("code", "leaks"), [(0, False), (1, True), (7, True)])
def test_one_is_a_leak_or_zero_is_and_an_unknown_code_is_one_either_way(
    code: int, leaks: bool
) -> None:
    frame = coreboard.main_to_pc(Tolerances())
    values = decoded("coreboard.main_to_pc", MAIN_TO_PC)
    assert values is not None
    raw = frame.pack(values | {"leak": code})
    assert report(raw, 3).leak is leaks
    assert report(raw, 3, leak002="0").leak is (leaks if code == 7 else not leaks)


@pytest.mark.parametrize(
    ("leak002", "leak23", "leak", "legacy", "disagree"),
    [
        *(("1", "0", leak, legacy, leak == legacy) for leak in (0, 1) for legacy in (0, 1)),
        *(("0", "0", leak, legacy, leak != legacy) for leak in (0, 1) for legacy in (0, 1)),
        *(("1", "1", leak, legacy, leak != legacy) for leak in (0, 1) for legacy in (0, 1)),
        *(("0", "1", leak, legacy, leak == legacy) for leak in (0, 1) for legacy in (0, 1)),
    ],
)
def test_the_older_leak_byte_is_compared_in_its_own_sense(
    leak002: str, leak23: str, leak: int, legacy: int, disagree: bool
) -> None:
    usual = decoded("coreboard.sensor_to_main", SENSOR_TO_MAIN)
    assert usual is not None
    frame = coreboard.sensor_to_main(Tolerances())
    raw = frame.encode(usual | {"leak": leak, "leak_legacy_raw": legacy})
    told = decoded("coreboard.sensor_to_main", raw, leak002=leak002, leak23=leak23)
    assert told is not None
    flags = told["flags"]
    assert isinstance(flags, list)
    assert ("leak_legacy_raw:disagrees" in flags) == disagree


CORE = [n for n in frame_types() if n.startswith("coreboard.") and "CAN" not in n]


@pytest.mark.parametrize("name", CORE)
def test_either_tail_is_heard_where_it_is_allowed_and_the_tables_is_sent(name: str) -> None:
    either = frame_types(Tolerances.parse({"tail002": "either"}))[name]
    usual = frame_types()[name]
    raw = next(example.raw for example in examples() if example.type == name)
    own = raw[-2:]
    other = raw[:-2] + (b"\xfd\xdf" if own == b"\xfa\xaf" else b"\xfa\xaf")
    assert usual.check(other) == "bad_tail"
    assert either.check(other) is None
    assert either.check(raw[:-2] + b"\x00\x00") == "bad_tail"
    assert either.encode(either.decode(raw))[-2:] == own


# --- 003 ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [-1.0, -0.25, 0.0, 0.5, 1.0])
def test_the_rovs_effort_is_a_share_or_a_percentage(share: float) -> None:
    for full, name in ((1.0, "1"), (100.0, "100")):
        (raw,) = codec("rov", "documented", {"effort003": name}).encode(Setpoint(surge=share))
        told = decoded("rov.down", raw, effort003=name)
        assert told is not None
        assert told["x"] == share * full
    assert decoded("rov.down", raw) is None or abs(share) <= 0.01


def test_the_older_layout_of_the_rov_is_50_bytes_up_and_28_down() -> None:
    legacy = {"layout003": "legacy"}
    up = frame_types(Tolerances.parse(legacy))["rov.UP"]
    usual = decoded("rov.up", ROV_UP)
    assert usual is not None
    raw = up.encode(usual)
    assert (len(raw), raw[3]) == (50, 0x2B)
    told = report(raw, name="rov", **legacy)
    assert told.depth == pytest.approx(usual["depth_m"])
    assert (told.temperature_c, told.actuators) == (None, None)
    (down,) = codec("rov", "documented", legacy).encode(Setpoint(surge=0.5, heave=-0.5))
    assert (len(down), down[3]) == (28, 0x15)
    values = decoded("rov.down", down, **legacy)
    assert values is not None
    assert (values["x"], values["f"]) == (0.5, 0.5)
    assert "led_pct" not in values
    assert decoded("rov.down", down) is None
    assert decoded("rov.up", raw) is None


# --- @VS ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("unit", "told"), [("cm/s", b",150,"), ("m/s", b",1.5,"), ("km/h", b",5.4,"), ("kn", b",2.92,")]
)
def test_the_ground_speed_of_a_status_is_told_in_the_unit_that_topside_expects(
    unit: str, told: bytes
) -> None:
    tolerances = Tolerances.parse({"vs_speed": unit})
    status = Status("2025-01-19T23:26:25", Fix(0.0, 0.5, 2.0, 1.0, speed=1.5, elevation=7.0))
    raw = encode(status, tolerances)
    assert b",7" + told in raw
    (heard,) = ConsoleCodec(tolerances).receive(raw, 0.0)
    assert isinstance(heard, Status)
    assert heard.fix is not None
    assert heard.fix.speed == pytest.approx(1.5, rel=0.01)


@pytest.mark.parametrize(("unit", "told"), [("nT", b",53191,"), ("uT", b",53.191,")])
def test_the_magnetometers_of_a_status_are_told_in_the_unit_that_topside_expects(
    unit: str, told: bytes
) -> None:
    tolerances = Tolerances.parse({"vs_mag": unit})
    raw = encode(Status(None, None, Telemetry(0.0, magnetic=(53.191e-6,) * 9)), tolerances)
    assert raw.count(told) >= 4
    (heard,) = ConsoleCodec(tolerances).receive(raw, 0.0)
    assert isinstance(heard, Status)
    assert heard.telemetry is not None
    assert heard.telemetry.magnetic == pytest.approx((53.191e-6,) * 9)


# --- a board that was built otherwise flies -------------------------------------------------------

BUILT = [
    ("coreboard", {"place002": "lon", "leak002": "0", "tail002": "either"}, {}),
    ("coreboard", {"float_order": "high"}, {"usbl_on": "1", "angle_error_step": "0.1"}),
    ("rov", {"effort003": "100"}, {}),
    ("rov", {"layout003": "legacy", "float_order": "high"}, {}),
    ("robot", {"mod": "256"}, {"full_speed": "500", "speed_step": "10"}),
]


@pytest.mark.proof
@pytest.mark.parametrize(("name", "tolerances", "wire"), BUILT, ids=lambda value: str(value)[:40])
def test_a_board_that_was_built_otherwise_flies_by_its_vehicle_file(
    name: str, tolerances: dict[str, str], wire: dict[str, str]
) -> None:
    vehicle = replace(load_vehicle(name), tolerances=tolerances, wire=wire, outputs=())
    flight = fly(parse(TEXTS[name]), vehicle, seed=3)
    assert flight.outcome == "completed", flight.reason
    stop = codec(*vehicle.speaks).encode(Order.STOP)[-1]
    assert stop in [tx.data for tx in flight.sent if tx.link == "vehicle"]
    assert not math.isnan(flight.max_depth)
