"""Every state of every vehicle, looked at each second of whole flights, by each way there is.

The core of serve and a simulated vehicle in lock step. What the Pi keeps of itself (its health, its
records) is what a boat reads by `@AE`, `@DU` and `@AQ`, by network and in the modem's envelopes, what
a viewer is sent, and what `status` and `watch` make of either, in words and as data. That sockets,
certificates and acoustic modems carry these bytes is seen by test_same_truth.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import pytest

from links.base import Rx
from links.simulated.link import START
from links.simulated.settings import Settings
from mission.authoring.language import digest, parse, script
from mission.model import Tx
from mission.model.alarms import standing
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.records import ListRecorder
from mission.onboard.serve.health import of_drive
from mission.onboard.serve.view import view
from mission.topside import panels
from mission.topside.looking import Looked
from mission.topside.monitor import Watched
from mission.topside.showing import as_lines, as_object
from mission.topside.sources import frame_of
from mission.verification.rig.acts import MODEM, TOPSIDE, Act, Disturbance
from mission.verification.rig.program import FillableStore, Program
from mission.verification.rig.rehearsal import Cue, Operator
from mission.verification.rig.rig import Rig
from mission.verification.rig.vehicle import home_of, simulated
from protocol.messages import FrameFault, StateReport, Status, StoreReport
from protocol.modem import ModemCodec, Sender, wrap
from protocol.state_frame import STATES
from protocol.topside import Answer, ConsoleCodec

ASKED = (b"@AE$", b"@DU$", b"@AQ$")
ONLOOKER = "onlooker"
SURE = {"depth": 0.51, "radius": 0.51, "time": 0.51, "voltage": 0.06}  # of a margin as @AE has it
PLACE = "home 30.2874595 120.1535765\n"
HEADS = {
    "auv": f"{PLACE}safety radius 600 time 20min depth 10 voltage 10\nassume current 0.1\n",
    "coreboard": f"{PLACE}safety radius 600 time 20min depth 20 voltage 12\nassume current 0.1\n",
    "rov": "safety time 20min depth 20\nassume current 0\nstart without fix\n",
    "robot": "safety time 20min\nassume start 0\nstart without fix\n",
}
LEGS = {
    "auv": """dive: depth 3 heading 0 gear 4 until depth >= 2.5 timeout 90
repeat 2 rows:
  out: heading 90 gear 4 for 15s
end
up: surface timeout 3min
""",
    "coreboard": """dive: depth 4 heading 90 gear 6 until depth >= 3.7 timeout 90
repeat 2 rows:
  out: depth 4 heading 180 gear 4 for 15s
end
up: surface timeout 3min
""",
    "rov": """dive: down 9 until depth >= 3 timeout 30s
repeat 2 rows:
  out: gear 2 down 5 for 8s
end
up: surface timeout 3min
""",
    "robot": """ahead: gear 2 for 15s
repeat 2 rows:
  out: gear 2 for 15s
