"""The laws of the boards of documents 002 to 004: a sound flight keeps them, a tampered one does not."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest
from known_missions import known_on
from programs import run

from links.simulated.settings import FaultEvent, Settings
from mission.authoring.language import parse
from mission.authoring.prepare import check_prepared, prepare
from mission.model import MANUAL_DRIVING, SURFACING, Action, Mission, Outcome, Step, Tx
from mission.model.shipped import load_vehicle
from mission.onboard.runtime import repeater
from mission.onboard.runtime.repeater import Repeater
from mission.verification.campaign.board_laws import audit
from mission.verification.campaign.draw import (
    INCIDENTS,
    Plan,
    draw,
    profiles_of,
)
from mission.verification.campaign.faults import fly_plan
from mission.verification.campaign.laws import IGNORED, LOST, SPURIOUS, Violation, violations
from mission.verification.campaign.proofs import Claim
from mission.verification.campaign.scene import repeated, say
from mission.verification.campaign.staging import faults_of, scenes_of
from mission.verification.campaign.trial import try_out
from mission.verification.campaign.whole_flight import SUNK, UNLAWFUL, throughout
from mission.verification.campaign.withheld import drawn_for
from mission.verification.rig.speech import MOTION, Speech
from mission.verification.rig.trace import Event, Said, Trace
from mission.verification.rig.vehicle import body_of
from protocol.messages import Order, Setpoint

TEXTS = {
    "coreboard": """mission short vehicle coreboard
home 30.2874595 120.1535765
safety radius 500 time 20min depth 20 voltage 12
assume current 0.1
dive: depth 4 heading 90 gear 6 until depth >= 3.7 timeout 90s
hold: depth 4 heading 180 gear 4 for 60s
up: surface until fix timeout 3min
""",
    "rov": """mission short vehicle rov
safety time 20min depth 40
assume current 0
start without fix
dive: down 9 until depth >= 3 timeout 30s
stay: down 5 for 60s
up: surface timeout 3min
""",
    "robot": """mission short vehicle robot
safety time 20min
assume start 0
start without fix
out: gear 6 for 60s
""",
}
STICK_AT, ORDER_AT = 20.0, 35.0
NAMES = tuple(TEXTS)


@functools.cache
def flown(name: str, order: bytes = b"@ZAWF$") -> tuple[Mission, Trace]:
    """The stick for 3 s in mid-mission, then an order."""
    mission = parse(TEXTS[name])
    said = (*repeated(STICK_AT, STICK_AT + 3.0, 0.2, b"@MMB6$"), say(ORDER_AT, order))
    settings = Settings(body=body_of(name))
    return mission, try_out(mission, load_vehicle(name), "documented", 3, settings, said)


def judged(name: str, trace: Trace, mission: Mission) -> list[Violation]:
    vehicle, settings = load_vehicle(name), Settings(body=body_of(name))
    found = violations(trace, mission, vehicle, "documented", settings)
    return [*found, *throughout(trace, mission, vehicle, "documented", settings)]


def kinds(name: str, change: Callable[[Event], Iterator[Event]]) -> set[str]:
    mission, trace = flown(name)
    events = tuple(new for event in trace.events for new in change(event))
    return {v.kind for v in judged(name, replace(trace, events=events), mission)}


def is_word(event: Event) -> bool:
    return isinstance(event, Tx) and event.link == "vehicle"


@pytest.mark.proof
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("order", [b"@ZAX0$", b"@ZAWF$"])
def test_a_flight_with_the_stick_and_an_order_keeps_every_law(name: str, order: bytes) -> None:
    mission, trace = flown(name, order)
    assert judged(name, trace, mission) == []
    states = [e.entered[-1] for e in trace.events if isinstance(e, Step) and e.entered]
    assert trace.started is not None
    assert MANUAL_DRIVING in states
    assert trace.truth.depth < 0.5


@pytest.mark.proof
@pytest.mark.parametrize("name", NAMES)
def test_a_push_that_nothing_asks_for_is_spurious(name: str) -> None:
    frame = Speech(load_vehicle(name)).board.encode(Setpoint(surge=-0.9))[-1]

    def change(event: Event) -> Iterator[Event]:
        yield event
        if is_word(event) and 8.0 < event.t < 8.1:
            yield replace(event, data=frame)  # type: ignore[type-var]

    assert SPURIOUS in kinds(name, change)


@pytest.mark.parametrize("name", NAMES)
def test_a_push_under_the_stick_that_no_m_asks_for_is_spurious(name: str) -> None:
    frame = Speech(load_vehicle(name)).board.encode(Setpoint(surge=0.9))[-1]

    def change(event: Event) -> Iterator[Event]:
        under = is_word(event) and STICK_AT + 1.0 < event.t < STICK_AT + 1.2
        yield replace(event, data=frame) if under else event  # type: ignore[type-var]

    assert SPURIOUS in kinds(name, change)


@pytest.mark.parametrize("name", NAMES)
def test_a_stick_that_pushes_on_when_it_is_let_go_is_spurious(name: str) -> None:
    last = STICK_AT + 0.4

    def change(event: Event) -> Iterator[Event]:
        if not (isinstance(event, Said) and event.t > last and event.data.startswith(b"@MM")):
            yield event

    assert SPURIOUS in kinds(name, change)


@pytest.mark.parametrize("name", NAMES)
def test_what_holds_and_is_not_said_again_is_spurious(name: str) -> None:
    def change(event: Event) -> Iterator[Event]:
        if not (is_word(event) and 12.0 < event.t < 12.5):
            yield event

    assert SPURIOUS in kinds(name, change)


@pytest.mark.parametrize(("at", "found"), [(5.05, 0), (5.15, 1)])
def test_only_at_once_a_w_is_said_before_the_way_in_use(at: float, found: int) -> None:
    vehicle = load_vehicle("coreboard")
    board = Speech(vehicle).board
    words = ("emergency surfacing: W", "everything stopped: W")
    events: list[Event] = [Step(5.0, "", (), (), (SURFACING,), words, "W")]
    for t, order in ((5.0, Order.STOP), (at, Order.SURFACE), (at + 0.1, Order.STOP)):
        events.append(Tx(t, "vehicle", board.encode(order)[0], "W"))
    told = [one for one in audit(events, vehicle) if "not asked for" in one.says]
    assert len(told) == found


@pytest.mark.parametrize(("moves_at", "found"), [(None, 0), (0.0, 1), (4.0, 0)])
def test_outputs_alone_need_no_pace(moves_at: float | None, found: int) -> None:
    """As mission 369 of the robot's soak of seed 63: told to end before it had moved anything."""
    vehicle = load_vehicle("robot")
    board = Speech(vehicle).board
    video = bytes.fromhex("aa0203010000000000 00b0dd")
    sent = [(t, video) for t in (0.0, 2.0, 4.0)]
    if moves_at is not None:
        sent += [(moves_at, board.encode(Order.STOP)[0])]
    frames = [Tx(t, "vehicle", data, "in idle") for t, data in sorted(sent)]
    told = [one for one in audit(frames, vehicle) if one.says.startswith("nothing was said")]
    assert bool(told) == bool(found)


