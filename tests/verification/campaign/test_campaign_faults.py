"""Disturbed flights: nothing is lost, overrun or sent unasked; and the laws see it when it is."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from known_missions import KNOWN

from links.simulated.faults import FAULTS
from links.simulated.settings import Settings, parse_settings
from mission.authoring.language import parse
from mission.commands.faults import faults
from mission.engine.ascent import Ascent
from mission.engine.core import Core
from mission.engine.engine import Engine
from mission.engine.monitor import LimitMonitor
from mission.model import IDLE_EMPTY, IDLE_READY, SURFACED, SURFACING, Action, Step, Tx
from mission.model.shipped import load_vehicle
from mission.onboard.blackbox import notes_of
from mission.onboard.runtime import mission_validator
from mission.onboard.runtime.commander import Commander
from mission.onboard.runtime.frontseat import Frontseat
from mission.verification.campaign.disturbances import INCIDENTS
from mission.verification.campaign.draw import CLUSTER, MOST, OUT_OF_HAND, draw
from mission.verification.campaign.faults import fly_numbered, fly_plan
from mission.verification.campaign.laws import IGNORED, LOST, OVERRUN, RAISED, violations
from mission.verification.campaign.scene_texts import mission_of
from mission.verification.campaign.trial import FOREVER, known_judge, try_out
from mission.verification.campaign.whole_flight import throughout
from mission.verification.campaign.word_laws import UNLAWFUL
from mission.verification.rig.acts import OTHER_BOAT, PORT, Act, Disturbance
from mission.verification.rig.trace import Done, Heard, Said, Trace
from protocol.messages import Order

VEHICLE = load_vehicle("auv")
FIRST = next(s for s in KNOWN if s.path.stem == "first-dive")
PROFILES = ("as-built", "documented")
NO_FAULTS = Settings()


def flown(
    disturbances: list[Disturbance], profile: str = "as-built", settings: Settings = NO_FAULTS
) -> Trace:
    return try_out(FIRST.mission, VEHICLE, profile, 1, settings, disturbances)


def kinds_of(trial: Trace, profile: str = "as-built", settings: Settings = NO_FAULTS) -> set[str]:
    return {v.kind for v in violations(trial, FIRST.mission, VEHICLE, profile, settings)}


# --- the campaign --------------------------------------------------------------------------------


def test_what_is_drawn_of_a_fault_is_told_alike_by_both_builds() -> None:
    """Compiled code makes a float of a whole number, and a flight's words would say 2.0 for 2."""
    drawn = [event for n in range(300) for event in draw(3, n, KNOWN).settings.faults]
    values = [v for e in drawn for v in (e.begin, e.duration, e.value) if v is not None]
    assert len(values) > 300
    assert {type(value) for value in values} == {float}


@pytest.mark.proof
@pytest.mark.parametrize("ten", range(5))
def test_no_disturbed_flight_loses_overruns_or_sends_unasked(ten: int) -> None:
    for number in range(10 * ten, 10 * ten + 10):
        result = fly_numbered(0, number, KNOWN)
        assert not result.violations, result


def test_a_forgotten_stick_waits_for_a_node_that_is_closed() -> None:
    """As flight 9557 of seed 5111: an operator closed AUTO under the stick."""
    result = fly_numbered(5111, 9557, KNOWN)
    assert not result.violations, result


@pytest.mark.proof
@pytest.mark.parametrize("name", INCIDENTS)
def test_an_incident_alone_breaks_no_law(name: str) -> None:
    drawn = INCIDENTS[name].draw(random.Random(name), ("mission other vehicle auv", "wait 9"))
    disturbances = [Disturbance(40.0 + d.after, d.act, d.data, d.link, d.address) for d in drawn]
    for profile in PROFILES:
        assert kinds_of(flown(disturbances, profile), profile) == set()


