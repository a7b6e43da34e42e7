"""The vehicles of documents 002, 003 and 004 fly missions end to end, over their own bytes.

Operator -- @AW @AA --> Drive -- frames every period --> board -- thrusters --> plant, or ground
                              <-------- reports --------
"""

from __future__ import annotations

import functools
import itertools
import math
from pathlib import Path

import pytest

from mission.authoring.language import parse, script
from mission.authoring.prepare import Prepared, Unreadable, prepare, prepare_text
from mission.engine.engine import Engine
from mission.engine.vehicle_state import VehicleState
from mission.engine.watch import Descent
from mission.model import Health, Position, Vertical
from mission.model.shipped import load_vehicle
from mission.navigation import Navigation
from mission.onboard.store import Stored
from mission.verification.exhaustive.world import World
from mission.verification.rig.rehearsal import Cue
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight
from protocol.messages import Order, Setpoint, Telemetry
from protocol.vehicles import codec, link

CORE = """mission core-dive vehicle coreboard
home 30.2874595 120.1535765
safety radius 500 time 20min depth 20 voltage 12
assume current 0.1
dive: depth 4 heading 90 gear 6 until depth >= 3.7 timeout 90s
hold: depth 4 heading 180 gear 4 for 30s
up: surface until fix timeout 3min
"""
ROV = """mission rov-dive vehicle rov
safety time 20min depth 20
assume current 0
start without fix
dive: down 9 until depth >= 3 timeout 30s
stay: down 5 for 10s
ahead: gear 4 down 5 for 5s
up: surface timeout 3min
"""
ROBOT = """mission robot-drive vehicle robot
safety time 20min
assume start 0
start without fix
out: gear 6 for 10s
spin: stop right 6 for 2s
back: gear 6 for 10s
"""
LEGS = {
    "coreboard": [("dive", "until"), ("hold", "for"), ("up", "end"), ("surface", "end")],
    "rov": [
        ("dive", "until"),
        ("stay", "for"),
        ("ahead", "for"),
        ("up", "end"),
        ("surface", "end"),
    ],
    "robot": [("out", "for"), ("spin", "for"), ("back", "for"), ("surface", "end")],
}
TEXTS = {"coreboard": CORE, "rov": ROV, "robot": ROBOT}
DOWN = {"coreboard": "coreboard.pc_to_main", "rov": "rov.down", "robot": "robot.down"}


def prepared(folder: Path, text: str) -> Prepared:
    path = folder / "mission.mission"
    path.write_text(text, encoding="utf-8")
    return prepare(path)


@functools.cache
def flown(name: str, *said: Cue) -> Flight:
    """Looked at by several tests, changed by none."""
    ready = prepare_text(TEXTS[name], name)
    return fly(ready.mission, ready.vehicle, seed=3, said=said)


@pytest.mark.proof
@pytest.mark.parametrize("name", TEXTS)
def test_a_suitable_mission_is_flown_to_its_end_at_the_surface(name: str) -> None:
    flight = flown(name)
    assert flight.outcome == "completed", flight.reason
    assert [(leg.name, leg.by) for leg in flight.legs] == LEGS[name]
    assert flight.final_state == "idle/ready"
    assert flight.at_surface
    assert (3.0 < flight.max_depth < 6.0) is (name != "robot")


def test_the_core_board_is_where_it_was_sent() -> None:
    flight = flown("coreboard")
    hold = next(leg for leg in flight.legs if leg.name == "hold")
    entered = flight.mission_time - hold.entered
    end = flight.track[-1].t
    held = [p for p in flight.track if end - entered + 12 < p.t < end - entered + 28]
    assert all(abs(p.depth - 4.0) < 0.3 for p in held)
    assert held[-1].north < held[0].north - 3.0  # south, as heading 180 says
    assert abs(held[-1].east - held[0].east) < 3.0


HOMEWARD = """mission core-home vehicle coreboard
home 30.2874595 120.1535765
safety radius 500 time 20min depth 20 voltage 12
assume current 0.1
dive: depth 3 heading 90 gear 6 until depth >= 2.7 timeout 60s
east: depth 3 heading 90 gear 8 until travelled >= 30 timeout 90s
back: goto home gear 8 depth 3 within 10 timeout 2min
up: surface until fix timeout 3min
"""


