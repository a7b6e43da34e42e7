"""Vehicle files: what is wrong in one is said with file, key and what there is instead."""

from __future__ import annotations

import math
import random
import re
from pathlib import Path

import pytest

from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, load
from mission.engine.limits import DEPTH_MARGIN
from mission.model.diagnostics import MissionErrors
from mission.model.shipped import load_vehicle, missions_folder
from mission.model.vehicle import FOLLOWS, REPORTS, Beacon, VehicleError
from mission.model.vehicle_file import read_vehicle
from mission.model.vehicle_ranges import RANGES, TOGETHER
from mission.navigation.belief import UNPUSHED, DepthBelief
from mission.navigation.fixes import Receiver
from mission.navigation.health import CHANNELS

SHIPPED = sorted((missions_folder() / "vehicles").glob("*.yaml"))
AUV = (missions_folder() / "vehicles" / "auv.yaml").read_text(encoding="utf-8")


def loaded(folder: Path, old: str, new: str) -> object:
    assert AUV.count(old) == 1
    path = folder / "mine.yaml"
    path.write_text(AUV.replace(old, new), encoding="utf-8")
    return load_vehicle(path)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.stem)
def test_a_shipped_file_says_of_every_sensor_and_axis_whether_it_is_there(path: Path) -> None:
    vehicle = load_vehicle(path)
    text = path.read_text(encoding="utf-8")
    for name in REPORTS | FOLLOWS:
        assert f"\n  {name}: " in text, name
    assert vehicle.reports <= REPORTS
    assert vehicle.follows <= FOLLOWS


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("dive_rate: 0.35", "diverate: 0.35", "diverate"),
        (
            "  voltage: 10 V",
            "  volts: 10 V",
            r"limits: no key volts .*\n.*\n.*\n +did you mean voltage",
        ),
        ("  leak: false", "  leek: true", r"reports: no key leek .*\n.*\n.*\n +did you mean leak"),
        ("  attitude: false", "  yaw: true", "follows: no key yaw"),
        ("bias_deg: 0.0", "bias: 0.0", "compass: no key bias"),
        ("power: 1.0}", "thrusters: 1.0}", "battery_scale: no key thrusters"),
        ("hotel: 35", "house: 35", "battery: no key house"),
        ("  fix: 2.5 m", "  gps: 2.5 m", "sensors: no key gps"),
        ("  turn_slip: 1.8 s", "  slip: 1.8 s", "calibration: no key slip"),
    ],
)
def test_a_key_nobody_knows_is_refused_with_those_there_are(
    tmp_path: Path, old: str, new: str, named: str
) -> None:
    with pytest.raises(VehicleError, match=named):
        loaded(tmp_path, old, new)


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        (
            "codec: auv",
            "codec: submarine",
            r"codec: no vehicle 'submarine' .*\n.*\n.*\n +there are: auv",
        ),
        ("dialect: as-built ", "dialect: spoken ", "codec: no dialect 'spoken' of auv"),
        ("tolerances: {}", "tolerances: {sd: on}", "codec: no tolerance 'sd'"),
    ],
)
def test_what_no_codec_knows_is_refused_when_the_file_is_read(
    tmp_path: Path, old: str, new: str, named: str
) -> None:
    with pytest.raises(VehicleError, match=named):
        loaded(tmp_path, old, new)


def test_a_dialect_belongs_to_its_codec(tmp_path: Path) -> None:
    rov = (missions_folder() / "vehicles" / "rov.yaml").read_text(encoding="utf-8")
    path = tmp_path / "rov.yaml"
    path.write_text(rov.replace("dialect: documented", "dialect: as-built"), encoding="utf-8")
    with pytest.raises(
        VehicleError, match=r"no dialect 'as-built' of rov .*\n.*\n.*\n +there are: documented"
    ):
        load_vehicle(path)


def with_number(key: str, value: str) -> str:
    """The AUV's file, where ``key`` has another number, in its own unit."""
    *tables, name = key.split(".")
    at = 0
    for table in tables:
        at = re.compile(rf"\b{table}:").search(AUV, at).end()  # type: ignore[union-attr]
    found = re.compile(rf"\b{name}: *([^\s,}}]+( [a-zA-Z/]+)?)").search(AUV, at)
    if found is None or (tables == ["calibration"] and found.start() < at):
        raise LookupError(key)
    return AUV[: found.start(1)] + value + AUV[found.end(1) :]


