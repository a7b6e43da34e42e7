"""The sea floor under each leg from a file of depths: what counts, what refuses, what is not known."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.authoring.bathymetry import Depths, bathymetry_of
from mission.authoring.check import Report
from mission.authoring.check.seabed import Ground, told
from mission.authoring.prepare import check_prepared, prepare_text
from mission.cli import main

HOME = (30.2874595, 120.1535765)
STEP = 10.0 / 111_000.0  # deg: some 10 m
CELLS = 60


def chart(bank: float = 20.0, *, hole: bool = False) -> str:
    """A floor of 20 m with a bank from 100 m east of home on, over all latitudes."""
    west, south = HOME[1] - 30 * STEP, HOME[0] - 30 * STEP
    head = f"ncols {CELLS}\nnrows {CELLS}\nxllcorner {west!r}\nyllcorner {south!r}\n"
    unknown = "-9999" if hole else "20"
    row = " ".join(f"{bank}" if 42 <= k < 46 else unknown for k in range(CELLS))
    return f"{head}cellsize {STEP!r}\nnodata_value -9999\n" + f"{row}\n" * CELLS


def depths(bank: float = 20.0, *, hole: bool = False) -> Depths:
    return bathymetry_of(chart(bank, hole=hole), "bay.asc")


def mission(leg: str, assume: str = "") -> str:
    return (
        f"mission m vehicle auv\nhome {HOME[0]} {HOME[1]}\nsafety depth 12 time 30min\n"
        f"assume current 0.01{assume}\n{leg}\nup: surface timeout 3min\n"
    )


def judged(leg: str, found: Depths | None, assume: str = "") -> Report:
    return check_prepared(prepare_text(mission(leg, assume), "m.mission"), found)


def ground(report: Report, leg: str) -> Ground:
    return next(one for one in report.grounds if one.leg == leg)


OVER = "out: goto north 0 east 150 depth 6 gear 8 timeout 5min"
SHORT = "out: goto north 0 east 30 depth 6 gear 8 within 2 timeout 1min"
RISING = "out: goto north 0 east 150 altitude 3 gear 8 timeout 5min"


def test_a_leg_that_may_be_deeper_than_the_floor_it_leads_over_is_refused_with_its_place() -> None:
    (refusal,) = judged(OVER, depths(5.0)).refusals
    assert refusal.code == "grounding"
    assert refusal.where.line == 5
    assert "out may be 7.0 m deep over a sea floor at 5.0 m (30.28" in refusal.message


def test_a_leg_that_stays_off_the_bank_is_not_refused() -> None:
    report = judged(SHORT, depths(5.0))
    assert report.ok
    assert ground(report, "out").shallowest == 20.0


def test_the_error_of_a_leg_widens_what_it_may_be_over() -> None:
    long = SHORT.replace("1min", "25min")
    assert judged(SHORT, depths(5.0), " start 1").ok
    assert not judged(long, depths(5.0), " start 1").ok


def test_a_leg_that_keeps_an_altitude_is_not_refused_for_a_bank() -> None:
    report = judged(RISING, depths(5.0))
    assert [r.code for r in report.refusals] == []
    assert ground(report, "out").shallowest == 5.0


GUARDED = OVER.replace("depth 6", "depth 6 never below altitude 2")


@pytest.mark.parametrize(("leg", "least"), [(GUARDED, 3.0), (RISING, 3.0)])
def test_a_leg_kept_above_a_floor_that_leaves_no_depth_to_hold_is_refused_with_its_place(
    leg: str, least: float
) -> None:
    assert judged(leg, depths(least)).ok
    (refusal,) = judged(leg, depths(least - 0.1)).refusals
    assert (refusal.code, refusal.where.line) == ("grounding", 5)
    floor = f"out may be over a sea floor at {least - 0.1:.1f} m (30.28"
    assert refusal.message.startswith(floor)
    assert "no depth is left to hold" in refusal.message
    assert "keep less altitude" in refusal.hint


@pytest.mark.parametrize("leg", [OVER, GUARDED, RISING])
def test_land_under_a_leg_is_called_so_and_no_shallower_leg_is_proposed(leg: str) -> None:
    (refusal,) = judged(leg, depths(-4.0)).refusals
    assert refusal.code == "grounding"
    assert "over land (30.28" in refusal.message
    assert refusal.hint == "lead it farther off, or take fixes on the way"


def test_without_a_file_nothing_is_said_of_the_floor() -> None:
    report = judged(OVER, None)
    assert report.ok
    assert report.grounds == ()


def test_a_floor_deeper_than_the_one_assumed_is_refused() -> None:
    report = judged(SHORT, depths(), " floor 15")
    assert {r.code for r in report.refusals} == {"floor"}
    assert "write assume floor 20" in report.refusals[0].hint
    assert judged(SHORT, depths(), " floor 20").ok


def test_a_hold_that_fails_ends_at_the_floor_where_all_of_it_is_known() -> None:
    free, bounded = judged(SHORT, None), judged(SHORT, depths())
    assert free.proved is not None
    assert bounded.proved is not None
    assert free.proved.blind_depth > 25.0
    assert bounded.proved.blind_depth == 20.0


def test_what_the_file_does_not_know_is_told_and_bounds_nothing() -> None:
    report = judged(SHORT, depths(hole=True))
    free = judged(SHORT, None)
    assert report.proved is not None
    assert free.proved is not None
    assert report.proved.blind_depth == free.proved.blind_depth
    assert told(ground(report, "out")) == "not known: the floor that is assumed"
    part = ground(judged(OVER, depths(8.0, hole=True)), "out")
    assert 0.0 < part.known < 0.9
    assert "of it not known" in told(part)


def test_a_floor_that_is_known_in_part_does_not_bound_a_hold_that_fails() -> None:
    leg = OVER.replace("depth 6", "depth 4")
    part, free = judged(leg, depths(8.0, hole=True)), judged(leg, None)
    assert part.proved is not None
    assert free.proved is not None
    assert part.proved.blind_depth == free.proved.blind_depth > 20.0


def test_a_leg_beyond_the_edge_of_the_file_is_known_in_part() -> None:
    far = OVER.replace("east 150", "east 330")
    assert 0.5 < ground(judged(far, depths()), "out").known < 1.0


def test_a_mission_without_a_home_has_no_floor() -> None:
    text = mission(SHORT).replace(f"home {HOME[0]} {HOME[1]}\n", "")
    report = check_prepared(prepare_text(text, "m.mission"), depths())
    assert {r.code for r in report.refusals} == {"no-home"}


# --- the commands ------------------------------------------------------------------------------


def run(*words: str) -> tuple[int, str]:
    done = CliRunner().invoke(main, list(words))
    return done.exit_code, done.output


@pytest.fixture
def files(tmp_path: Path) -> tuple[str, str]:
    text, floor = tmp_path / "m.mission", tmp_path / "bay.asc"
    text.write_text(mission(OVER))
    floor.write_text(chart(5.0))
    return str(text), str(floor)


def test_check_refuses_by_a_file_of_depths_and_tells_the_floor_by_leg(
    files: tuple[str, str],
) -> None:
    text, floor = files
    code, said = run("check", text, "--bathymetry", floor)
    assert code == 1
    assert "sea floor under out  5.0 to 20.0 m, shallowest at 30.28" in said
    _, said = run("check", text, "--bathymetry", floor, "--json")
    (found,) = [one for one in json.loads(said)["sea_floor"] if one["leg"] == "out"]
    assert (found["shallowest_m"], found["deepest_m"], found["known"]) == (5.0, 20.0, 1.0)


@pytest.mark.parametrize("command", ["check", "simulate"])
def test_a_file_that_is_no_bathymetry_is_told_with_exit_2(
    command: str, files: tuple[str, str], tmp_path: Path
) -> None:
    wrong = tmp_path / "wrong.asc"
    wrong.write_text("ncols 2\nnrows 1\n")
    code, said = run(command, files[0], "--bathymetry", str(wrong))
    assert code == 2
    assert "an ESRI ASCII grid begins with it" in said


def test_the_simulated_sea_has_the_floor_of_the_file(files: tuple[str, str]) -> None:
    text, floor = files
    _, said = run("simulate", text, "--bathymetry", floor, "--json")
    flown = json.loads(said)
    assert flown["clearance"]["least_m"] < 0.3
    assert flown["clearance"]["longitude"] == pytest.approx(HOME[1] + 12 * STEP, abs=3 * STEP)
    assert flown["flown"]["sea"]["bathymetry"] == floor
    _, free = run("simulate", text, "--json")
    assert "clearance" not in json.loads(free)
    assert "bathymetry" not in json.loads(free)["flown"]["sea"]


def test_an_altimeter_reads_the_floor_of_the_file(tmp_path: Path) -> None:
    text, floor = tmp_path / "clear.mission", tmp_path / "bank.asc"
    floor.write_text(chart(7.0))
    text.write_text(mission(OVER.replace("depth 6", "depth 6 never below altitude 2"), " floor 20"))
    _, said = run("simulate", str(text), "--bathymetry", str(floor), "--json")
    flown = json.loads(said)
    assert flown["outcome"] == "completed"
    assert 0.3 < flown["clearance"]["least_m"] < 2.5


@pytest.mark.parametrize("east", [150, -150])
@pytest.mark.parametrize("longitude", [120.0, 180.0, 179.9999, -179.9999])
def test_a_bank_counts_on_either_side_of_the_antimeridian(longitude: float, east: int) -> None:
    west, south = longitude - 30 * STEP, 0.5 - 30 * STEP
    head = f"ncols {CELLS}\nnrows {CELLS}\nxllcorner {west!r}\nyllcorner {south!r}\n"
    banks = range(42, 46) if east > 0 else range(14, 18)
    row = " ".join("5" if k in banks else "20" for k in range(CELLS))
    found = bathymetry_of(f"{head}cellsize {STEP!r}\n" + f"{row}\n" * CELLS, "bay.asc")
    text = mission(OVER.replace("150", str(east)))
    text = text.replace(f"home {HOME[0]} {HOME[1]}", f"home 0.5 {longitude}")
    report = check_prepared(prepare_text(text, "m.mission"), found)
    assert [r.code for r in report.refusals] == ["grounding"]
    assert ground(report, "out").known == 1.0


def test_the_same_refusal_of_several_legs_is_said_once_and_names_them() -> None:
    two = OVER + "\n" + OVER.replace("out:", "again:")
    refusals = judged(two, depths(5.0)).refusals
    (grounding,) = [one for one in refusals if one.code == "grounding"]
    assert "out, again may be 7.0 m deep" in grounding.message
    assert grounding.where.line == 5
