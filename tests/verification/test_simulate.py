"""A flight in simulation: real bytes, both profiles, the same seed gives the same bytes."""

from __future__ import annotations

import contextlib
import gc
import itertools
import json
import math
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from links.simulated.link import SimulatedVehicle
from links.simulated.sea import Sea
from links.simulated.settings import parse_settings
from mission.analysis.replay.replay import replay
from mission.analysis.replay.rerun import failed_writes, feed, runtime_from
from mission.authoring.language import digest, parse
from mission.authoring.prepare import prepare
from mission.commands.simulate import simulate
from mission.model import STOPPED, SURFACED, By, Record
from mission.model.shipped import load_vehicle
from mission.onboard.blackbox import read_records
from mission.onboard.runtime.records import (
    INPUTS,
    OUTPUTS,
    STEP,
    TX,
    ListRecorder,
    read_start,
    read_tx,
)
from mission.verification.rig.rehearsal import Cue
from mission.verification.rig.vehicle import simulated
from mission.verification.simulation import plot
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight, LegFlown
from mission.verification.simulation.flown import Flown
from mission.verification.simulation.legtable import table

ROOT = Path(__file__).resolve().parents[2]
EARLIER = ROOT / "tests" / "analysis" / "recorded" / "heavy-then-ended.mcap"
PROFILES = ("as-built", "documented")
SHORT = """\
mission short vehicle auv
home 30.2874595 120.1535765
safety radius 500 time 15min depth 10 voltage 10
dive: depth 4 heading 0 gear 6 until depth >= 3.5 timeout 90
repeat 2 there:
out: heading 45 gear 6 for 20
end
up: surface timeout 3min
"""
THERE = """\
mission there vehicle auv
home 30.2874595 120.1535765
safety radius 500 time 15min depth 10 voltage 10
assume current 0.2
dive: depth 4 heading 0 gear 6 until depth >= 3.5 timeout 90
there: goto north 60 east 30 gear 8 depth 4 within 10 timeout 5min
up: surface timeout 3min
"""
COLUMNS = ["name", "entered_s", "left_s", "by"]
KEYS = [
    "outcome",
    "reason",
    "digest",
    "mission_time_s",
    "wall_s",
    "real_time_factor",
    "final_state",
    "legs",
    "max_depth_m",
    "max_range_m",
    "navigation_error_m",
    "coverage",
    "purpose",
    "flown",
]


def flown(profile: str = "as-built", seed: int = 0, **more: Any) -> Flight:
    return fly(parse(SHORT), load_vehicle("auv"), profile, seed, **more)


def said(after: float, data: bytes) -> list[Cue]:
    return [Cue(after, data)]


@pytest.fixture
def short(tmp_path: Path) -> Path:
    path = tmp_path / "short.mission"
    path.write_text(SHORT)
    return path


def run(*arguments: object) -> Result:
    return CliRunner().invoke(simulate, [str(a) for a in arguments])


# --- flights ------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("name", ["first-dive", "harbour-survey"])
def test_a_shipped_mission_comes_home_on_both_profiles(name: str, profile: str) -> None:
    from mission.authoring.prepare import prepare

    prepared = prepare(ROOT / "missions" / f"{name}.yaml")
    flight = fly(prepared.mission, prepared.vehicle, profile, 1)
    assert (flight.outcome, flight.final_state) == ("completed", "idle/ready")
    assert flight.at_surface
    assert {leg.by for leg in flight.legs} <= {"until", "for", "end"}
    assert flight.digest == digest(prepared.mission)


def test_legs_are_named_by_group_and_round_and_follow_each_other() -> None:
    flight = flown()
    names = [leg.name for leg in flight.legs]
    assert names == ["dive", "there/out", "there/out#2", "up", "surface"]
    assert flight.legs[0].entered == 0.0
    for before, after in zip(flight.legs, flight.legs[1:], strict=False):
        assert before.left == after.entered
    assert flight.legs[1].left - flight.legs[1].entered == pytest.approx(20.0)
    assert flight.mission_time == flight.legs[-1].left


@pytest.mark.parametrize("profile", PROFILES)
def test_the_same_seed_gives_the_same_bytes(profile: str) -> None:
    sea = parse_settings(["current=0.3@45", "fault=depth_frozen@20+10"])
    first, second = (flown(profile, 7, settings=sea) for _ in range(2))
    assert first.sent == second.sent
    assert first.steps == second.steps
    assert first.samples == second.samples
    other = flown(profile, 8, settings=sea)
    assert [s.true for s in other.samples] != [s.true for s in first.samples]