WRITTEN = [key for key in RANGES if key.count(".") < 2 and f"{key.rpartition('.')[2]}:" in AUV]
NUMBERS = [key for key in WRITTEN if key not in ("speed_by_gear", "thruster_power")]


@pytest.mark.parametrize("key", NUMBERS)
def test_a_number_beyond_its_range_is_refused_with_its_line_and_the_range(key: str) -> None:
    row = RANGES[key]
    for value in (row.low - 1e-3 if not row.above else row.low, row.high * 1.001, 1e300):
        with pytest.raises(
            VehicleError, match=rf"^f.yaml:\d+:\d+: .*{key.rpartition('.')[2]}: .* out of range"
        ):
            read_vehicle(with_number(key, f"{value!r} {row.unit}"), "f.yaml")
    for value in ("nan", "1e400", "", "five", "3 fathom", "[1]"):
        with pytest.raises(VehicleError, match=rf"^f.yaml:\d+:\d+: .*{key.rpartition('.')[2]}: "):
            read_vehicle(with_number(key, value), "f.yaml")


def test_most_numbers_of_the_table_stand_in_the_file_that_is_tried() -> None:
    assert len(NUMBERS) > 25


def test_no_figure_is_beyond_what_navigation_believes_of_a_depth() -> None:
    """A limit would never act there, or each dive be contradicted."""
    assert RANGES["limits.depth"].high + DEPTH_MARGIN < CHANNELS["depth"].high
    for period in (0.1, 1.0, 2.0, 4.0):
        fastest = DepthBelief()
        for report in range(round(60.0 / period)):
            t = period * report
            deep = 0.2 + RANGES["dive_rate"].high * t
            fastest.take(t, deep, None, 0.0, UNPUSHED, Receiver())
            assert fastest.reason == ""
    for key in ("ascent_thrust", "ascent_buoyancy"):
        assert RANGES[key].high == RANGES["dive_rate"].high < RANGES["limits.descent_rate"].high


@pytest.mark.parametrize("pair", TOGETHER, ids=lambda pair: pair.more)
def test_two_numbers_that_contradict_each_other_are_refused_with_the_reason(pair) -> None:
    row = RANGES[pair.less]
    text = with_number(pair.less, f"{min(9.0, row.high)} {row.unit}")
    with pytest.raises(VehicleError, match=f"{pair.more.replace('.', ': ')}: .*: {pair.why}"):
        read_vehicle(text, "f.yaml")


@pytest.mark.parametrize("rate", ["0", "-0.1"])
def test_what_drives_says_a_rise_above_0_that_the_check_divides_by(rate: str) -> None:
    text = (missions_folder() / "vehicles" / "robot.yaml").read_text(encoding="utf-8")
    (line,) = (line for line in text.splitlines() if line.startswith("ascent_buoyancy"))
    with pytest.raises(VehicleError, match=r"ascent_buoyancy: not above 0(.*\n)*.* write 0\.1 m/s"):
        read_vehicle(text.replace(line, f"ascent_buoyancy: {rate} m/s"), "mine")
    heavy = AUV.replace("ascent_buoyancy: 0.25", f"ascent_buoyancy: {rate}")
    assert read_vehicle(heavy, "mine").ascent_buoyancy == float(rate), "what dives is measured"


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("{0: 0, 2: 15", "{1: 0, 2: 15", "the first for gear 0"),
        ("10: 600, 12: 600}", "10: 600, 12: 6}", "rows that do not fall"),
        ("10: 600, 12: 600}", "10: 600, 12: -6}", "-6 is out of range"),
        ("10: 600, 12: 600}", "10: 600, 13: 600}", "13 is out of range"),
        ("10: 600, 12: 600}", "10: 600, 10: 600}", "appears twice"),
        ("10: 600, 12: 600}", "10: 600, 10.0: 600}", "a gear appears twice"),
        ("{0: 0, 2: 15, 4: 80, 6: 200, 8: 380, 10: 600, 12: 600}", "{0: 0, 12: 0}", "has nothing"),
    ],
)
def test_figures_by_gear_begin_at_a_standstill_and_do_not_fall(
    tmp_path: Path, old: str, new: str, why: str
) -> None:
    with pytest.raises(VehicleError, match=f"thruster_power.*{why}"):
        loaded(tmp_path, old, new)


