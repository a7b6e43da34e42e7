"""The exhaustive proof on the boards of documents 002 to 004: their bytes, and broken boards."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from mission.authoring.prepare import prepare
from mission.engine.limits import LIMITS
from mission.engine.monitor import LimitMonitor
from mission.model import Position
from mission.model.shipped import load_vehicle, shipped_missions
from mission.onboard.runtime import repeater, situation
from mission.onboard.runtime.repeater import Repeater
from mission.onboard.store import Stored
from mission.verification.exhaustive.cell import Configuration
from mission.verification.exhaustive.configurations import Ground, configurations, ground
from mission.verification.exhaustive.events import events, events_of
from mission.verification.exhaustive.fork import Fork
from mission.verification.exhaustive.lines import Line, line_of, upward, ways_of
from mission.verification.exhaustive.run import LAWS, _played, examine_ground
from mission.verification.exhaustive.world import World
from protocol.messages import Order, Setpoint, Telemetry
from protocol.vehicles import codec

MISSIONS = {"coreboard": "coreboard-dive", "rov": "rov-dive", "robot": "robot-drive"}
EVERY = {"coreboard": 20, "rov": 16, "robot": 1}  # of the configurations: a sample of seconds
HERE = Position(30.0, 120.0)
# Limits that nothing in the bytes of a board can bring about.
ELSEWHERE = {
    "no answer": "nothing is acknowledged",
    "depth contradicted": "no report tells which way the verticals push",
    "course against heading": "a place without a course over ground",
}


def line(name: str) -> Line:
    return line_of(load_vehicle(name))


def heard(name: str, of: Line, **sea: object) -> Telemetry:
    """What the vehicle's codec reads of one report."""
    told = of.sea()
    for key, value in sea.items():
        setattr(told, key, value)
    (found,) = codec(*load_vehicle(name).speaks).receive(of.report(told, HERE), 1.0)
    assert isinstance(found, Telemetry)
    return found


@pytest.mark.parametrize("name", ["coreboard", "rov"])
def test_a_report_says_what_the_sea_is(name: str) -> None:
    found = heard(name, line(name), depth=3.0, heading_deg=90.0, roll_deg=20.0, temperature=7.0)
    assert found.depth == pytest.approx(3.0, abs=0.02)
    assert math.degrees(found.heading or 0.0) == pytest.approx(90.0, abs=0.02)
    assert math.degrees(found.roll or 0.0) == pytest.approx(20.0, abs=0.02)
    assert found.temperature_c == pytest.approx(7.0, abs=0.02)
    assert found.faults == ()


@pytest.mark.parametrize("name", ["coreboard", "rov"])
def test_what_is_not_known_and_what_is_absurd_can_be_said(name: str) -> None:
    blind = heard(name, line(name), unknown={"depth", "yaw"})
    assert (blind.depth, blind.heading) == (None, None)
    assert heard(name, line(name), yaw_offset_deg=600.0).faults == (
        ("yaw_deg" if name == "coreboard" else "ez_deg") + ":out_of_range",
    )


def test_water_low_voltage_a_place_and_way_can_be_said() -> None:
    of = line("coreboard")
    leaks = codec(*load_vehicle("coreboard").speaks)
    wet = leaking(of)
    told = [leaks.receive(wet, t)[0] for t in (0.1, 0.2, 0.3)]
    assert [one.leak for one in told if isinstance(one, Telemetry)] == [False, False, True]
    assert heard("coreboard", of).position is None
    assert heard("coreboard", of, placed=True).position is not None
    assert heard("robot", line("robot"), control_v=9.0).batteries == (9.0, None)
    assert heard("robot", line("robot"), stopped=True).velocity == (0.0, 0.0, 0.0)


def leaking(of: Line) -> bytes:
    sea = of.sea()
    sea.leak = True
    return of.report(sea, HERE)


@pytest.mark.parametrize("name", MISSIONS)
def test_what_a_board_is_told_is_a_word_of_the_laws(name: str) -> None:
    of, board = line(name), codec(*load_vehicle(name).speaks)
    (stop,) = board.encode(Order.STOP)
    ahead = board.encode(Setpoint(surge=0.5))
    assert of.word(stop, "any") == b"@ZAX0$"
    assert of.word(stop, "no M for 600 ms: neutral").startswith(b"@M=")
    assert [of.word(data, "entry of a") for data in ahead] == list(of.words(Setpoint(surge=0.5)))
    assert all(of.word(data, "relay of MMF6").startswith(b"@M=") for data in ahead)
    assert of.steers(b"@MMF5$")
    assert not of.steers(b"@MT1,-10$")


def test_ways_up_are_those_of_the_vehicles_own_table() -> None:
    assert ways_of(line("auv")) == (b"@ZAWF$", b"@ZAU12$", b"@ZAX0$")
    assert ways_of(line("coreboard")) == ways_of(line("rov")) == (b"@ZAU12$", b"@ZAX0$")
    assert ways_of(line("robot")) == (b"@ZAX0$",)
    assert [upward(line(name)) for name in ("auv", "rov", "robot")] == [
        [b"@ZAX0$", b"@ZAU12$"],
        [b"@ZAU12$"],
        [b"@ZAX0$"],
    ]


def test_what_holds_is_one_word_however_often_it_is_said() -> None:
    vehicle = load_vehicle("rov")
    world = World(vehicle, Stored(()), HERE)
    world.say(b"@ZAX0$")
    world.wait(1.0)
    assert [t.data for t in world.sent if t.link == "vehicle"] == [b"@ZAX0$"]
    assert len(world.paced) in (20, 21)


