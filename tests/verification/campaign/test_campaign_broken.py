"""The campaign is tested: with a safety rule broken, the flight that needs it tells, and by name."""

from __future__ import annotations

import functools
import json
import math
from collections import Counter
from dataclasses import replace

import pytest
from click.testing import CliRunner
from known_missions import KNOWN

from links.simulated.settings import FaultEvent, parse_settings
from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, script
from mission.commands.faults import faults
from mission.engine import limits, monitor, thrust, vehicle_state
from mission.engine.core import Core
from mission.engine.limits import LIMITS
from mission.engine.vehicle_state import VehicleState
from mission.model import Health, Step
from mission.model.shipped import load_vehicle
from mission.onboard.runtime import frontseat
from mission.verification.campaign.broken import BROKEN, broken
from mission.verification.campaign.draw import Drawn, Plan, draw, stage
from mission.verification.campaign.faults import fly_plan, result_of, shipped, subjects
from mission.verification.campaign.noticing import Flights, notice
from mission.verification.campaign.scene import say
from mission.verification.campaign.scene_texts import TEXTS, mission_of
from mission.verification.campaign.scenes import SCENES
from mission.verification.campaign.scenes_at_sea import AUTO_CLOSED, AUTO_OPEN
from mission.verification.rig.acts import MODEM, TOPSIDE, Act, Disturbance
from protocol.messages import MissionLine
from protocol.modem import Sender, wrap
from protocol.topside import encode

pytestmark = pytest.mark.proof  # long: make proofs


# The rule that is broken, a scene and its seed, and the law that sees it.
SEEN = [
    ("sinks at rest", "heavy_when_surfaced", 3, "sunk", "sinks in"),
    ("stays down", "neutral_after_x", 0, "sunk", "stopped"),
    ("held up", "heavy_when_surfaced", 0, "sunk", "not held up"),
    ("way W", "unliftable", 0, "sunk", "without @ZAWF$"),
    ("way X0", "unliftable", 0, "sunk", "without letting go"),
    ("way D12", "capsized_and_heavy", 0, "sunk", "without @ZAD12$"),
    ("ways in turn", "dives_until_up", 0, "sunk", "s of an ascent without"),
    ("way U12", "heavy_for_ever", 0, "sunk", "though it could"),
    ("latch", "restarted_after_x", 0, "unlawful", "restarted out of"),
    ("restart", "restarted", 0, "unsent", "of a restart"),
    ("rest with AUTO closed", "heavy_with_auto_closed", 0, "unlawful", "AUTO is closed"),
    ("AUTO ends", "auto_closed", 0, "unlawful", "AUTO is closed"),
    ("stuck receiver", "stuck_receiver", 0, "unlawful", "surfaced, said"),
    ("fixes below", "clogged_at_the_surface", 0, "unanswered", "clogged port"),
    ("relays between", "busy_slider", 3, "overrun", "limit 10 m"),
    ("lift again", "busy_slider", 6, "sunk", "though it could"),
    ("belief", "clogged", 0, "unanswered", "clogged port"),
    ("orderly end", "ended", 0, "unlawful", "told to end"),
    ("cleared below", "cleared_below", 0, "unlawful", "cleared"),
    ("started below", "started_below", 0, "unlawful", "begins"),
    ("held stick", "held_stick", 0, "unlawful", "a stick heard"),
    ("waited words", "held_stick", 2, "unlawful", "words that have waited"),
    ("neutral stick", "neutral_stick", 0, "unlawful", "takes over"),
    ("silent stick", "stick_left", 0, "unlawful", "without M"),
    ("commander", "other_commander", 0, "unlawful", "commands"),
    ("stop again", "deaf_to_x", 0, "unsent", "no X0"),
    ("stop doubted", "turns_after_a_stop", 0, "unsent", "a thruster is on"),
    ("line doubted", "pulled", 11, "unsent", "the line is back"),
    ("refused set", "refused", 0, "unlawful", "answered N"),
    ("blind leg", "blind_compass", 0, "unlawful", "and still in"),
    ("above the bottom", "blind_above_the_bottom", 0, "unlawful", "would be clear"),
    ("areas", "onto_the_shoal", 0, "unanswered", "an area: still autonomous/go"),
    ("healthy attitude", "full_scale_roll", 0, "unanswered", "was not passed"),
    ("gap", "auto_closed", 0, "unlawful", "too soon"),
    ("clock of a leg", "turns_after_a_stop", 0, "", ""),
    ("limit depth", "shallow_depth", 0, "unanswered", "depth passed"),
    ("limit roll-over", "capsized", 2, "unanswered", "roll passed"),
    ("slow descent", "sinks_adrift", 2, "unanswered", "nothing asks for"),
    ("limit unexplained descent", "sinks_adrift", 0, "unanswered", "nothing asks for"),
    ("limit depth unknown", "blind", 1, "unanswered", "without a depth"),
    ("limit topside", "silent_topside", 0, "unanswered", "from topside"),
    ("limit no answer", "no_answers", 0, "unanswered", "without an answer"),
    ("limit voltage", "low_battery", 4, "unanswered", "V, and still"),
    ("limit heading does not follow", "wrong_compass", 0, "unanswered", "off and growing"),
    ("limit course against heading", "loose_compass", 0, "unanswered", "course and heading"),
    ("limit brown-out", "brown_out", 0, "unanswered", "no thruster turns"),
    ("limit uncertain", "swept_away", 0, "unanswered", "sigma"),
    ("pushed in the dark", "capsized_blind", 0, "lost", "deep at the end"),
    ("sank unseen", "sinks_unseen", 0, "lost", "in idle"),
    ("moving depth", "heavy_beside", 0, "lost", "deep at the end"),
    ("depth that moves", "heavy_and_clogged", 0, "lost", "deep at the end"),
    ("fixes too early", "blind_and_wandering", 0, "unlawful", "surfaced, said"),
    ("blind thrust", "heavy_and_late", 1, "lost", "deep at the end"),
    ("blind thrust", "held_up", 2, "lost", "deep at the end"),
    ("fixes against movement", "heavy_and_wandering", 0, "lost", "deep at the end"),
]