class _Collecting(ListRecorder):
    """Looks for garbage itself, and counts it once the mission is compiled; raises ``error``."""

    def __init__(self, error: Exception | None = None) -> None:
        super().__init__()
        self.error, self.enabled, self.garbage = error, set[bool](), 0

    def record(self, record: Record) -> None:
        super().record(record)
        self.enabled.add(gc.isenabled())
        if len(self.records) % 50 == 0:
            found = gc.collect()
            self.garbage += found if len(self.records) > 50 else 0
        if self.error and len(self.records) == 200:
            raise self.error


@pytest.mark.parametrize("enabled", [True, False])
@pytest.mark.parametrize("error", [None, KeyError("a fault of the program")])
def test_a_flight_needs_no_collector_and_leaves_it_as_it_was(
    enabled: bool, error: Exception | None
) -> None:
    recorder = _Collecting(error)
    gc.collect()
    gc.freeze()  # what is there already is none of the flight's, and is much in a whole run
    (gc.enable if enabled else gc.disable)()
    try:
        with pytest.raises(KeyError) if error else contextlib.nullcontext():
            flown(recorder=recorder)
        assert gc.isenabled() is enabled
    finally:
        gc.enable()
    assert recorder.enabled == {False}
    assert recorder.garbage == 0


def test_every_byte_to_the_vehicle_has_a_reason() -> None:
    assert all(tx.reason for tx in flown().sent)


@pytest.mark.parametrize("profile", PROFILES)
def test_a_leg_that_steers_never_stops_the_thrusters_on_its_way(profile: str) -> None:
    recorder = ListRecorder()
    flight = fly(parse(THERE), load_vehicle("auv"), profile, 1, recorder=recorder)
    assert flight.outcome == "completed"
    sent = [read_tx(record) for record in recorder.records if record.kind == TX]
    steered = [tx.data for tx in sent if tx.reason.startswith("there steers")]
    assert len(steered) > 5
    assert b"@ZAX0$" not in steered


@pytest.mark.parametrize("profile", PROFILES)
def test_a_stop_by_the_operator_stops_at_once_and_stays(profile: str) -> None:
    flight = flown(profile, said=said(30.0, b"@ZAX0$"))
    assert (flight.outcome, flight.final_state) == ("emergency", STOPPED)
    assert flight.legs[-1].by == "operator"
    assert flight.at_surface  # buoyancy brings it up
    after = [
        tx for tx in flight.sent if tx.link == "vehicle" and tx.t >= flight.legs[-1].left + 5.0
    ]
    assert {tx.data for tx in after} <= {b"@ZAX0$"}


@pytest.mark.parametrize("profile", PROFILES)
def test_an_emergency_surfacing_ends_proved_at_the_surface(profile: str) -> None:
    flight = flown(profile, said=said(30.0, b"@ZAWF$"))
    assert (flight.outcome, flight.final_state) == ("emergency", SURFACED)
    assert flight.at_surface
    reported = [tx for tx in flight.sent if tx.link == "topside" and tx.data.startswith(b"@VS")]
    assert len(reported) == 1  # R11, unasked


def test_a_stick_interrupts_and_the_mission_goes_on_with_the_same_leg() -> None:
    start = 12.0
    script = [Cue(start + 0.2 * i, b"@MMF3$") for i in range(10)]
    script += [Cue(start + 5.0, b"@AA$")]
    flight = flown(said=script)
    assert flight.outcome == "completed"
    interrupted = [leg for leg in flight.legs if leg.by == "operator"]
    assert len(interrupted) == 1
    again = flight.legs[flight.legs.index(interrupted[0]) + 1]
    assert again.name.partition("#")[0] == interrupted[0].name.partition("#")[0]


def test_a_vehicle_that_falls_silent_is_an_emergency_and_comes_up() -> None:
    flight = flown(settings=parse_settings(["fault=stm32_silent@40+1000"]))
    assert flight.outcome == "emergency"
    assert "telemetry" in flight.reason or "silen" in flight.reason or "answer" in flight.reason


