"""Rehearsals: what is drawn, what many flights say together, and that each can be flown again."""

from __future__ import annotations

import json
import math
import re
import shlex
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
from click.testing import CliRunner

from links.simulated.settings import parse_settings
from mission.authoring.language import parse
from mission.authoring.prepare import prepare, prepare_text
from mission.cli import main
from mission.model.shipped import load_vehicle
from mission.onboard.runtime import mission_validator
from mission.verification.rehearsing.flights import Flown, Rehearsed, energy_of, rehearsed
from mission.verification.rehearsing.page import html_page
from mission.verification.rehearsing.report import as_text, quantile, regions, report_of, wilson
from mission.verification.rehearsing.sea import drawn, sea_of
from mission.verification.simulation.coverage import Coverage
from mission.verification.simulation.flight import fly
from mission.verification.workers.places import Place

DIVE = prepare("first-dive")
FLIGHTS = 4
BAY = "ncols 2\nnrows 2\nxllcorner 120\nyllcorner 30\ncellsize 0.5\n20 20\n20 20\n"


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, object], Path]:
    picture = tmp_path_factory.mktemp("rehearsal") / "a.png"
    command = ["rehearse", "first-dive", "--flights", str(FLIGHTS), "--seed", "5", "--workers", "1"]
    run = CliRunner().invoke(main, [*command, "--json", "-o", str(picture)])
    assert run.exit_code == 0, run.output
    return json.loads(run.stdout), picture


def flown(number: int, true: float = 1.0, outcome: str = "completed", error: float = 1.0) -> Flown:
    return Flown(number, ("current=0.1@0",), outcome, "", 60.0 + number, 3600.0, error,
                 (Coverage("mow", true, 1.0),), (float(number), 0.0),
                 (("time", 0.1 * number),))  # fmt: skip


def test_the_sea_is_within_what_the_mission_assumes_and_fills_it() -> None:
    seas = [parse_settings(drawn(DIVE.mission, DIVE.vehicle, 0, n)) for n in range(400)]
    speeds = sorted(s.sea.current[0] for s in seas)
    most = DIVE.mission.current(DIVE.vehicle.current)
    assert speeds[-1] <= most + 5e-4
    # alike over the disc: half of the flights beyond 1 / sqrt(2) of its radius
    assert quantile(speeds, 0.5) == pytest.approx(most / math.sqrt(2.0), rel=0.08)
    directions = [s.sea.current[1] for s in seas]
    assert max(directions) - min(directions) > math.radians(350.0)


def test_the_vehicle_errs_as_its_file_says() -> None:
    seas = [parse_settings(drawn(DIVE.mission, DIVE.vehicle, 0, n)) for n in range(400)]
    biases = [s.errors.compass_bias for s in seas if s.errors.compass_bias is not None]
    sigma = math.sqrt(sum(b * b for b in biases) / len(biases))
    assert sigma == pytest.approx(DIVE.vehicle.sensors.heading_bias, rel=0.15)
    assert len({s.thrust for s in seas}) > 100


def test_a_seed_draws_the_same_sea_and_another_seed_another() -> None:
    assert drawn(DIVE.mission, DIVE.vehicle, 1, 7) == drawn(DIVE.mission, DIVE.vehicle, 1, 7)
    assert drawn(DIVE.mission, DIVE.vehicle, 1, 7) != drawn(DIVE.mission, DIVE.vehicle, 2, 7)


