"""Jobs without a result: told with the command that does them again, counted, and no bound is the
better for them. All others are done."""

from __future__ import annotations

import json
import re
import shlex
from typing import Any

import pytest
from click.testing import CliRunner, Result

from mission.cli import main
from mission.commands import campaign, faults
from mission.verification.bounds import at_most
from mission.verification.campaign import generated, noticing, soak
from mission.verification.campaign.faults import FlightResult
from mission.verification.campaign.proofs import Margin, Shown
from mission.verification.campaign.soak import Summary
from mission.verification.exhaustive import run
from mission.verification.exhaustive.run import Found
from mission.verification.rehearsing import flights
from mission.verification.rehearsing.report import share_of, wilson
from mission.verification.simulation.flight import fly

WHY = "no result: raised RuntimeError: the worker is out of luck"


def unlucky() -> Any:
    raise RuntimeError("the worker is out of luck")


def told(call: str, code: int = 1) -> tuple[dict[str, Any], Result]:
    ran = CliRunner().invoke(main, [*shlex.split(call), "--on", "local"])
    assert ran.exit_code == code, ran.output
    return json.loads(ran.stdout.splitlines()[-1]), ran


def again(ran: Result) -> list[str]:
    return re.findall(r"^  again: (.*?) *$", ran.output, re.M)


def test_a_rehearsed_flight_without_a_result_is_undone_and_can_be_flown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    but = lambda *of, seed, **how: unlucky() if seed == 6 else fly(*of, seed=seed, **how)  # noqa: E731
    monkeypatch.setattr(flights, "fly", but)
    found, ran = told("rehearse first-dive --flights 3 --seed 5 --json")
    assert (found["flights"], found["undone"]) == (2, 1)
    assert f"flight 1: {WHY}" in ran.stderr
    (command,) = again(ran)
    assert command.startswith("auvmission simulate first-dive --seed 6 --set current=")
    low, high = found["completion_95"]
    assert (low, high) == tuple(round(p, 4) for p in share_of(2, 2, 1))
    monkeypatch.undo()
    flown = CliRunner().invoke(main, [*shlex.split(command)[1:], "--json"])
    assert json.loads(flown.stdout)["outcome"] == "completed"


def test_the_text_of_a_rehearsal_counts_what_is_undone(monkeypatch: pytest.MonkeyPatch) -> None:
    but = lambda *of, seed, **how: unlucky() if seed == 6 else fly(*of, seed=seed, **how)  # noqa: E731
    monkeypatch.setattr(flights, "fly", but)
    ran = CliRunner().invoke(
        main, ["rehearse", "first-dive", "--flights", "2", "--seed", "5", "--on", "local"]
    )
    assert re.search(r"^completed +1 of 2: ", ran.stdout, re.M)
    assert re.search(r"^ +undone +1$", ran.stdout, re.M)


def test_a_rehearsal_without_any_result_says_how_many_are_undone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(flights, "fly", lambda *_, **__: unlucky())
    found, ran = told("rehearse first-dive --flights 2 --seed 5 --json")
    assert found == {"flights": 0, "undone": 2, "seed": 5}
    assert len(again(ran)) == 2


@pytest.mark.parametrize(("hits", "of", "undone"), [(7, 7, 1), (3, 9, 4), (0, 1, 5)])
def test_a_share_holds_whatever_the_undone_would_have_come_to(
    hits: int, of: int, undone: int
) -> None:
    low, high = share_of(hits, of, undone)
    for more in range(undone + 1):
        least, most = wilson(hits + more, of + undone)
        assert low <= least <= most <= high
    assert share_of(hits, of, 0) == wilson(hits, of)


def result_of(number: int) -> FlightResult:
    return FlightResult(number, "", (), (), (), f"{number}")


