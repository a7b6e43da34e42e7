"""What excuses is physics and what the rules say of an order; and calm flights see a false alarm."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from links.simulated.settings import FaultEvent, Settings, parse_settings
from mission.model import (
    SURFACED,
    SURFACING,
    Estimate,
    Evaluation,
    NavigationMode,
    Step,
    Tx,
)
from mission.onboard.runtime.runtime import VEHICLE
from mission.verification.campaign.audit import audit
from mission.verification.campaign.calm import alarms, calm
from mission.verification.campaign.excuses import (
    auto_closed,
    dives_unseen,
    doubted_at_rest,
    helpless,
    left,
    lift,
    net,
    obeys_no_stop,
    spoils_a_turn,
    unknown,
    unknown_and_heavy,
    unpowered,
    untamed,
    value_of,
)
from mission.verification.campaign.faults import shipped, subjects
from mission.verification.campaign.home import WHOLE_ROUND, lost
from mission.verification.campaign.laws import dive
from mission.verification.campaign.scene_texts import mission_of
from mission.verification.rig.acts import Act
from mission.verification.rig.trace import Done, Event, Heard, Said, Told, Trace
from mission.verification.rig.vehicle import flown, simulated
from protocol.vehicles.auv import SD

REPORT = bytes.fromhex("405344" + "00" * 60 + "DC05" * 7 + "0C003000" + "F05C9375" + "24")
CLOSE, OPEN, DONE = b"@NSOOOCCC$", b"@NSOOOCCO$", b"@ACK_NSS$"


def body(*faults: str) -> Settings:
    return parse_settings([f"fault={fault}@10+1000000" for fault in faults])


@pytest.mark.parametrize(
    ("profile", "faults", "lifted"),
    [
        ("as-built", ("heavy=40",), True),
        ("as-built", ("heavy=40", "deaf_to_u"), False),
        ("documented", ("heavy=40", "deaf_to_u"), True),
        ("documented", ("heavy=40", "deaf_to_w"), True),
        ("documented", ("heavy=40", "deaf_to_w", "deaf_to_u"), False),
        ("documented", ("heavy=40", "verticals_weak=0.3"), False),
        ("documented", ("heavy=40", "verticals_dead"), False),
        ("documented", ("heavy=40", "capsized"), False),
        ("as-built", ("deaf_to_u",), True),
        ("as-built", ("dives_until_up", "deaf_to_u"), False),
        ("documented", ("heavy=40", "stm32_restart"), False),
        ("documented", ("stm32_restart",), True),
    ],
)
def test_what_no_word_lifts_that_the_board_obeys_is_physics(profile, faults, lifted):
    assert (lift(body(*faults), profile, 20.0) > 1.0) is lifted
    assert (helpless(body(*faults), profile, 20.0) == 0) is lifted


@pytest.mark.parametrize(
    ("faults", "rounds"),
    [
        (("heavy=40@10+1000000", "deaf_to_u@20+165"), 1),  # as flight 1349 of seed 12742
        (("heavy=40@10+1000000",), 0),
        (("deaf_to_u@20+165",), 0),
        (("heavy=40@10+20", "deaf_to_u@40+165"), 0),
        (("heavy=40@10+1000000", "deaf_to_w@20+165"), 0),
    ],
)
def test_what_sinks_from_rest_and_is_deaf_to_full_thrust_sinks_for_a_round(faults, rounds):
    """Full thrust and letting go have twice their turns before W lifts it (R7)."""
    settings = parse_settings([f"fault={fault}" for fault in faults])
    trial = seen((), SURFACED)
    trial = replace(trial, truth=trial.truth._replace(t=300.0))
    weights = tuple(fault for fault in settings.faults if fault.name == "heavy")
    hears = replace(settings, faults=weights)
    more = dive(settings, "documented", trial) - dive(hears, "documented", trial)
    weight = sum(value_of(fault) for fault in weights) - settings.body.buoyancy
    sinks = math.sqrt(max(weight, 0.0) / settings.body.quadratic[2])
    assert more == pytest.approx(rounds * WHOLE_ROUND * sinks)


@pytest.mark.parametrize(("heavy", "lifted"), [(54.0, True), (57.0, False), (58.0, False)])
def test_what_thrust_lifts_so_slowly_that_no_turn_shows_it_is_physics(heavy, lifted):
    """As flight 6215 of seed 10621: lifted by 2.6 N, it sinks ten times as fast in other turns."""
    settings = body(f"heavy={heavy}")
    assert lift(settings, "as-built", 20.0) > 1.0
    assert (helpless(settings, "as-built", 20.0) == 0) is lifted


def test_what_is_over_or_has_not_begun_excuses_nothing():
    settings = parse_settings(["fault=heavy=40@10+20", "fault=light=5@50+20"])
    assert [net(settings, t) for t in (5.0, 10.0, 29.9, 30.0, 60.0)] == [15, -25, -25, 15, 20]


@pytest.mark.parametrize(
    ("fault", "spans"),
    [
        ("depth_stuck=0.1@20+5", [(20, 85)]),
        ("depth_drifting=0.1@20+30", [(20, 110)]),
        ("depth_too_deep=1@20+200", [(20, 80), (220, 280)]),
        ("altitude_stuck=0.1@20+5", []),
        ("depth_intermittent@20+50", []),
    ],
)
def test_a_depth_says_nothing_while_it_does_not_move_with_the_vehicle(fault, spans):
    """And for a minute after a change, in which it has to show that it does."""
    settings = parse_settings([f"fault={fault}"])
    seconds = [t for t in range(400) if unknown(settings, float(t))]
    assert seconds == [t for begin, end in spans for t in range(begin, end)]


def test_a_board_that_stops_at_an_upward_word_alone_obeys_no_stop_until_it_has_heard_one():
    up = Tx(30.0, VEHICLE, b"@ZAU12$", "")
    assert obeys_no_stop(body("dives_until_up"), [])
    assert not obeys_no_stop(body("dives_until_up"), [up])
    assert obeys_no_stop(body("dives_until_up"), [replace(up, t=5.0)])
    assert not obeys_no_stop(body("dives_until_stop"), [])


def test_only_behind_a_depth_that_was_wrong_is_what_sinks_left_to_a_third_of_the_thrust():
    heavy = "fault=heavy=40@10+20"
    assert unknown_and_heavy(parse_settings([heavy]), 100.0) == 0
    assert unknown_and_heavy(parse_settings([heavy, "fault=depth_stuck@20+5"]), 100.0) == 10


def test_a_board_that_obeys_u12_alone_is_let_dive_only_while_no_depth_tells():
    dives = "fault=dives_until_up@10+20"
    assert untamed(parse_settings([dives]), (), 100.0) == 0
    assert untamed(parse_settings([dives, "fault=depth_frozen@5+20"]), (), 100.0) == 20
    assert untamed(parse_settings([dives, "fault=depth_frozen@5+20"]), (), 15.0) == 5
    assert untamed(parse_settings(["fault=depth_frozen@5+20"]), (), 100.0) == 0


def test_a_dive_at_rest_is_unseen_while_no_depth_tells_and_where_the_sensor_was_wrong_meanwhile():
    """As mission 2758 of soak 14: on the ground in idle, and a depth that stood comes back there."""
    dives = "fault=dives_until_up@10+1000000"
    for faults, unseen in (
        ([dives], False),
        ([dives, "fault=depth_stuck@12+60"], True),
        ([dives, "fault=depth_stuck@2+6"], False),
        ([dives, "fault=depth_full_scale@12+60"], False),
        (["fault=depth_stuck@12+60"], False),
    ):
        assert dives_unseen(parse_settings(faults), 1000.0) is unseen, faults


def test_a_board_that_obeys_x_alone_is_let_dive_only_at_rest_and_while_no_depth_tells():
    """As flight 7077 of seed 808: surfaced, and its board silent."""
    dives, silent = "fault=dives_until_stop@10+20", "fault=stm32_silent@5+200"
    up = Step(12.0, "", (), (), (SURFACING,), (), "W", None)
    assert untamed(parse_settings([dives, silent]), (), 100.0) == 20
    assert untamed(parse_settings([dives, silent]), (up,), 100.0) == 3
    assert untamed(parse_settings([dives]), (), 100.0) == 0


@pytest.mark.parametrize(
    ("fault", "doubted"),
    [
        ("depth_full_scale@10+20", False),
        ("depth_full_scale@10+200", True),
        ("depth_frozen@10+20", True),
        ("altitude_frozen@10+20", False),
    ],
)
def test_a_depth_that_said_garbage_or_was_slightly_off_is_known_again_a_minute_later(
    fault, doubted
):
    assert doubted_at_rest(parse_settings([f"fault={fault}"]), 200.0) is doubted


def said(t: float, data: bytes) -> Said:
    return Said(t, "topside", "boat", data)


def entered(t: float, state: str) -> Step:
    return Step(t, "", (), (), (state,), (), "limit", None)


def test_auto_is_closed_from_what_was_acknowledged_until_it_is_opened_or_begun_anew():
    done = Tx(1.1, "topside", DONE, "")
    assert list(auto_closed([said(1.0, CLOSE)])) == []
    assert list(auto_closed([said(1.0, CLOSE), done])) == [(1.0, math.inf)]
    opened = said(9.0, OPEN), replace(done, t=9.1)
    assert list(auto_closed([said(1.0, CLOSE), done, *opened])) == [(1.0, 9.0)]
    assert list(auto_closed([said(1.0, CLOSE), done, said(9.0, OPEN)])) == [(1.0, math.inf)]
    assert list(auto_closed([said(1.0, CLOSE), done, Done(5.0, Act.BOOT)])) == [(1.0, 5.0)]


def test_it_leaves_alone_what_is_at_rest_and_no_ascent():
    events: list[Event] = [entered(2.0, SURFACING), said(3.0, CLOSE), Tx(3.1, "topside", DONE, "")]
    assert left(events) == []
    assert left([*events, entered(8.0, SURFACED)]) == [(8.0, math.inf)]


# --- the audit -----------------------------------------------------------------------------------


def test_two_words_of_one_step_leave_one_behind_the_other():
    both = ("emergency surfacing: W from the operator", "everything stopped: W from the operator")
    step = Step(10.0, "", (), (), (SURFACING,), both, "W", None)
    sent = [Tx(10.05, VEHICLE, b"@ZAWF$", ""), Tx(10.1, VEHICLE, b"@ZAX0$", "")]
    assert audit([said(9.99, b"@ZAWF$"), step, *sent], "as-built") == []
    late = Tx(12.0, VEHICLE, b"@ZAWF$", "")
    assert len(audit([said(9.99, b"@ZAWF$"), step, *sent, late], "as-built")) == 1


# --- calm ----------------------------------------------------------------------------------------


def test_a_calm_flight_is_told_by_its_seed_and_has_no_fault():
    known = subjects(shipped()[:2])
    plans = [calm(3, number, known) for number in range(20)]
    assert plans == [calm(3, number, known) for number in range(20)]
    assert plans != [calm(4, number, known) for number in range(20)]
    assert not any(plan.settings.faults or plan.incidents for plan in plans)
    for plan in plans:
        assert plan.settings.sea.current[0] <= plan.subject.mission.current(0.5)


def seen(events: tuple[Event, ...], state: str) -> Trace:
    """A trace of these alone."""
    truth = simulated(flown("auv"), 1, Settings()).truth()
    mission = mission_of("deep")
    return Trace(events, (), (0.0, 0.0), truth, state, "", None, "", False, mission)


@pytest.mark.parametrize(
    ("trigger", "state", "alarmed"),
    [("limit", SURFACING, 1), ("autonomous/a:else", "autonomous/b", 1),
     ("autonomous/a:for", "autonomous/b", 0), ("surfaced", SURFACED, 0)],
)  # fmt: skip
def test_a_limit_that_acts_or_an_else_in_a_calm_flight_is_a_false_alarm(trigger, state, alarmed):
    step = Step(9.0, "", (), (), (state,), (), trigger, None)
    trial = seen((step,), state)
    assert len(list(alarms(trial, flown("auv")))) == alarmed


@pytest.mark.parametrize(("echo", "alarmed"), [((3.9, 5.9), 1), ((3.9,), 1), ((1.9,), 0)])
def test_the_else_of_a_leg_without_an_echo_is_a_false_alarm_where_the_altimeter_heard_one(
    echo, alarmed
):
    reports = [
        Heard(t, SD.encode(SD.decode(REPORT) | {"altitude_m": 4.0 if t in echo else 0.0}))
        for t in (1.9, 3.9, 5.9, 7.9)
    ]
    looked = Evaluation("autonomous/a:else", True, (("elapsed", 5.0), ("altitude", None)))
    step = Step(9.0, "telemetry", (looked,), (), ("autonomous/b",), (), "autonomous/a:else", None)
    events = (*reports, step)
    trial = seen(events, "")
    assert len(list(alarms(trial, flown("auv")))) == alarmed


def held_up(depth: Callable[[int], float], *events: Tx) -> Trace:
    """Out of surfaced up again by itself, and a thruster on at the end; ``depth``: m in each s."""
    steps = [
        Step(t, "", (), (), (state,), (), trigger, None)
        for t, state, trigger in (
            (5.0, SURFACED, "surfaced"),
            (25.0, SURFACING, "limit"),
            (40.0, SURFACED, "surfaced"),
        )
    ]
    trial = seen((*events, *steps), SURFACED)
    track = [trial.truth._replace(t=float(t), depth=depth(t)) for t in range(50)]
    return replace(trial, track=tuple(track), truth=track[-1], turning=True)


@pytest.mark.parametrize(
    ("deep", "when", "lost_by"),
    [
        (0.7, (20,), ""),
        (0.7, (8,), "its thrusters turn"),
        (0.4, range(15, 26), ""),
        (0.4, (20,), "its thrusters turn"),
        (0.2, range(15, 26), "its thrusters turn"),
    ],
)
def test_what_sank_out_of_surfaced_as_its_fixes_tell_is_held_up(deep, when, lost_by) -> None:
    """As flights 2405 of seed 4707, up again by then, and 5224 of seed 5010, 0.1 N too heavy."""
    held = held_up(lambda t: deep if t in when else 0.2)
    assert lost(held, "documented", Settings()).startswith(lost_by)
    assert bool(lost(held, "documented", Settings())) is bool(lost_by)


@pytest.mark.parametrize(
    ("begin", "waves", "wet", "lifted", "is_lost"),
    [
        (5.0, 0.21, (19, 22, 25), None, False),
        (5.0, 0.21, (19, 25), None, True),
        (5.0, 0.0, (19, 22, 25), None, True),
        (15.0, 0.21, (19, 22, 25), None, True),
        (5.0, 0.21, (19, 22, 25), 10.0, True),
    ],
)
def test_what_its_own_board_pushes_down_in_waves_at_the_surface_is_held_up(
    begin: float, waves: float, wet: Sequence[int], lifted: float | None, is_lost: bool
) -> None:
    """As flight 14049 of seed 11126: on its side, where the push moves it by 0.1 m.
    ``wet``: s at which waves wash over the antenna."""
    dives = FaultEvent("dives_until_up", begin, 1e6)
    settings = Settings(faults=(dives,))
    settings = replace(settings, sea=replace(settings.sea, waves=(waves, 4.0)))
    ups = (25.0, *(() if lifted is None else (lifted,)))
    lifts = [Tx(t, VEHICLE, b"@ZAU12$", "") for t in ups]
    held = held_up(lambda t: 0.25 if t in wet else 0.15, *lifts)
    assert bool(lost(held, "documented", settings)) is is_lost


@pytest.mark.parametrize(("off", "is_lost"), [(15.0, False), (-40.0, True), (None, True)])
def test_what_is_held_up_because_its_receiver_was_switched_off_is_not_lost(off, is_lost) -> None:
    """As flight 18727 of seed 5313: nobody knows its depth, and its fixes have ended."""
    switched = () if off is None else (Tx(off, "nodes", b"BDGPS C", "operator @NS"),)
    held = held_up(lambda t: 0.2, *switched)
    assert bool(lost(held, "documented", Settings())) is is_lost


def test_what_lies_upside_down_for_good_and_nothing_tells_it_may_go_down_to_the_ground() -> None:
    """As flight 3248 of seed 4909: its board had fallen silent three seconds before."""
    over, silent = FaultEvent("capsized", 20.0, 1e6), FaultEvent("stm32_silent", 17.0, 1e6)
    at = Estimate(*(0.0,) * 10, (1.0, 0.0, 1.0), {}, None, None, NavigationMode.NONE)
    before, behind = ((Told(t, at._replace(t=t)),) for t in (16.0, 25.0))
    for faults, told, untold in (
        ((over, silent), before, True),
        ((over, silent), behind, False),
        ((silent,), before, False),
    ):
        trial = seen(told, SURFACING)
        assert math.isinf(dive(Settings(faults=faults), "documented", trial)) is untold


def test_a_dive_that_begins_in_a_turn_of_full_thrust_costs_a_round() -> None:
    """As flights 7934 and 12699 of seed 1313."""
    words = [Tx(49.08, VEHICLE, b"@ZAX0$", ""), Tx(49.12, VEHICLE, b"@ZAU12$", "")]
    for name in ("dives_until_up", "dives_until_stop"):
        for begin in (49.1, 55.0):
            assert spoils_a_turn(FaultEvent(name, begin, 60.0), words)
        assert not spoils_a_turn(FaultEvent(name, 49.1, 60.0), [])
    assert spoils_a_turn(FaultEvent("dives_until_stop", 48.99, 60.0), words)
    assert not spoils_a_turn(FaultEvent("dives_until_up", 48.99, 60.0), words)


@pytest.mark.parametrize(
    ("off", "lasts", "depth", "excused"),
    [
        (132.9, 1e6, "depth_stuck", True),
        (-132.9, 1e6, "depth_stuck", True),
        (60.0, 1e6, "depth_stuck", False),
        (132.9, 60.0, "depth_stuck", False),
        (132.9, 1e6, "depth_absurd", False),  # over, and known again
    ],
)
def test_what_is_said_to_lie_upside_down_is_let_go_for_good_where_no_depth_tells(
    off: float, lasts: float, depth: str, excused: bool
) -> None:
    """As flight 19562 of seed 6424: upright, heavy, and on the ground by a depth that leapt."""
    faults = (
        FaultEvent("attitude_off", 45.0, lasts, off),
        FaultEvent(depth, 52.0, 54.0),
        FaultEvent("heavy", 52.0, 1e6, 50.0),
    )
    trial = seen((), SURFACING)
    there = [trial.truth._replace(t=float(t), depth=29.8) for t in range(2600, 2700)]
    trial = replace(trial, track=tuple(there), truth=there[-1])
    assert bool(lost(trial, "documented", Settings(faults=faults))) is not excused


@pytest.mark.parametrize(
    ("name", "begin", "said", "excused"),
    [
        ("gps_wanders", 10.0, CLOSE, True),
        ("gps2_wanders", 10.0, CLOSE, True),
        ("gps_wanders", 60.0, CLOSE, False),
        ("gps_wanders", 10.0, OPEN, False),
        ("gps_stuck", 10.0, CLOSE, False),
    ],
)
def test_what_sank_with_auto_closed_stays_after_a_restart_where_fixes_said_that_it_floats(
    name: str, begin: float, said: bytes, excused: bool
) -> None:
    """As flight 4132 of seed 6424: 30 m deep, killed, and its receiver said places all the time."""
    events = (
        Said(30.0, "topside", "boat", said),
        Tx(30.1, "topside", DONE, ""),
        Done(50.0, Act.KILL),
        Done(52.0, Act.BOOT),
    )
    sea = Settings(faults=(FaultEvent(name, begin, 1e6), FaultEvent("heavy", 35.0, 1e6, 40.0)))
    trial = seen(events, "idle/empty")
    deep = replace(trial, truth=trial.truth._replace(depth=30.0))
    assert bool(lost(deep, "documented", sea)) is not excused
    assert lost(replace(deep, state=SURFACED), "documented", sea)


def test_a_receiver_is_off_from_the_switch_at_the_vehicle_until_it_is_switched_on_again() -> None:
    """@RS of operators: the third of its letters is the receiver's."""

    def sent(t: float, letters: bytes, link: str = VEHICLE) -> Tx:
        return Tx(t, link, b"@RS%b$" % letters, "relay of @RS for topside")

    on, off, others = b"OOOOOOO", b"OOCOOOO", b"OCOOOOC"
    assert unpowered([sent(10.0, on), sent(20.0, others), sent(30.0, off, "topside")]) == []
    words = [sent(10.0, off), sent(11.0, off), sent(20.0, others), sent(30.0, off)]
    assert unpowered(words) == [(10.0, 20.0), (30.0, math.inf)]