@pytest.mark.parametrize("name", NAMES)
def test_an_order_that_does_not_leave_at_once_is_ignored(name: str) -> None:
    def change(event: Event) -> Iterator[Event]:
        if not (is_word(event) and ORDER_AT <= event.t < ORDER_AT + 0.3):
            yield event

    assert IGNORED in kinds(name, change)


@pytest.mark.parametrize("name", ["coreboard", "rov"])
def test_an_ascent_without_an_upward_word_is_seen(name: str) -> None:
    speech = Speech(load_vehicle(name))
    stop = speech.board.encode(Order.STOP)[-1]

    def change(event: Event) -> Iterator[Event]:
        late = isinstance(event, Tx) and is_word(event) and event.t > ORDER_AT + 0.2
        lifts = late and speech.word(event.data) == b"@ZAU12$"  # type: ignore[union-attr]
        yield replace(event, data=stop) if lifts else event  # type: ignore[type-var]

    found = kinds(name, change)
    assert SPURIOUS in found, "a stop is not what the ascent asks for"


@pytest.mark.parametrize("name", NAMES)
def test_a_flight_that_ends_under_water_or_under_way_is_lost(name: str) -> None:
    mission, trace = flown(name)
    deep = replace(trace, truth=trace.truth._replace(depth=5.0))
    moving = replace(trace, turning=True)
    assert LOST in {v.kind for v in judged(name, deep, mission)}
    assert LOST in {v.kind for v in judged(name, moving, mission)}


def test_the_robot_has_no_law_of_the_water_and_the_others_have() -> None:
    assert [Speech(load_vehicle(name)).lifts for name in NAMES] == [True, True, False]
    assert set(MOTION) == {*NAMES, "mainboard"}


@pytest.mark.parametrize("name", NAMES)
def test_a_flight_is_judged_whatever_fault_of_its_board_it_has(name: str) -> None:
    mission, trace = flown(name)
    faults = tuple(FaultEvent(fault, 1.0) for fault in faults_of(name))
    settings = Settings(body=body_of(name), faults=faults)
    found = violations(trace, mission, load_vehicle(name), "documented", settings)
    assert {violation.kind for violation in found} <= {LOST, IGNORED}


@pytest.mark.proof
@pytest.mark.parametrize("name", NAMES)
def test_what_is_drawn_for_a_board_is_what_it_can_have(name: str) -> None:
    known = known_on(name)
    drawn = [draw(1, number, known) for number in range(400)]
    kinds_drawn = {kind for plan in drawn for kind in plan.kinds}
    scenes = {f"scene {scene}" for scene in scenes_of(name)}
    assert kinds_drawn <= {*faults_of(name), *INCIDENTS, *scenes}
    assert scenes <= kinds_drawn
    assert set(faults_of(name)) <= kinds_drawn
    assert {plan.profile for plan in drawn} == set(profiles_of(name)) == {"documented"}
    assert {plan.vehicle.name for plan in drawn} == {name}