@pytest.mark.proof
def test_a_board_that_tells_no_thrust_still_knows_its_way_by_what_it_was_told(
    tmp_path: Path,
) -> None:
    ready = prepared(tmp_path, HOMEWARD)
    flight = fly(ready.mission, ready.vehicle, seed=3)
    assert [(leg.name, leg.by) for leg in flight.legs][:3] == [
        ("dive", "until"), ("east", "until"), ("back", "end")
    ]  # fmt: skip
    east = next(s for s in flight.samples if s.t >= flight.legs[1].left)
    assert 30.0 < east.true.east < 60.0
    for sample in flight.samples:
        north, _, other = sample.estimate.covariance
        assert sample.error < 3.0 * math.sqrt(north + other) + 3.0


def test_the_robot_drives_out_turns_and_drives_on() -> None:
    flight = flown("robot")
    assert max(p.north for p in flight.track) == pytest.approx(5.0, abs=0.3)
    assert max(p.east for p in flight.track) == pytest.approx(5.0, abs=0.3)  # after a right angle


@pytest.mark.parametrize("name", TEXTS)
def test_what_holds_is_said_every_period_in_whole_good_frames(name: str) -> None:
    flight = flown(name)
    sent = [tx for tx in flight.sent if tx.link == "vehicle"]
    framer = link(DOWN[name]).framer()
    assert all(len(framer.receive(tx.data, tx.t)) == 1 for tx in sent)
    assert framer.next_timer() is None
    vehicle = load_vehicle(name)
    period = codec(name, vehicle.dialect, {}).period  # type: ignore[attr-defined]
    gaps = [b.t - a.t for a, b in itertools.pairwise(sent)]
    assert max(gaps) <= period + 1e-6
    assert all(tx.reason for tx in sent)


@pytest.mark.parametrize("name", TEXTS)
def test_surfacing_by_the_operator_ends_at_the_surface_or_where_it_stands(name: str) -> None:
    flight = flown(name, Cue(9.0, b"@ZAWF$"))
    assert flight.outcome == "emergency"
    assert flight.final_state == "emergency/surfaced"
    assert flight.at_surface
    last = [tx.data for tx in flight.sent if tx.link == "vehicle"][-1]
    vehicle = load_vehicle(name)
    assert last == codec(name, vehicle.dialect, {}).encode(Order.STOP)[-1]


@pytest.mark.parametrize("name", TEXTS)
def test_a_stop_by_the_operator_is_said_until_the_end(name: str) -> None:
    flight = flown(name, Cue(5.0, b"@ZAX0$"))
    assert flight.final_state == "emergency/stopped"
    vehicle = load_vehicle(name)
    stop = codec(name, vehicle.dialect, {}).encode(Order.STOP)[-1]
    sent = [tx for tx in flight.sent if tx.link == "vehicle"]
    first = next(i for i, tx in enumerate(sent) if "X from the operator" in tx.reason)
    assert first < len(sent) - 10
    assert {tx.data for tx in sent[first:] if "outputs in" not in tx.reason} == {stop}


# --- what cannot be flown ------------------------------------------------------------------------


def refusal(folder: Path, vehicle: str, legs: str) -> list[tuple[str, int, str]]:
    text = f"mission m vehicle {vehicle}\nstart without fix\n{legs}\n"
    with pytest.raises(Unreadable) as caught:
        prepared(folder, text)
    return [(p.code, p.where.line, p.message) for p in caught.value.diagnostics]


