"""The demonstration's command line; the demonstration itself is flown by the README's command."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.commands import demo as command
from mission.simulation.demo import Demo, DemoError


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
        raise DemoError(f"{self.folder}: {self.folder.exists()}")

    monkeypatch.setattr(Demo, "fly", fails)
    out = tmp_path / "out"
    (out / "pi" / "log").mkdir(parents=True)
    (out / "vehicle.log").write_text("")
    ran = CliRunner().invoke(command.demo, ["--out", str(out)])
    assert ran.exit_code == 1
    assert f"{out}: False" in ran.stderr


def test_a_mission_the_check_refuses_is_not_flown(tmp_path: Path) -> None:
    mission = tmp_path / "far.mission"
    mission.write_text("mission far\nsafety radius 50 time 1h\na: heading 0 gear 8 for 10min\n")
    ran = CliRunner().invoke(command.demo, [str(mission), "--out", str(tmp_path / "out")])
    assert ran.exit_code == 1
    assert "refused by the check" in ran.stderr
    assert not (tmp_path / "out").exists()