def test_a_mission_that_the_pi_refuses_is_not_flown() -> None:
    lines = ["mission short vehicle auv", "a: depth 500 timeout 10"]
    flight = flown(lines=lines)
    assert (flight.outcome, flight.final_state) == ("failed", "idle/empty")
    assert "refused" in flight.reason
    assert flight.legs == ()
    assert not [tx for tx in flight.sent if tx.link == "vehicle"]


@pytest.mark.parametrize("profile", PROFILES)
def test_what_is_recorded_replays_to_the_last_bit(profile: str) -> None:
    first, again = ListRecorder(), ListRecorder()
    flown(profile, 3, recorder=first, said=said(40.0, b"@ZAWF$"))
    start, records = read_start(first.records[0]), first.records[1:]
    runtime = runtime_from(start, failed_writes(records), again)
    for record in records:
        if record.kind in INPUTS:
            feed(runtime, record)
    assert again.records == first.records
    assert {record.kind for record in first.records} >= {STEP, TX} <= OUTPUTS


# --- the command ------------------------------------------------------------------------------------


def test_json_is_exactly_the_object_of_the_design(short: Path) -> None:
    result = run(short, "--json")
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    assert list(found) == KEYS
    assert [list(leg) for leg in found["legs"]] == [COLUMNS] * 5
    assert list(found["navigation_error_m"]) == ["end", "p95"]
    assert found["outcome"] == "completed"
    assert found["max_depth_m"] == pytest.approx(4.0, abs=0.5)
    assert result.stdout.count("\n") == 1


def test_people_get_a_table(short: Path) -> None:
    result = run(short, "--profile", "documented", "--seed", "4")
    assert result.exit_code == 0
    assert "there/out#2" in result.stdout
    assert "completed: the mission's end was reached" in result.stdout


SEA = ("--seed", "4", "--set", "current=0.2@45", "--set", "compass_bias=-3.5")


def test_what_was_flown_is_told_as_data(short: Path) -> None:
    told = json.loads(run(short, "--json", "--profile", "documented", *SEA).stdout)["flown"]
    current = {"speed_m_s": 0.2, "towards_deg": 45.0}
    assert told == {
        "mission": "short",
        "vehicle": "auv",
        "profile": "documented",
        "seed": 4,
        "settings": ["current=0.2@45", "compass_bias=-3.5"],
        "sea": {"current": current, "deep_current": current, "floor_m": 30.0},
        "compass_bias_deg": -3.5,
    }


def test_what_was_flown_is_told_in_words(short: Path) -> None:
    rows = run(short, *SEA).stdout.splitlines()
    assert rows[-5:] == [
        "simulated         short on auv, as-built",
        "sea               current 0.2 m/s towards 45 deg, floor at 30 m",
        "set               current=0.2@45 compass_bias=-3.5",
        "seed              4",
        "compass bias      -3.5 deg (true)",
    ]


def test_a_compass_bias_that_the_seed_drew_is_the_one_that_is_told(short: Path) -> None:
    told = json.loads(run(short, "--json", "--seed", "4").stdout)["flown"]
    vehicle = simulated(load_vehicle("auv"), 4)
    assert isinstance(vehicle, SimulatedVehicle)
    assert told["compass_bias_deg"] == round(math.degrees(vehicle.sensors.compass_bias), 3) != 0.0


def test_an_emergency_is_exit_1(short: Path) -> None:
    result = run(short, "--json", "--set", "fault=stm32_silent@40+1000")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["outcome"] == "emergency"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["absent.mission"], "absent.mission"),
        (["{short}", "--set", "curent=1"], "curent"),
        (["{short}", "--param", "x"], "NAME=VALUE"),
        (["{short}", "--vehicle", "nessie"], "nessie"),
    ],
)
def test_what_cannot_be_read_is_exit_2_and_told_on_stderr(
    short: Path, arguments: list[str], words: str
) -> None:
    result = run(*(a.replace("{short}", str(short)) for a in arguments))
    assert result.exit_code == 2
    assert result.stdout == ""
    assert words in result.stderr


def test_a_mission_with_errors_is_told_with_lines_and_not_flown(tmp_path: Path) -> None:
    path = tmp_path / "bad.mission"
    path.write_text(
        SHORT.replace("gear 6 for 20", "gear 60 for 20").replace("timeout 90", "tmeout 90")
    )
    result = run(path, "--json")
    assert result.exit_code == 2
    assert f"{path}:4:" in result.stderr
    assert f"{path}:6:" in result.stderr
    told = json.loads(result.stdout)
    assert not told["ok"]
    assert [row["line"] for row in told["refusals"]] == [4, 6]
    assert all(row["code"] and row["message"] for row in told["refusals"])
    assert any(row["hint"] for row in told["refusals"])