def judged(plan: Plan) -> set[tuple[str, str]]:
    vehicle = plan.vehicle
    result = result_of(plan, fly_plan(plan, vehicle), vehicle, plan.profile)
    return {(violation.kind, violation.says) for violation in result.violations}


@functools.cache
def whole(scene: str, seed: int) -> set[tuple[str, str]]:
    return judged(stage(scene, seed))


@pytest.mark.parametrize(("rule", "scene", "seed", "kind", "says"), SEEN)
def test_a_scene_tells_a_rule_from_its_absence_by_its_law(
    rule: str, scene: str, seed: int, kind: str, says: str
) -> None:
    assert whole(scene, seed) == set()
    with broken(rule):
        found = judged(stage(scene, seed))
    assert any(k == kind and says in words for k, words in found) == bool(kind), found


@pytest.mark.replaces
def test_a_depth_at_full_scale_as_the_program_begins_is_noticed_where_it_is_believed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It made the ascent behind it last for hours, and no law asked for its end."""
    ask = VehicleState._ask  # noqa: SLF001

    def believing(self: VehicleState, sensor: str) -> Health:
        health = ask(self, sensor)
        return Health(True, "", health.age) if health.reason == "absurd" else health

    assert whole("restarted_at_full_scale", 1) == set()
    monkeypatch.setattr(VehicleState, "_ask", believing)
    found = judged(stage("restarted_at_full_scale", 1))
    assert any(kind == "unlawful" and "by its fixes" in says for kind, says in found), found


def test_a_depth_that_freezes_in_a_dive_lets_no_made_up_fix_end_the_ascent_below() -> None:
    """As in flight 595 of seed 81; here it is the mission's own ascent, behind the leg's else."""
    plan = stage("blind_and_wandering", 0)
    faults = (FaultEvent("gps_wanders", 5.1, 1e6), FaultEvent("depth_frozen", 17.7, 154.5))
    frozen = replace(plan, settings=replace(plan.settings, faults=faults), incidents=())
    assert judged(frozen) == set()
    with broken("fixes too early"):
        found = judged(frozen)
    assert any(kind == "unlawful" and "surfaced, said" in says for kind, says in found)


def test_what_is_held_up_is_let_go_and_sinks_while_auto_is_closed_and_its_thrust_is_noticed() -> (
    None
):
    """Closed in its ascent, or where it is held up; opened, it is brought up and held up again."""
    plan = stage("heavy_when_surfaced", 0)
    (drawn,) = plan.incidents

    def closing(t: float) -> Plan:
        said = (*drawn.disturbances, say(t, AUTO_CLOSED), say(130.0, AUTO_OPEN))
        return replace(plan, incidents=(replace(drawn, disturbances=said),))

    assert judged(closing(105.0)) == judged(closing(116.0)) == set()
    with broken("AUTO ends"):
        found = judged(closing(116.0))
    assert found == {("unlawful", "node AUTO is closed, and in emergency/surfaced b'@ZAU12$'")}


def in_the_lagoon(*faults: FaultEvent) -> Plan:
    plan = stage("heavy_for_ever", 3)
    return replace(plan, settings=replace(plan.settings, faults=faults), incidents=())


def test_what_is_heavy_is_home_while_its_ascent_brings_it_up_in_turns_and_lost_without() -> None:
    """As flight 1959 of seed 505: nothing can prove the surface, and W is one of the ways."""
    plan = in_the_lagoon(
        FaultEvent("heavy", 48.4, 1e6, 38.4),
        FaultEvent("deaf_to_w", 48.4, 1e6),
        FaultEvent("depth_too_deep", 48.4, 1e6, 6.5),
        FaultEvent("gps_stuck", 32.3, 1e6),
    )
    assert judged(plan) == set()
    with broken("way U12"):
        found = judged(plan)
    assert any(kind == "lost" and "deep at the end" in says for kind, says in found)


def test_made_up_fixes_may_end_the_ascent_of_what_no_word_lifts_and_of_nothing_else() -> None:
    """As flight 326 of seed 505: pushes that move nothing contradict a depth that is true."""
    wandering = FaultEvent("gps_wanders", 6.0, 1e6), FaultEvent("deaf_to_w", 56.4, 1e6)
    weak = FaultEvent("verticals_weak", 35.9, 1e6, 0.574)
    assert judged(in_the_lagoon(*wandering, weak, FaultEvent("heavy", 56.4, 1e6, 44.7))) == set()
    with broken("fixes too early"), broken("fixes against movement"):
        found = judged(in_the_lagoon(*wandering, FaultEvent("depth_frozen", 56.4, 154.5)))
    assert any(kind == "unlawful" and "surfaced, said" in says for kind, says in found)


def test_a_limit_that_was_tightened_by_modem_acts_and_is_asked_for() -> None:
    """As flight 1992 of seed 707: the answer leaves within an envelope."""
    plan = stage("shallow_depth", 0)
    words = (replace(d, data=wrap(d.data, Sender.TOPSIDE), link=MODEM) for d in plan.disturbances)
    by_modem = replace(plan, incidents=(replace(plan.incidents[0], disturbances=tuple(words)),))
    assert judged(by_modem) == set()
    with broken("limit depth"):
        found = judged(by_modem)
    assert any(kind == "unanswered" and "depth passed" in says for kind, says in found)


def test_what_dives_until_it_hears_u12_is_left_alone_while_auto_is_closed_and_then_alone() -> None:
    """As flight 6592 of seed 707: nothing turns by itself, and the board obeys nothing else."""
    plan = stage("started_with_auto_closed", 0)
    diving = FaultEvent("dives_until_up", 68.8, 1e6)
    closed = replace(plan, settings=replace(plan.settings, faults=(diving,)))
    assert judged(closed) == set()
    with broken("way U12"):
        found = judged(replace(closed, incidents=()))
    assert any(kind == "lost" and "deep at the end" in says for kind, says in found)


def heavy_under_made_up_fixes(weight: float, *more: FaultEvent) -> Plan:
    """``heavy_and_wandering`` with these faults; ``weight`` is in N."""
    plan = stage("heavy_and_wandering", 0)
    begin = plan.settings.faults[0].begin
    faults = [FaultEvent("heavy", begin, 1e6, weight), FaultEvent("deaf_to_w", begin, 1e6)]
    faults += [FaultEvent("gps_wanders", 7.9, 1e6), *more]
    settings = replace(plan.settings, faults=tuple(faults))
    return replace(plan, profile="documented", settings=settings)


def test_fixes_that_contradict_a_moving_depth_would_keep_what_is_heavy_down() -> None:
    """Where full thrust is not tried for longer, either: that alone brings it up, too."""
    plan = heavy_under_made_up_fixes(49.0)
    assert judged(plan) == set()
    with broken("blind thrust"):
        assert judged(plan) == set()
        with broken("fixes against movement"):
            assert any(kind == "lost" and "at the end" in says for kind, says in judged(plan))


def test_a_heavy_vehicle_whose_late_depth_made_up_fixes_contradict_is_lifted() -> None:
    """As flight 1205 of seed 1212: no turn of full thrust was ever seen to lift it."""
    plan = heavy_under_made_up_fixes(41.3, FaultEvent("depth_late", 43.9, 1e6, 9.0))
    assert judged(plan) == set()
    with broken("blind thrust"):
        assert any(kind == "lost" for kind, _ in judged(plan))


def test_another_mission_that_was_sent_whole_is_judged_by_its_own_limits() -> None:
    """As flight 3629 of seed 1212: it dived to 12 m, where the first one allows 5 m."""
    plan = stage("shallow_depth", 0)
    other = script(mission_of("deep"))
    lines = [encode(MissionLine(len(other), i, line)) for i, line in enumerate(other, 1)]
    sent = tuple(Disturbance(3.0 + 0.05 * i, Act.SAY, line) for i, line in enumerate(lines))
    plan = replace(plan, incidents=(Drawn("second", 0.0, sent),))
    assert judged(plan) == set()


def test_an_altimeter_whose_power_an_operator_has_switched_is_not_asked_to_stay_silent() -> None:
    """As flight 6498 of seed 1313: it speaks again, and the leg goes by it."""
    plan = stage("blind_above_the_bottom", 0)
    gone = FaultEvent("altitude_silent", 36.6, 1e6)
    plan = replace(plan, settings=replace(plan.settings, faults=(gone,)), incidents=())
    on = Disturbance(64.4, Act.SAY, b"@RSOOOOOOC$")
    assert judged(replace(plan, incidents=(Drawn("power", 0.0, (on,)),))) == set()
    with broken("above the bottom"):
        assert any("would be clear" in says for _, says in judged(plan))


def test_the_stop_of_an_ascent_is_said_until_it_is_answered_and_is_no_three_commands() -> None:
    """As flight 3618 of seed 5616: at the surface for a fix, its board answers nothing."""
    plan = stage("shallow_depth", 0)
    gone = FaultEvent("gps_silent", 100.0, 1e6)
    waits = replace(plan, profile="as-built", incidents=())
    for begin, says in ((330.0, ()), (282.0, ("no answer",))):  # at the surface; as a leg begins
        mute = FaultEvent("ack_lost", begin, 60.0)
        flown = replace(waits, settings=replace(plan.settings, faults=(gone, mute)))
        assert judged(flown) == set()
        with broken("limit no answer"):
            found = {law for _, law in judged(flown)}
        assert len(found) == len(says), found


def test_a_program_that_stands_still_as_the_line_comes_back_says_nothing_yet() -> None:
    """As flight 13441 of seed 5616: it stood still from 1.4 s before until 2.54 s behind it."""
    plan, t = stage("pulled", 11), 60.0
    cut = (Disturbance(t, Act.UNPLUG), Disturbance(t + 8.5, Act.PLUG))
    still = (Disturbance(t + 7.1, Act.STALL), Disturbance(t + 11.1, Act.RUN))
    acts = tuple(sorted((*cut, *still), key=lambda act: act.after))
    assert judged(replace(plan, incidents=(Drawn("pulled", 0.0, acts),))) == set()
    with broken("line doubted"):
        found = judged(replace(plan, incidents=(Drawn("pulled", 0.0, cut),)))
    assert any("the line is back" in says for _, says in found), found


def test_what_sinks_behind_verticals_that_contradicted_its_depth_is_left() -> None:
    """As flight 7305 of seed 5717: cleared; its depth was garbage while it sank to the ground."""
    plan = stage("sinks_unseen", 0)
    acts = (Act.SAY, b"@ZAWF$", 36.0), (Act.SAY, b"@AC$", 170.1)
    words = Drawn("sinks_unseen", 0.0, tuple(Disturbance(t, act, data) for act, data, t in acts))
    dead = FaultEvent("verticals_dead", 8.5, 43.3)
    rest = (FaultEvent("depth_full_scale", 174.1, 181.4), FaultEvent("heavy", 178.1, 1e6, 30.8))
    plan = replace(plan, profile="as-built", incidents=(words,))
    assert judged(replace(plan, settings=replace(plan.settings, faults=(dead, *rest)))) == set()
    with broken("sank unseen"):
        found = judged(replace(plan, settings=replace(plan.settings, faults=rest)))
    assert any(kind == "lost" for kind, _ in found), found


@pytest.mark.parametrize("fault", ["intermittent", "frozen", "stuck", "dead"])
def test_what_is_heavy_comes_up_by_its_thrust_whatever_stands_in_for_its_depth(fault):
    plan = replace(stage("heavy_for_ever", 0), profile="as-built")
    said = Drawn("x", 0.0, (Disturbance(62.0, Act.SAY, b"@ZAWF$"),))
    faults = FaultEvent("heavy", 60.0, 1e6, 30.0), FaultEvent(f"depth_{fault}", 50.0, 1e6)
    plan = replace(plan, incidents=(said,), settings=replace(plan.settings, faults=faults))
    assert judged(plan) == set()
    with broken("way U12"):
        found = judged(plan)
    assert any(kind == "lost" and "deep at the end" in says for kind, says in found), found


def test_a_depth_that_stays_silent_behind_another_fault_of_it_is_gone() -> None:
    """As flight 9794 of seed 5717: nothing starts with a depth that stays away."""
    bottom = next(s for s in subjects(shipped()) if s.path.stem == "bottom-following")
    plan = replace(stage("blind_altimeter", 0), incidents=(), subject=bottom, profile="documented")
    silent = FaultEvent("depth_silent", 3.4, 1e6)
    both = (FaultEvent("depth_full_scale", 3.0, 19.5), silent)
    plan = replace(plan, settings=replace(plan.settings, faults=both))
    assert "the depth is not to be believed" in fly_plan(plan, plan.vehicle).failure
    assert judged(plan) == set()


@pytest.mark.parametrize(
    "faults",
    [
        ("battery_low=8@60+300", "battery_frozen@40+20"),
        ("battery_low=8@60+300", "battery_silent@110+10"),
        ("battery_low=8@60+300", "battery_flickers=12.5@80+20"),
        ("battery_flickers=8.4@60+300",),
    ],
)
def test_another_fault_of_a_battery_excuses_its_limit_for_no_longer_than_it_lasts(faults):
    settings = parse_settings([f"fault={fault}" for fault in faults])
    plan = stage("low_battery", 4)
    plan = replace(plan, settings=replace(plan.settings, faults=settings.faults))
    assert judged(plan) == set()
    with broken("limit voltage"):
        found = judged(plan)
    assert any("V, and still autonomous" in says for _, says in found), found


def test_a_place_that_a_receiver_makes_up_is_told_as_soon_as_reports_are_stale() -> None:
    """As flight 10229 of seed 5717: the last report was received 5.995 s before."""
    plan = stage("heavy_and_wandering", 0)
    said = Drawn("x", 0.0, (Disturbance(47.58477852054665, Act.SAY, b"@ZAX0$"),))
    faults = (FaultEvent("gps_wanders", 6.0, 1e6), FaultEvent("stm32_silent", 43.3, 26.4))
    plan = replace(plan, profile="as-built", incidents=(said,))
    assert judged(replace(plan, settings=replace(plan.settings, faults=faults))) == set()


def test_a_depth_counts_as_the_surfaces_until_its_report_is_stale_though_the_cable_is_pulled() -> (
    None
):
    """As flight 14152 of seed 5717: X 4.8 s behind the last report, of its begin at the surface."""
    survey = next(s for s in subjects(shipped()) if s.path.stem == "harbour-survey")
    plan = replace(stage("blind_altimeter", 0), subject=survey, profile="as-built")
    acts = (Act.UNPLUG, b"", 7.7), (Act.SAY, b"@ZAX0$", 11.9), (Act.PLUG, b"", 34.7)
    cut = Drawn("x", 0.0, tuple(Disturbance(t, act, data) for act, data, t in acts))
    plan = replace(plan, settings=replace(plan.settings, faults=()), incidents=(cut,))
    assert judged(plan) == set()


def test_a_board_that_is_deaf_to_u12_is_held_up_by_w() -> None:
    """As flight 10267 of seed 5717: held up by what it did not hear it sank again and again."""
    faults = FaultEvent("heavy", 96.6, 1e6, 42.9), FaultEvent("deaf_to_u", 13.7, 1e6)
    plan = replace(stage("sinks_in_a_hold", 0), profile="documented")
    assert judged(replace(plan, settings=replace(plan.settings, faults=faults))) == set()


def test_without_a_depth_full_thrust_has_its_four_turns_behind_two_brown_outs_of_a_hold() -> None:
    """The word that was tried last had them, and as built W turns nothing for long: on the bottom,
    and no law said so, since no depth told."""
    plan = replace(stage("heavy_when_surfaced", 0), profile="as-built")
    heavy, blind = FaultEvent("heavy", 90.0, 1e6, 27.0), FaultEvent("depth_silent", 130.0, 1e6)
    brown_outs = FaultEvent("stm32_restart", 150.0, 3.0), FaultEvent("stm32_restart", 154.5, 2.0)
    plan = replace(plan, settings=replace(plan.settings, faults=(heavy, blind, *brown_outs)))
    assert judged(plan) == set()
    with broken("blind thrust"):
        found = judged(plan)
    assert any(kind == "lost" and "deep at the end" in says for kind, says in found)


def test_what_sinks_behind_a_restart_that_knew_no_depth_is_left_and_otherwise_brought_up() -> None:
    """As flight 5865 of seed 707: it may be on deck, and a depth of 30 m an error."""
    plan = stage("sinks_unseen", 0)
    acts = (Act.SAY, b"@ZAWF$", 36.0), (Act.END, b"", 58.6), (Act.SAY, b"@AC$", 84.6)
    words = Drawn("sinks_unseen", 0.0, tuple(Disturbance(t, act, data) for act, data, t in acts))
    heavy, garbage = FaultEvent("heavy", 92.6, 1e6, 29.0), FaultEvent("depth_full_scale", 88.6, 183)
    plan = replace(plan, profile="as-built", incidents=(words,))
    assert judged(replace(plan, settings=replace(plan.settings, faults=(heavy, garbage)))) == set()
    later = replace(garbage, begin=91.6)
    seen = replace(plan, settings=replace(plan.settings, faults=(heavy, later)))
    assert judged(seen) == set()
    with broken("sank unseen"):
        found = judged(seen)
    assert any(kind == "lost" and "in idle" in says for kind, says in found)


def test_what_capsizes_unknown_to_all_may_be_pushed_down_and_what_is_told_may_not() -> None:
    """As flight 9625 of seed 707: U12 and W take their turns where nothing is reported."""
    over = FaultEvent("capsized", 64.5, 1e6)
    assert judged(in_the_lagoon(FaultEvent("stm32_silent", 29.2, 1e6), over)) == set()
    with broken("upside down"):
        found = judged(stage("capsized_and_heavy", 0))
    assert any(kind == "sunk" and "led deeper" in says for kind, says in found), found


def test_a_depth_that_drifts_into_the_air_ends_no_ascent(monkeypatch: pytest.MonkeyPatch) -> None:
    """As flight 13619 of seed 707: told to end, it would be gone at 5 m."""
    drifts = FaultEvent("depth_drifting", 17.9, 1e6, -0.122)
    plan = replace(stage("ended", 0), profile="as-built")
    acts = (Act.SAY, b"@ZAWF$", 50.1), (Act.END, b"", 52.1)
    words = Drawn("ended", 0.0, tuple(Disturbance(t, act, data) for act, data, t in acts))
    settings = replace(plan.settings, faults=(drifts,))
    plan = replace(plan, settings=settings, incidents=(words,))
    assert judged(plan) == set()
    monkeypatch.setattr(vehicle_state, "_STILL_RISES", math.inf)
    monkeypatch.setattr(thrust, "_DIVES", math.inf)
    assert judged(plan) == set()
    monkeypatch.setattr(vehicle_state, "IN_AIR", -math.inf)
    assert any("told to end" in says for _, says in judged(plan))


def test_of_a_program_that_is_dead_when_it_is_told_to_end_no_word_is_asked() -> None:
    """As flight 13077 of seed 5414: killed and told to end in one instant; it begins 3.5 s later."""
    plan = stage("ended", 0)
    acts = (Act.KILL, 50.1), (Act.END, 50.1), (Act.BOOT, 53.6)
    dead = Drawn("ended", 0.0, tuple(Disturbance(t, act) for act, t in acts))
    assert judged(replace(plan, incidents=(dead,))) == set()
    told = Drawn("ended", 0.0, (Disturbance(50.1, Act.END),))
    with broken("orderly end"):
        found = judged(replace(plan, incidents=(told,)))
    assert any("told to end" in says for _, says in found)


def test_who_is_dead_cannot_be_told_to_end_at_once() -> None:
    """As flight 1204 of seed 10015: killed, told to end, told to hurry; and begun anew."""
    plan = stage("ended", 0)
    acts = (Act.KILL, 50.1), (Act.END, 50.3), (Act.HURRY, 51.1), (Act.BOOT, 57.6), (Act.JOIN, 61.6)
    dead = Drawn("ended", 0.0, tuple(Disturbance(t, act) for act, t in acts))
    assert judged(replace(plan, incidents=(dead,))) == set()


def test_what_is_told_to_end_as_the_stick_takes_over_is_brought_up_behind_the_stick() -> None:
    """Both in one instant: no upward word is due while it is held."""
    end, moves = Disturbance(50.1, Act.END), [50.1 + 0.2 * i for i in range(15)]
    stick = tuple(Disturbance(t, Act.SAY, b"@MMF4$") for t in moves)
    plan = replace(stage("ended", 0), incidents=(Drawn("ended", 0.0, (*stick, end)),))
    assert judged(plan) == set()
    plan = replace(plan, incidents=(Drawn("ended", 0.0, (end,)),))
    with broken("orderly end"):
        assert any("told to end" in says for _, says in judged(plan))


@pytest.mark.replaces
def test_a_depth_limit_may_end_what_a_swell_and_the_air_alone_say_is_deeper(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = stage("auto_closed", 0)  # holds 6 m
    sea = replace(plan.settings.sea, waves=(1.0, 14.0))
    errors = replace(plan.settings.errors, depth_bias=0.4)
    plan = replace(plan, settings=replace(plan.settings, sea=sea, errors=errors))

    def tightened(t: float) -> Plan:
        return replace(plan, incidents=(Drawn("", 0.0, (say(t, b"@SP,,30,5.25,10,$"),)),))

    trial = fly_plan(tightened(60.0), plan.vehicle)
    assert any(isinstance(e, Step) and e.trigger == "limit" for e in trial.events)
    assert judged(tightened(60.0)) == set()
    monkeypatch.setattr(limits, "DEPTH_MARGIN", -5.0)
    assert any("depth that was not passed" in says for _, says in judged(tightened(14.0)))


def test_a_stick_whose_first_m_kills_the_program_was_moved_in_that_instant() -> None:
    """As flight 6502 of seed 5515: moved before and let go; the next time its step is the last
    thing that is written, and its relay never leaves."""
    plan = stage("ended", 0)

    def says(t: float, data: bytes) -> Disturbance:
        return Disturbance(t, Act.SAY, data, "topside", "boat")

    before = says(40.1, b"@MRB2$"), says(45.1, b"@AA$")
    again = Disturbance(60.1, Act.DIE_AFTER), says(65.1, b"@MRF5$"), Disturbance(68.1, Act.BOOT)
    moved = Drawn("ended", 0.0, (*before, *again))
    assert judged(replace(plan, incidents=(moved,))) == set()
    with broken("silent stick"):
        found = judged(replace(plan, incidents=(Drawn("ended", 0.0, before[:1]),)))
    assert any("without M" in said for _, said in found)


def test_a_limit_that_is_tightened_behind_a_clogged_port_is_not_asked_for() -> None:
    """As flight 14186 of seed 707: at 8 m an operator allows 5 m, by a port that says 5 m."""
    plan = stage("clogged", 0)
    said = Disturbance(plan.settings.faults[0].begin + 12.0, Act.SAY, b"@SP,,,5,,$")
    tightened = replace(plan, incidents=(replace(plan.incidents[0], disturbances=(said,)),))
    assert judged(tightened) == set()
    with broken("belief"):
        found = judged(tightened)
    assert any(kind == "unanswered" and "clogged port" in says for kind, says in found)


def test_a_compass_that_has_turned_back_has_its_seconds_anew() -> None:
    """As flight 16946 of seed 707: stuck for a while, told the truth, and then mirrored."""
    plan = stage("wrong_compass", 0)
    yoyo = next(subject for subject in KNOWN if subject.path.stem == "yoyo-profile")
    stuck = FaultEvent("heading_stuck", 535.3, 22.8, 0.822)
    mirrored = FaultEvent("heading_mirrored", 561.9, 1e6)
    settings = replace(plan.settings, faults=(stuck, mirrored))
    plan = replace(plan, subject=yoyo, settings=settings, incidents=())
    assert judged(plan) == set()
    with broken("limit heading does not follow"):
        found = judged(plan)
    assert any(kind == "unanswered" and "off and growing" in says for kind, says in found)


def test_a_second_clear_beside_thrusters_that_push_in_vain_may_come_deep() -> None:
    """As flight 11757 of seed 909: a true depth is contradicted, and an unknown one forbids none."""
    plan = stage("cleared_below", 0)
    dead = replace(
        plan, settings=replace(plan.settings, faults=(FaultEvent("verticals_dead", 30.2, 1e6),))
    )
    assert judged(dead) == set()
    with broken("cleared below"):
        found = judged(plan)
    assert any(kind == "unlawful" and "cleared" in says for kind, says in found)


def test_a_board_with_two_ways_of_diving_costs_a_round_more() -> None:
    """As flight 15535 of seed 909: the second begins while U12 ends the first."""
    plan = stage("dives_until_stop", 0)
    first = plan.settings.faults[0].begin
    both = (*plan.settings.faults, FaultEvent("dives_until_up", first + 14.9, 1e6))
    assert judged(replace(plan, settings=replace(plan.settings, faults=both))) == set()


def test_a_place_that_a_program_has_not_heard_yet_may_end_an_ascent_within_the_last_metre() -> None:
    """As flight 17504 of seed 707: four places in turn, behind a restart."""
    plan = stage("restarted", 0)
    acts = (Act.KILL, 7.6), (Act.BOOT, 10.96), (Act.JOIN, 11.7)
    words = Drawn("restarted", 0.0, tuple(Disturbance(t, act) for act, t in acts))
    in_turn = FaultEvent("gps_in_turn", 14.5, 40.5, 4.0)
    plan = replace(plan, settings=replace(plan.settings, faults=(in_turn,)), incidents=(words,))
    assert judged(plan) == set()


def test_what_lies_on_the_ground_above_the_depth_that_is_asked_for_makes_no_progress() -> None:
    plan = stage("weak_thrusters", 0)
    shoal = replace(plan.settings, faults=(), sea=replace(plan.settings.sea, floor=11.0))
    plan = replace(plan, settings=shoal)
    assert judged(plan) == set()
    with broken("limit no progress"):
        found = judged(plan)
    assert any(kind == "unanswered" and "no nearer" in says for kind, says in found), found


def test_an_answer_to_a_copy_of_what_came_by_modem_hands_nothing_over() -> None:
    """As flight 8912 of seed 3101: @AA by modem, then by two boats, of which neither commands."""
    plan = stage("modem_stick", 0)
    acts = [Disturbance(130.0, Act.SAY, wrap(b"@AA$", Sender.TOPSIDE), MODEM)]
    for t, boat in ((136.0, "one"), (138.0, "two")):
        acts += [
            Disturbance(t, Act.JOIN, b"", TOPSIDE, boat),
            Disturbance(t + 0.5, Act.SAY, b"@AA$", TOPSIDE, boat),
        ]
    assert judged(replace(plan, incidents=(Drawn("modem_stick", 0.0, tuple(acts)),))) == set()


def test_an_m_hands_the_command_over_by_the_stick_that_it_moves() -> None:
    """As flight 19472 of seed 4404: it is not acknowledged, and what follows is answered."""
    plan = stage("modem_stick", 0)
    acts = [Disturbance(110.0, Act.JOIN, b"", TOPSIDE, boat) for boat in ("one", "two")]
    acts += [
        Disturbance(112.0, Act.SAY, b"@NSOOOOOO$", TOPSIDE, "one"),
        Disturbance(130.0, Act.SAY, b"@MMF5$", TOPSIDE, "two"),
        Disturbance(139.0, Act.SAY, b"@SP,,18,17,11,$", TOPSIDE, "one"),
        Disturbance(139.5, Act.SAY, b"@MMF5$", TOPSIDE, "two"),
        Disturbance(145.0, Act.SAY, b"@NSOOOOOO$", TOPSIDE, "two"),
    ]
    assert judged(replace(plan, incidents=(Drawn("modem_stick", 0.0, tuple(acts)),))) == set()


def test_what_a_commander_asked_for_is_answered_behind_the_w_of_another_boat() -> None:
    """As flight 13430 of seed 4202: @RI, and 50 ms later the command is the other's."""
    plan = stage("modem_stick", 0)
    acts = [Disturbance(130.0, Act.JOIN, b"", TOPSIDE, boat) for boat in ("one", "two")]
    acts += [Disturbance(135.0 + 0.02 * i, Act.SAY, b"@RI$", TOPSIDE, "one") for i in range(340)]
    acts.append(Disturbance(141.75, Act.SAY, b"@ZAWF$", TOPSIDE, "two"))
    assert judged(replace(plan, incidents=(Drawn("modem_stick", 0.0, tuple(acts)),))) == set()