end
last: gear 1 for 5s
""",
}
OF_LEGS = {
    "dive": {"auv", "coreboard", "rov"},
    "ahead": {"robot"},
    "rows/out": set(LEGS),
    "up": {"auv", "coreboard", "rov"},
    "last": {"robot"},
    "surface": set(LEGS),
}
STICK = [Cue(30.0 + 0.2 * n, b"@MMF1$") for n in range(60)]
FLIGHTS: dict[str, list[Cue]] = {
    "to its end": [],
    "by stick, and on by itself": [*STICK, Cue(55.0, b"@AA$")],
    "stopped": [Cue(25.0, b"@ZAX0$"), Cue(45.0, b"@ZAWF$")],
    "surfaced": [Cue(25.0, b"@ZAWF$")],
    "stick without an end": [*STICK, Cue(50.0, b"@ZAX0$"), Cue(70.0, b"@AC$")],
}
ENDS_S = 240.0


@dataclass(frozen=True)
class Truth:
    """What the Pi keeps of itself, at one instant."""

    t: float
    state: str
    leg: str
    setpoint: str
    alarms: frozenset[str]
    margins: dict[str, float | None]

    @property
    def words(self) -> str:
        """The state as @AE has it: of a leg its name stands elsewhere."""
        return re.sub("^autonomous/.*", "autonomous", self.state)


@dataclass
class Seen:
    """By whom a state was seen, and what contradicted it."""

    states: dict[str, set[str]] = field(default_factory=dict)
    wrong: list[str] = field(default_factory=list)

    def by(self, who: str, truth: Truth, contradictions: Iterator[str]) -> None:
        self.states.setdefault(who, set()).add(truth.state)
        self.wrong += [f"{who} at {truth.t:.1f} in {truth.state}: {w}" for w in contradictions]


class Watching(Rig):
    """A rig at which somebody looks each second, and changes nothing by it."""

    def __init__(self, name: str, text: str, cues: Sequence[Cue]) -> None:
        mission, self.vehicle = parse(text), load_vehicle(name)
        self.recorder, self.seen = ListRecorder(), Seen()
        sea = simulated(self.vehicle, 1, Settings(), position=home_of(mission))
        program = Program(
            self.vehicle, FillableStore(), START.timestamp(), lambda: self.recorder,
            Configuration(),
        )  # fmt: skip
        super().__init__(sea, program, Operator(script(mission), digest(mission), cues))
        self._by_modem: dict[type, Answer] = {}
        self._asked: tuple[int, Truth | None] = (0, None)
        program.boot(0.0)
        self.send(program.navigate(0.0))
        self.look()
        self.join()
        self.join(ONLOOKER)

    def fly(self) -> Seen:
        while self.now < ENDS_S:
            self.run_until(self.now + 1.0)
            self.look()
        assert self.operator is not None
        assert not self.operator.failure, self.operator.failure
        self.judge_records()
        return self.seen

    # --- who looks -----------------------------------------------------------------------------

    def truth(self) -> Truth:
        runtime, now = self.program.runtime, self.now
        assert runtime is not None
        kept = of_drive(runtime, self.vehicle, now)
        left = {name: margin.left for name, margin in kept["margins"].items()}
        left["time"] = None if left["time"] is None else left["time"] / 60.0
        alarms = frozenset(alarm.name for alarm in standing(runtime.condition(now)))
        return Truth(now, kept["state"], kept["leg"], kept["setpoint"], alarms, left)

    def look(self) -> None:
        truth = self.truth()
        self._look_by_network(truth)
        self._look_as_viewer(truth)
        self._look_by_modem(truth)

    def _look_by_network(self, truth: Truth) -> None:
        if ONLOOKER not in self.joined:
            return
        asked = Rx(self.now, TOPSIDE, b"".join(ASKED), ONLOOKER)
        out = self.program.receive(asked, self.now)
        answered = b"".join(tx.data for tx in out if tx.address == ONLOOKER)
        self.send(out)
        told = {type(one): one for one in ConsoleCodec().receive(answered, self.now)}
        self.seen.by("the boat", truth, contradicted(looked(told), truth))

    def _look_as_viewer(self, truth: Truth) -> None:
        runtime, watched = self.program.runtime, Watched()
        assert runtime is not None
        state = view(runtime, standing(runtime.condition(self.now)), self.now)
        watched.take({"n": 1, "t": self.now, "state": state}, 0.0)
        self.seen.by("the viewer", truth, contradicted_on_screen(watched, truth, truth.state))

    def _look_by_modem(self, truth: Truth) -> None:
        """A question each second: R12 has but one waiting."""
        if len(self._by_modem) == len(ASKED):
            asked_at = self._asked[1]
            assert asked_at is not None
            self.seen.by("the modem", asked_at, contradicted(looked(self._by_modem), asked_at))
            self._by_modem = {}
        number = len(self._by_modem)
        if number == 0:
            self._asked = (0, truth)
        question = wrap(ASKED[number], Sender.TOPSIDE)
        self.send(self.program.receive(Rx(self.now, MODEM, question), self.now))

    def send(self, sent: list[Tx]) -> None:
        for tx in sent:
            if tx.link == MODEM:
                self._hear_by_modem(tx.data)
        super().send(sent)

    def _hear_by_modem(self, data: bytes) -> None:
        for envelope in ModemCodec().receive(data, self.now):
            assert not isinstance(envelope, FrameFault)
            for one in ConsoleCodec().receive(envelope.content, self.now):
                expected = (StateReport, Status, StoreReport)[len(self._by_modem)]
                if type(one) is expected:  # and no @VS that nobody asked for (R11)
                    self._by_modem[type(one)] = one
                    return

    # --- what is on record -----------------------------------------------------------------------

    def judge_records(self) -> None:
        """The states of the black box are those that were seen, and in none was nobody looking."""
        steps = [rec.step_of(one.payload) for one in self.recorder.of(rec.STEP)]
        entered = [(step.t, step.entered[-1]) for step in steps if step.entered]
        recorded = lasting(entered, self.now)
        for who in ("the boat", "the viewer"):
            missed = recorded - self.seen.states[who]
            self.seen.wrong += [f"{who} did not see {state}" for state in sorted(missed)]
            made_up = self.seen.states[who] - {state for _, state in entered} - {"idle/empty"}
            self.seen.wrong += [f"{who} saw {state}" for state in sorted(made_up)]


def lasting(steps: Sequence[tuple[float, str]], end: float) -> set[str]:
    """The states that lasted two looks."""
    found, since = set[str](), dict[str, float]()
    for (t, state), (until, _) in zip(steps, [*steps[1:], (end, "")], strict=True):
        since = since if state in since else {state: t}
        if until - since[state] > 2.0:
            found.add(state)
    return found


def looked(told: dict[type, Any]) -> Looked:
    return Looked(told[Status], told[Status], told[StoreReport], 0, told[StateReport], 0.0)


def contradicted(look: Looked, truth: Truth) -> Iterator[str]:
    """By `status`, as data and in words, and by `watch --frames`."""
    told, lines = as_object(look), list(as_lines(look))
    wanted = {"state": truth.words, "leg": truth.leg, "setpoint": truth.setpoint}
    for name, value in wanted.items():
        if (told[name] or "") != value:
            yield f"{name} {told[name]!r}, and it is {value!r}"
        if value and f"{name:12} {value}" not in lines:
            yield f"status does not print {name} {value}"
    names = frozenset(alarm["name"] for alarm in told["alarms"])
    if names != truth.alarms:
        yield f"alarms {sorted(names)}, and they are {sorted(truth.alarms)}"
    for name in truth.alarms:
        if not any(line.startswith(f"ALARM {name}:") for line in lines):
            yield f"status does not print the alarm {name}"
    for name, left in truth.margins.items():
        given = next(v for k, v in told["margins"].items() if k.partition("_")[0] == name)
        if (given is None) != (left is None) or (
            given is not None and left is not None and abs(given - left) > SURE[name]
        ):
            yield f"margin of {name} {given}, and it is {left}"
    watched = Watched()
    watched.take(frame_of(look, 100.0), 0.0)
    yield from contradicted_on_screen(watched, truth, truth.words)


def contradicted_on_screen(watched: Watched, truth: Truth, state: str) -> Iterator[str]:
    """By what is sent, and by what `watch` shows of it."""
    first, *shown = [line.text for line in panels.state(watched, 0.0)]
    if (watched.state["state"], first) != (state, state):
        yield f"{watched.state['state']!r} on {first!r}"
    if (watched.state["leg"] or "", watched.state["setpoint"] or "") != (truth.leg, truth.setpoint):
        yield f"leg {watched.state['leg']!r}, setpoint {watched.state['setpoint']!r}"
    if truth.setpoint and f"{'setpoint':10} {truth.setpoint}" not in shown:
        yield f"watch does not show {truth.setpoint}"
    alarms = {alarm["name"] for alarm in watched.state["alarms"]}
    banner = [line.text for line in panels.banner(watched, 0.0)]
    if alarms != truth.alarms:
        yield f"alarms {sorted(alarms)}, and they are {sorted(truth.alarms)}"
    for name in truth.alarms:
        if not any(line.startswith(f"ALARM {name}:") for line in banner):
            yield f"watch does not show the alarm {name}"


# --- flights ---------------------------------------------------------------------------------------


def text_of(name: str, legs: str) -> str:
    return f"mission look vehicle {name}\n{HEADS[name]}{legs}"


@functools.cache
def flown(name: str) -> dict[str, Seen]:
    """Of each flight what was seen."""
    found = {
        flight: Watching(name, text_of(name, LEGS[name]), cues).fly()
        for flight, cues in FLIGHTS.items()
    }
    forgotten = LEGS[name].partition("up:")[0]  # its end is the implicit leg
    found["by the implicit leg"] = Watching(name, text_of(name, forgotten), []).fly()
    cut = Watching(name, text_of(name, LEGS[name]), [])
    cut.plan(Disturbance(25.0, Act.UNPLUG))
    return found | {"without its board": cut.fly()}


by_one_worker = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.xdist_group(f"looks {name}")) for name in LEGS]
)


@pytest.mark.proof
@by_one_worker
def test_in_every_state_all_see_what_the_pi_keeps_of_itself(name: str) -> None:
    wrong = [f"{flight}: {told}" for flight, seen in flown(name).items() for told in seen.wrong]
    assert not wrong, "\n".join([f"{len(wrong)} contradictions", *wrong[:20]])


@pytest.mark.proof
@by_one_worker
@pytest.mark.parametrize("who", ["the boat", "the viewer", "the modem"])
def test_every_state_that_a_vehicle_can_come_to_was_seen_by_all(name: str, who: str) -> None:
    seen = set().union(*(one.states.get(who, set()) for one in flown(name).values()))
    legs = {f"autonomous/{leg}" for leg, vehicles in OF_LEGS.items() if name in vehicles}
    states = {*legs, *STATES.values()} - {"autonomous"}
    assert seen == states
