"""Every row of every document in frames that were written from the documents alone (held_out)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from from_code.rows import NOBODY, ROWS, UP
from held_out import FRAMES, MAGNETIC, PWM, Written, of

from mission.model.shipped import load_vehicle
from protocol.framing import Frame
from protocol.messages import Telemetry
from protocol.vehicles import codec, frame_types, link

WORDS = ("auv.ZA", "robot.DOWN")  # a row is a word
CASES = [(name, n, one) for name, every in FRAMES.items() for n, one in enumerate(every)]
IDS = [f"{name}-{n}" for name, n, _ in CASES]


def read(name: str, one: Written) -> Mapping[str, Any]:
    framer = link(one.link).framer()
    (frame,) = framer.receive(one.raw, 0.0)
    assert isinstance(frame, Frame), frame
    assert (frame.type.name, frame.raw) == (name, one.raw)
    return frame.values()


def test_the_frames_have_every_row_of_every_document() -> None:
    assert set(FRAMES) == set(frame_types())
    assert [row for row in ROWS if not list(of(*row))] == []


@pytest.mark.parametrize(("frame", "row"), ROWS)
def test_a_row_is_read_as_its_document_has_it(frame: str, row: str) -> None:
    """Two values, so that neither a constant nor another row's value would do."""
    seen = set()
    for one in of(frame, row):
        got, said = read(frame, one), {**one.values, **one.derived}
        names = said if frame in WORDS else [row] if row else []
        assert {name: got[name] for name in names} == {name: said[name] for name in names}
        seen.add(str(said.get(row)))
    assert frame in WORDS or not row or len(seen) > 1


@pytest.mark.parametrize(("name", "_n", "one"), CASES, ids=IDS)
def test_a_frame_says_what_was_written_and_nothing_else(name: str, _n: int, one: Written) -> None:
    said = {k: v for k, v in read(name, one).items() if k != "flags" or v}
    assert said == {**one.values, **one.derived}


@pytest.mark.parametrize(("name", "_n", "one"), CASES, ids=IDS)
def test_its_values_are_written_as_the_document_has_them(name: str, _n: int, one: Written) -> None:
    head = 3 if one.link == "coreboard.can" else 0  # identifier and length are the bus's
    assert frame_types()[name].encode(one.values) == one.raw[head:]


# --- what the engine is told of it -----------------------------------------------------------------

Told = Callable[[Telemetry], Any]
In = tuple[Told, Callable[[Any], float]]  # where it stands, and the document's value in SI


def part(name: str, index: int, scale: float = 1.0) -> In:
    return lambda t: getattr(t, name)[index], lambda value: scale * value


def angle(name: str) -> In:
    return lambda t: getattr(t, name), math.radians


def heading(sign: int) -> In:
    """Clockwise from north; the AUV's yaw counts to port (E-V8)."""
    return lambda t: t.heading, lambda value: math.radians(sign * value % 360.0)


def same(name: str) -> In:
    return lambda t: getattr(t, name), float


_BATTERIES = {"control_v": part("batteries", 0), "power_v": part("batteries", 1)}
_PLACE = {
    "lat_deg": part("position", 0, math.pi / 180.0),
    "lon_deg": part("position", 1, math.pi / 180.0),
}
_COMMON = {"roll_deg": angle("roll"), "pitch_deg": angle("pitch"), "leak": same("leak")}
_COMMON |= {name: same(name.rpartition("_")[0]) for name in ("depth_m", "altitude_m")}
_COMMON |= {"temperature_c": same("temperature_c")}
TOLD: Mapping[str, Mapping[str, In]] = {
    "auv.SD": {
        **_COMMON,
        "yaw_deg": heading(-1),
        **{name: part("magnetic", n, 1e-6) for n, name in enumerate(MAGNETIC)},
        **{
            f"pwm_{name}": (part("actuators", n)[0], lambda us: (us - 1500) / 500)
            for n, name in enumerate(PWM)
        },
        "battery_control": part("batteries", 0),
        "battery_power": part("batteries", 1),
    },
    "coreboard.MAIN_TO_PC": {**_COMMON, "yaw_deg": heading(1), **_PLACE, **_BATTERIES},
    "coreboard.SENSOR_TO_MAIN": {**_COMMON, "yaw_deg": heading(1), **_PLACE, **_BATTERIES},
    "rov.UP": {
        "ex_deg": angle("roll"),
        "ey_deg": angle("pitch"),
        "ez_deg": heading(1),
        "depth_m": same("depth"),
        "temperature_c": same("temperature_c"),
        **{
            f"rpm_{name}": part("actuators", n, 1e-3)
            for n, name in enumerate(("left_front", "right_front", "left_up", "right_up"))
        },
    },
    "robot.UP": {
        "speed_mm_s": part("velocity", 0, 1e-3),
        "voltage_mv": part("batteries", 0, 1e-3),
    },
}
REPORTED = [(f, r) for f, r in ROWS if f in UP and r not in NOBODY.get(f, {})]


def reported(frame: str, one: Written) -> Telemetry:
    """By the shipped file's codec, said six times: three confirm a leak."""
    board = codec(*load_vehicle(UP[frame]).speaks)
    found = [said for t in range(6) for said in board.receive(one.raw, float(t))]
    assert isinstance(found[-1], Telemetry)
    return found[-1]


@pytest.mark.parametrize(("frame", "row"), REPORTED)
def test_what_a_board_reports_reaches_the_engine_in_its_units(frame: str, row: str) -> None:
    """What has no place of its own stands under its row's name in ``board``."""
    for one in FRAMES[frame]:
        if not one.values.get("ins_aligned", 1) and row in _PLACE:
            continue  # a place counts once the INS is aligned
        where, si = TOLD[frame].get(row, (lambda t: dict(t.board)[row], float))
        assert where(reported(frame, one)) == pytest.approx(si(one.values[row]), abs=1e-9)