@pytest.mark.proof
def test_every_fault_and_every_incident_is_drawn() -> None:
    plans = [draw(1, number, KNOWN, staged=0.0) for number in range(1800)]
    assert {kind for plan in plans for kind in plan.kinds} == {*FAULTS, *INCIDENTS}
    assert max(len(plan.kinds) for plan in plans) == MOST
    for event in (event for plan in plans for event in plan.settings.faults):
        assert event.name not in OUT_OF_HAND or (event.duration or 0.0) < FOREVER


@pytest.mark.proof
def test_a_flight_is_told_by_its_seed_and_number_alone() -> None:
    assert draw(5, 7, KNOWN) == draw(5, 7, KNOWN)
    assert draw(5, 7, KNOWN) != draw(6, 7, KNOWN)
    plan = draw(5, 7, KNOWN)
    first, second = (fly_plan(plan, VEHICLE) for _ in range(2))
    assert first.events == second.events


def test_a_mission_that_was_judged_in_an_earlier_flight_is_flown_alike(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = draw(5, 7, KNOWN)
    anew = fly_plan(plan, plan.vehicle)
    known = fly_plan(plan, plan.vehicle, judge=known_judge)
    monkeypatch.setattr(mission_validator, "judge", None)  # who asks it now is refused
    again = fly_plan(plan, plan.vehicle, judge=known_judge)
    assert anew.events == known.events == again.events
    assert again.mission is plan.subject.mission


def test_a_verdict_is_that_of_one_vehicle() -> None:
    assert known_judge(VEHICLE, "a") is known_judge(replace(VEHICLE), "a")
    assert known_judge(VEHICLE, "a") is not known_judge(VEHICLE, "b")
    assert known_judge(VEHICLE, "a") is not known_judge(replace(VEHICLE, dialect="documented"), "a")


def test_the_command_ends_with_one_object_and_flies_one_again(tmp_path: Path) -> None:
    done = CliRunner().invoke(faults, ["--seed", "4", "--flight", "2", "--report", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert "auvmission faults --seed 4 --flight 2" in done.output
    found = json.loads(done.stdout.splitlines()[-1])
    assert (found["flights"], found["lost"], found["overruns"], found["spurious"]) == (1, 0, 0, 0)
    assert sum(found["faults"].values()) == len(draw(4, 2, KNOWN).kinds)
    notes = notes_of(tmp_path / "life1.mcap")
    assert (notes["seed"], notes["simulated"]) == ("4, flight 2", draw(4, 2, KNOWN).profile)
    assert "floor at" in notes["sea"]
    assert "set" not in notes or not notes["set"], "what went wrong is not told before the story"


def test_a_calm_flight_that_is_flown_again_leaves_its_black_box(tmp_path: Path) -> None:
    asked = ["--calm", "--seed", "19", "--flight", "2", "--report", str(tmp_path)]
    done = CliRunner().invoke(faults, asked)
    assert done.exit_code == 0, done.output
    assert notes_of(tmp_path / "life1.mcap")["seed"] == "19, flight 2"
    done = CliRunner().invoke(faults, ["--calm", "--flight", "there/0"])
    assert done.exit_code == 2
    assert "flights without faults have numbers" in done.output


# --- what it has found ---------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
def test_a_program_killed_after_a_disk_was_full_at_the_start_still_surfaces(profile: str) -> None:
    killed = [
        Disturbance(100.0, Act.KILL),
        Disturbance(103.0, Act.BOOT),
        Disturbance(104.0, Act.JOIN),
    ]
    trial = flown([Disturbance(4.5, Act.FILL), Disturbance(20.0, Act.FREE), *killed], profile)
    assert kinds_of(trial, profile) == set()
    assert trial.started is not None
    assert trial.state == SURFACED


@pytest.mark.proof
@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("death", [Act.DIE_BEFORE, Act.DIE_AFTER])
def test_a_program_killed_between_the_end_and_its_stop_leaves_no_thruster_on(
    profile: str, death: Act
) -> None:
    steps = [e for e in flown([], profile).events if isinstance(e, Step)]
    ends = next(step.t for step in steps if IDLE_READY in step.entered and step.by)
    trial = flown([Disturbance(ends - 0.3, death)], profile)
    assert kinds_of(trial, profile) == set()
    assert any(isinstance(e, Done) and e.act is Act.KILL for e in trial.events)
    # On record is the mission, or the stop that waits for its answer: said again, and idle (R7).
    assert trial.state == (SURFACED if death is Act.DIE_BEFORE else IDLE_READY)


@pytest.mark.parametrize("profile", PROFILES)
def test_a_stop_that_was_cleared_before_its_answer_still_stops(profile: str) -> None:
    """Cleared at the surface, where alone it may be: before the mission has dived."""
    deaf = parse_settings(["fault=command_lost@5.2+3"])
    said = [Disturbance(5.3, Act.SAY, b"@ZAX0$"), Disturbance(5.6, Act.SAY, b"@AC$")]
    trial = flown(said, profile, deaf)
    assert kinds_of(trial, profile, deaf) == set()
    assert trial.state == IDLE_EMPTY


@pytest.mark.parametrize("profile", PROFILES)
def test_a_program_killed_with_the_stick_held_leaves_no_thruster_on(profile: str) -> None:
    stick = [Disturbance(200.0 + 0.2 * i, Act.SAY, b"@MMF9$") for i in range(20)]
    killed = [
        Disturbance(204.1, Act.KILL),
        Disturbance(207.0, Act.BOOT),
        Disturbance(208.0, Act.JOIN),
    ]
    said = [Disturbance(60.0, Act.SAY, b"@ZAWF$"), Disturbance(150.0, Act.SAY, b"@AC$")]
    trial = flown([*said, *stick, *killed], profile)
    assert kinds_of(trial, profile) == set()
    assert trial.state == IDLE_EMPTY


@pytest.mark.proof
@pytest.mark.parametrize("profile", PROFILES)
def test_upside_down_with_no_depth_and_no_angle_it_comes_to_rest_at_the_surface(
    profile: str,
) -> None:
    """Turns of 10 s are a circle below the surface: pushed down as far as it rose."""
    unseen = "fault=attitude_full_scale@8+500 fault=capsized@47+500 fault=depth_silent@48+500"
    settings = parse_settings([*unseen.split(), "current=0.46@100", "floor=30"])
    w = Disturbance(60.0, Act.SAY, b"@ZAWF$")
    trial = try_out(mission_of("loose"), VEHICLE, profile, 1, settings, [w])
    entered = [e for e in trial.events if isinstance(e, Step) and e.entered]
    assert entered[-1].entered[-1] == SURFACED
    assert entered[-1].t < 400.0


# --- the laws bite -------------------------------------------------------------------------------


@pytest.mark.proof
def test_a_vehicle_that_does_not_come_up_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Ascent, "act", lambda self, *seen: ())
    settings = parse_settings(["fault=stm32_silent@60+20"])
    assert LOST in kinds_of(flown([], settings=settings), settings=settings)


@pytest.mark.proof
def test_a_limit_that_nobody_looks_at_is_overrun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LimitMonitor, "look", lambda self, reported, fixed: [])
    silent = parse_settings(["fault=stm32_silent@60+20"])
    assert OVERRUN in kinds_of(flown([], settings=silent), settings=silent)
    tight = [Disturbance(60.0, Act.SAY, b"@SP,2000,2,100,10,$")]
    assert OVERRUN in kinds_of(flown(tight))


def test_a_dive_beyond_its_limit_is_an_overrun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LimitMonitor, "look", lambda self, reported, fixed: [])
    text = FIRST.mission
    deep = parse(
        "mission deep vehicle auv\nhome 30.2874595 120.1535765\nsafety radius 500 time 15min\n"
        "down: depth 40 heading 0 gear 4 for 240\n"
    )
    assert text.safety.depth == 10.0
    sea = parse_settings(["floor=60"])
    trial = try_out(deep, VEHICLE, "as-built", 1, sea)
    found = violations(trial, FIRST.mission, VEHICLE, "as-built", sea)
    assert any(v.kind == OVERRUN and v.says.startswith("depth") for v in found)