def test_flights_that_are_undone_count_as_broken_in_the_bound(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one = lambda seed, known, number: unlucky() if number < 3 else result_of(number)  # noqa: E731
    monkeypatch.setattr(faults, "_fly_numbered", one)
    found, ran = told("faults --flights 20 --seed 4")
    assert (found["flights"], found["undone"], found["at_most"]) == (17, 3, at_most(3, 20))
    assert again(ran) == [f"auvmission faults --seed 4 --flight {n}" for n in range(3)]


def shown_of(seed: int, job: campaign.Job) -> Shown:
    subject, number = job
    some = Margin(1.0, 1.0, 1.0, 1.0)
    return Shown(subject.source, number, "", True, (), some, some)


def test_a_campaign_counts_what_is_undone_in_its_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        campaign, "_show", lambda seed, job: unlucky() if job[1] else shown_of(seed, job)
    )
    found, ran = told("campaign first-dive --flights 2 --seed 4")
    assert (found["flights"], found["undone"], found["at_most"]) == (1, 1, at_most(1, 2))
    assert again(ran) == ["auvmission campaign first-dive --seed 4 --flight 1"]


def test_a_mission_that_cannot_be_generated_costs_its_own_flights_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    generate = generated.generate
    monkeypatch.setattr(
        generated, "generate", lambda s, n, v: unlucky() if n == 1 else generate(s, n, v)
    )
    found, ran = told("campaign first-dive --missions 4 --flights 1 --seed 3")
    assert (found["missions"], found["flights"], found["undone"]) == (4, 3, 1)
    assert f"flight --generated 1 --flight 0: {WHY}" in ran.stdout
    assert again(ran) == ["auvmission campaign --generated 1 --seed 3 --flight 0"]


def test_cells_that_are_undone_are_told_and_all_others_examined(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one = lambda on: unlucky() if on.profile == "as-built" else Found({on.mission}, cells=7)  # noqa: E731
    monkeypatch.setattr(run, "examine_ground", one)
    found, ran = told("exhaustive first-dive loiter --vehicle auv --json")
    assert (found["missions"], found["cells"], len(found["undone"])) == (2, 14, 2)
    assert all(one.endswith(f"as-built: {WHY}") for one in found["undone"])
    assert "no cell asks" not in ran.stderr
    files = [command.split()[2].rpartition("/")[2] for command in again(ran)]
    assert files == ["first-dive.yaml", "loiter.yaml"]
    assert all(command.endswith(" --vehicle auv") for command in again(ran))


@pytest.mark.replaces
def test_a_broken_rule_that_is_undone_is_told_with_its_command(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(noticing, "notice", lambda name, *_, **__: unlucky())
    found, ran = told("faults --broken 'limit time' --flights 9 --seed 4 --search --vehicle rov")
    assert found["undone"] == ["limit time"]
    rest = "--seed 4 --flights 9 --search --vehicle rov"
    assert again(ran) == [f"auvmission faults --broken 'limit time' {rest}"]


def test_a_soak_that_is_undone_is_told_with_its_command(monkeypatch: pytest.MonkeyPatch) -> None:
    one = lambda *args: unlucky() if args[-1] == 4 else Summary({}, (), True)  # noqa: E731
    monkeypatch.setattr(soak, "soak_alone", one)
    found, ran = told("faults --soak 0.5 --soaks 2 --seed 3 --vehicle rov")
    assert found == {"soaks": {"3": {}, "4": None}, "undone": [4]}
    assert again(ran) == ["auvmission faults --vehicle rov --seed 4 --soak 0.5"]
    _, ran = told("faults --soak 0.5 --soaks 2 --seed 3 --calm")
    assert again(ran) == ["auvmission faults --calm --seed 4 --soak 0.5"]


def test_soaks_that_are_interrupted_tell_what_has_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*args: object) -> Summary:
        if args[-1] == 4:
            raise KeyboardInterrupt
        return Summary({"missions": 7}, (), True)

    monkeypatch.setattr(soak, "soak_alone", interrupted)
    found, _ = told("faults --soak 0.5 --soaks 3 --seed 3", 130)
    assert found == {"soaks": {"3": {"missions": 7}}, "undone": [4, 5]}