def test_a_port_that_clogs_at_the_surface_lets_an_orderly_end_go_what_is_heavy() -> None:
    """As flight 9356 of seed 3101."""
    plan = stage("ended", 0)
    end = Drawn("ended", 0.0, (Disturbance(26.1, Act.END),))
    faults = (
        FaultEvent("heavy", 42.7, 1e6, 50.8),
        FaultEvent("deaf_to_w", 42.7, 1e6),
        FaultEvent("depth_stuck", 42.7, 59.8),
    )
    settings = replace(plan.settings, faults=faults)
    assert judged(replace(plan, settings=settings, incidents=(end,))) == set()


def test_an_ascent_that_lay_upside_down_has_a_round_behind_that() -> None:
    """As flight 13457 of seed 3101: U12 had led deeper, and W was the next way when it lay right."""
    plan = replace(stage("heavy_when_waiting", 0), profile="documented")
    begin = plan.incidents[0].disturbances[0].after  # of the stick
    faults = (
        FaultEvent("heavy", begin + 1.5, 1e6, 33.3),
        FaultEvent("capsized", begin + 5.3, 62.7),
    )
    assert judged(replace(plan, settings=replace(plan.settings, faults=faults))) == set()


def said(t: float, word: bytes) -> Disturbance:
    return Disturbance(t, Act.SAY, word, TOPSIDE, "boat")