@pytest.mark.parametrize("name", NAMES)
def test_what_is_withheld_or_lost_within_a_proof_is_what_the_board_can_lack(name: str) -> None:
    subject, vehicle = known_on(name)[0], load_vehicle(name)
    report = check_prepared(prepare(subject.path, name))
    assert report.proved is not None
    claim = Claim(str(subject.path), subject.mission, report.proved)
    for flight in range(60):
        proof = drawn_for(claim, flight)(claim, vehicle, 1, flight)
        assert {fault.name for fault in proof.settings.faults} <= set(faults_of(name))
        assert proof.profile == "documented"


def test_sunk_and_unlawful_are_asked_of_boards_too() -> None:
    """An ascent whose state says so, and a stay past its clock."""
    mission, trace = flown("rov")
    begun = next(
        e.t for e in trace.events if isinstance(e, Step) and e.entered and "stay" in e.entered[-1]
    )
    late = [
        replace(e, t=e.t + 200.0) if isinstance(e, Step) and e.t > begun else e
        for e in trace.events
        if not (isinstance(e, Said) and e.data.startswith(b"@M"))
    ]
    found = {v.kind for v in judged("rov", replace(trace, events=tuple(late)), mission)}
    assert found & {UNLAWFUL, SUNK}


@pytest.mark.proof
def test_the_commands_fly_the_other_vehicles_and_say_how_to_fly_one_again() -> None:
    ran = run("faults", "--vehicle", "robot", "--seed", "1", "--flights", "2", "--json")
    assert ran.exit_code == 0, ran.output
    counted = json.loads(ran.stdout.splitlines()[-1])
    assert (counted["flights"], counted["lost"], counted["spurious"]) == (2, 0, 0)
    again = run("faults", "--vehicle", "robot", "--seed", "1", "--flight", "1")
    assert re.match(r"flight 1: \S+ on documented, ", again.stdout)
    assert "auvmission faults --vehicle robot --seed 1 --flight 1" in again.stdout
    proved = run("campaign", "--vehicle", "robot", "--flights", "2")
    assert proved.exit_code == 0, proved.output
    assert json.loads(proved.stdout.splitlines()[-1])["flights"] == 2


@pytest.mark.parametrize(
    "words",
    [
        ("faults", "--vehicle", "motorboards"),
        ("faults", "--vehicle", "submarine"),
        ("campaign", "--vehicle", "rov", "--missions", "3"),
        ("campaign", "--vehicle", "rov", "--words"),
    ],
)
def test_what_is_of_the_auv_alone_is_refused_for_the_others(words: tuple[str, ...]) -> None:
    assert run(*words).exit_code == 2


# --- a program that breaks a rule ------------------------------------------------------------------


def _half_the_pace(monkeypatch: pytest.MonkeyPatch) -> None:
    poll = Repeater.poll

    def late(self: Repeater, now: float) -> tuple[list[Tx], list[Outcome]]:
        out = poll(self, now)
        self.__dict__["_due"] += self.__dict__["_period"] * bool(out[0])
        return out

    monkeypatch.setattr(Repeater, "poll", late)


def _a_stick_that_is_never_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(repeater, "STICK_S", 60.0)


def _a_stop_that_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    command = Repeater.command

    def driven(self: Repeater, action: Action) -> Outcome | None:
        drives = action.command is Order.STOP
        return command(self, replace(action, command=Setpoint(surge=0.3)) if drives else action)

    monkeypatch.setattr(Repeater, "command", driven)


@pytest.mark.proof
@pytest.mark.parametrize(
    ("breaks", "kind"),
    [
        (_half_the_pace, SPURIOUS),
        (_a_stick_that_is_never_let_go, SPURIOUS),
        (_a_stop_that_drives, LOST),
    ],
)
def test_a_program_that_breaks_a_rule_is_noticed(
    breaks: Callable[[pytest.MonkeyPatch], None], kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    breaks(monkeypatch)
    flown.cache_clear()
    mission, trace = flown("robot")
    flown.cache_clear()
    assert kind in {violation.kind for violation in judged("robot", trace, mission)}


@pytest.mark.parametrize("name", ["coreboard", "rov", "mainboard"])
def test_slow_sensors_and_a_wild_depth_now_and_then_end_no_mission_of_a_board(name: str) -> None:
    """It says each of them 3 to 25 times, which is not to be agreed on."""
    for number, subject in enumerate(known_on(name)):
        lasting = FaultEvent("sensors_slow", 0.0, 1e6, 0.45), FaultEvent("depth_wild", 0.0, 1e6)
        settings = Settings(body=body_of(name), faults=lasting)
        plan = Plan(7, number, subject, "documented", number, settings, (), 0.0)
        trace = fly_plan(plan, plan.vehicle)
        triggers = [e.trigger for e in trace.events if isinstance(e, Step) and e.entered]
        assert "start" in triggers
        assert not [t for t in triggers if t == "limit" or t.endswith(":else")]
