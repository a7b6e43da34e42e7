"""The demonstration's command line; the demonstration itself is flown by the README's command."""

from __future__ import annotations

import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from served import noted_processes

from mission.authoring.prepare import prepare
from mission.commands import demo as command
from mission.verification.simulation.demo import Demo, DemoError, Progress, not_as_planned
from mission.verification.simulation.flightlog import Flight, LegFlown
from mission.verification.simulation.staged import Stage, own_bus


def test_a_folder_with_somebody_elses_files_is_left_alone(tmp_path: Path) -> None:
    thesis = tmp_path / "thesis.tex"
    thesis.write_text("years of work")
    (tmp_path / "track.png").write_bytes(b"")
    ran = CliRunner().invoke(command.demo, ["--out", str(tmp_path)])
    assert ran.exit_code == 2
    assert "holds thesis.tex" in ran.stderr
    assert thesis.read_text() == "years of work"


def test_what_an_earlier_demonstration_left_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(self: Demo) -> None:
        raise DemoError(f"{self.folder}: {[*self.folder.iterdir()]}")

    monkeypatch.setattr(Demo, "fly", fails)
    out = tmp_path / "out"
    (out / "pi" / "log").mkdir(parents=True)
    (out / "vehicle.log").write_text("")
    ran = CliRunner().invoke(command.demo, ["--out", str(out)])
    assert ran.exit_code == 1
    assert f"{out}: []" in ran.stderr


def test_a_mission_the_check_refuses_is_not_flown(tmp_path: Path) -> None:
    mission = tmp_path / "far.mission"
    mission.write_text("mission far\nsafety radius 50 time 1h\na: heading 0 gear 8 for 10min\n")
    ran = CliRunner().invoke(command.demo, [str(mission), "--out", str(tmp_path / "out")])
    assert ran.exit_code == 1
    assert "refused by the check" in ran.stderr
    assert not (tmp_path / "out").exists()


def test_progress_is_where_the_vehicle_takes_itself_to_be(
    capsys: pytest.CaptureFixture[str],
) -> None:
    shown = command.Shown()
    flying = Progress(state="autonomous", leg="box/north", depth=5.04, left=774.0)
    shown.show(flying)
    flying.leg, flying.position, flying.uncertainty = "box/east", (12.3, -0.6), 7.9
    shown.show(flying)
    shown.show(flying)
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert rows == [
        [
            "autonomous/box/north",
            "5.0",
            "m",
            "deep",
            "no",
            "fix",
            "yet",
            "at",
            "most",
            "12.9",
            "min",
            "left",
        ],
        [
            "autonomous/box/east",
            "5.0",
            "m",
            "deep",
            "+12",
            "m",
            "north",
            "-1",
            "m",
            "east",
            "within",
            "8",
            "m",
            "at",
            "most",
            "12.9",
            "min",
            "left",
        ],
    ]


@pytest.mark.proof
def test_a_demonstration_that_is_told_to_end_ends_its_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By SIGTERM as by ctrl-C, once both processes run."""
    started = noted_processes(monkeypatch)

    def operate(self: Demo, topside: str, events: object) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(Demo, "_operate", operate)
    ran = CliRunner().invoke(command.demo, ["--out", str(tmp_path / "out")])
    assert ran.exit_code == 128 + signal.SIGTERM
    assert len(started) == 2
    assert all(process.poll() is not None for process in started)


def test_a_folder_that_cannot_be_made_and_a_sea_that_is_none_are_told(tmp_path: Path) -> None:
    out = tmp_path / "file" / "out"
    out.parent.write_text("")
    ran = CliRunner().invoke(command.demo, ["--out", str(out)])
    assert ran.exit_code == 2
    assert f"{out}: cannot be written: Not a directory" in ran.stderr
    left = tmp_path / "out"
    (left / "pi").mkdir(parents=True)
    ran = CliRunner().invoke(command.demo, ["--out", str(left), "--set", "curent=1"])
    assert ran.exit_code == 2
    assert "curent" in ran.stderr
    assert left.exists()


def test_what_is_not_as_planned_is_named() -> None:
    legs = (LegFlown("dive", 0.0, 1.0, "until"), LegFlown("box/a#2", 1.0, 2.0, "timeout"))
    flown = Flight("completed", "", "", 2.0, 1.0, "idle/ready", legs, 0, 0, (), (), (), (), True)
    assert not_as_planned(flown) == ["box/a#2 was left by timeout"]
    assert not_as_planned(replace(flown, legs=legs[:1])) == []
    lost = replace(flown, legs=legs[:1], at_surface=False, outcome="emergency")
    assert len(not_as_planned(lost)) == 2


@pytest.mark.proof
def test_two_demonstrations_at_a_time_have_a_bus_each(tmp_path: Path) -> None:
    """Frames by multicast reach whoever listens: each would fly with the other's thrust."""
    numbers = (1, 2, 255, 256, 257, 65535, 65536, 70000, 4194303)
    assert len({own_bus(number) for number in numbers}) == len(numbers)
    stage = Stage(prepare("rov-dive", "mainboard"), tmp_path, "mainboard", 1.0, 0, ())
    with stage.vehicle() as told:
        assert told["vehicle"].startswith(f"{own_bus(os.getpid())}&sensors=")