def test_of_w_that_is_said_each_second_one_leaves_in_the_turn_of_another_way() -> None:
    """As flight 811 of seed 4101."""
    plan = stage("heavy_for_ever", 1)
    heavy = FaultEvent("heavy", 41.0, 1e6, 45.0)
    words = tuple(said(45.0 + 0.97 * i, b"@ZAWF$") for i in range(30))
    plan = replace(plan, profile="as-built", settings=replace(plan.settings, faults=(heavy,)))
    assert judged(replace(plan, incidents=(Drawn("w again", 0.0, words),))) == set()


def test_an_altitude_that_stands_while_the_vehicle_rests_is_known_only_later() -> None:
    """As flight 2402 of seed 4101: the leg above the bottom goes on behind the stick."""
    plan = stage("blind_above_the_bottom", 0)
    stick = [said(76.4 + 0.2 * i, b"@MMF0$") for i in range(76)]
    frozen = (FaultEvent("altitude_frozen", 88.9, 1e6),)
    on = Drawn("stick", 0.0, (*stick, said(120.8, b"@AA$")))
    settings = replace(plan.settings, faults=frozen)
    assert judged(replace(plan, settings=settings, incidents=(on,))) == set()


@pytest.mark.parametrize(
    "attitude",
    [
        FaultEvent("roll_stuck", 17.8, 1e6, 0.31),  # nothing tells: the law knows
        FaultEvent("attitude_off", 71.6, 1e6, 79.511),  # it says what is no angle now and then
    ],
    ids=lambda fault: fault.name,
)
def test_upside_down_without_a_depth_beside_an_attitude_that_lies(attitude: FaultEvent) -> None:
    """As flights 17249 and 18855 of seed 4101."""
    plan = stage("capsized_blind", 0)
    faults = (
        FaultEvent("capsized", 42.8, 1e6),
        FaultEvent("depth_full_scale", 46.3, 1e6),
        attitude,
    )
    assert judged(replace(plan, settings=replace(plan.settings, faults=faults))) == set()