@pytest.mark.parametrize(
    ("vehicle", "leg", "rule", "reason"),
    [
        ("coreboard", "a: depth 3 gear 4 for 9s", "vehicle-has-no-word", "heading and depth together"),
        ("coreboard", "a: heading 9 gear 4 for 9s", "vehicle-has-no-word", "heading and depth together"),
        ("coreboard", "a: heading 9 down 4 for 9s", "vehicle-has-no-word", "heading and depth together"),
        ("coreboard", "a: goto home gear 4 within 5 timeout 9s", "vehicle-has-no-word", "together"),
        ("coreboard", "a: altitude 3 for 9s", "vehicle-cannot-follow", "altitude"),
        ("coreboard", "a: pitch 5 for 9s", "vehicle-cannot-follow", "attitude"),
        ("rov", "a: depth 3 for 9s", "signs-unconfirmed", "depth"),
        ("rov", "a: heading 90 gear 3 for 9s", "signs-unconfirmed", "heading"),
        ("rov", "a: goto home gear 3 within 5 timeout 9s", "vehicle-cannot-know", "position"),
        ("rov", "a: yoyo 2 shallow 1 deep 4 timeout 99s", "signs-unconfirmed", "depth"),
        ("rov", "a: surface until fix timeout 99s", "vehicle-cannot-know", "no fix can end this"),
        ("rov", "a: down 3 until altitude < 2 timeout 9s", "never-known", "altitude"),
        ("rov", "a: down 3 until battery < 11 timeout 9s", "never-known", "battery"),
        ("robot", "a: down 3 for 9s", "vehicle-cannot-follow", "heave"),
        ("robot", "a: depth 3 for 9s", "vehicle-cannot-follow", "depth"),
        ("robot", "a: heading 90 gear 3 for 9s", "vehicle-cannot-follow", "heading"),
        ("robot", "a: gear 3 right 3 for 9s", "vehicle-has-no-word", "straight or spins"),
        ("robot", "a: gear 3 until depth > 1 timeout 9s", "never-known", "depth"),
        ("robot", "a: gear 3 until travelled > 1 timeout 9s", "never-known", "heading"),
    ],
)  # fmt: skip
def test_what_a_vehicle_cannot_do_or_know_is_refused_at_its_line(
    vehicle: str, leg: str, rule: str, reason: str, tmp_path: Path
) -> None:
    found = refusal(tmp_path, vehicle, leg)
    assert (rule, 3) in [(r, line) for r, line, _ in found]
    assert reason in " ".join(message for r, _, message in found if r == rule)


@pytest.mark.parametrize(
    ("leg", "reason"),
    [
        ("a: heading 90 gear -4 depth 3 for 9s", "a heading is held ahead only, not astern"),
        ("a: gear 4 right 4 for 9s", "one horizontal mode at a time"),
        ("a: gear 6 down 8 for 9s", "one speed for both"),
        ("a: heading 90 gear 6 down 8 for 9s", "one speed for both"),
        ("a: right 6 down 8 for 9s", "one speed for both"),
        ("a: heading 90 stop down 8 for 9s", "both share one speed"),
        ("a: heading 90 stop up 8 for 9s", "both share one speed"),
        ("a: depth 3 pitch 5 for 9s", "cannot follow attitude"),
    ],
)
def test_the_auv_as_built_is_asked_for_nothing_that_it_has_no_word_for(
    leg: str, reason: str, tmp_path: Path
) -> None:
    found = refusal(tmp_path, "auv", leg)
    assert [line for _, line, _ in found] == [3]
    assert reason in found[0][2]


def test_every_set_of_a_chart_that_compiles_has_its_bytes(tmp_path: Path) -> None:
    for name, text in TEXTS.items():
        ready = prepared(tmp_path, text)
        wire = codec(ready.vehicle.codec, ready.vehicle.dialect, {})
        for state in ready.chart.states:
            if state.setpoint is not None and state.leg is not None:
                assert wire.encode(state.setpoint), name


# --- what the engine makes of their reports ------------------------------------------------------


def test_noise_between_two_quick_reports_is_no_descent() -> None:
    descent = Descent()
    for i in range(100):
        descent.take(0.1 * i, 3.0 + 0.06 * (i % 2), asked=True, fastest=0.5)
        assert not descent.unexplained
    for i in range(100, 140):
        descent.take(0.1 * i, 3.0 + 0.1 * (i - 100), asked=True, fastest=0.5)
    assert "sinking at 1.00 m/s" in descent.words


