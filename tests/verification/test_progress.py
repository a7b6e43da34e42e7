"""Progress: what is done, how fast and how long it takes yet, whichever job is slow."""

from __future__ import annotations

import json
import re
from collections.abc import Callable

import pytest
from click.testing import CliRunner, Result

from mission.cli import main
from mission.verification.campaign import noticing, soak
from mission.verification.campaign.noticing import Noticed
from mission.verification.campaign.soak import Soaked
from mission.verification.exhaustive import run
from mission.verification.exhaustive.run import Found
from mission.verification.workers import progress, results
from mission.verification.workers.places import place
from mission.verification.workers.progress import Progress, pace

RATE = r"[\d.]+ (a second|a minute|an hour), \d+ s left"


def told(*call: str) -> Result:
    return CliRunner().invoke(main, [*call, "--on", "local"])


def test_progress_tells_rate_and_time_left() -> None:
    lines: list[str] = []
    assert list(results(abs, range(5), place("local"), progress=Progress(5, "jobs", lines.append)))
    assert [line.split(",")[0] for line in lines] == ["5 of 5 jobs"]
    assert "a second, 0 s left" in lines[-1]


@pytest.mark.parametrize(
    ("done", "left", "seconds", "words"),
    [
        (30, 60, 10.0, "3.0 a second, 20 s left"),
        (3, 6, 10.0, "18.0 a minute, 20 s left"),
        (1, 3, 1800.0, "2.0 an hour, 5400 s left"),
        (1, 0, 7200.0, "0.5 an hour, 0 s left"),
    ],
)
def test_a_rate_has_the_unit_in_which_it_can_be_read(
    done: int, left: int, seconds: float, words: str
) -> None:
    assert pace(done, left, seconds) == words


def test_a_job_that_takes_long_holds_back_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its result is the first that is due, and comes last."""
    monkeypatch.setattr(progress, "EVERY", 0.0)
    lines: list[str] = []

    class Backwards:
        def doing(self, work: Callable[[int], int]) -> Backwards:
            return self

        def __enter__(self) -> Callable[..., object]:
            return lambda jobs: ((name, job) for name, job in reversed([*jobs]))

        def __exit__(self, *_: object) -> None: ...

    told = results(abs, range(3), Backwards(), progress=Progress(3, "jobs", lines.append))  # type: ignore[arg-type]
    assert next(told) == 0
    assert [line.split(",")[0] for line in lines] == [f"{n} of 3 jobs" for n in (1, 2, 3)]


@pytest.mark.replaces
def test_rules_that_are_broken_have_a_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.0)
    monkeypatch.setattr(noticing, "notice", lambda name, *_, **__: Noticed(name, "R5", 1, "lost"))
    done = told("faults", "--broken", "all")
    count = json.loads(done.stdout.splitlines()[-1])["rules"]
    assert len(re.findall(rf"^\d+ of {count} rules, {RATE}$", done.stderr, re.M)) == count


def test_cells_have_a_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.0)
    monkeypatch.setattr(run, "examine_ground", lambda on: Found({on.mission}, cells=7))
    done = told("exhaustive", "first-dive", "loiter")
    assert len(re.findall(rf"^\d of 4 missions on a profile, {RATE}$", done.stderr, re.M)) == 4
    assert "loiter.yaml documented: 28 cells so far, 0 violations" in done.stderr


@pytest.mark.parametrize("soaks", [(), ("--soaks", "2", "--on", "local")])
def test_a_soak_tells_how_far_it_is_while_it_works(
    soaks: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(soak, "EVERY", 0.0)

    def fly_on(soaked: Soaked, *_: object) -> None:
        told = _[-1]
        for missions in (1, 2):
            soaked.missions, soaked.days = missions, 0.25 * missions
            told(soaked, result_of_none)  # type: ignore[operator]

    result_of_none = noticing.Flown((), {})
    monkeypatch.setattr(soak, "_fly_on", fly_on)
    done = CliRunner().invoke(main, ["faults", "--soak", "0.5", "--seed", "3", *soaks])
    lines = re.findall(rf"^seed 3: (0.\d+) of 0.5 days, {RATE}, (\d) missions", done.stderr, re.M)
    assert [(days, missions) for days, _, missions in lines] == [("0.25", "1"), ("0.50", "2")]
    assert not soaks or re.search(rf"^2 of 2 soaks, {RATE}$", done.stderr, re.M)
