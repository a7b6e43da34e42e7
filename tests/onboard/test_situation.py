"""@AE: what the runtime tells of itself is what it is, in every state, with true ages (R4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from links.base import Rx
from links.simulated.boards import SimulatedBoard
from links.simulated.link import START, SimulatedVehicle
from mission.analysis.replay.replay import replay
from mission.authoring.language import parse, script
from mission.engine.engine import Engine, Input
from mission.model import Step, Tx
from mission.model.alarms import ALARMS, alarms_of
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.records import ListRecorder
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.runtime.situation import TREND_EVERY_S, Situation
from mission.onboard.serve.health import of_drive
from mission.onboard.serve.view import view
from mission.onboard.store import MemoryStore, Stored
from protocol.messages import Emergency, Fix, Order, StateReport, Telemetry
from protocol.state_frame import MOST
from protocol.topside import ConsoleCodec

TEXT = """\
mission pool vehicle auv
safety radius 200 time 5min depth 5
start without fix
deep: depth 2 heading 0 gear 4 for 20
"""
VEHICLE = replace(load_vehicle("auv"), dialect="documented")


class Pi:
    """A runtime with a simulated vehicle on its line; ``unplugged``: nothing comes from there."""

    def __init__(self, text: str = TEXT, gps: bool = False) -> None:
        self.sea, self.now, self.unplugged = SimulatedVehicle("documented", 1), 0.0, False
        self.recorder, store = ListRecorder(), MemoryStore(Stored(tuple(script(parse(text)))))
        links = replace(Configuration().links, gps="memory:" if gps else None)
        configuration = replace(Configuration(), links=links)
        self.runtime = Runtime(configuration, VEHICLE, store, self.recorder, wall=START.timestamp())
        self.runtime.set_navigation(self.runtime.make_navigation(), 0.0)
        for link, name in (("topside", "boat"), ("topside", "other"), ("modem", "")):
            self.runtime.connected(link, name, 0.0)

    def say(self, data: bytes, who: str = "boat") -> list[bytes]:
        out = self.runtime.receive(Rx(self.now, "topside", data, who))
        self.leave(out)
        return [tx.data for tx in out if tx.link == "topside" and tx.address == who]

    def leave(self, out: list[Tx]) -> None:
        for tx in out:
            if tx.link == "vehicle" and not self.unplugged:
                self.sea.vehicle_link.send(tx.data, self.now)

    def until(self, end: float) -> None:
        link = self.sea.vehicle_link
        while True:
            due = min(t for t in (link.next_event(), self.runtime.next_timer()) if t is not None)
            if due > end:
                self.now = end
                return
            self.now = max(self.now, due)
            for rx in link.receive(self.now):
                if not self.unplugged:
                    self.leave(self.runtime.receive(rx, self.now))
            self.leave(self.runtime.handle_timer(self.now))

    def told(self, who: str = "boat") -> StateReport:
        (raw,) = self.say(b"@AE$", who)
        assert len(raw) <= MOST
        (report,) = ConsoleCodec().receive(raw, 0.0)
        assert isinstance(report, StateReport)
        return report

    def alarms(self) -> set[str]:
        return {alarm.name for alarm in alarms_of(self.told().alarms)}


STATES = [
    ([], "idle/ready", ""),
    ([b"@AC$"], "idle/empty", ""),
    ([b"@AA$"], "autonomous", "F33%H0S2"),
    ([b"@MMF5$"], "manual/driving", "M"),
    ([b"@ZAX0$"], "emergency/stopped", "X"),
    ([b"@AA$", b"@ZAX0$"], "emergency/stopped", "X"),
    ([b"@ZAWF$"], "emergency/surfacing", "W"),
]


@pytest.mark.parametrize(("words", "state", "setpoint"), STATES)
def test_in_every_state_the_boat_is_told_the_pis_own(
    words: list[bytes], state: str, setpoint: str
) -> None:
    pi = Pi()
    pi.until(4.0)
    for word in words:
        pi.say(word)
    told = pi.told()
    assert pi.runtime.state.startswith(state)
    assert told.state == state
    assert told.setpoint == setpoint
    assert told.leg == ("deep" if state == "autonomous" else "")
    assert ("emergency" in pi.alarms()) == state.startswith("emergency")


def test_a_stick_that_was_let_go_and_an_ascent_that_is_over_are_told_too() -> None:
    pi = Pi()
    pi.until(4.0)
    pi.say(b"@MMF5$")
    pi.until(7.0)
    assert (pi.told().state, pi.told().setpoint) == ("manual/waiting", "X")
    pi.say(b"@ZAWF$")
    pi.until(30.0)
    assert (pi.told().state, pi.told().setpoint) == ("emergency/surfaced", "X")


def test_an_age_grows_while_nothing_comes_and_is_told_as_an_alarm() -> None:
    pi = Pi()
    assert pi.told().report_age is None
    assert pi.alarms() == set(), "nothing is due yet"
    pi.until(4.0)
    assert pi.told().report_age == pytest.approx(0.0, abs=1.0)
    pi.unplugged = True
    pi.until(40.0)
    assert pi.told().report_age == pytest.approx(37.0, abs=1.5)
    assert "old report" in pi.alarms()


def test_a_board_that_was_never_heard_is_an_alarm() -> None:
    pi = Pi()
    pi.unplugged = True
    pi.until(20.0)
    assert pi.told().report_age is None
    assert pi.alarms() == {"old report"}


def test_who_commands_is_told_as_the_asker_sees_it() -> None:
    pi = Pi()
    pi.until(4.0)
    assert pi.told().commander == "nobody"
    pi.say(b"@AA$")
    assert pi.told().commander == "asker"
    assert pi.told("other").commander == "network"


def test_who_has_said_no_frame_for_10_s_is_told_as_no_commander() -> None:
    pi = Pi()
    pi.until(4.0)
    pi.say(b"@AA$")
    pi.until(13.5)
    assert pi.told("other").commander == "network"
    pi.until(14.5)
    assert pi.told("other").commander == "nobody"
    assert pi.told().commander == "asker", "whose question is a frame"


def test_what_is_left_to_the_limits_is_told() -> None:
    pi = Pi()
    pi.until(4.0)
    assert pi.told().to_time is None
    pi.say(b"@AA$")
    pi.until(20.0)
    told, depth = pi.told(), pi.runtime.engine.depth
    assert depth is not None
    assert told.to_depth_m == pytest.approx(5.0 - depth, abs=0.5)
    assert told.to_time == pytest.approx(5.0 - 16.0 / 60.0, abs=0.5)


def test_a_refusal_is_an_alarm_for_two_minutes() -> None:
    pi = Pi()
    pi.until(4.0)
    pi.say(b"@AC$")
    pi.say(b"@AA$")
    assert pi.alarms() == {"refused"}
    pi.until(130.0)
    assert pi.alarms() == set()


def test_an_operator_who_only_asks_takes_nothing_and_moves_nothing() -> None:
    pi = Pi()
    pi.until(4.0)
    pi.say(b"@AA$", "other")
    before = pi.runtime.state
    for _ in range(5):
        pi.told()
    assert pi.runtime.commander.peer is not None
    assert pi.runtime.commander.peer.address == "other"
    assert pi.runtime.state == before


def test_at_the_surface_without_a_fix_for_a_minute_is_an_alarm_where_there_is_a_receiver() -> None:
    for gps, wanted in ((True, {"no fix"}), (False, set())):
        pi = Pi(gps=gps)
        pi.until(58.0)
        assert pi.alarms() == set()
        pi.until(70.0)
        assert pi.alarms() == wanted


def test_an_ascent_that_believes_no_depth_says_after_a_while_that_it_pushes_on() -> None:
    for unplugged in (True, False):
        pi = Pi()
        pi.until(4.0)
        pi.unplugged = unplugged
        pi.say(b"@ZAWF$")
        pi.until(123.0)
        assert "surface unproved" not in pi.alarms()
        pi.until(125.0)
        assert ("surface unproved" in pi.alarms()) is unplugged
    assert pi.runtime.state == "emergency/surfaced", "by its depth"


def test_a_battery_that_falls_to_its_limit_is_an_alarm_in_time() -> None:
    pi = Pi()
    vehicle = replace(VEHICLE, constant_batteries=False)
    bound = pi.runtime.engine.bounds.voltage
    for fall, alarmed in ((0.002, True), (0.0001, False), (-0.01, False)):
        situation = Situation(pi.runtime.engine, vehicle, False)
        for step in range(60):
            t = step * TREND_EVERY_S
            situation.report(Telemetry(t, depth=0.0, batteries=(bound + 2.0 - fall * t, 48.0)))
        left = situation.condition("", 0.0, 600.0).battery_runs_out
        words = ALARMS["battery"].judge(situation.condition("", 0.0, 600.0))
        assert bool(words) == alarmed
        if fall > 0:
            assert left == pytest.approx(2.0 / fall - 590.0, rel=0.01)


def told_at(depths: Sequence[float | None], fixes: range, *, stuck: bool = False) -> list[float]:
    """When the one @VS leaves that nobody asked for (R11); a report a second, and an X at 10 s."""
    engine = Engine(VEHICLE)
    situation, told = Situation(engine, VEHICLE, True), []
    for second, depth in enumerate(depths):
        t = float(second)
        inputs: list[Input] = [Telemetry(t, depth=depth)]
        situation.report(Telemetry(t, depth=depth))
        if second in fixes:
            place = Fix(t, 0.5 if stuck else 0.5 + 1e-8 * t, 2.0, 1.5)
            situation.take_fix(place)
            inputs.append(place)
        if second == 10:
            inputs.append(Emergency(Order.STOP))
        for step in engine.step(t, inputs).steps:
            situation.note(step)
        if situation.owes_report(t):
            told.append(t)
    return told


UP_AT_20 = [0.2] * 9 + [0.7 + 0.2 * i for i in range(6)] + [1.7 - 0.25 * i for i in range(6)]


@pytest.mark.parametrize(
    ("depths", "fixes", "stuck", "told"),
    [
        (UP_AT_20, range(9), False, [20.0]),  # the last fix is of just before it dived
        (UP_AT_20, range(40), True, [20.0]),
        ([0.2] * 9 + [3.0] * 15, range(40), True, []),
        ([0.2] * 9 + [0.7] * 15, range(12, 40), False, [12.0]),  # a zero that is a little off
        ([0.2] * 9 + [None] * 15, range(15, 40), False, [20.0]),  # where no depth is believed
        ([0.2] * 9 + [None] * 15, range(40), True, []),
        ([0.2] * 9 + [None] * 15, range(15, 18), False, []),
    ],
)
def test_the_status_that_nobody_asked_for_leaves_at_the_surface_as_the_engine_knows_it(
    depths: list[float | None], fixes: range, stuck: bool, told: list[float]
) -> None:
    assert told_at(depths, fixes, stuck=stuck) == told


@pytest.mark.parametrize(
    ("entered", "owed"),
    [("autonomous/a", True), ("emergency/surfacing", True), ("manual/driving", False)],
)
def test_what_was_in_a_mission_or_an_emergency_owes_its_status_once(
    entered: str, owed: bool
) -> None:
    """R11: a mission that has ended by itself, too."""
    engine = Engine(VEHICLE)
    situation = Situation(engine, VEHICLE, True)
    situation.note(Step(1.0, "start", (), (), (entered,), ()))
    for t in (2.0, 4.0):
        engine.step(t, (Telemetry(t, depth=0.2),))
        situation.report(Telemetry(t, depth=0.2))
        assert situation.owes_report(t) is (owed and t == 2.0)


def located(gps: bool, *reports: Telemetry, fix: Fix | None = None) -> Situation:
    """As the runtime knows it after these."""
    engine = Pi().runtime.engine
    situation = Situation(engine, load_vehicle("coreboard"), gps)
    if fix is not None:
        situation.take_fix(fix)
    for report in reports:
        situation.report(report)
        engine.step(report.t, (report,))
        situation.locate()
    return situation


def test_the_boat_is_told_the_place_that_a_vehicle_knows_by_itself_as_it_was_at_the_surface() -> (
    None
):
    deep = Telemetry(1.0, depth=1.5, position=(0.5, 2.0))
    assert located(False, deep).shown is None
    shallow = Telemetry(2.0, depth=0.2, position=(0.6, 2.1))
    below = Telemetry(4.0, depth=3.0, position=(0.7, 2.2))
    situation = located(False, deep, shallow, Telemetry(3.0, depth=0.2), below)
    shown = situation.shown
    assert shown is not None
    assert (shown.t, shown.latitude, shown.longitude) == (2.0, 0.6, 2.1)
    assert situation.fix_age(9.0) == 7.0
    assert situation.fix is None, "it proves no surface"


@pytest.mark.parametrize(("gps", "gps2"), [(None, None), ("memory:", None), (None, "memory:")])
def test_afloat_without_a_receiver_the_pi_tells_where_its_board_says_it_is(
    gps: str | None, gps2: str | None
) -> None:
    board, links = SimulatedBoard("coreboard", 1), Configuration().links
    links = replace(links, gps=gps, gps2=gps2)
    configuration, vehicle = replace(Configuration(), links=links), load_vehicle("coreboard")
    runtime = Runtime(configuration, vehicle, MemoryStore(Stored()))
    for now in (0.1 * tick for tick in range(100)):
        for rx in board.vehicle_link.receive(now):
            for tx in runtime.receive(rx, now):
                board.vehicle_link.send(tx.data, now)
        for tx in runtime.handle_timer(now):
            board.vehicle_link.send(tx.data, now)
    assert (runtime.status(10.0).fix is None) is bool(gps or gps2)
    fixed, told = view(runtime, ())["fix_at"], runtime.situation.fix_age(10.0)
    assert (fixed is None) is (told is None) is bool(gps or gps2)
    assert fixed is None or 10.0 - fixed == pytest.approx(told, abs=0.01), "viewers see the same"


def test_by_a_depth_that_is_not_believed_a_vehicle_is_at_no_surface() -> None:
    jumped = Telemetry(2.0, depth=0.2, position=(0.6, 2.1))
    assert located(False, Telemetry(1.0, depth=30.0), jumped).shown is None


def test_with_a_receiver_the_vehicles_own_place_is_told_as_no_fix_however_old_the_last_is() -> None:
    fix, own = Fix(1.0, 0.5, 2.0, 3.0), Telemetry(1800.0, depth=0.2, position=(0.6, 2.1))
    situation = located(True, own, fix=fix)
    assert situation.shown is fix
    assert situation.fix_age(1801.0) == 1800.0
    assert located(True, own).shown is None
    assert located(True, own).fix_age(1801.0) is None


def test_what_serve_alone_sees_is_told_and_replayed_to_the_bit() -> None:
    pi = Pi()
    pi.until(4.0)
    pi.leave(pi.runtime.take_alarms(("disk", "link away"), pi.now))
    assert pi.alarms() == {"disk", "link away"}
    pi.leave(pi.runtime.take_alarms((), pi.now))
    assert pi.alarms() == set()
    pi.say(b"@AA$")
    pi.until(10.0)
    pi.told()
    assert replay(pi.recorder.records).identical


def test_on_the_pi_what_a_silent_vehicle_said_grows_old_and_no_margin_is_told_of_it() -> None:
    pi = Pi(gps=True)
    pi.until(9.0)
    for rx in pi.sea.gps_link.receive(pi.now):
        pi.runtime.receive(rx, pi.now)
    pi.until(10.0)
    new = of_drive(pi.runtime, VEHICLE, pi.now)
    assert new["sensors"]["depth"].why == ""
    assert new["sensors"]["depth"].age_s <= 2.0
    assert new["margins"]["depth"].left is not None
    told_at = pi.now - new["sensors"]["depth"].age_s
    old = of_drive(pi.runtime, VEHICLE, told_at + VEHICLE.stale_after + 0.1)
    for name in ("depth", "heading", "battery"):
        assert old["sensors"][name].why == "stale"
        assert old["sensors"][name].age_s == pytest.approx(VEHICLE.stale_after + 0.1)
        assert old["sensors"][name].value == new["sensors"][name].value
    assert old["margins"]["depth"].left is None
    later = old["sensors"]["fix_age"].value - new["sensors"]["fix_age"].value
    assert later == pytest.approx(told_at + VEHICLE.stale_after + 0.1 - pi.now)


def test_where_it_takes_itself_to_be_is_less_sure_the_longer_the_board_is_silent() -> None:
    """Stopped and afloat no timer is due: the engine's own estimate is then of its last step."""
    pi = Pi(gps=True)
    pi.until(9.0)
    for rx in pi.sea.gps_link.receive(pi.now):
        pi.runtime.receive(rx, pi.now)
    pi.until(10.0)
    sure, seen = pi.told(), view(pi.runtime, (), pi.now)
    health = of_drive(pi.runtime, VEHICLE, pi.now)
    pi.unplugged, pi.now = True, pi.now + 188.0
    late, after = pi.told(), view(pi.runtime, (), pi.now)
    assert late.uncertainty_m is not None
    assert sure.uncertainty_m is not None
    assert late.uncertainty_m > sure.uncertainty_m + 5
    assert after["ellipse"][0] > seen["ellipse"][0] + 5.0
    grown = of_drive(pi.runtime, VEHICLE, pi.now)["sensors"]["uncertainty"].value
    assert grown > health["sensors"]["uncertainty"].value + 5.0
    assert grown == pytest.approx(after["ellipse"][0], abs=0.1)
    assert replay(pi.recorder.records).identical
