"""`temperature falls 2 within 5 m` and `depth back at highest temperature within 0.5`: both texts,
what is refused and with what instead, pictures, and a dive through water that has such layers."""

from __future__ import annotations

import json
import math

import pytest

from links.simulated.sensors import SensorErrors, warmth
from links.simulated.settings import parse_settings
from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.graph.dot import dot
from mission.authoring.graph.outline import outline
from mission.authoring.graph.tables import tables
from mission.authoring.language import digest, parse, to_lines, to_yaml
from mission.model import Back, Chart, Leg, Mission, Term, Trend, terms
from mission.model.diagnostics import MissionErrors
from mission.model.shipped import load_vehicle
from mission.verification.simulation.flight import fly

HEAD = "mission m vehicle {vehicle}\nhome 30 120\nsafety radius 900 time 30min depth 25\n"
PEAK = "back: depth 3 gear 4 until depth back at highest temperature within 0.5 timeout 3min"
FALLS = "temperature falls 2 within 5 m held 4"
LAYERS = ("thermocline=4@12", "warm_layer=2@8")


def text(guard: str, vehicle: str = "auv", then: str = PEAK) -> str:
    down = f"down: depth 20 heading 90 gear 4 until {guard} timeout 3min"
    return HEAD.format(vehicle=vehicle) + f"{down}\n{then}\nup: surface timeout 3min\n"


def term(guard: str) -> Term:
    leg = parse(text(guard)).body[0]
    assert isinstance(leg, Leg)
    return next(terms(leg.exits[0].guard.expression))


def chart(mission: Mission) -> Chart:
    return compile_mission(mission, load_vehicle(mission.vehicle), digest(mission))


def refusals(guard: str, **more: str) -> list[tuple[str, str]]:
    with pytest.raises(MissionErrors) as caught:
        chart(parse(text(guard, **more)))
    return [(problem.code, problem.hint) for problem in caught.value.diagnostics]


# --- texts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("guard", "meant"),
    [
        (FALLS, Trend("temperature", False, 2.0, 5.0, True)),
        ("temperature falls 2 C within 1 min", Trend("temperature", False, 2.0, 60.0)),
        ("altitude rises 300 cm", Trend("altitude", True, 3.0)),
        ("pitch falls 90 deg within 500 cm", Trend("pitch", False, math.pi / 2, 5.0, True)),
        ("heading back at lowest temperature within 90", Back("heading", False, "temperature",
                                                              math.pi / 2)),
    ],
)  # fmt: skip
def test_a_trend_means_what_it_says(guard: str, meant: Term) -> None:
    assert term(guard) == meant


@pytest.mark.parametrize("guard", [FALLS, "not depth rises 3 within 20 s or temperature falls 1"])
def test_both_texts_are_one_mission(guard: str) -> None:
    mission = parse(text(guard))
    again = parse(to_lines(mission)), parse(to_yaml(mission))
    assert {digest(m) for m in (mission, *again)} == {digest(mission)}


def test_within_behind_a_trend_is_its_own_and_elsewhere_the_legs() -> None:
    leg = "go: goto north 0 east 50 within 7 depth 5 gear 6 until temperature rises 1 within 20 s"
    mission = parse(text(FALLS, then=f"{leg} timeout 3min"))
    moved = parse(text(FALLS, then=f"{leg} timeout 3min".replace("within 7 ", "") + " within 7"))
    assert digest(mission) == digest(moved)
    assert " within 7 " in to_lines(mission)


def test_a_parameter_may_stand_for_each_number() -> None:
    lines = text("temperature falls step within far").splitlines()
    lines[1:1] = ["param step 2", "param far 5 m"]
    assert digest(parse("\n".join(lines))) == digest(parse(text("temperature falls 2 within 5 m")))


