"""A law is one row: this file has toys that nobody else knows, of cells and of flights; each is asked,
and what breaks it is told and counted."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from contracts import keep

from mission.authoring.prepare import prepare
from mission.model.shipped import missions_folder
from mission.verification.campaign.draw import stage
from mission.verification.campaign.faults import Totals, fly_plan, result_of
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.scenes import SCENES
from mission.verification.campaign.story import Story
from mission.verification.campaign.whole_flight import FLIGHT_LAWS, FlightLaw
from mission.verification.exhaustive import run
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.configurations import ground
from mission.verification.exhaustive.events import EVENTS
from mission.verification.exhaustive.laws import Law
from mission.verification.exhaustive.run import LAWS, examine_ground, unasked


def no_x_leaves(cell: Cell) -> str | None:
    """Which is false: an operator's X does."""
    if cell.event.command != "X":
        return None
    return "X0 left" if cell.frames(b"@ZAX0$") else ""


def nothing_is_said(story: Story) -> Iterator[Violation]:
    """Which is false of every flight."""
    yield Violation("chatty", story.trial.truth.t, f"{len(story.trial.events)} things happened")


OF_CELLS = Law("toy: no X leaves", "R7", no_x_leaves)
OF_FLIGHTS = FlightLaw("toy", ("chatty",), nothing_is_said)


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    with LAWS.registered(OF_CELLS), FLIGHT_LAWS.registered(OF_FLIGHTS):
        yield


def test_they_keep_the_contracts_of_laws() -> None:
    keep("laws of cells", OF_CELLS)
    keep("laws of flights", OF_FLIGHTS)


def test_every_cell_is_asked_and_one_that_breaks_it_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    few = tuple(event for name, event in EVENTS.items() if name in ("X", "ACK Y"))
    monkeypatch.setattr(run, "events_of", lambda line: few)
    on = ground(prepare(missions_folder() / "first-dive.yaml"), "as-built")
    found = examine_ground(on, every=1000)
    assert found.configurations == 1
    assert found.asked[OF_CELLS.name] == found.broken[OF_CELLS.name] == 1
    (told,) = found.violations
    assert (told["law"], told["event"], told["seen"]) == (OF_CELLS.name, "X", "X0 left")
    assert OF_CELLS.name not in unasked(found)
    assert OF_CELLS.name in unasked(run.Found())


def test_every_flight_of_the_campaign_is_asked_and_counted() -> None:
    plan = stage(next(iter(SCENES)), 1)
    result = result_of(plan, fly_plan(plan, plan.vehicle), plan.vehicle, plan.profile)
    assert [violation.kind for violation in result.violations] == ["chatty"]
    totals = Totals()
    totals.add(result)
    assert totals.as_json()["chatty"] == 1
    assert not totals.clean