@pytest.mark.proof
def test_the_report_holds_the_track_and_a_black_box_that_replays(
    short: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "a" / "report"
    folder.mkdir(parents=True)
    shutil.copy(EARLIER, folder / "flight.mcap")  # an earlier one,
    (folder / "track.png").write_bytes(b"an earlier one")  # which this one replaces
    assert run(short, "--report", folder).exit_code == 0
    assert (folder / "track.png").read_bytes().startswith(b"\x89PNG")
    assert replay(list(read_records(folder / "flight.mcap"))).identical


def test_a_report_that_cannot_be_written_is_told(short: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = run(short, "--report", tmp_path / "file" / "report")
    assert result.exit_code == 2
    assert "file/report" in result.stderr


def test_the_table_names_the_guard_and_what_it_saw(short: Path) -> None:
    rows = run(short).stdout.splitlines()
    assert re.search(r"^dive .* until +depth >= 3\.5 m \(depth \d+\.?\d* m\)$", rows[1])
    assert re.search(r"^there/out .* for +after 20 s$", rows[2])
    assert re.search(r"^up .* end +at the surface$", rows[4])
    assert all(row.isascii() for row in rows)


def test_the_table_says_why_a_leg_was_cut_short(short: Path) -> None:
    rows = run(short, "--set", "fault=depth_frozen@40").stdout
    assert re.search(r" limit +limit depth unknown: submerged", rows)


def test_every_leg_of_a_picture_has_a_number_and_neighbours_differ_in_colour() -> None:
    legs = [LegFlown(f"l{i}", float(i), i + 1.0, "for") for i in range(20)]
    again = LegFlown("l3#2", 20.0, 21.0, "for")
    marks = list(plot.marks_of([*legs, again]).values())
    assert [mark.number for mark in marks] == list(range(1, 21))
    assert all(a.colour != b.colour for a, b in itertools.pairwise(marks))


def test_a_picture_of_a_flight_that_never_began_says_why(tmp_path: Path) -> None:
    flight = flown(lines=["mission short vehicle auv", "a: depth 500 timeout 10"])
    sea = Sea(current=(0.123456, 0.0), floor=20.04)
    caption = Flown("short", "auv", "", 7, ("floor=20",), sea, None).caption
    assert caption == "current 0.123 m/s towards 0 deg, floor at 20 m, set floor=20, seed 7"
    assert "refused" in plot.title_of(flight, "short")
    assert plot.title_of(flight, "short", caption).endswith(f"\n{caption}")
    plot.draw_flight(flight, tmp_path / "track.png", "short", caption)
    assert (tmp_path / "track.png").stat().st_size > 1000


def test_the_table_names_the_reading_that_a_leg_was_blind_of() -> None:
    ready = prepare("first-dive")
    edge = next(e for e in ready.chart.edges if e.by is By.ELSE)
    blind = LegFlown("dive", 0.0, 9.0, "else", edge.trigger, (("elapsed", 9.0), ("depth", None)))
    flight = replace(flown(), legs=(blind,))
    assert table(flight, ready.chart).splitlines()[1].endswith("refused or blind (depth unknown)")


@pytest.mark.proof
def test_forty_legs_fit_into_the_picture_and_no_number_hides_another() -> None:
    flight = flown()
    every = flight.mission_time / 40.0
    legs = tuple(LegFlown(f"survey_line_{i}", i * every, (i + 1) * every, "for") for i in range(40))
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 10.0), layout="constrained")
    FigureCanvasAgg(figure)
    plot.drawn(figure, replace(flight, legs=legs), "many")
    figure.canvas.draw()
    plan, profile = figure.axes
    legend = profile.get_legend()
    assert legend is not None
    key = legend.get_window_extent()
    assert key.x0 >= 0.0
    assert key.x1 <= figure.bbox.x1
    for axes in (plan, profile):
        boxes = [text.get_window_extent() for text in axes.texts]
        assert len(boxes) >= 5
        assert not [1 for a, b in itertools.combinations(boxes, 2) if a.overlaps(b)]