def test_a_worker_judges_a_mission_once_and_its_flights_are_as_if_each_had(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    short = (
        "mission m vehicle auv\nassume current 0.1\nsafety depth 5 time 20min\n"
        "out: gear 6 heading 90 depth 2 for 10s\nup: surface timeout 2min\n"
    )
    ready = prepare_text(short, "m.mission")
    judged, really = [], mission_validator.judge
    monkeypatch.setattr(
        mission_validator, "judge", lambda *said: judged.append(said) or really(*said)
    )
    flights = list(rehearsed(Rehearsed(ready, 3), 3, Place()))
    assert len(judged) == 1
    for number, one in enumerate(flights):
        assert isinstance(one, Flown)
        sea = parse_settings(drawn(ready.mission, ready.vehicle, 3, number))
        alone = fly(ready.mission, ready.vehicle, seed=3 + number, settings=sea)
        assert (one.outcome, one.time) == (alone.outcome, alone.mission_time)
        assert one.error == max(sample.error for sample in alone.samples)
    assert len(judged) == 4


LAYER = """mission m vehicle auv
assume current 0.1
safety depth 14 radius 400 time 20min
down: gear 4 heading 90 depth 10 until temperature falls 2 within 4 m timeout 60s
back: gear 4 depth 3 until depth < 4 timeout 60s
up: surface timeout 2min
"""
COLD = ("thermocline=4@6", "current=0.05@30")


def test_what_is_set_holds_in_every_flight_and_all_else_is_drawn_as_it_would_be() -> None:
    for number in range(4):
        plain = drawn(DIVE.mission, DIVE.vehicle, 2, number)
        given = sea_of(DIVE.mission, DIVE.vehicle, 2, number, (" current = 0.05@30", COLD[0]))
        assert given == (*plain[1:], " current = 0.05@30", COLD[0])
        assert plain[0].startswith("current=")
        assert sea_of(DIVE.mission, DIVE.vehicle, 2, number, ()) == plain


@pytest.fixture(scope="module")
def rehearsed_layer(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    file = tmp_path_factory.mktemp("layer") / "m.mission"
    file.write_text(LAYER, encoding="utf-8")
    return file, ["rehearse", str(file), "--flights", "2", "--workers", "1"]


def test_a_leg_that_no_flight_came_to_is_told_and_with_what_is_set_it_is_flown(
    rehearsed_layer: tuple[Path, list[str]], tmp_path: Path
) -> None:
    _, command = rehearsed_layer
    page, runner = tmp_path / "a.html", CliRunner()
    plain = json.loads(runner.invoke(main, [*command, "--json", "-o", str(page)]).stdout)
    assert plain["legs"] == {"down": 2, "back": 0, "up": 0}
    assert plain["never_flown"] == ["back", "up"]
    assert plain["set"] == []
    assert "Never flown: back" in page.read_text(encoding="utf-8")
    said = [word for text in COLD for word in ("--set", text)]
    cold = json.loads(runner.invoke(main, [*command, *said, "--json", "-o", str(page)]).stdout)
    assert cold["legs"] == {"down": 2, "back": 2, "up": 2}
    assert cold["never_flown"] == []
    assert cold["set"] == list(COLD)
    assert "In every flight: thermocline=4@6" in page.read_text(encoding="utf-8")


def test_the_text_names_what_is_set_and_the_legs_never_flown() -> None:
    rows = [replace(flown(n), legs=("down", "back")[: n + 1]) for n in range(2)]
    made = report_of(rows, ("down", "back", "up"), COLD)
    assert made.legs == {"down": 2, "back": 1, "up": 0}
    text = as_text(made, "dive", 0)
    assert re.search(r"^never flown +up$", text, re.M)
    assert re.search(r"^set +thermocline=4@6$", text, re.M)
    assert "never flown" not in as_text(report_of(rows, ("down", "back")), "dive", 0)


def test_what_flies_one_again_sets_the_same_and_names_the_same_mission(
    rehearsed_layer: tuple[Path, list[str]],
) -> None:
    file, command = rehearsed_layer
    wide = file.with_name("wide.mission")
    wide.write_text(LAYER.replace("\n", "\nparam far 30s\n", 1).replace("60s", "far"))
    command = [*command, "--param", "far=40s", "--vehicle", "auv", "--set", COLD[0], "--json"]
    command[1] = str(wide)
    run = CliRunner().invoke(main, command)
    again = shlex.split(json.loads(run.stdout)["worst"][0]["again"])
    assert again[again.index("--param") + 1] == "far=40s"
    assert again[again.index("--vehicle") + 1] == "auv"
    assert again[-2:] == ["--set", COLD[0]]


@pytest.mark.parametrize("text", ["tide=3", "fault=nonsense@3", "fault=doppler_frozen@3"])
def test_what_cannot_be_set_is_said_before_anything_is_flown(text: str) -> None:
    run = CliRunner().invoke(main, ["rehearse", "first-dive", "--flights", "1", "--set", text])
    assert run.exit_code == 2
    assert text.partition("=")[0] in run.stderr
    assert not run.stdout


@pytest.mark.proof
def test_every_figure_of_a_rehearsal_is_told(told: tuple[dict[str, object], Path]) -> None:
    report, picture = told
    assert report["flights"] == FLIGHTS
    assert report["outcomes"] == {"completed": FLIGHTS}
    for key in ("time_s", "energy_wh", "error_m"):
        spread = report[key]
        assert isinstance(spread, list)
        assert 0.0 < spread[0] <= spread[1] <= spread[2]
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.proof
def test_a_page_has_the_picture_and_every_figure_and_loads_nothing() -> None:
    rows = [flown(n, error=float(n), true=1.0 - n / 10.0) for n in range(4)]
    rows.append(flown(4, outcome="emergency"))
    made = html_page(report_of(rows), rows, "a<b", 7, "dive")
    assert made.count("<svg") == 1
    for says in ("4 of 5 flights completed", "coverage of mow, %", "99%", "position error, m",
                 "auvmission simulate a&lt;b --seed 11 --set current=0.1@0"):  # fmt: skip
        assert says in made
    assert not re.search(r"<script|<link|src=|url\(http", made)


@pytest.mark.proof
def test_the_worst_flights_come_with_the_command_that_flies_them_again(
    told: tuple[dict[str, object], Path],
) -> None:
    worst = told[0]["worst"]
    assert isinstance(worst, list)
    assert len(worst) == FLIGHTS
    first = worst[0]
    run = CliRunner().invoke(main, [*shlex.split(first["again"])[1:], "--json"])
    assert json.loads(run.stdout)["outcome"] == first["outcome"]
    settings = parse_settings(drawn(DIVE.mission, DIVE.vehicle, 5, first["flight"]))
    flight = fly(DIVE.mission, DIVE.vehicle, seed=5 + first["flight"], settings=settings)
    assert round(max(s.error for s in flight.samples), 1) == first["error_m"]


def test_over_the_floor_of_a_file_the_least_water_is_told(tmp_path: Path) -> None:
    file = tmp_path / "a bay.asc"
    file.write_text(BAY, encoding="utf-8")
    over = ["--bathymetry", str(file), "--json"]
    command = ["rehearse", "first-dive", "--flights", "1", "--workers", "1", *over]
    told = json.loads(CliRunner().invoke(main, command).stdout)
    assert told["clearance_m"][0] == pytest.approx(20.0 - 5.0, abs=0.6)
    assert told["aground"] == 0
    again = shlex.split(told["worst"][0]["again"])
    assert again[again.index("--bathymetry") :][:2] == over[:2]


@pytest.mark.proof
def test_flights_that_run_aground_are_counted_and_drawn_on_the_page() -> None:
    rows = [replace(flown(n), clearance=metres) for n, metres in enumerate((0.1, 4.0, 5.0))]
    made = report_of([*rows, flown(3)])
    assert made.clearance is not None
    assert made.clearance[1] == 1
    assert "aground in 1" in as_text(made, "dive", 0)
    assert "1 aground" in html_page(made, rows, "dive", 0, "dive")
    assert "clearance" not in as_text(report_of([flown(0)]), "dive", 0)


@pytest.mark.proof
def test_a_rehearsal_says_the_same_whatever_works_on_it(
    told: tuple[dict[str, object], Path],
) -> None:
    command = ["rehearse", "first-dive", "--flights", str(FLIGHTS), "--seed", "5", "--workers", "2"]
    run = CliRunner().invoke(main, [*command, "--json"])
    assert json.loads(run.stdout) == told[0]


def test_the_energy_of_a_flight_is_power_times_time() -> None:
    flight = fly(DIVE.mission, DIVE.vehicle)
    energy = energy_of(flight, DIVE.chart, DIVE.vehicle)
    battery = DIVE.vehicle.battery
    least = battery.hotel * flight.mission_time
    most = (battery.hotel + battery.vertical + max(DIVE.vehicle.thruster_power.y)) * (
        flight.mission_time
    )
    assert least < energy < most


def test_the_worst_are_those_that_fail_then_those_that_see_least_then_those_that_err_most() -> None:
    rows = [flown(0), flown(1, error=9.0), flown(2, true=0.5), flown(3, outcome="emergency")]
    made = report_of(rows)
    assert [f.number for f in made.worst] == [3, 2, 1, 0]
    assert made.near == {"time": pytest.approx(0.3)}
    assert made.outcomes == {"completed": 3, "emergency": 1}
    assert made.coverage["mow"][0].low == 0.5


def test_regions_hold_the_share_of_the_places_that_they_say() -> None:
    rng = Random(1)
    places = [(rng.gauss(5.0, 30.0), rng.gauss(-3.0, 10.0)) for _ in range(500)]
    found = regions(places)
    assert [r.share for r in found] == [0.5, 0.9, 0.99]
    for r in found:
        c, s = math.cos(r.bearing), math.sin(r.bearing)
        inside = 0
        for north, east in places:
            along = (north - r.north) * c + (east - r.east) * s
            across = (east - r.east) * c - (north - r.north) * s
            inside += math.hypot(along / r.axes[0], across / r.axes[1]) <= 1.0 + 1e-9
        assert inside == math.ceil(r.share * len(places))
    assert abs(math.sin(found[0].bearing)) < 0.2  # north and south


def test_two_places_make_no_region() -> None:
    assert regions([(0.0, 0.0), (1.0, 1.0)]) == ()


@pytest.mark.parametrize(("hits", "of"), [(0, 10), (10, 10), (90, 100)])
def test_the_chance_of_completion_has_an_interval_that_is_never_sure(hits: int, of: int) -> None:
    low, high = wilson(hits, of)
    assert 0.0 <= low <= hits / of <= high <= 1.0
    assert high - low > 0.05
    if (hits, of) == (90, 100):  # Newcombe 1998, table I has such figures
        assert (low, high) == (pytest.approx(0.8256, abs=1e-3), pytest.approx(0.9448, abs=1e-3))


@pytest.mark.proof
@pytest.mark.parametrize(
    ("name", "leg"), [("auv", "heading 0 gear 6"), ("rov", "gear 4"), ("robot", "gear 6")]
)
def test_thrust_is_a_share_of_what_the_vehicle_has_and_speed_its_root(name: str, leg: str) -> None:
    mission = parse(
        f"mission m vehicle {name}\nstart without fix\nsafety time 10min radius 300 depth 10\n"
        f"assume current 0 start 0\na: {leg} for 60\n"
    )

    def way(*said: str) -> float:
        vehicle = load_vehicle(name)
        return fly(mission, vehicle, settings=parse_settings(said)).max_range

    assert way("thrust=0.25") == pytest.approx(0.5 * way(), rel=0.2)


def test_what_cannot_be_rehearsed_is_said(tmp_path: Path) -> None:
    runner = CliRunner()
    assert runner.invoke(main, ["rehearse", "no-such"]).exit_code == 2
    assert runner.invoke(main, ["rehearse", "first-dive", "-o", "a.pdf"]).exit_code == 2