@pytest.mark.parametrize(
    ("guard", "code", "instead"),
    [
        ("temperature falls 2 within 5", "unit", "within 20 s, or within 5 m"),
        ("temperature falls 2 within 5 V", "unit", "within 20 s, or within 5 m"),
        ("temperature falls 2 within 1 s", "range", "2 or more"),
        ("temperature falls 0", "range", "more than 0"),
        ("metal falls 2", "unknown-variable", "variables"),
        ("heading falls 2", "no-trend", "heading > 60"),
        ("elapsed rises 2", "no-trend", "elapsed > 60"),
        ("depth rises 2 within 5 m", "no-trend", "within 20 s"),
        ("depth back at highest course within 2", "no-trend", "course > 60"),
        ("elapsed back at highest depth within 2", "no-trend", "depth, heading"),
        ("depth back at highest metal within 2", "unknown-variable", "variables"),
        ("temperature falls 66", "never-true", "ask for less"),
        ("depth rises 9 within 4 s", "never-true", "give it longer"),
        ("temperature rises 1 within 2 s", "never-known", "write within 4 s or more"),
        ("temperature drops 2", "unknown-word", "write falls"),
        ("temperature increases 2", "unknown-word", "write rises"),
        ("depth back at peak temperature within 1", "unknown-word", "highest or lowest"),
        ("depth back at highest temperature", "syntax", "within"),
    ],
)
def test_what_can_never_be_is_refused_with_what_instead(guard: str, code: str, instead: str):
    ((told, hint),) = refusals(guard)
    assert told == code
    assert instead in hint


def test_a_vehicle_that_lacks_the_reading_is_told() -> None:
    assert [code for code, _ in refusals("leak rises 1 within 5 m")] == ["never-known"]


def test_the_first_leg_has_no_leg_before() -> None:
    mission = parse(text("depth back at highest temperature within 1"))
    found = check_mission(chart(mission), load_vehicle("auv")).refusals
    assert [d.code for d in found] == ["no-leg-before"]
    later = parse(text(FALLS))
    assert not check_mission(chart(later), load_vehicle("auv")).refusals


def test_pictures_and_tables_say_it() -> None:
    found = chart(parse(text(FALLS)))
    assert "temperature falls 2 C within 5 m for 4 s" in dot(outline(found))
    edges = json.loads(tables(found))["edges"]
    said = [edge["guard"]["expression"] for edge in edges if edge["guard"]]
    assert {"variable": "temperature", "moves": "falls", "amount": 2.0, "depth": 5.0} in said
    assert any(edge.get("back at") == "highest" and edge["within"] == 0.5 for edge in said)


# --- by truth -------------------------------------------------------------------------------------


def test_the_water_has_its_layers() -> None:
    plain = SensorErrors()
    errors = parse_settings(LAYERS).errors
    assert warmth(errors, 40.0) == pytest.approx(warmth(plain, 40.0) - 4.0, abs=1e-3)
    depths = [0.1 * n for n in range(250)]
    assert max(depths, key=lambda d: warmth(errors, d)) == pytest.approx(8.0, abs=0.3)
    steepest = max(depths, key=lambda d: warmth(errors, d) - warmth(errors, d + 0.1))
    assert steepest == pytest.approx(12.0, abs=0.6)


@pytest.mark.parametrize("profile", ["as-built", "documented"])
def test_a_dive_finds_the_thermocline_and_comes_back_to_the_warmest_depth(profile: str) -> None:
    mission = parse(text(FALLS))
    flight = fly(mission, load_vehicle("auv"), profile, 4, parse_settings(LAYERS))
    down, back, *_ = flight.legs
    assert (flight.outcome, down.by, back.by) == ("completed", "until", "until")
    assert 11.0 < flight.max_depth < 15.5
    begun = flight.samples[0].true.t - flight.samples[0].t
    at = min(flight.track, key=lambda place: abs(place.t - begun - back.left))
    assert at.depth == pytest.approx(8.0, abs=1.2)


@pytest.mark.parametrize("fault", ["temperature_silent", "temperature_frozen"])
def test_a_sensor_that_says_nothing_leaves_it_to_the_clock(fault: str) -> None:
    settings = parse_settings([*LAYERS, f"fault={fault}@0+4000"])
    flight = fly(parse(text(FALLS)), load_vehicle("auv"), "as-built", 4, settings)
    assert (flight.outcome, flight.legs[0].by) == ("completed", "timeout")
