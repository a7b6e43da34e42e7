"""What a bench must not do: measure a refusal, or end in an error for want of turns."""

from __future__ import annotations

import shutil
import statistics
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))

import run
from bench_modem import FLIGHTS, WATERS, row
from run import BENCHES, Bench, Figure, reached, table

from links.acoustic import Water


def test_a_mission_that_the_check_refuses_is_no_figure_of_judging() -> None:
    from bench_language import judge, mission_of

    assert judge(mission_of(20)).ok
    with pytest.raises(RuntimeError, match="the safety time is 240"):
        judge(mission_of(20).replace("timeout 1s", "timeout 30min"))


def test_an_hour_is_measured_by_one_turn_and_by_many() -> None:
    # here, since it brings all of filterpy, which no other test needs
    from bench_hour import main, quartiles

    assert quartiles([15.0]) == (15.0, 15.0, 15.0)
    many = [float(n) for n in range(32)]
    assert quartiles(many) == tuple(statistics.quantiles(many, n=4))
    with pytest.raises(ValueError, match="0 turns"):
        main(0)


SPEED = Figure("speed", "speed of it", "x", 28, True, pure=13.5, before=13.8)
FAST = Bench("bench_fast", "a fast bench", (SPEED, Figure("size", "size of it", "MB", 1.5)))


def rows(found: dict[tuple[str, str], dict[str, float] | None]) -> list[list[str]]:
    return [line.split() for line in table(found, [FAST])]


def test_the_table_has_each_figure_of_both_builds_beside_the_old_one() -> None:
    both = {"pure": {"speed": 14.0, "size": 2.0}, "compiled": {"speed": 14.0}}
    head, *told = rows({("bench_fast", build): values for build, values in both.items()})
    assert head == ["figure", "build", "before", "now", "wanted", "met"]
    assert told == [
        ["speed", "of", "it,", "x", "pure", "13.80", "14.00", "at", "least", "13.5", "yes"],
        ["speed", "of", "it,", "x", "compiled", "13.80", "14.00", "at", "least", "28", "NO"],
        ["size", "of", "it,", "MB", "pure", "-", "2.00", "at", "most", "1.5", "NO"],
        ["size", "of", "it,", "MB", "compiled", "-", "skipped", "at", "most", "1.5"],
    ]


def test_the_table_says_where_a_bench_failed() -> None:
    _, failed = rows({("bench_fast", "pure"): None})
    assert " ".join(failed) == "bench_fast.py ended in an error on the pure build"


def test_a_compiled_build_that_cannot_be_made_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(run, "made", lambda: False)
    monkeypatch.setattr(run, "BENCHES", [FAST])
    monkeypatch.setattr(run, "reached", lambda bench, tree, python: {"speed": 14.0})
    assert run.main([]) == 0
    *_, last = capsys.readouterr().out.splitlines()
    assert last.startswith("the compiled build was not measured")


def test_a_bench_runs_on_the_tree_and_the_program_of_its_build(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # the second text is another one at once
    folder = tmp_path / "tests" / "bench"
    folder.mkdir(parents=True)
    shutil.copy(Path(__file__).parent / "run.py", folder)
    bench = folder / "bench_fast.py"
    bench.write_text("def main():\n    return {'speed': 2}\n")
    assert reached(FAST, tmp_path, Path(sys.executable)) == {"speed": 2.0}
    bench.write_text("def main():\n    raise SystemExit(1)\n")
    assert reached(FAST, tmp_path, Path(sys.executable)) is None


def test_every_bench_of_the_table_exists() -> None:
    for bench in BENCHES:
        assert Path(__file__).with_name(f"{bench.module}.py").exists(), bench.module


@pytest.mark.proof
@pytest.mark.parametrize("water", WATERS, ids=str)
def test_an_upload_takes_at_most_one_and_a_half_times_what_its_water_allows(water: Water) -> None:
    _, ratio = row(water, FLIGHTS)
    assert ratio <= 1.5
