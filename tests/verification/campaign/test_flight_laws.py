"""Laws of flights that no row of the broken rules needs: each is seen to be broken, and by name."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import timedelta
from functools import partial
from types import SimpleNamespace

import pytest

from links.simulated.geodesy import moved
from links.simulated.link import START
from links.simulated.settings import FaultEvent, Settings, parse_settings
from mission.engine import engine
from mission.engine.bounds import Bounds
from mission.engine.core import Core
from mission.engine.restart import begin_again
from mission.engine.travel import Travel
from mission.engine.watch import Watch
from mission.model import STOPPED, SURFACED, SURFACING, Restarted, Step, Tx
from mission.onboard.runtime.operator_server import OperatorServer
from mission.onboard.runtime.receivers import GPS
from mission.onboard.runtime.runtime import VEHICLE
from mission.onboard.runtime.situation import Situation
from mission.verification.campaign.broken import broken
from mission.verification.campaign.depth_laws import _misses_its_lift, _missing
from mission.verification.campaign.draw import Drawn, Plan, stage
from mission.verification.campaign.faults import fly_plan, result_of, shipped, subjects
from mission.verification.campaign.laws import Span, _ranges
from mission.verification.campaign.leg_laws import waits
from mission.verification.campaign.limit_laws import (
    _BY_REPORT,
    _blind,
    _by_report,
    _one_unanswered,
)
from mission.verification.campaign.reports import Report
from mission.verification.campaign.scene import DOWN, X, repeated, say
from mission.verification.campaign.status_laws import _is_alone, _is_stuck, _is_told, _is_told_up
from mission.verification.campaign.story import Stay, Story
from mission.verification.campaign.surface_laws import (
    _died_near,
    _froze_near,
    _is_asked_twice,
    _is_at_surface,
)
from mission.verification.campaign.word_laws import _allowed
from mission.verification.rig.acts import MODEM, TOPSIDE, Act, Disturbance
from mission.verification.rig.trace import Done, Heard, Located, Said
from protocol.messages import Setpoint
from protocol.nmea import encode_gga, encode_rmc

pytestmark = pytest.mark.proof  # long: make proofs


def judged(plan: Plan) -> list[str]:
    result = result_of(plan, fly_plan(plan, plan.vehicle), plan.vehicle, plan.profile)
    return sorted({f"{each.kind}: {each.says}" for each in result.violations})


@pytest.mark.replaces
def test_what_was_stopped_and_begins_again_as_surfaced_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """R7: a restart comes back to the very state: one floats up by itself, the other was up."""

    def as_surfaced(core: Core, how: Restarted) -> None:
        begin_again(core, replace(how, during=SURFACED) if how.during else how)

    plan = stage("restarted_after_x", 0)
    assert judged(plan) == []
    monkeypatch.setattr(engine, "begin_again", as_surfaced)
    assert judged(plan) == [f"unlawful: restarted out of {STOPPED} into {SURFACED}"]


def faulty(name: str, *faults: str) -> Plan:
    plan, settings = stage(name, 0), parse_settings([f"fault={fault}" for fault in faults])
    settings = replace(plan.settings, faults=settings.faults)
    return replace(plan, settings=settings, profile="documented", incidents=())


@pytest.mark.replaces
@pytest.mark.parametrize("scene", ["no_answers", "brown_out"])
def test_thrust_that_stays_dead_behind_its_set_sent_again_is_seen(
    monkeypatch: pytest.MonkeyPatch, scene: str
) -> None:
    """R8: once, then up; a set that is sent again and again hid it."""
    repeat = Core.repeat_set

    def for_ever(core: Core, why: str) -> None:
        repeat(core, why)
        core.watch.repeated = False

    plan = faulty(scene, "thrust_dead@60+120")
    assert judged(plan) == []
    monkeypatch.setattr(Core, "repeat_set", for_ever)
    assert any("no thruster turns in 8 reports, and still in" in says for says in judged(plan))


@pytest.mark.replaces
@pytest.mark.parametrize("letter", ["f", "h", "s"])
def test_one_word_that_is_never_answered_among_others_is_seen(
    monkeypatch: pytest.MonkeyPatch, letter: str
) -> None:
    plan = faulty("swept_away", f"deaf_to_{letter}@2+1000000")
    assert judged(plan) == []
    monkeypatch.setattr(Watch, "unanswered", property(lambda watch: watch.lost))
    says = f"unanswered: {letter.upper()} without an answer 5 times, and still autonomous"
    assert says in judged(plan)


@pytest.mark.replaces
@pytest.mark.parametrize("heavy", [16, 20])
def test_a_port_that_clogs_at_rest_hides_no_water_that_comes_in_where_the_ground_tells(
    monkeypatch: pytest.MonkeyPatch, heavy: int
) -> None:
    """The fixes end, the depth trembles at 0.2 m; a minute later the ground comes nearer."""
    faults = f"heavy={heavy}@75+1000000", "depth_stuck=0.05@70+1000000"
    staged = stage("heavy_when_surfaced", 0)
    plan = replace(faulty("heavy_when_surfaced", *faults), incidents=staged.incidents)
    assert fly_plan(plan, plan.vehicle).track[-1].depth < 1.0
    monkeypatch.setattr("mission.engine.core.NEARS_GROUND", "said by nobody")
    assert fly_plan(plan, plan.vehicle).track[-1].depth > 20.0


@pytest.mark.replaces
def test_a_vehicle_whose_reports_show_how_it_sinks_is_missed_though_their_zero_has_leapt(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """R7, at rest: it was up, and sank to the ground behind flight 840 of seed 777002. The leap
    excused it, and at its end, too."""
    always = "heavy=48.7@47.8+1000000", "deaf_to_w@47.8+1000000", "gps_wanders@6+1000000"
    plan = faulty("heavy_and_wandering", *always, "depth_too_deep=5@70+1000000")
    stopped = Drawn("", 0.0, (say(47.8, b"@ZAX0$"),))
    plan = replace(plan, profile="as-built", incidents=(stopped,))
    assert judged(plan) == []
    monkeypatch.setattr(Travel, "descends", lambda travel, now: False)
    (found,) = judged(plan)
    assert re.fullmatch(r"sunk: sinks in emergency/surfaced, .* m deep, as .* no response", found)


def test_one_word_that_legs_say_minutes_apart_without_an_answer_ends_no_mission() -> None:
    """R8: a minute at most lies between two of them. Five rows end with a W, 200 s apart."""
    rows = [path for path in shipped() if path.stem == "lawnmower"]
    plan = replace(faulty("swept_away", "deaf_to_w@2+1000000"), subject=subjects(rows)[0], scene="")
    trace = fly_plan(plan, plan.vehicle)
    said = [e.t for e in trace.events if isinstance(e, Tx) and e.data == b"@ZAWF$"]
    assert len(said) >= 15
    assert result_of(plan, trace, plan.vehicle, plan.profile).violations == ()


def test_a_depth_that_was_dead_and_has_not_shown_the_surface_yet_tells_nothing() -> None:
    """As flight 982 of seed 10116: 0 from 6 m on, and back 20 s before the stick takes over."""
    faults = "fault=depth_dead@35.4+99.5", "fault=heavy=18.4@86+1000000"
    staged, settings = stage("held_and_then", 0), parse_settings(["waves=0.3@6", *faults])
    held = say(36.0, b"@ZAWF$"), *repeated(157.0, 163.0, 0.2, b"@MMF2$")
    sea = replace(staged.settings.sea, waves=settings.sea.waves)
    settings = replace(staged.settings, faults=settings.faults, sea=sea)
    plan = replace(staged, settings=settings, profile="as-built", incidents=(Drawn("", 0.0, held),))
    assert judged(plan) == []


@pytest.mark.parametrize("degrees", [70, 95, 105, 115, 125, 180])
def test_a_list_that_shifted_weight_holds_ends_a_mission_and_comes_up(degrees: int) -> None:
    plan = faulty("brown_out", f"listing={degrees}@60+1000000")
    assert judged(plan) == []
    with broken("limit roll-over"):  # farther over the heading's acts before the law has seen it
        seen = any("unanswered: roll passed" in says for says in judged(plan))
    assert seen is (degrees < 110)


def eased(plan: Plan) -> Plan:
    """Its stick is held beyond its range in the first half, as if at 12 of 12 and beyond."""
    said = [d for incident in plan.incidents for d in incident.disturbances]
    held = [d for d in said if d.data == b"@MMD6$"]
    beyond = {id(d) for d in held[: len(held) // 2]}
    incidents = (
        replace(
            incident,
            disturbances=tuple(
                replace(d, data=b"@MMD16$") if id(d) in beyond else d for d in incident.disturbances
            ),
        )
        for incident in plan.incidents
    )
    return replace(plan, incidents=tuple(incidents))


@pytest.mark.replaces
def test_a_stick_that_was_held_beyond_its_range_and_takes_over_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = eased(stage("held_stick", 0))
    assert judged(plan) == []
    monkeypatch.setattr(OperatorServer, "_refuse_unfit", lambda self, peer, unfit, now: None)
    assert any("unlawful: a stick heard" in says for says in judged(plan))


@pytest.mark.replaces
def test_a_status_that_tells_of_the_surface_below_it_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Situation, "_afloat", lambda self, now: True)
    (says,) = judged(stage("restarted_after_x", 0))
    assert says.startswith("unlawful: told to be at the surface ")


@pytest.mark.replaces
def test_a_surface_that_nobody_is_told_of_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = stage("heavy_when_surfaced", 0)
    assert judged(plan) == []
    monkeypatch.setattr(Situation, "owes_report", lambda self, now: False)
    assert judged(plan) == ["unlawful: at the surface, and nobody was told"]


@pytest.mark.parametrize(("began", "excused"), [(80.0, True), (90.0, False)])
def test_a_status_waits_where_the_surface_was_proved_by_a_receiver_that_is_stuck_by_now(
    began: float, excused: bool
) -> None:
    """As flight 17592 of seed 6020: the oldest of its four new places was 20.0 s old."""
    stuck = FaultEvent("gps_stuck", began)
    told = SimpleNamespace(faults=lambda *_: [stuck], faulty=lambda *_: True)
    assert _is_stuck(told, 100.0) is excused  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("joins", "excused"), [((105.0,), True), ((95.0,), False), ((92.0, 105.0), False), ((), True)]
)
def test_a_status_that_is_sent_before_the_boat_is_back_reaches_no_boat(
    joins: Sequence[float], excused: bool
) -> None:
    """As flight 18145 of seed 11732: a W by modem, and the boat connects half a second later."""
    begun = [Done(5.0, Act.JOIN), Done(86.0, Act.KILL), Done(91.0, Act.BOOT)]
    told = SimpleNamespace(
        done=[*begun, *(Done(t, Act.JOIN) for t in joins)],
        hindered=lambda *_: False,
        faults=lambda *_: [],
        faulty=lambda *_: False,
        reports=[],
    )
    stay = Stay(SURFACED, 100.0, 120.0, SURFACING, None)
    by_modem = [Tx(100.1, MODEM, b"@VS", "at the surface")]
    assert _is_alone(told, 100.0) is excused  # type: ignore[arg-type]
    assert bool(list(_is_told(told, stay, by_modem))) is not excused  # type: ignore[arg-type]


@pytest.mark.replaces
def test_what_has_sunk_in_idle_with_auto_closed_is_lost_where_a_restart_forgets_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """R7, at rest, and R13: a restart opens AUTO, and on the ground it does not sink any more."""
    plan = stage("restarted_with_auto_closed", 1)
    assert judged(plan) == []
    monkeypatch.setattr(engine, "under_way", lambda core: "")
    assert judged(plan) == ["lost: 29.8 m deep at the end, in idle/empty"]


@pytest.mark.parametrize("silent", [3.0, 7.0])
def test_a_program_that_ends_while_its_cable_is_out_brings_up_what_the_stick_has(
    silent: float,
) -> None:
    """Told to end so many seconds behind the last report, which was deep."""
    plan, out = stage("heavy_when_idle", 0), 60.0
    weight = [replace(f, begin=out) for f in plan.settings.faults if f.name == "heavy"]
    said = (
        say(DOWN, X),
        *repeated(DOWN + 3.0, out + 10.0, 0.5, b"@MMD2$"),
        Disturbance(out, Act.UNPLUG),
        Disturbance(out + silent, Act.END),
        Disturbance(out + 8.2, Act.PLUG),
    )
    settings = replace(plan.settings, faults=tuple(weight))
    plan = replace(plan, settings=settings, incidents=(Drawn(plan.scene, 0.0, said),))
    trace = fly_plan(plan, plan.vehicle)
    assert result_of(plan, trace, plan.vehicle, plan.profile).violations == ()
    (gone,) = (e.t for e in trace.events if isinstance(e, Done) and e.act is Act.LEAVE)
    up = next(e.t for e in trace.events if isinstance(e, Step) and SURFACED in e.entered)
    assert out + 10.0 < up < gone


CLEAR = b"@AC$"


@pytest.mark.parametrize(
    ("said", "state", "twice"),
    [
        ([(90.0, CLEAR)], STOPPED, True),
        ([(90.0, CLEAR)], SURFACED, True),
        ([(90.0, CLEAR)], SURFACING, False),
        ([(96.0, CLEAR)], STOPPED, False),
        ([(69.0, CLEAR)], STOPPED, False),
        ([(90.0, CLEAR), (92.0, X)], STOPPED, False),
        ([(88.0, X), (90.0, CLEAR)], STOPPED, True),
        ([(85.0, CLEAR), (86.0, X), (90.0, CLEAR)], STOPPED, True),
        ([], STOPPED, False),
    ],
)
def test_a_first_clear_counts_where_and_when_it_may_be_repeated_and_with_no_order_behind_it(
    said: Sequence[tuple[float, bytes]], state: str, twice: bool
) -> None:
    stay = Stay(state, 60.0, 100.0, "autonomous/out", None)
    told = SimpleNamespace(
        said=[Said(t, MODEM if t < 88.0 else TOPSIDE, "", data) for t, data in said],
        stays=[stay],
        stay_at=lambda t: stay,
    )
    assert _is_asked_twice(told, 100.0) is twice  # type: ignore[arg-type]


@pytest.mark.parametrize(("depth", "untold"), [(3.7, True), (5.0, False)])
def test_a_depth_that_died_near_the_surface_is_not_told_from_one_that_rose(
    depth: float, untold: bool
) -> None:
    """As flight 3396 of seed 6020: 3.8 m by one report, 0 by the next, and cleared by that."""
    dead = FaultEvent("depth_dead", 90.0)
    told = SimpleNamespace(faults=lambda *_: [dead], depth=lambda t: depth)
    assert _died_near(told, 100.0) is untold  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("depth", "turns", "untold"),
    [
        (0.4, (), True),
        (3.7, (), False),
        (0.4, (82.0, 84.0, 86.0, 88.0), True),
        (0.4, (82.0, 84.0, 86.0, 88.0, 90.0), False),
        (0.4, (70.0, 72.0, 74.0, 76.0, 78.0), True),
    ],
)
def test_a_depth_that_froze_near_the_surface_is_not_told_while_no_thruster_turns(
    depth: float, turns: Sequence[float], untold: bool
) -> None:
    """As flight 1985 of seed 11025: killed and deaf to U12 with a depth that said 0.48 m."""
    frozen, on, off = FaultEvent("depth_frozen", 60.0), (1800.0,) * 5, (1500.0,) * 5
    said = [Report(t, 0.0, 0.0, 0.0, 0.4, on if t in turns else off) for t in range(62, 100, 2)]
    told = SimpleNamespace(
        faults=lambda *_: [frozen],
        depth=lambda t: depth,
        done=[Done(81.0, Act.BOOT)],
        reports=said,
    )
    assert _froze_near(told, 100.0) is untold  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("places", "booted", "depth", "lawful"),
    [
        ({75: 1}, None, 1.1, True),
        ({75: 1}, None, 1.3, False),
        ({73: 1}, None, 1.1, True),
        ({69: 1}, None, 1.1, False),
        ({75: None}, None, 1.1, False),
        ({5: 1, 6: 2, 75: 2}, None, 1.1, False),
        ({5: 1, 6: 2, 75: 2}, 50.6, 1.1, True),
        ({5: 1, 6: 2, 75: 2}, 75.1, 1.1, False),
        ({60: 1, 75: 1}, 50.6, 1.1, False),
        ({71: 1, 75: 1}, 50.6, 1.1, False),
        ({68: 1, 69: 2, 74: 2, 75: 1}, 50.6, 1.1, False),
        ({68: 1, 69: 2, 74: 1, 75: 3}, 50.6, 1.1, True),
    ],
)
def test_a_place_that_the_program_was_not_given_before_proves_the_surface(
    places: Mapping[int, int | None], booted: float | None, depth: float, lawful: bool
) -> None:
    """As flight 6897 of seed 13146: killed in a leg, and an old place comes as the vehicle comes
    up. ``places``: at which degree, by time."""
    events: list[Done | Located] = [] if booted is None else [Done(booted, Act.BOOT)]
    for t, degree in places.items():
        at = None if degree is None else math.radians(degree)
        utc = START + timedelta(seconds=t)
        events.append(Located(t, GPS, encode_gga(utc, at, at) + encode_rmc(utc, at, at)))
    told = SimpleNamespace(
        trial=SimpleNamespace(events=sorted(events, key=lambda event: event.t)),
        deepest=lambda *_: 2.0,
        depth=lambda t: depth if t > 72.0 else 3.0,
        faulty=lambda *_: False,
        told_in=lambda *_: [None],
        settings=Settings(),
        profile="documented",
    )
    stay = Stay(SURFACED, 75.3, 90.0, SURFACING, None)
    assert bool(list(_is_at_surface(told, stay))) is not lawful  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("degrees", "seen", "broken"), [(92, 6, False), (92, 7, True), (110, 5, True), (75, 5, True)]
)
def test_a_roll_of_ninety_degrees_may_take_six_reports(
    degrees: float, seen: int, broken: bool
) -> None:
    """As flight 17083 of seed 11126: 105, 91, 89, 93, 91 and 90 degrees, and then it acted."""
    stay = Stay("autonomous/third/fix", 0.0, 100.0, "", None)
    told = SimpleNamespace(
        samples_in=lambda *_: [SimpleNamespace(t=2.0 * i) for i in range(seen)],
        tilt=lambda t: math.radians(degrees),
        vehicle=SimpleNamespace(limits=SimpleNamespace(roll=math.radians(60.0))),
        hindered=lambda *_: False,
        faulty=lambda *_: False,
    )
    assert bool(list(_by_report(told, [stay], _BY_REPORT[1]))) is broken  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("busy", "stopped", "tries", "missed"),
    [
        (0.89, 144.29, (0.12, 0.42, 0.72), True),
        (0.5, 144.29, (0.12, 0.42, 0.72), False),
        (0.89, 144.29, (), False),
        (0.89, 140.0, (0.12, 0.42, 0.72), False),
        (0.89, 149.69, (0.12, 0.42, 0.72), False),
    ],
)
def test_a_board_that_is_busy_with_a_stop_lets_what_is_held_up_sink_until_u12_is_repeated(
    busy: float, stopped: float, tries: Sequence[float], missed: bool
) -> None:
    """As flight 8129 of seed 11631: full thrust had another turn as the surface was proved."""
    words = [Tx(stopped, VEHICLE, b"@ZAX0$", "")]
    words += [Tx(stopped + t, VEHICLE, b"@ZAU12$", "") for t in tries]
    told = SimpleNamespace(
        faults=lambda *_: [FaultEvent("busy", 46.4, 1e6, busy)],
        words_in=lambda begin, end: [word for word in words if begin <= word.t <= end],
    )
    assert _misses_its_lift(told, 149.69) is missed  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("roll", "pitch", "missing"),
    [
        (115.0, 0.0, ["@ZAU12$"]),
        (121.0, 0.0, []),  # upside down by R7: U12, which led deeper, is not tried again
        (-121.0, 0.0, []),
        (121.0, 40.0, []),  # 113 degrees from upright
        (129.0, 0.0, []),
        (140.0, 0.0, ["@ZAD12$"]),
    ],
)
def test_beyond_120_degrees_no_way_is_missed_and_beyond_130_a_push_down_is(
    roll: float, pitch: float, missing: list[str]
) -> None:
    place = SimpleNamespace(roll=math.radians(roll), pitch=math.radians(pitch))
    words = [Tx(5.0, VEHICLE, b"@ZAWF$", ""), Tx(20.0, VEHICLE, b"@ZAX0$", "")]
    told = SimpleNamespace(
        trial=SimpleNamespace(track=(place,)),
        upward=(b"@ZAWF$", b"@ZAU12$"),
        words_in=lambda begin, end: [word for word in words if begin <= word.t <= end],
        told_in=lambda *_: range(10),
        faulty=lambda *_: False,
    )
    told.tilt, told.heel = (partial(each, told) for each in (Story.tilt, Story.heel))
    assert _missing(told, 0.0, 150.0) == missing  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("state", "closed", "most"),
    [(SURFACED, False, 1.5), (SURFACED, True, 2.5), (STOPPED, False, 2.5)],
)
def test_an_end_leaves_nothing_that_would_be_brought_up(
    state: str, closed: bool, most: float
) -> None:
    """As flight 8887 of seed 6323: its operator had closed AUTO, and it sank as 30 s were over."""
    stay = Stay(state, 60.0, 100.0, SURFACING, None)
    told = SimpleNamespace(stay_at=lambda t: stay, auto_closed=lambda *_: closed)
    assert _allowed(told, 90.0) == most  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("last", "hindered", "broken"),
    [(95.0, False, False), (98.0, False, True), (98.0, True, False), (94.0, False, False)],
)
def test_a_vehicle_is_told_up_by_its_last_report_until_that_is_stale(
    last: float, hindered: bool, broken: bool
) -> None:
    """As flight 14167 of seed 6424: 0.5 m deep by the last report, and its board silent since."""
    told = SimpleNamespace(
        stay_at=lambda t: SimpleNamespace(state=STOPPED),
        told_in=lambda begin, end: [last] if begin <= last <= end else [],
        hindered=lambda begin, end: hindered,
        depth=lambda t: max(t - 95.5, 0.5),
        settings=Settings(),
        profile="documented",
        faulty=lambda *_: False,
    )
    assert bool(list(_is_told_up(told, 100.0))) is broken  # type: ignore[arg-type]


@pytest.mark.parametrize("steered", [(), (6.0,), (2.0, 4.0, 6.0)])
def test_a_report_that_turns_the_heading_counts_for_the_depth(steered: tuple[float, ...]) -> None:
    """As flight 12994 of seed 5919: 4.87 m was half a metre nearer, and turned the vehicle too."""
    depths = {2.0: 4.21, 4.0: 4.30, 6.0: 4.87, 8.0: 5.30, 10.0: 5.25, 12.0: 5.38}
    reports = [Report(t, 0.0, 0.0, 0.0, depth, ()) for t, depth in depths.items()]
    begins = (0.0, *steered)
    turns = [Setpoint(surge=1.0, heading=0.1 * i, depth=8.0) for i in range(len(begins))]
    sets = list(zip(begins, (*begins[1:], 100.0), turns, strict=True))
    assert list(waits(sets, reports))[-1] == (12.0, 12.0, 8.0)


@pytest.mark.parametrize(
    ("scene", "seed", "sets"),
    [
        *[("loose_compass", seed, ["waves=0.7@3.8"]) for seed in (5, 9)],
        *[("heavy_when_surfaced", seed, ["waves=0.75@8.6", "depth_bias=0.2"]) for seed in (3, 16)],
    ],
)
def test_fixes_that_waves_hide_and_show_are_no_fault_of_the_program(
    scene: str, seed: int, sets: list[str]
) -> None:
    """R5, R7: what nobody can tell counts neither way, and a trough uncovers what is still deep."""
    plan = stage(scene, seed)
    settings = parse_settings(sets, plan.settings)
    assert judged(replace(plan, settings=settings, profile="documented")) == []


@pytest.mark.parametrize("letters", ["OOOOOOO", "OOCOOOO"])
def test_a_receiver_that_an_operator_has_switched_off_tells_no_drift(letters: str) -> None:
    """As flight 3794 of seed 11328: 917 m from home, where it had drifted for 55 min without a fix;
    its estimate was 10 m behind. A receiver that is on brings the drift back to that of its fixes.
    """
    drifts = []
    for t in range(400):
        north, east = moved(0.0, 0.0, 0.3 * t, 0.0)
        drifts.append(
            SimpleNamespace(
                t=float(t),
                latitude=north,
                longitude=east,
                depth=0.2,
                speed=0.0,
                current=(0.3, 0.0),
            )
        )
    switched = Tx(10.0, VEHICLE, b"@RS%b$" % letters.encode(), "relay of @RS for topside")
    trace = SimpleNamespace(events=(switched,), track=drifts, truth=drifts[-1], home=(0.0, 0.0))
    flown = [Span(0.0, 400.0, "autonomous/up", Bounds(50.0, 900.0, 10.0, 10.0), 0.0)]
    found = list(_ranges(trace, flown, Settings(), True))  # type: ignore[arg-type]
    assert bool(found) is (letters == "OOOOOOO")


@pytest.mark.parametrize(
    ("word", "apart", "unanswered"),
    [(b"@ZAF8$", 50.0, True), (b"@ZAF8$", 61.0, False), (b"@ZAWF$", 50.0, False)],
)
def test_a_w_belongs_to_no_set_whose_words_are_counted(
    word: bytes, apart: float, unanswered: bool
) -> None:
    """As flight 5307 of seed 12237: without a depth, an ascent tried its ways each minute."""
    words, answers = [], []
    for at in (10.0 + apart * i for i in range(6)):
        words += [
            *(Tx(at + 0.3 * i, VEHICLE, word, f"set (try {i + 1} of 3)") for i in range(3)),
            Tx(at + 10.0, VEHICLE, b"@ZAU12$", "the next way"),
        ]
        answers.append(Heard(at + 10.1, b"@ACK_ZAY$"))
    told = SimpleNamespace(
        board=None,
        heard=answers,
        words_in=lambda begin, end: words,
        deepest=lambda begin, end: 0.2,
        hindered=lambda begin, end: False,
    )
    assert bool(list(_one_unanswered(told, 0.0, 400.0))) is unanswered  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("shows", "said", "unanswered"),
    [
        (True, [(20.0, "everything stopped: off")], True),
        (False, [(20.0, "emergency surfacing: up")], True),
        (False, [(20.0, "everything stopped: off")], False),
        (False, [(20.0, "emergency surfacing: up"), (62.0, "everything stopped: off")], False),
        (False, [(20.0, "everything stopped: off"), (59.0, "surge 1 depth 6: on")], True),
        (False, [(20.0, "surge 1 depth 6: on"), (81.0, "everything stopped: off")], True),
        (False, [(20.0, "surge 1 depth 6: on"), (70.0, "output led1 0: off")], True),
    ],
)
def test_a_depth_that_froze_is_not_told_while_thrusters_that_are_not_shown_are_stopped(
    shows: bool, said: Sequence[tuple[float, str]], unanswered: bool
) -> None:
    """As flight 79 of the main board's seed 301: it froze in the turn that lets go, 8 m deep."""
    thrust = (1800.0,) * 5 if shows else ()
    told = SimpleNamespace(
        settings=Settings(faults=(FaultEvent("depth_frozen", 60.0, 30.0),)),
        profile="documented",
        depth=lambda t: 8.0,
        faults=lambda names, begin, end: ["it alone"],
        told_in=lambda begin, end: range(20),
        reports=[Report(t, 0.0, 0.0, 0.0, 8.0, thrust) for t in range(0, 100, 2)],
        steps=[SimpleNamespace(t=t, actions=(words,)) for t, words in said],
        hindered=lambda begin, end: False,
    )
    assert bool(list(_blind(told, 40.0, 100.0))) is unanswered  # type: ignore[arg-type]