def test_a_position_of_its_own_proves_no_surface_but_counts_as_a_fix_there() -> None:
    vehicle_state, here = VehicleState(), (0.5, 2.0)
    for i in range(20):
        vehicle_state.at(float(i))
        vehicle_state.take_telemetry(Telemetry(float(i), depth=5.0, position=here))
    assert vehicle_state.fix is None
    assert not vehicle_state.surfaced(0.0)
    for i in range(20, 26):
        vehicle_state.at(float(i))
        vehicle_state.take_telemetry(Telemetry(float(i), depth=0.1 + 0.01 * (i % 2), position=here))
        assert vehicle_state.fix is None
    for i in range(26, 29):
        vehicle_state.at(float(i))
        vehicle_state.take_telemetry(Telemetry(float(i), depth=0.1 + 0.01 * (i % 2), position=here))
    assert vehicle_state.fix is not None
    assert vehicle_state.surfaced(0.0)
    assert vehicle_state.home_from_fixes() is None
    for i in range(29, 31):
        vehicle_state.at(float(i))
        vehicle_state.take_telemetry(Telemetry(float(i), depth=0.1 + 0.01 * (i % 2), position=here))
    home = vehicle_state.home_from_fixes()
    assert home is not None, "five of its own at a proved surface are a home"
    assert math.radians(home.latitude_deg) == pytest.approx(here[0])


class Listener:
    """A navigator that keeps what it was told."""

    frame = None

    def __init__(self) -> None:
        self.heard: list[Telemetry] = []

    def telemetry(self, t: Telemetry, push: Vertical) -> None:
        self.heard.append(t)

    def estimate(self, now: float) -> None:
        return None

    def health(self, sensor: str, now: float) -> Health:
        return Health(True, "", 0.0)


def test_what_a_vehicle_says_of_its_thrusters_is_believed_before_what_it_was_told() -> None:
    listener = Listener()
    vehicle_state = VehicleState(listener)  # type: ignore[arg-type]
    vehicle_state.word = Setpoint(surge=0.5, depth=3.0)
    vehicle_state.take_telemetry(Telemetry(0.0, depth=1.0, actuators=(0.1, 0.2)))
    vehicle_state.take_telemetry(Telemetry(1.0, depth=1.0))
    vehicle_state.word = None
    vehicle_state.take_telemetry(Telemetry(2.0, depth=1.0))
    thrusts = [t.actuators for t in listener.heard]
    assert thrusts == [(0.1, 0.2), (0.5, 0.5, 1.0), (0.0, 0.0, 0.0)]
    assert vehicle_state.telemetry is not None
    assert vehicle_state.telemetry.actuators is None


def test_on_the_ground_it_is_always_at_the_surface() -> None:
    vehicle_state = VehicleState(grounded=True)
    assert vehicle_state.depth == 0.0
    assert not vehicle_state.submerged
    vehicle_state.at(10.0)
    assert not vehicle_state.surfaced(5.0)
    vehicle_state.at(11.0)
    assert vehicle_state.surfaced(5.0)
    assert load_vehicle("robot").drives


@pytest.mark.proof
def test_a_start_refused_for_want_of_a_fix_says_what_allows_it() -> None:
    text = "mission m vehicle rov\nhome 30 120\n{}a: gear 4 for 20\n"
    refused = fly(parse(text.format("")), load_vehicle("rov"))
    assert "'start without fix' in the mission allows it" in refused.reason
    assert fly(parse(text.format("start without fix\n")), load_vehicle("rov")).legs


def test_before_the_filter_is_loaded_reports_grow_as_old_as_the_vehicle_file_allows() -> None:
    for vehicle in ("coreboard", "auv"):
        engine = Engine(load_vehicle(vehicle))
        engine.step(1.0, (Telemetry(1.0, depth=3.0),))
        age = load_vehicle(vehicle).stale_after
        engine.step(1.0 + age)
        assert engine.depth == 3.0
        engine.step(1.01 + age)
        assert engine.depth is None


def test_what_drives_tells_the_boat_once_that_it_stands() -> None:
    """R11: it is at the surface wherever it is, so the end of its way is told."""
    robot = load_vehicle("robot")
    world = World(robot, Stored(tuple(script(parse(ROBOT)))), Position(30.0, 120.0))
    world.navigate(Navigation(robot, date="2026-03-01"))
    world.wait(2.0)
    world.say(b"@AA$")
    world.wait(20.0)
    assert not [t for t in world.sent if t.data.startswith(b"@VS")]
    world.wait(10.0)
    told = [t for t in world.sent if t.data.startswith(b"@VS") and t.address == "boat"]
    assert world.state == "idle/ready"
    assert [t.reason for t in told] == ["at the surface"]