def test_a_push_that_led_deeper_upside_down_is_seen_when_it_comes_again() -> None:
    """Where D12 does not bring it up before."""
    with broken("way D12"), broken("pushed down again"):
        found = judged(stage("capsized_and_heavy", 0))
    assert any(kind == "sunk" and "upside down again" in says for kind, says in found)


def test_a_rule_that_was_broken_is_whole_again_afterwards() -> None:
    before = (frontseat.GAP_S, monitor.LIMITS, Core.surface)
    for name in BROKEN:
        with broken(name):
            pass
    assert (frontseat.GAP_S, monitor.LIMITS, Core.surface) == before


def test_every_limit_is_a_rule_to_be_broken_and_what_no_flight_can_tell_has_its_reason() -> None:
    assert {f"limit {row.name}" for row in LIMITS.values()} <= set(BROKEN)
    assert len(BROKEN) - sum(bool(row.reason) for row in BROKEN.values()) >= 40


def test_what_is_not_there_cannot_be_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(Core, "doubt_line")
    with pytest.raises(KeyError, match="doubt_line"), broken("line doubted"):
        pass


def test_the_missions_of_scenes_pass_the_check() -> None:
    vehicle = load_vehicle("auv")
    for text in TEXTS:
        mission = mission_of(text)
        assert check_mission(compile_mission(mission, vehicle, digest(mission)), vehicle).ok


