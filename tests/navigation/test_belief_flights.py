"""Flights by truth: a depth that is wrong leads nowhere, and one that is right is believed."""

from __future__ import annotations

import pytest

from links.simulated.settings import parse_settings
from mission.authoring.language import parse
from mission.authoring.prepare import prepare
from mission.model import SURFACED, Mission
from mission.model.shipped import load_vehicle, missions_folder
from mission.verification.campaign.trial import try_out
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight, TruePlace

pytestmark = pytest.mark.proof  # long: make proofs

PROFILES = ("as-built", "documented")
LIMIT = "limit depth contradicted"
SINKS = 6.0  # m beyond the limit, in the time that it takes
MISSION = """mission hold vehicle auv
home 30.2874595 120.1535765
safety radius 500 time 30min depth {limit}
assume current 0.1
dive: ZAS{depth} heading 90 ZAF4 until depth >= {reached} timeout 3min
hold: heading 90 ZAF4 until elapsed >= 100s timeout 110s
up: surface timeout 3min
"""


def hold(depth: int) -> Mission:
    return parse(MISSION.format(depth=depth, limit=depth + 1, reached=depth - 0.5))


def flown(mission: Mission, profile: str, *settings: str, seed: int = 1) -> Flight:
    return fly(
        mission,
        load_vehicle("auv"),
        profile=profile,
        seed=seed,
        settings=parse_settings(["floor=150", *settings]),
    )


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize(
    ("depth", "fault"),
    [
        (10, "depth_stuck@1"),
        (10, "depth_stuck@12"),
        (10, "depth_stuck=0.2@20"),
        (10, "depth_stuck=0.3@26"),
        (3, "depth_stuck@8"),
        (2, "depth_stuck@2"),
        (10, "depth_drifting=-0.3@10"),
    ],
)
def test_a_port_that_clogs_a_metre_short_leads_no_deeper_than_it_sinks_meanwhile(
    profile: str, depth: int, fault: str
) -> None:
    flight = flown(hold(depth), profile, f"fault={fault}+900")
    assert flight.reason.startswith(LIMIT)
    assert flight.max_depth <= depth + 1 + SINKS
    assert flight.final_state == SURFACED
    assert flight.at_surface


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("fault", ["depth_too_deep=2@9", "depth_drifting=0.1@30"])
def test_an_offset_or_a_drift_keeps_no_vehicle_from_its_surface(profile: str, fault: str) -> None:
    flight = flown(hold(3), profile, f"fault={fault}+900")
    assert any(
        "surfaced" in step.trigger or "emergency/surfaced" in step.entered for step in flight.steps
    )
    assert flight.at_surface
    assert flight.track[-1].t < 400.0


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("fault", ["gps_wanders@1", "gps_in_turn@1", "gps_stuck@1"])
def test_what_a_receiver_says_under_water_ends_no_ascent(profile: str, fault: str) -> None:
    flight = flown(hold(8), profile, f"fault={fault}+900")
    assert flight.reason == "the mission's end was reached"
    up = next(step.t for step in flight.steps if step.entered[-1:] == ("autonomous/up",))
    stopped = next(
        step.t for step in flight.steps if step.t > up and "stopped" in str(step.actions)
    )
    assert next(place.depth for place in flight.track if place.t >= stopped) < 0.5
    clean = flown(hold(8), profile)
    assert flight.max_range <= clean.max_range + 15.0


@pytest.mark.parametrize(
    ("name", "profile"),
    [
        (path.stem, PROFILES[i % 2])
        for i, path in enumerate(sorted(missions_folder().glob("*.yaml")))
    ],
)
def test_no_depth_of_a_flight_without_faults_is_contradicted(name: str, profile: str) -> None:
    flight = flown(
        prepare(missions_folder() / f"{name}.yaml").mission,
        profile,
        *("current=0.4@200", "depth_noise=0.1", "altitude_drop=0.5", "floor=28"),
        seed=len(name),
    )
    assert flight.outcome != "emergency", flight.reason


# --- a sensor that says one thing ----------------------------------------------------------------

UP = {SURFACED, "autonomous/surface", "idle/ready"}  # what an ascent leads to when it has ended


SHORT = parse(
    MISSION.replace("elapsed >= 100s timeout 110s", "elapsed >= 60s timeout 70s").format(
        depth=8, limit=11, reached=7.5
    )
)


def watched(profile: str, *faults: str) -> tuple[TruePlace, ...]:
    """The track of a flight that is watched on behind its end."""
    settings = parse_settings(["floor=250", *(f"fault={fault}" for fault in faults)])
    return try_out(SHORT, load_vehicle("auv"), profile, 1, settings).track


@pytest.mark.parametrize(
    ("profile", "at"),
    [("as-built", at) for at in (118, 122, 124, 126)]
    + [("documented", at) for at in (103, 104, 106, 109)],
)
def test_a_depth_that_dies_at_zero_on_the_way_up_ends_no_ascent(profile: str, at: int) -> None:
    """3 N too heavy, it would sink for ever once it is let go."""
    track = watched(profile, f"depth_dead=0@{at}+700", "heavy=18@60+700")
    died = next(place.depth for place in track if place.t >= at)
    assert 1.0 < died < 6.0
    assert max(place.depth for place in track if at < place.t < at + 600.0) <= max(died, 3.0)


@pytest.mark.parametrize("profile", PROFILES)
def test_a_depth_that_has_died_at_zero_leaves_a_sound_vehicle_to_its_fixes(profile: str) -> None:
    at = 112 if profile == "as-built" else 102
    flight = flown(SHORT, profile, f"fault=depth_dead=0@{at}+2000")
    assert flight.reason == "the mission's end was reached"
    ended = next(step.t for step in flight.steps if step.t > at and set(step.entered) & UP)
    assert next(place.depth for place in flight.track if place.t >= ended) < 0.8
    assert flight.at_surface


@pytest.mark.parametrize("at", [126, 128, 132, 138])
def test_what_sinks_at_rest_with_a_frozen_depth_is_brought_up_when_its_fixes_end(at: int) -> None:
    """Nothing turns, so that nothing says that it has frozen."""
    track = watched("as-built", f"depth_frozen@{at}+700", "heavy=18@60+700")
    assert max(place.depth for place in track if place.t > at + 20.0) < 4.0


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("fault", ["depth_stuck@1", "depth_stuck@18", "depth_stuck@26"])
def test_an_altimeter_that_hears_itself_hides_no_clogged_port(profile: str, fault: str) -> None:
    """In deep water, where no bottom is in its range."""
    mission = parse(MISSION.replace("100s", "400s").replace("110s", "410s").format(
        depth=10, limit=11, reached=9.5
    ))  # fmt: skip
    faults = [f"fault={fault}+900", "fault=altitude_rings=0.6@1+900"]
    flight = flown(mission, profile, "floor=250", *faults)
    assert flight.reason.startswith(LIMIT)
    assert flight.max_depth <= 11 + SINKS
    assert flight.at_surface
