"""No word of the language leads past what the check proved, whatever it waits for is withheld."""

from __future__ import annotations

from dataclasses import replace

import pytest
from click.testing import CliRunner

from links.simulated.settings import FaultEvent
from mission.authoring.check.ascents import ascent_time
from mission.authoring.check.assumptions import FROZEN, LATE, STICKS, TURNED
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse, words
from mission.commands.campaign import campaign
from mission.engine.variables import VARIABLES
from mission.legs import LEGS
from mission.model.diagnostics import MissionErrors
from mission.model.shipped import load_vehicle
from mission.verification.campaign.draw import PROFILES
from mission.verification.campaign.proofs import ENERGY, RANGE, TIME, Claim, show
from mission.verification.campaign.trial import FOREVER
from mission.verification.campaign.withheld import (
    ASSUMPTIONS,
    CLAUSES,
    HEAD,
    REFUSED,
    SETTINGS,
    claim_of,
    claims,
    draw_withheld,
    drawn_for,
    missions,
)

pytestmark = pytest.mark.proof  # long: make proofs

VEHICLE = load_vehicle("auv")
CLAIMS = list(claims(VEHICLE))


def test_every_word_of_the_language_has_its_flights() -> None:
    """A new word fails here until it is flown."""
    trials = {row.name: row.trial for row in VARIABLES.values() if row.trial}
    flown_or_refused = {*trials, *(word for word in REFUSED if word in VARIABLES)}
    assert all(row.trials for row in LEGS.values())
    assert {*SETTINGS, *(w for w in REFUSED if w in words.SETTINGS)} == set(words.SETTINGS)
    assert {*CLAUSES, *(w for w in REFUSED if w in words.CLAUSES)} == set(words.CLAUSES)
    assert set(ASSUMPTIONS) == set(words.ASSUMPTIONS)
    assert flown_or_refused == set(VARIABLES)
    assert {row.word for row in words.ZA.values()} <= set(SETTINGS)
    for word, body in missions():
        asked = trials.get(word, word)
        assert asked.split()[0] in body or word in ("hold", "start"), (word, body)


@pytest.mark.parametrize("word", REFUSED)
def test_what_is_not_flown_no_mission_may_say(word: str) -> None:
    mission = parse(f"{HEAD.format(name='m')}{REFUSED[word]}\n")
    with pytest.raises(MissionErrors):
        compile_mission(mission, VEHICLE, digest(mission))


@pytest.mark.parametrize("number", range(len(CLAIMS)), ids=[c.mission.name for c in CLAIMS])
def test_no_word_leads_past_what_was_proved_with_what_it_waits_for_withheld(number: int) -> None:
    claim = CLAIMS[number]
    shown = show(claim, VEHICLE, 7, number, drawn_for(claim, number))
    assert shown.started, shown
    assert not shown.violations, shown


@pytest.mark.parametrize("number", [5, 64])
def test_without_a_depth_it_knows_as_late_as_is_stated_that_it_is_up(number: int) -> None:
    """Fixes alone prove the surface then, after the way from where it can have been (R7)."""
    claim = CLAIMS[number]
    shown = show(claim, VEHICLE, 5, 0, drawn_for(claim, number))
    assert not shown.violations, shown
    assert claim.proved.worst_time < shown.needed.time
    assert claim.proved.dark_time == VEHICLE.limits.depth / VEHICLE.ascent_buoyancy + 5.0


@pytest.mark.parametrize("profile", PROFILES)
def test_a_hold_whose_port_clogs_near_its_depth_stays_above_the_depth_stated(profile: str) -> None:
    """By the true depth, over a floor far below; nothing can see the last metre of it."""
    claim = claim_of(VEHICLE, "depth", "a: depth 5 gear 4 heading 0 for 240", 0)
    drawn = draw_withheld(claim, VEHICLE, 7, 0)
    deepest = 0.0
    for begin in (17.0, 21.0):  # more than a metre short of it, and less
        faults = (FaultEvent("depth_stuck", begin, FOREVER),)
        sea = replace(drawn.settings.sea, floor=300.0)
        settings = replace(drawn.settings, sea=sea, faults=faults)
        proof = replace(drawn, profile=profile, settings=settings)
        shown = show(claim, VEHICLE, 7, 0, lambda *_, proof=proof: proof)
        assert not shown.violations, shown
        deepest = max(deepest, shown.needed.depth)
    seen = claim.proved.max_depth + VEHICLE.dive_rate * (FROZEN + LATE + STICKS + TURNED)
    assert seen < deepest < claim.proved.blind_depth


def surfacing() -> tuple[Claim, float]:
    """A leg that waits at the surface for a fix, and how long an ascent takes."""
    claim = next(c for c in CLAIMS if "until fix timeout 3min" in dict(_texts())[c.source])
    return claim, ascent_time(claim.proved.max_depth, VEHICLE)


def _texts() -> list[tuple[str, str]]:
    return [(c.source, body) for c, (_, body) in zip(CLAIMS, missions(), strict=True)]


def test_a_proof_that_takes_the_fix_for_granted_is_seen_to_be_false() -> None:
    claim, ascent = surfacing()
    granted = claim.proved.worst_time - 180.0 + ascent
    false = replace(claim, proved=replace(claim.proved, worst_time=granted, worst_energy=1e3))
    kinds = {v.kind for n in range(4) for v in show(false, VEHICLE, 7, n, draw_withheld).violations}
    assert {TIME, ENERGY} <= kinds


def test_a_proof_in_which_the_way_on_stops_at_once_is_seen_to_be_false() -> None:
    """As built, W does not stick: the way on lasts until X0 and U12."""
    claim = next(
        c for c in CLAIMS if c.mission.name.startswith("current-") and not c.mission.current(1)
    )
    tight = replace(claim.proved, max_range=claim.proved.max_range - 2.0 * 10.0 * 1.2)
    false = replace(claim, proved=tight)
    kinds = {
        v.kind for n in range(20, 40) for v in show(false, VEHICLE, 7, n, draw_withheld).violations
    }
    assert RANGE in kinds


def test_the_command_flies_a_word_again() -> None:
    done = CliRunner().invoke(campaign, ["--word", "3", "--flight", "1", "--workers", "1"])
    assert done.exit_code == 0, done.output
    assert "auvmission campaign --word 3 --seed 0 --flight 1" in done.output