@pytest.mark.parametrize("name", MISSIONS)
def test_every_limit_that_can_act_has_its_event(name: str) -> None:
    vehicle = load_vehicle(name)
    armed = {row.name for row in LIMITS.values() if not row.disarmed(vehicle)} - set(ELSEWHERE)
    brown = set() if name == "rov" else {"brown-out"}  # who tells what its thrusters do
    assert {e.limit for e in events_of(line(name)) if e.limit} == armed - brown


def test_events_of_the_auv_are_all_but_the_leak() -> None:
    left = {e.name for e in events()} - {e.name for e in events_of(line("auv"))}
    assert left == {"limit leak"}


# --- whole samples, and boards that are broken on purpose -----------------------------------------


@pytest.fixture(scope="module", params=MISSIONS)
def at(request: pytest.FixtureRequest) -> Ground:
    return ground(prepare(shipped_missions()[MISSIONS[request.param]]), "documented")


@pytest.mark.proof
def test_no_cell_of_a_sample_breaks_a_law(at: Ground) -> None:
    found = examine_ground(at, EVERY[at.line.vehicle.name])
    assert found.violations == []
    assert found.cells == found.configurations * found.events > 200


@pytest.fixture(scope="module")
def grounds() -> dict[str, Ground]:
    return {
        name: ground(prepare(shipped_missions()[m]), "documented") for name, m in MISSIONS.items()
    }


Break = Callable[[pytest.MonkeyPatch], None]


def _says_seldom(patch: pytest.MonkeyPatch) -> None:
    poll = Repeater.poll

    def late(self: Repeater, now: float) -> object:
        self._period = 0.3
        return poll(self, now)

    patch.setattr(Repeater, "poll", late)


def _talks_over_itself(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(repeater, "BITS_PER_BYTE", 0)
    poll = Repeater.poll

    def at_once(self: Repeater, now: float) -> object:
        self._free = 0.0
        return poll(self, now)

    patch.setattr(Repeater, "poll", at_once)


def _takes_any_m(patch: pytest.MonkeyPatch) -> None:
    def lenient(self: Repeater, frame: bytes) -> str:
        return ""

    def relayed(self: Repeater, data: bytes, reason: str, manual: bool = False) -> str:
        return ""

    patch.setattr(Repeater, "cannot_relay", lenient)
    patch.setattr(Repeater, "relay", relayed)


def _limits_sleep(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(LimitMonitor, "look", lambda self, reported, fixed: [])


def _one_way_only(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("mission.engine.ascent.TURN", 1e9)


def _tells_nobody(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(situation.Situation, "_afloat", lambda self, now: False)


def _w_is_a_stop(patch: pytest.MonkeyPatch) -> None:
    command = Repeater.command

    def stops(self: Repeater, action: object) -> object:
        if getattr(action, "command", None) is Order.SURFACE:
            action = replace(action, command=Order.STOP)  # type: ignore[type-var]
        return command(self, action)  # type: ignore[arg-type]

    patch.setattr(Repeater, "command", stops)


BROKEN: tuple[tuple[Break, str, str, str], ...] = (
    (_says_seldom, "rov", "surfacing", "what holds is said again within the board's period"),
    (_says_seldom, "robot", "stopped", "what holds is said again within the board's period"),
    (_talks_over_itself, "coreboard", "ready", "a board is sent no more than its line carries"),
    (_takes_any_m, "robot", "ready", "M takes over at once, an emergency by a push behind 2 s of silence"),
    (_limits_sleep, "coreboard", "autonomous/dive , quiet", "a breach leads to its response where it acts, and only there"),
    (_limits_sleep, "robot", "autonomous/out , quiet", "who is left alone comes up"),
    (_one_way_only, "rov", "surfacing", "an ascent tries every way and never gives up"),
    (_one_way_only, "coreboard", "ready", "from everywhere to the surface by W"),
    (_w_is_a_stop, "rov", "ready", "W acts from everywhere within the step"),
    (_tells_nobody, "robot", "autonomous/out , quiet", "one @VS unasked at the surface"),
)  # fmt: skip


@pytest.fixture(scope="module")
def worlds(grounds: dict[str, Ground]) -> dict[tuple[str, str], tuple[Configuration, Fork[World]]]:
    wanted = {(name, where) for _, name, where, _ in BROKEN}
    return {
        (name, c.name): (c, Fork(w))
        for name, on in grounds.items()
        for c, w in configurations(on)
        if (name, c.name) in wanted
    }


@pytest.fixture
def patch() -> Iterator[pytest.MonkeyPatch]:
    with pytest.MonkeyPatch.context() as context:
        yield context


@pytest.mark.proof
@pytest.mark.parametrize(
    ("broken", "name", "where", "law"), BROKEN, ids=lambda v: getattr(v, "__name__", str(v))
)
def test_a_broken_board_is_seen(
    broken: Break, name: str, where: str, law: str, grounds, worlds, patch
) -> None:
    configuration, fork = worlds[name, where]
    broken(patch)
    asked: list[str] = []
    for event in events_of(grounds[name].line):
        cell, fault = _played(configuration, event, grounds[name], fork)
        verdict = fault or LAWS[law].ask(cell)
        if verdict:
            asked.append(f"{event.name}: {verdict}")
            break
    assert asked, law
