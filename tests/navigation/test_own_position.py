"""A vehicle's own position under water is reckoned and no fix, and a quick receiver is no surer."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

import numpy as np
import pytest

from links.simulated.sea import Sea
from links.simulated.settings import Settings
from mission.authoring.prepare import prepare_text
from mission.model import Estimate, NavigationMode, Position
from mission.model.shipped import load_vehicle
from mission.navigation import LocalFrame, Navigation
from mission.navigation.distribution import around_95
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Sample
from protocol.messages import Fix, Telemetry

HOME = Position(30.2874595, 120.1535765)
FRAME = LocalFrame(HOME)
AFLOAT, UNDER = 60, 600  # s
DIVE = """mission dive vehicle coreboard
home 30.2874595 120.1535765
safety radius 900 time 40min depth 20 voltage 12
assume current 0.2
wait: surface until fix timeout 1min
dive: depth 4 heading 90 gear 4 until depth >= 3.7 timeout 90s
out: depth 4 heading 90 gear 4 for 5min
up: surface until fix timeout 3min
"""


def reckoned(depth: float, current: float = 0.0, *, told: bool = True) -> Estimate:
    """A minute afloat, and ten at ``depth``, in a current to the east, m/s. Its own positions come
    once a second. Afloat they are true, and under water they see nothing of the current."""
    rng = Random(1)
    nav = Navigation(replace(load_vehicle("coreboard"), declination=0.0), HOME)
    for second in range(AFLOAT + UNDER):
        t, deep = float(second), second >= AFLOAT
        shown = min(0.1 + 0.25 * max(second - AFLOAT, 0), depth) + rng.gauss(0.0, 0.03)
        compass = rng.gauss(1.0, 0.02)
        nav.telemetry(Telemetry(t, depth=shown, heading=compass, actuators=(0.0,) * 6))
        if told or not deep:
            east = current * min(t, AFLOAT)
            place = FRAME.to_geodetic(rng.gauss(0.0, 0.5), east + rng.gauss(0.0, 0.5))
            nav.fix(Fix(t, *place, accuracy=math.inf))
    estimate = nav.estimate(float(AFLOAT + UNDER))
    assert estimate is not None
    return estimate


def test_it_is_a_fix_at_the_surface_alone() -> None:
    afloat, under = reckoned(0.1), reckoned(5.0)
    assert afloat.fix_age == pytest.approx(1.0)
    assert afloat.mode is NavigationMode.FIX
    assert under.fix_age == pytest.approx(UNDER, abs=10.0)
    assert under.mode is NavigationMode.DEAD_RECKONING


@pytest.mark.parametrize("current", [0.0, 0.1, 0.2, 0.3])
def test_the_ellipse_holds_a_current_that_the_vehicle_itself_does_not_see(current: float) -> None:
    """0.2 m/s is what the vehicle file says of currents. As fixes they left a radius of 2 m."""
    estimate = reckoned(5.0, current)
    off = math.hypot(estimate.north, current * (AFLOAT + UNDER) - estimate.east)
    assert off < around_95(estimate.covariance)


def test_it_makes_the_estimate_no_surer_than_half_of_what_it_is_without() -> None:
    told, alone = reckoned(5.0), reckoned(5.0, told=False)
    ratio = around_95(told.covariance) / around_95(alone.covariance)
    assert 0.4 < ratio < 1.0


def test_a_receiver_that_speaks_five_times_a_second_is_no_surer_than_one_that_speaks_once() -> None:
    """Its errors last for longer than that, and so do waves."""
    radius = {}
    for hertz in (1, 5):
        rng, nav = Random(2), Navigation(replace(load_vehicle("auv"), declination=0.0), HOME)
        for step in range(60 * hertz):
            t = step / hertz
            if step % (2 * hertz) == 0:
                nav.telemetry(
                    Telemetry(t, depth=0.1, heading=rng.gauss(1.0, 0.02), actuators=(0.0,) * 5)
                )
            place = FRAME.to_geodetic(rng.gauss(0.0, 2.5), rng.gauss(0.0, 2.5))
            nav.fix(Fix(t + 0.1, *place, 2.5, speed=0.1, course=0.0))
        estimate = nav.estimate(60.0)
        assert estimate is not None
        radius[hertz] = around_95(estimate.covariance)
    assert radius[5] == pytest.approx(radius[1], rel=0.05)


@pytest.mark.proof
def test_after_five_minutes_of_a_core_boards_dive_the_ellipse_is_as_wide_as_the_errors() -> None:
    """Through the bytes of a board whose own position drifts; NEES of 8 flights, by chi square."""
    ready, total = prepare_text(DIVE, "dive"), 0.0
    for seed in range(8):
        rng = Random(seed)
        sea = Sea(current=(rng.uniform(0.0, 0.25), rng.uniform(0.0, 2.0 * math.pi)))
        flight = fly(ready.mission, ready.vehicle, seed=seed, settings=Settings(sea=sea))
        dive = next(leg for leg in flight.legs if leg.name == "out")
        last = [sample for sample in flight.samples if sample.t < dive.left][-1]
        assert last.estimate.fix_age > 300.0
        total += nees(last)
    assert 5.1 < total < 34.3, "99 % of what 16 degrees of freedom give"


def nees(sample: Sample) -> float:
    e, true = sample.estimate, sample.true
    nn, ne, ee = e.covariance
    off = np.array([e.north - true.north, e.east - true.east])
    return float(off @ np.linalg.solve(np.array([[nn, ne], [ne, ee]]), off))