@pytest.mark.replaces
def test_a_program_that_raises_is_a_violation(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Engine, now: float, inputs: object = ()) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(Engine, "step", fail)
    assert kinds_of(flown([])) == {RAISED}


@pytest.mark.replaces
def test_a_byte_that_nobody_asked_for_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    honest = Frontseat.poll

    def poll(self: Frontseat, now: float) -> tuple[list[Tx], list[object]]:
        sent, outcomes = honest(self, now)
        extra = [Tx(now, "vehicle", b"@ZAX0$", "every 5 s")] if int(now) == 90 else []
        return [*sent, *extra], list(outcomes)

    monkeypatch.setattr(Frontseat, "poll", poll)
    assert kinds_of(flown([])) == {"spurious"}


@pytest.mark.replaces
def test_an_order_that_does_not_leave_at_once_is_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    honest, dropped = Frontseat.command, []

    def forgetful(self: Frontseat, action: Action) -> object:
        if action.command is Order.STOP and not dropped:
            dropped.append(action)
            return None
        return honest(self, action)

    monkeypatch.setattr(Frontseat, "command", forgetful)
    assert IGNORED in kinds_of(flown([Disturbance(60.0, Act.SAY, b"@ZAX0$")]))


@pytest.mark.proof
def test_a_set_that_relays_keep_back_is_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    following = Frontseat.next_out

    def polite(self: Frontseat, now: float) -> list[Tx]:
        if self._relays and not self._urgent:
            return [self._transmit(*self._relays.take(), now)]
        return following(self, now)

    monkeypatch.setattr(Frontseat, "next_out", polite)
    slider = [Disturbance(60.0 + i / 100, Act.SAY, b"@DS%d,5$" % (i % 2 + 1)) for i in range(2500)]
    assert IGNORED in kinds_of(flown([Disturbance(60.0, Act.SAY, b"@ZAWF$"), *slider]))


