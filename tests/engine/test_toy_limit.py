"""A limit is one row: this file has a toy that nobody else knows, and it is seen everywhere."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from contracts import keep
from engine_world import World
from limit_cases import CASES, Case, flying

from mission.analysis.replay.replay import replay
from mission.authoring.language import parse
from mission.engine.bounds import in_force
from mission.engine.limits import LIMITS, Limit
from mission.engine.monitor import LimitMonitor
from mission.engine.vehicle_state import VehicleState
from mission.model import SURFACING
from mission.model.shipped import load_vehicle
from mission.onboard.runtime.records import ListRecorder
from mission.verification.exhaustive.cell import Event
from mission.verification.exhaustive.events import EVENTS
from mission.verification.exhaustive.world import World as Cell
from mission.verification.simulation.flight import fly
from protocol.messages import SetSafety

DOCS = Path(__file__).resolve().parents[2] / "docs"
BOUND = 2.0  # m


def breached(watch) -> bool | None:
    depth = watch.vehicle_state.depth
    return None if depth is None else depth > BOUND


TOY = Limit(
    "toy depth",
    "depth",
    "2 m",
    breached,
    lambda watch: f"deeper than {BOUND:g} m",
    samples=2,
    needs=frozenset({"depth"}),
)
VEHICLE = load_vehicle("auv")
TEXT = (
    "mission toy vehicle auv\nhome 30.28 120.15\nsafety radius 400 time 30min depth 20\n"
    "a: heading 0 gear 6 depth 4 for 60\n"
)


def reported(world: World, depth: float, count: int) -> None:
    """So many reports of this depth, then of 1 m again."""
    for metres in (*[depth] * count, 1.0, 1.0):
        world.depth = metres
        world.wait(2.0)


CASE = Case(
    "deeper than 2 m",
    lambda world: reported(world, math.nextafter(BOUND, 3.0), 2),
    lambda world: reported(world, math.nextafter(BOUND, 3.0), 1),
    lambda world: reported(world, BOUND, 20),
    begin=lambda: flying(depth=1.0),
)


def dives(world: Cell) -> None:
    world.sea.depth = BOUND + 1.0
    world.wait(6.0)


EVENT = Event("limit toy depth", lambda world, c, chart: dives(world), limit=TOY.name)


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setitem(CASES, TOY.name, CASE)
    with LIMITS.registered(TOY), EVENTS.registered(EVENT):
        yield


def test_it_keeps_the_contract_of_limits_with_a_bound_case_of_its_own() -> None:
    keep("limits", TOY)
    keep("events", EVENT)


def test_it_is_looked_at_answered_recorded_and_replayed_to_the_bit() -> None:
    recorder = ListRecorder()
    flight = fly(parse(TEXT), VEHICLE, seed=3, recorder=recorder)
    assert (flight.legs[0].name, flight.legs[0].by) == ("a", "limit")
    assert "deeper than 2 m" in flight.legs[0].why
    assert flight.at_surface
    assert replay(recorder.records).identical


def test_a_report_without_what_it_needs_takes_nothing_from_its_count_and_adds_nothing() -> None:
    world = flying(depth=1.0)
    for metres in (3.0, None, 3.0):
        world.depth = metres
        world.wait(2.0)
    assert world.state == SURFACING
    world = flying(depth=1.0)
    for metres in (3.0, 1.0, 3.0):
        world.depth = metres
        world.wait(2.0)
    assert world.state != SURFACING


def test_it_is_listed_in_the_manual(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(DOCS))
    from from_code.tables import limits

    row = "| toy depth | depth | 2 m | 2 samples | autonomous | emergency/surfacing |"
    assert row in limits().split("\n")
    assert "| voltage | control battery | the voltage in force | 10 s |" in limits()
    assert "```{from-code} limits" in (DOCS / "operation.md").read_text(encoding="utf-8")


def test_a_flight_within_it_is_not_disturbed() -> None:
    flight = fly(parse(TEXT.replace("depth 4", "depth 1")), VEHICLE, seed=3)
    assert flight.legs[0].by == "for"


def test_a_vehicle_that_does_not_report_what_it_needs_disarms_it_and_flies_on() -> None:
    deaf = replace(VEHICLE, reports=VEHICLE.reports - {"depth"})
    assert LIMITS[TOY.name].disarmed(deaf) == f"{VEHICLE.name} does not report depth"
    armed = [
        LimitMonitor(v, VehicleState(), in_force(v, None, SetSafety())) for v in (VEHICLE, deaf)
    ]
    assert [TOY in monitor.rows for monitor in armed] == [True, False]
