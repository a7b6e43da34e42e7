"""X rests on the buoyant ascent: it is measured by the float test, dated, and asked for."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from click.testing import CliRunner
from engine_world import World, leg
from engine_world import mission as flown

from mission.analysis.floating import ENOUGH, Rise, rise_of
from mission.authoring.check import check_mission
from mission.authoring.prepare import prepare
from mission.cli import main
from mission.model import IDLE_READY
from mission.model.buoyancy import OLD, doubt, heavy, rises
from mission.model.shipped import load_vehicle, missions_folder
from mission.model.vehicle import VehicleError
from mission.onboard.doctor.buoyant import buoyant
from mission.onboard.doctor.findings import Condition
from protocol.messages import Fix, StartMission, Telemetry

VEHICLE = load_vehicle("auv")
AUV = missions_folder() / "vehicles" / "auv.yaml"
TODAY = datetime.now(UTC).date()
DAY = Fix(0.0, 0.5, 2.0, 2.5, utc="2026-11-22T08:00:00")


def measured(rate: float, day: str = TODAY.isoformat()) -> str:
    """The shipped vehicle file with another figure."""
    text = AUV.read_text(encoding="utf-8")
    assert text.count("ascent_buoyancy: 0.25 m/s") == 1
    return text.replace(
        "ascent_buoyancy: 0.25 m/s", f"ascent_measured: {day}\nascent_buoyancy: {rate} m/s"
    )


def reports(rates: list[float], *, thrust: float = 0.0, top: float = 0.2) -> list[Telemetry]:
    """One rise after another from 2.4 m, a report each 2 s, a push down in between."""
    heard, t = [], 0.0
    for rate in rates:
        heard.append(Telemetry(t, depth=2.4, actuators=(0.0, 0.0, 0.6, 0.6, 0.6)))
        for second in range(2, 22, 2):
            depth = 2.4 - rate * (second - 2)
            if depth >= top:
                acts = (0.0, 0.0, thrust, thrust, thrust)
                heard.append(Telemetry(t + second, depth=depth, actuators=acts))
        t += 30.0
    return heard


# --- measured ------------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [0.25, 0.1, 0.02, -0.05])
def test_a_rise_is_found_as_fast_as_it_is_and_a_sinking_one_is_negative(rate: float) -> None:
    found = rise_of([[DAY, *reports([rate] * 5)]], noise=0.1)
    assert found is not None
    assert found.rate == pytest.approx(rate)
    assert (found.rises, found.day) == (5, "2026-11-22")
    assert found.at_least <= found.rate


def test_what_is_told_is_what_it_rises_at_least() -> None:
    assert Rise(0.25, 0.02, 5, "").at_least == pytest.approx(0.21)


@pytest.mark.parametrize(
    "log",
    [
        [DAY, *reports([0.2] * (ENOUGH - 1))],
        [DAY, *reports([0.2] * 5, thrust=-0.3)],
        [DAY, *(r._replace(actuators=None) for r in reports([0.2] * 5))],
        [DAY, *(r for r in reports([0.2] * 5) if r.t % 30.0 in (0.0, 2.0, 16.0))],
        reports([0.2] * 5),
    ],
    ids=["too few", "pushed", "nothing said of thrusters", "gaps", "no day"],
)
def test_nothing_is_measured_where_the_logs_hold_no_float_test(log: list[Telemetry | Fix]) -> None:
    assert rise_of([log], noise=0.1) is None


@pytest.mark.proof
@pytest.mark.parametrize("profile", ["as-built", "documented"])
@pytest.mark.parametrize("newtons", [15.0, 5.0])
def test_the_shipped_float_test_measures_the_simulated_vehicle(
    newtons: float, profile: str, tmp_path: Path
) -> None:
    """At the end of its way it rises at sqrt(buoyancy over drag), 240 N s2/m2."""
    call = ["simulate", "float-test", "--profile", profile, "--report", str(tmp_path)]
    done = CliRunner().invoke(main, [*call, "--set", f"buoyancy={newtons}"])
    assert done.exit_code == 0, done.output
    told = CliRunner().invoke(main, ["calibrate", str(tmp_path / "flight.mcap")])
    assert told.exit_code == 0, told.output
    rate, day = (line.split()[1] for line in told.stdout.splitlines()[:2])
    truth = (newtons / 240.0) ** 0.5
    assert 0.75 * truth < float(rate) < truth
    mine = tmp_path / "mine.yaml"
    mine.write_text(measured(float(rate), day))
    assert load_vehicle(mine).ascent_measured == day == "2025-06-01"


@pytest.mark.proof
def test_logs_without_a_float_test_leave_the_figure_and_say_what_to_fly(tmp_path: Path) -> None:
    fly = ["simulate", "first-dive", "--report", str(tmp_path)]
    assert CliRunner().invoke(main, fly).exit_code == 0
    told = CliRunner().invoke(main, ["calibrate", str(tmp_path / "flight.mcap")])
    assert "ascent_" not in told.stdout
    assert "fly float-test" in told.stderr


# --- asked for -----------------------------------------------------------------------------------


def test_a_heavy_vehicle_passes_no_check_and_starts_no_mission() -> None:
    chart = prepare("first-dive").chart
    for rate in (0.0, -0.1):
        vehicle = replace(VEHICLE, ascent_buoyancy=rate, ascent_measured="2026-11-22")
        report = check_mission(chart, vehicle)
        assert [r.code for r in report.refusals] == ["heavy"]
        assert f"{rate:g} m/s, measured 2026-11-22" in report.refusals[0].message
        world = World(flown(leg("a")), vehicle=vehicle)
        world.tell(world.report(), world.fix())
        (verdict,) = world.tell(StartMission()).verdicts
        assert not verdict.accepted
        assert "does not rise by itself" in verdict.why
        assert world.state == IDLE_READY
    assert rises(replace(VEHICLE, ascent_buoyancy=-0.1, drives=True))
    assert not heavy(VEHICLE)


def test_the_check_says_where_the_figure_is_from_and_reckons_with_it(tmp_path: Path) -> None:
    plain = CliRunner().invoke(main, ["check", "first-dive"])
    assert "0.25 m/s, a planning figure, never measured" in plain.stdout
    mine = tmp_path / "mine.yaml"
    mine.write_text(measured(0.125, "2020-01-01"))
    told = CliRunner().invoke(main, ["check", "first-dive", "--vehicle", str(mine)])
    assert "0.125 m/s, measured 2020-01-01" in told.stdout
    assert "days ago: fly float-test" in told.stderr
    slow, fast = (
        json.loads(CliRunner().invoke(main, ["check", "first-dive", "--json", *more]).stdout)
        for more in (["--vehicle", str(mine)], [])
    )
    assert slow["proved"]["worst_time_s"] > fast["proved"]["worst_time_s"]


def test_a_figure_is_old_after_a_season_and_none_from_tomorrow() -> None:
    for days, old in ((0, False), (OLD, False), (OLD + 1, True), (-1, True)):
        day = (TODAY - timedelta(days=days)).isoformat()
        assert bool(doubt(replace(VEHICLE, ascent_measured=day), TODAY)) is old
    assert "never measured" in doubt(VEHICLE, TODAY)
    assert not doubt(load_vehicle("robot"), TODAY)


@pytest.mark.parametrize(
    ("rate", "days", "condition"),
    [
        (0.2, 1, Condition.OK),
        (0.2, OLD + 5, Condition.WARNING),
        (0.2, None, Condition.WARNING),
        (-0.1, 1, Condition.FAULT),
        (0.0, None, Condition.FAULT),
    ],
)
def test_doctor_says_whether_it_rises(rate: float, days: int | None, condition: Condition) -> None:
    day = "" if days is None else (TODAY - timedelta(days=days)).isoformat()
    vehicle = replace(VEHICLE, ascent_buoyancy=rate, ascent_measured=day)
    (finding,) = buoyant(vehicle)
    assert finding.condition is condition
    assert f"{rate:g} m/s" in finding.says
    assert (finding.todo == "") is (condition is Condition.OK)


def test_doctor_asks_nothing_of_what_drives_on_the_ground() -> None:
    assert not list(buoyant(load_vehicle("robot")))


def test_a_day_that_is_none_is_refused_with_its_line(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(measured(0.2, "22.11.2026"))
    with pytest.raises(
        VehicleError, match=r"mine.yaml:\d+:\d+: ascent_measured: 22.11.2026 is no day"
    ):
        load_vehicle(mine)