def test_most_flights_of_the_auv_report_unevenly_and_say_so() -> None:
    plans = [draw(1, number, KNOWN) for number in range(200)]
    uneven = Counter(plan.settings.uneven for plan in plans)
    assert set(uneven) == {0.0, 0.2, 0.4, 0.6}
    assert min(uneven.values()) > 20
    for plan in plans:
        assert (f"uneven={plan.settings.uneven:g}" in plan.in_words()) == bool(plan.settings.uneven)


def test_half_of_the_flights_of_the_auv_are_in_waves_and_say_so() -> None:
    plans = [draw(1, number, KNOWN) for number in range(200)]
    heights = [plan.settings.sea.waves[0] for plan in plans]
    assert 70 < sum(height > 0.0 for height in heights) < 130
    assert 0.6 < max(heights) <= 0.75
    for plan, height in zip(plans, heights, strict=True):
        assert (f"waves={height:g}@" in plan.in_words()) == (height > 0.0)


def test_all_scenes_are_drawn_some_with_something_else_beside() -> None:
    plans = [draw(1, number, KNOWN) for number in range(800)]
    assert {plan.scene for plan in plans} == {"", *SCENES}
    alone = [p for p in plans if p.kinds == ("auto_closed", "scene auto_closed")]
    beside = [p for p in plans if p.scene == "auto_closed"]
    assert 0 <= len(alone) < len(beside)
    assert stage("heavy_for_ever", 3) == stage("heavy_for_ever", 3)


