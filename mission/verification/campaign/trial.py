"""One disturbed flight on a rig. It ends when nothing more can happen and the vehicle is at the
surface, or when the vehicle should have been there long before.

What does not live here: the rig, what is disturbed (draw, disturbances), the laws of the flight
(laws, audit).
"""

from __future__ import annotations

import functools
import math
import re
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from links.simulated.board_faults import ANY
from links.simulated.geodesy import moved
from links.simulated.link import START, SimulatedVehicle
from links.simulated.plant import DEAD_BAND_PWM, NEUTRAL_PWM
from links.simulated.settings import FaultEvent, Settings
from mission.authoring.language import digest, parse, script
from mission.model import AUTONOMOUS, STOPPED, SURFACED, Mission, Step
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.mission_validator import MissionValidator
from mission.onboard.runtime.records import Recorder
from mission.verification.rig.acts import Disturbance
from mission.verification.rig.program import FillableStore, Program
from mission.verification.rig.rehearsal import Operator
from mission.verification.rig.rig import Rig
from mission.verification.rig.trace import Trace
from mission.verification.rig.vehicle import home_of, simulated

WATCHED = 20.0  # s at least for which a fault is watched
FOREVER = 1e6  # s: longer than any flight
QUIET = 20.0  # s at the surface with nothing under way
ASCENT = 900.0  # s that the way up may take at most, when all faults are over
OPERATOR_AFTER = 15.0  # s in which a program that lives on can be brought to idle
UPLOAD = 200.0  # s until the operator has started the mission, or given up
RADIO = 0.1  # s until the operator's program has answered an answer
AUTO_NODE = re.compile(rb"@NS[OC]{5}([OC])\$")
_AT_REST = ("idle/", STOPPED, SURFACED)
_AFLOAT = 0.5  # m (R7)
Judge = Callable[[Vehicle, str], MissionValidator | None]  # of a vehicle, for a mission's digest


@dataclass(frozen=True, slots=True)
class _Pair:
    digest: str
    vehicle: Vehicle = field(hash=False)  # a vehicle has no hash


def known_judge(vehicle: Vehicle, digest: str) -> MissionValidator:
    """Return one validator for all flights of this mission by this vehicle.

    Use it only for flights of the whole program: with a rule broken, a kept verdict is not computed
    again.
    """
    return _judge(_Pair(digest, vehicle))


@functools.lru_cache(maxsize=64)
def _judge(of: _Pair) -> MissionValidator:
    return MissionValidator(of.vehicle)


def try_out(
    mission: Mission,
    vehicle: Vehicle,
    profile: str,
    seed: int,
    settings: Settings,
    disturbances: Sequence[Disturbance] = (),
    *,
    offset: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    recorder: Callable[[], Recorder | None] = lambda: None,
    program: Program | None = None,
    configuration: Configuration | None = None,
    judge: Judge = lambda vehicle, digest: None,
) -> Trace:
    """Fly a mission once, and return the trace.

    ``disturbances`` are at the flight's times. ``offset``: m north and east of home where the
    flight begins. ``recorder`` makes one recorder for each run of the program. ``judge`` may know
    the mission from an earlier flight. A ``program`` that is given runs before and after the
    flight; the operator begins ``OPERATOR_AFTER`` s later.
    """
    flown = replace(vehicle, dialect=profile) if vehicle.codec == "auv" else vehicle
    home = home_of(mission)
    sea = simulated(flown, seed, settings, position=moved(*home, *offset), heading=heading)
    begins = program is None
    if program is None:
        store, wall = FillableStore(), START.timestamp()
        verdicts = judge(flown, digest(mission))
        program = Program(flown, store, wall, recorder, configuration, verdicts)
    program.store.death = None
    operator = Operator(script(mission), digest(mission))
    trial = _Trial(
        sea,
        program,
        operator,
        operator_from=0.0 if begins else OPERATOR_AFTER,
        radio=RADIO,
    )
    trial.expect(mission.safety.time or vehicle.limits.time, settings, disturbances)
    raised = trial.fly(begins=begins)
    return Trace(
        tuple(trial.events),
        tuple(sea.track),
        home,
        sea.truth(),
        program.state,
        operator.failure,
        trial.started,
        raised,
        _is_turning(sea) if isinstance(sea, SimulatedVehicle) else sea.turning,
        _first_flown(trial.lines, mission),
    )


def _first_flown(lines: tuple[str, ...], mission: Mission) -> Mission:
    """Return the stored mission as the first flight began: another boat may have sent another."""
    return mission if lines in ((), tuple(script(mission))) else parse("\n".join(lines) + "\n")


class _Trial(Rig):
    """A rig that knows when it is over."""

    def expect(
        self, safety: float, settings: Settings, disturbances: Sequence[Disturbance]
    ) -> None:
        """Plan the disturbances, and when to end; ``safety``: s that the mission may take."""
        for disturbance in disturbances:
            self.plan(disturbance)
        ends = [t for e in settings.faults if (t := fault_ends(e)) < FOREVER]
        ends += [event.begin + WATCHED for event in settings.faults if event.begin < FOREVER]
        self._last = max([0.0, *ends, *(disturbance.after for disturbance in disturbances)])
        self._deadline = self._last + UPLOAD + OPERATOR_AFTER + ASCENT
        self._safety = safety
        self.lines: tuple[str, ...] = ()  # of the mission that was started first
        self._rests_since: float | None = None

    def fly(self, *, begins: bool) -> str:
        """Fly; return the traceback of a program error, "" if none. ``begins``: boot it first."""
        try:
            if begins:
                self.program.boot(0.0, 0.0)
            self.join()
            while not self._is_over():
                self.step()
            self.run_until(self.now)
        except Exception:  # the flight looks for errors of the program
            return traceback.format_exc()
        return ""

    @property
    def started(self) -> float | None:
        assert self.operator is not None
        started = self.operator.started
        return None if started is None else started + self._operator_from

    def _is_over(self) -> bool:
        if self.now > self._deadline:
            return True
        assert self.operator is not None
        waits = self.operator.started is None and not self.operator.failure
        self.sea.advance(self.now)
        rests = self.program.state.startswith(_AT_REST) and self.sea.plant.depth <= _AFLOAT
        if waits or not rests or self.now < self._last or self.program.is_leaving:
            self._rests_since = None
            return False
        if self._rests_since is None:
            self._rests_since = self.now
        return self.now - self._rests_since > QUIET

    def stepped(self, step: Step) -> None:
        super().stepped(step)
        if any(path.startswith(AUTONOMOUS) for path in step.entered):
            self.lines = self.lines or self.program.store.content.lines
            self._deadline = max(self._deadline, step.t + self._safety + ASCENT)


def _is_turning(sea: SimulatedVehicle) -> bool:
    return any(abs(pwm - NEUTRAL_PWM) > DEAD_BAND_PWM for pwm in sea.stm32.pwm[:5])


def fault_ends(event: FaultEvent) -> float:
    """Return when a fault ends, s; infinity if it lasts for ever."""
    duration = event.duration
    if duration is None:
        duration = ANY[event.name].duration
    return math.inf if duration >= FOREVER else event.begin + duration