def test_all_mistakes_of_a_vehicle_file_are_told_at_once_by_their_lines() -> None:
    text = AUV.replace("dive_rate: 0.35", "dive_rate: -1").replace("leak: false", "leak: maybe")
    text = text.replace("turn_rate: 12 deg/s", "tern_rate: 12").replace("hotel: 35", "hotel: 1e9")
    with pytest.raises(VehicleError) as caught:
        read_vehicle(text, "f.yaml")
    found = caught.value.diagnostics
    assert len(found) == 5
    assert all(d.file == "f.yaml" and d.code and d.hint for d in found)
    lines = [d.where.line for d in found]
    assert lines == sorted(lines)
    assert all(d.text == text.split("\n")[d.where.line - 1] for d in found)
    rows = [d.message for d in found]
    for word in ("dive_rate", "leak", "tern_rate", "turn_rate is missing", "hotel"):
        assert any(word in row for row in rows)


@pytest.mark.proof
def test_a_vehicle_file_with_a_number_spoilt_is_refused_or_is_checked_against() -> None:
    """A small seeded sample of many: nothing but the program's own refusals comes of them."""
    chance = random.Random(21)
    mission = load(missions_folder() / "first-dive.yaml")
    for _ in range(300):
        text = chance.choice(SHIPPED).read_text(encoding="utf-8")
        number = chance.choice(list(re.finditer(r"-?\d+(?:\.\d+)?", text)))
        new = chance.choice(["0", "-0", "-1", "1e-9", "1e9", "nan", "1e400", "9" * 400, "~", "[]"])
        try:
            vehicle = read_vehicle(text[: number.start()] + new + text[number.end() :], "f.yaml")
            check_mission(compile_mission(mission, vehicle, digest(mission)), vehicle)
        except (VehicleError, MissionErrors):
            continue


def test_the_noise_of_added_sensors_may_be_said_and_need_not_be() -> None:
    said = read_vehicle(AUV + "added: {ground: 0.02 m/s, place: 5 m}\n", "mine")
    assert said.added == {"ground": 0.02, "place": 5.0}
    assert read_vehicle(AUV, "mine").added == {}
    for wrong, hint in (("grund: 1", "ground"), ("ground: 9 m/s", "up to 5"), ("place: 1 V", "m")):
        with pytest.raises(VehicleError, match=hint):
            read_vehicle(f"{AUV}added: {{{wrong}}}\n", "mine")


def test_beacons_are_places_and_depths_by_their_numbers() -> None:
    text = "beacons: {3: 30.28800 120.15400 4 m, 17: -30.5, -120.25, 6.5 m, 1480 m/s}\n"
    text = text.replace(
        "17: -30.5, -120.25, 6.5 m, 1480 m/s", '17: "-30.5, -120.25, 6.5 m, 1480 m/s"'
    )
    found = read_vehicle(AUV + text, "mine").beacons
    assert set(found) == {"3", "17"}
    assert found["3"] == Beacon(math.radians(30.288), math.radians(120.154), 4.0, 1500.0)
    assert found["17"] == Beacon(math.radians(-30.5), math.radians(-120.25), 6.5, 1480.0)
    assert read_vehicle(AUV, "mine").beacons == {}


@pytest.mark.parametrize(
    "wrong",
    ["x: 30.0 120.0 4 m", "128: 30.0 120.0 4 m", "3: 30.0 120.0", "3: 91.0 120.0 4 m",
     "3: 30.0 181.0 4 m", "3: 30.0 120.0 4 m 340 m/s", "3: somewhere"],
)  # fmt: skip
def test_what_is_no_beacon_is_refused_with_an_example(wrong: str) -> None:
    with pytest.raises(VehicleError, match=r"30\.28800 120\.15400 4 m|0 to 127"):
        read_vehicle(f"{AUV}beacons: {{{wrong}}}\n", "mine")


def test_its_own_position_drifts_as_fast_as_a_current_unless_the_file_says_how_fast() -> None:
    text = (missions_folder() / "vehicles" / "coreboard.yaml").read_text(encoding="utf-8")
    usual, stated = read_vehicle(text, "a"), read_vehicle(f"{text}\nreckoning: 0.02 m/s\n", "a")
    assert (usual.reckoning, usual.reckoned) == (None, usual.current)
    assert stated.reckoned == 0.02
    with pytest.raises(VehicleError, match="reckoning: 20 m/s is out of range"):
        read_vehicle(f"{text}\nreckoning: 20 m/s\n", "a")