def test_three_hundred_flights_of_any_seed_have_nearly_every_scene_in_them() -> None:
    for seed in (1, 12, 71):
        seen = Counter(draw(seed, number, KNOWN).scene for number in range(300))
        assert len(set(SCENES) - set(seen)) <= 2
        assert max(seen[scene] for scene in SCENES) <= 6


def test_what_notices_is_a_flight_that_the_whole_program_flies_well() -> None:
    noticed = notice("unasked", Flights(0, KNOWN), 3)
    assert noticed.flights == 1
    assert noticed.by.startswith("spurious")
    assert notice("limit leak", Flights(0, KNOWN), 1).flights is None


def test_the_command_tells_the_rule_the_flights_and_the_law() -> None:
    done = CliRunner().invoke(faults, ["--broken", "unasked", "--flights", "2", "--workers", "1"])
    assert done.exit_code == 0, done.output
    assert "| unasked | nothing that nothing asked for | 1 | spurious" in done.output
    found = json.loads(done.stdout.splitlines()[-1])
    assert (found["rules"], found["noticed"], found["blind"], found["flown"]) == (1, 1, [], 1)
    searched = ["--broken", "unasked", "--search", "--flights", "3", "--workers", "1"]
    assert json.loads(CliRunner().invoke(faults, searched).stdout.splitlines()[-1])["noticed"] == 1
    unknown = CliRunner().invoke(faults, ["--broken", "nonsense"])
    assert unknown.exit_code == 2
