"""A limit is one row: this file has a toy that nobody else knows, and it is seen everywhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from mission.analysis.replay.replay import replay
from mission.authoring.language import parse
from mission.engine.bounds import in_force
from mission.engine.limits import LIMITS, Limit
from mission.engine.monitor import LimitMonitor
from mission.engine.vehicle_state import VehicleState
from mission.model.shipped import load_vehicle
from mission.onboard.runtime.records import ListRecorder
from mission.verification.simulation.flight import fly
from protocol.messages import SetSafety

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


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    with LIMITS.registered(TOY):
        yield


def test_it_is_looked_at_answered_recorded_and_replayed_to_the_bit() -> None:
    recorder = ListRecorder()
    flight = fly(parse(TEXT), VEHICLE, seed=3, recorder=recorder)
    assert (flight.legs[0].name, flight.legs[0].by) == ("a", "limit")
    assert "deeper than 2 m" in flight.legs[0].why
    assert flight.at_surface
    assert replay(recorder.records).identical


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
