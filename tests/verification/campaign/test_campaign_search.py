"""A search for flights that nearly break a law: what it flies, and that it comes nearer."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from known_missions import KNOWN

from mission.commands.faults import faults
from mission.engine import monitor
from mission.engine.core import Core
from mission.verification.campaign.broken import BROKEN, broken
from mission.verification.campaign.draw import PROFILES, rows, stage
from mission.verification.campaign.faults import fly_near
from mission.verification.campaign.first_round import FILE, acts, in_order, ordered
from mission.verification.campaign.margins import MARGINS
from mission.verification.campaign.noticing import Flights, notice
from mission.verification.campaign.reached import reached
from mission.verification.campaign.scenes import SCENES
from mission.verification.campaign.search import (
    GENERATION,
    NEARLY,
    STEERED,
    Search,
    flown,
    fly_named,
)
from mission.verification.campaign.steered import plan_of
from mission.verification.workers.places import place

ROWS = rows(KNOWN)
WORST = json.loads(Path(__file__).with_name("worst_flights.json").read_text())


# --- names ---------------------------------------------------------------------------------------


def test_a_flight_follows_from_its_seed_and_its_name_alone() -> None:
    for name in ("heavy_for_ever/0", "held_stick/7/0/3", "first-dive/2"):
        assert plan_of(name, 5, KNOWN) == plan_of(name, 5, KNOWN)
        assert plan_of(name, 5, KNOWN) != plan_of(name, 6, KNOWN)
        assert plan_of(name, 5, KNOWN) != plan_of(f"{name}/0", 5, KNOWN)


@pytest.mark.parametrize("row", ROWS)
def test_every_row_is_flown_by_its_name(row: str) -> None:
    plan = plan_of(f"{row}/0/1", 3, KNOWN)
    assert (plan.scene or plan.subject.path.stem) == row


@pytest.mark.parametrize("row", ["heavy_for_ever", "lawnmower"])
def test_two_flights_of_a_row_try_both_profiles(row: str) -> None:
    plans = [plan_of(f"{row}/{number}", 1, KNOWN) for number in range(40)]
    for one, other in zip(plans[::2], plans[1::2], strict=True):
        assert {one.profile, other.profile} == set(PROFILES)


def test_four_flights_of_a_row_try_all_parts_of_a_range() -> None:
    """The weight is drawn between 0 and 45 N."""
    for first in range(0, 40, 4):
        plans = [plan_of(f"heavy_for_ever/{first + i}", 1, KNOWN) for i in range(4)]
        weights = [plan.settings.faults[0].value or 0.0 for plan in plans]
        assert sorted(int(4.0 * weight / 45.0) for weight in weights) == [0, 1, 2, 3]


def test_every_second_flight_of_a_scene_is_the_scene_alone() -> None:
    plans = [plan_of(f"auto_closed/{number}", 1, KNOWN) for number in range(40)]
    assert {len(plan.kinds) for plan in plans[::2]} == {1}
    assert {len(plan.kinds) for plan in plans[1::2]} == {1, 2}


def test_a_neighbour_is_the_same_flight_a_little_different() -> None:
    near = far = 0.0
    for number in range(20):
        parent = plan_of(f"heavy_for_ever/{number}", 2, KNOWN)
        child = plan_of(f"heavy_for_ever/{number}/0", 2, KNOWN)
        other = plan_of(f"heavy_for_ever/{number + 1}", 2, KNOWN)
        weight, moved, drawn = (p.settings.faults[0].value or 0.0 for p in (parent, child, other))
        near, far = near + abs(weight - moved), far + abs(weight - drawn)
    assert near < 0.5 * far


@pytest.mark.parametrize(
    "name", ["", "3", "nobody/0", "there", "clogged", "clogged/-1", "clogged/x"]
)
def test_a_name_that_is_none_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="no flight"):
        plan_of(name, 0, KNOWN)


# --- what is asked for ---------------------------------------------------------------------------


def row_of(name: str) -> str:
    return name.partition("/")[0]


def searching() -> Search:
    """Behind its first round, of which nothing was told."""
    search = Search(KNOWN)
    search.generation()
    return search


def test_the_first_round_is_one_flight_of_each_row() -> None:
    names = Search(KNOWN).generation()
    assert sorted(names) == sorted(f"{row}/0" for row in ROWS)
    assert names == Search(KNOWN).generation()
    assert {row_of(name) for name in names[len(SCENES) :]} == {s.path.stem for s in KNOWN}


def test_every_row_stands_in_the_order_and_a_new_one_comes_first() -> None:
    assert sorted(FILE.read_text().split()) == sorted(ROWS), "make first-round"
    assert in_order([*ROWS, "a new one"])[0] == "a new one"


def test_a_row_comes_before_those_that_act_by_nothing_new() -> None:
    acted = {"a": ["x"], "b": ["x", "y", "z"], "c": ["y"], "d": ["v"], "m": ["u", "w"]}
    assert ordered(acted, ("a", "b", "c", "d")) == ["b", "d", "c", "a", "m"]


@pytest.mark.proof
@pytest.mark.minutes
def test_each_of_the_first_rows_acts_by_a_rule_that_none_before_it_acted_by() -> None:
    before: set[str] = set()
    for row in in_order(ROWS)[:6]:
        acted = acts(KNOWN, row)
        assert acted - before, row
        before |= acted


def test_without_any_margin_the_rounds_go_on() -> None:
    search = searching()
    names = [name for _ in range(8) for name in search.generation()]
    assert len(set(names)) == len(names) == 8 * GENERATION
    assert sorted(map(row_of, names[: len(ROWS)])) == sorted(ROWS)


def test_neighbours_of_the_nearest_are_flown_by_turns_with_the_round() -> None:
    search = searching()
    search.tell("clogged/0", {"depth": 0.4}, broken=False)
    search.tell("capsized/0", {"depth": 0.45, "tilt": 0.3, "rest": NEARLY}, broken=False)
    names = search.generation()
    assert {"clogged/0/0", "capsized/0/0"} < set(names)
    assert len(names) == GENERATION
    search.tell("clogged/0/0", {"depth": 0.3}, broken=False)
    assert {"clogged/0/0/0", "capsized/0/1"} < set(search.generation())


def test_no_law_takes_all_the_flights() -> None:
    search = searching()
    for i in range(2 * STEERED):
        search.tell(f"{ROWS[i]}/0", {f"law {i}": i / 100.0}, broken=False)
    names = [name for _ in range(6) for name in search.generation()]
    tried = Counter(row_of(name) for name in names if name.count("/") > 1)
    assert set(tried.values()) == {3}
    assert len(tried) == 2 * STEERED


def test_what_has_broken_a_law_is_told_and_not_steered_by() -> None:
    search = searching()
    search.tell("clogged/0", {"depth": 0.0}, broken=True)
    assert not search.nearest
    assert all(name.count("/") == 1 for name in search.generation())


@pytest.mark.proof
@pytest.mark.minutes
def test_what_is_flown_does_not_depend_on_who_works() -> None:
    def names(workers: int) -> list[str]:
        found = flown(Search(KNOWN), 3, len(ROWS) + 20, KNOWN, place(workers=workers))
        return [name for name, _ in found]

    assert names(1) == names(2)


# --- margins -------------------------------------------------------------------------------------

# The rule that is broken, a scene and its seed, and the margin that falls.
FALLS = [
    ("limit depth", "shallow_depth", 0, "depth"),
    ("limit radius", "small_radius", 0, "radius"),
    ("limit roll-over", "capsized", 2, "tilt"),
    ("limit time", "short_time", 0, "time"),
    ("silence", "silent", 0, "reports"),
    ("limit topside", "silent_topside", 0, "topside"),
    ("limit no answer", "no_answers", 0, "answers"),
    ("blind leg", "blind_compass", 0, "sensor"),
    ("AUTO ends", "auto_closed", 0, "AUTO"),
    ("stays down", "neutral_after_x", 0, "rest"),
    ("ways in turn", "dives_until_up", 0, "ascent"),
    ("restart", "restarted", 0, "upward"),
    ("stuck receiver", "stuck_receiver", 0, "surface"),
    ("cleared below", "cleared_below", 0, "begin"),
    ("ways in turn", "heavy_for_ever", 0, "end"),
    ("stop again", "deaf_to_x", 0, "stop"),
    ("stop doubted", "turns_after_a_stop", 0, "turning"),
    ("relays first", "slider", 0, "order"),
    ("silent stick", "stick_left", 0, "stick"),
    ("stuck receiver", "stuck_receiver", 0, "estimate"),
]


def margins_of(scene: str, seed: int) -> Mapping[str, float]:
    return fly_near(stage(scene, seed))[1]


@pytest.mark.proof
@pytest.mark.parametrize(("rule", "scene", "seed", "law"), FALLS)
def test_a_margin_falls_when_a_rule_that_keeps_it_is_broken(
    rule: str, scene: str, seed: int, law: str
) -> None:
    whole = margins_of(scene, seed).get(law, 1.0)
    with broken(rule):
        assert margins_of(scene, seed)[law] < whole


def test_every_margin_is_seen_to_fall() -> None:
    assert {law for *_, law in FALLS} == set(MARGINS)


# --- which flights tell a rule from its absence ----------------------------------------------------


@pytest.mark.replaces
def test_a_rule_is_reached_where_it_could_have_made_a_difference() -> None:
    with reached() as rules:
        fly_near(stage("shallow_depth", 0))
    assert {"limit depth", "operator's limits", "gap"} < rules
    assert rules.isdisjoint({"limit roll-over", "commander", "AUTO ends", "copies", "belief"})


def test_what_was_watched_is_whole_again_afterwards() -> None:
    before = (monitor.LIMITS, Core.surface, Core.auto_off)
    with reached() as rules:
        assert Core.surface is not before[1]
    assert (monitor.LIMITS, Core.surface, Core.auto_off) == before
    assert rules < set(BROKEN)


@pytest.mark.proof
@pytest.mark.parametrize("scene", list(SCENES)[::6])
def test_a_flight_that_did_not_reach_a_rule_is_the_same_without_it(scene: str) -> None:
    plan = stage(scene, 4)
    with reached() as rules:
        whole = fly_near(plan)
    for rule in [name for name in BROKEN if name not in rules][::4]:
        with broken(rule):
            assert fly_near(plan) == whole, rule


@pytest.mark.proof
def test_a_search_notices_a_rule_that_is_broken() -> None:
    flights = Flights(0, KNOWN)
    noticed = notice("unasked", flights, 5, searched=True)
    assert noticed.flights is not None
    assert noticed.by.startswith("spurious")


# --- the worst, and the command --------------------------------------------------------------------


@pytest.mark.parametrize("law", WORST)
def test_the_flights_that_came_nearest_break_no_law(law: str) -> None:
    worst: dict[str, Any] = WORST[law]
    result, _ = fly_named(worst["seed"], KNOWN, worst["flight"])
    assert not result.violations, (worst, result)


@pytest.mark.proof
def test_the_command_tells_what_came_nearest_and_flies_it_again() -> None:
    run = CliRunner().invoke
    done = run(faults, ["--search", "--flights", "2", "--workers", "1", "--seed", "3"])
    assert done.exit_code == 0, done.output
    nearest = json.loads(done.stdout.splitlines()[-1])["nearest"]
    law, worst = next(iter(nearest.items()))
    assert 0.0 <= worst["left"] < 1.0
    assert law in MARGINS
    again = run(faults, ["--seed", "3", "--flight", worst["flight"]])
    assert again.exit_code == 0, again.output
    assert f"again: auvmission faults --seed 3 --flight {worst['flight']}" in again.output
    assert run(faults, ["--flight", "nonsense/0"]).exit_code == 2
    assert run(faults, ["--flight", "-1"]).exit_code == 2