@pytest.mark.proof
@pytest.mark.parametrize("profile", PROFILES)
def test_a_thruster_that_turns_at_the_end_is_a_loss(
    profile: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A device on the port answers for the STM32, and nobody doubts it: neither by the reports that
    come later nor because the line was away."""
    cut = [
        Disturbance(59.5, Act.UNPLUG),
        Disturbance(70.0, Act.PLUG),
        Disturbance(60.0, Act.SAY, b"@ZAX0$"),
    ]
    ack = [
        Disturbance(60.05, Act.SAY, b"@ACK_ZAY$", PORT, ""),
        Disturbance(60.06, Act.SAY, b"@ACK_ZXY$", PORT),
    ]
    assert kinds_of(flown([*cut, *ack], profile), profile) == set()
    monkeypatch.setattr(LimitMonitor, "turning", lambda self, since: False)
    assert kinds_of(flown([*cut, *ack], profile), profile) == set()
    monkeypatch.setattr(Core, "doubt_line", lambda self: None)
    assert kinds_of(flown([*cut, *ack], profile), profile) == set(), "it does not rise"
    monkeypatch.setattr(Core, "mind_rest", lambda self: None)
    assert LOST in kinds_of(flown([*cut, *ack], profile), profile)


def test_a_quarter_of_the_flights_has_all_its_troubles_within_seconds() -> None:
    begins = []
    for plan in (draw(3, number, KNOWN, staged=0.0) for number in range(400)):
        at = [e.begin for e in plan.settings.faults] + [d.begin for d in plan.incidents]
        if len(at) >= 3:
            begins.append(max(at) - min(at))
    assert 0.2 < sum(spread <= CLUSTER for spread in begins) / len(begins) < 0.4


# --- what a trial does ---------------------------------------------------------------------------


def test_a_program_that_stands_still_says_nothing_and_then_reads_everything_at_once() -> None:
    events = flown([Disturbance(50.0, Act.STALL), Disturbance(54.5, Act.RUN)]).events
    assert not [e for e in events if isinstance(e, Tx | Heard) and 50.0 < e.t < 54.5]
    assert [e for e in events if isinstance(e, Heard) and e.t == 54.5 and len(e.data) > 86]


def test_a_program_that_stands_still_is_told_nothing_by_operators_or_a_cable() -> None:
    """From before the operator starts the mission."""
    pulled = [Disturbance(4.0, Act.UNPLUG), Disturbance(7.0, Act.PLUG)]
    events = flown([Disturbance(3.0, Act.STALL), *pulled, Disturbance(9.0, Act.RUN)]).events
    assert not [e for e in events if isinstance(e, Tx | Heard | Said | Step) and 3.0 < e.t < 9.0]
    assert [e for e in events if isinstance(e, Said) and e.t == 9.0 and b"@AA$" in e.data]


def test_the_dead_do_not_stand_still() -> None:
    dead = [Disturbance(60.0, Act.KILL), Disturbance(63.0, Act.BOOT), Disturbance(64.0, Act.JOIN)]
    stalled = [Disturbance(61.0, Act.STALL), Disturbance(69.0, Act.RUN)]
    trial = flown([*dead, *stalled])
    assert not any(isinstance(e, Done) and e.act is Act.STALL for e in trial.events)
    assert any(isinstance(e, Tx) and e.link == PORT and 63.0 <= e.t < 64.0 for e in trial.events)


def test_a_program_that_ends_by_itself_is_told_from_one_that_is_killed() -> None:
    ended = flown([Disturbance(60.0, Act.END)])
    killed = flown([Disturbance(60.0, Act.KILL), Disturbance(63.0, Act.BOOT)])
    left = [
        any(isinstance(e, Done) and e.act is Act.LEAVE for e in t.events) for t in (ended, killed)
    ]
    assert left == [True, False]


@pytest.mark.parametrize(("says", "lawful"), [(b"\x0f\xc5@MMF\xff$", True), (b"@DU$", False)])
def test_who_says_nothing_that_is_a_frame_does_not_go_on_commanding(
    says: bytes, lawful: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever commands, another is obeyed here: lawful where the first has long been silent."""
    monkeypatch.setattr(Commander, "why_not", lambda *_: "")
    said = [
        Disturbance(58.0, Act.JOIN, address=OTHER_BOAT),
        Disturbance(60.0, Act.SAY, says),
        Disturbance(62.0, Act.SAY, b"@NSOOOCCO$", address=OTHER_BOAT),
    ]
    trial = flown(said)
    found = throughout(trial, FIRST.mission, VEHICLE, "as-built", NO_FAULTS)
    assert [v.kind for v in found] == ([] if lawful else [UNLAWFUL])


def test_a_relay_that_is_acknowledged_hands_the_command_over() -> None:
    """Then the other's words are lawful, though the first goes on talking."""
    said = [
        Disturbance(58.0, Act.JOIN, address=OTHER_BOAT),
        Disturbance(71.0, Act.SAY, b"@RI$", address=OTHER_BOAT),
        Disturbance(74.0, Act.SAY, b"@DU$"),
        Disturbance(76.0, Act.SAY, b"@NSOOOCCO$", address=OTHER_BOAT),
    ]
    trial = flown(said)
    told = [e.data for e in trial.events if isinstance(e, Tx) and e.address == OTHER_BOAT]
    assert b"@ACK_NSS$" in told
    assert not list(throughout(trial, FIRST.mission, VEHICLE, "as-built", NO_FAULTS))


def test_a_power_cut_takes_both_boards() -> None:
    cut = INCIDENTS["power_cut"].draw(random.Random(1), ())
    trial = flown([Disturbance(60.0 + d.after, d.act) for d in cut])
    assert {Act.POWER, Act.KILL, Act.BOOT} <= {e.act for e in trial.events if isinstance(e, Done)}
    assert trial.state == SURFACED


def test_surfacing_is_entered_for_a_reason_that_is_on_record() -> None:
    trial = flown([Disturbance(60.0, Act.SAY, b"@ZAWF$")])
    steps = [e for e in trial.events if isinstance(e, Step) and SURFACING in e.entered]
    assert [step.event for step in steps] == ["operator W"]
