"""One flight in simulation: a rig without disturbances, flown as fast as possible.

What does not live here: the rig, the figures of a flight (flightlog), the pictures (plot), the
vehicle's physics (links.simulated).
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from links.simulated.geodesy import local
from links.simulated.link import START, SimulatedVehicle
from links.simulated.settings import Settings
from mission.authoring.language import digest, script
from mission.model import STOPPED, Estimate, Mission, Position, Step, Tx
from mission.onboard.store import Stored
from mission.onboard.uncollected import uncollected
from mission.verification.rig.program import FillableStore, Program
from mission.verification.rig.rehearsal import Cue, Operator
from mission.verification.rig.rig import Rig
from mission.verification.rig.vehicle import Simulated, home_of, in_dialect, simulated
from mission.verification.simulation.flightlog import Flight, FlightEnd, FlightLog, TruePlace

if TYPE_CHECKING:
    from mission.model.vehicle import Vehicle
    from mission.onboard.runtime.mission_validator import MissionValidator
    from mission.onboard.runtime.records import Recorder

Home = tuple[float, float]  # latitude, longitude
Seen = tuple[float, float, float, float]  # t, latitude, longitude, depth
LONGEST_S = 12 * 3600.0  # s of a flight whose mission names no safety time, at most
AFTER_S = 2.0  # s that the last commands need to arrive
AFLOAT_S = 600.0  # s that a rise by buoyancy alone may need


def fly(
    mission: Mission,
    vehicle: Vehicle,
    profile: str = "",
    seed: int = 0,
    settings: Settings | None = None,
    recorder: Recorder | None = None,
    said: Sequence[Cue] = (),
    lines: Sequence[str] | None = None,
    stored: Stored | None = None,
    judge: MissionValidator | None = None,
) -> Flight:
    """Fly a mission in simulation. ``profile`` sets the dialect and the firmware together; "": as
    in the vehicle file. ``settings``: the sea, and faults. ``said``: what the operator sends
    besides upload and start. ``lines`` are uploaded instead of the mission's own script. ``judge``:
    the validator of an earlier flight of this vehicle, which may know the lines already."""
    flown = in_dialect(vehicle, profile)
    sea = simulated(flown, seed, settings, position=home_of(mission))
    program = Program(
        flown, FillableStore(stored), START.timestamp(), lambda: recorder, judge=judge
    )
    operator = Operator(lines or script(mission), digest(mission), said)
    with uncollected():  # the collector finds nothing: tests/bench/bench_tricks.py
        flight = _Flight(mission, sea, program, operator)
        begun = time.perf_counter()
        flight.run()
        return flight.result(time.perf_counter() - begun)


class _Flight(Rig):
    """A rig that ends with its mission, and logs the flight."""

    judged = False  # no law judges it: Heard, Located and Told would be unused

    def __init__(
        self, mission: Mission, sea: Simulated, program: Program, operator: Operator
    ) -> None:
        super().__init__(sea, program, operator)
        self.log = FlightLog(mission)
        self._home = sea.position  # of the frame of the estimate
        self._origin: Position | None = None  # the same, as the frame says it
        self._seen: list[tuple[Home, list[Seen]]] = []  # at each of the log's estimates
        self._longest = LONGEST_S if mission.safety.time is None else 2.0 * mission.safety.time
        self._digest = digest(mission)
        self._is_stopped = False  # whether the program is in stopped; only a Step changes that
        program.boot(0.0)
        self._is_stopped = program.state == STOPPED
        self.send(program.navigate(0.0))
        self.join()

    def run(self) -> None:
        while not self._is_over():
            self.step()
        end = self.now
        while self.step(end + AFTER_S):
            pass
        while self.log.started is not None and self._is_under_way_up(end):
            self.step()

    def result(self, wall: float) -> Flight:
        assert self.operator is not None
        track = [(p.t, p.latitude, p.longitude, p.depth) for p in self.sea.track]
        end = FlightEnd(
            self.now,
            self._digest,
            wall,
            self.program.state,
            _places(self._frame_home(), track),
            tuple(itertools.chain.from_iterable(_places(*part) for part in self._seen)),
            self._is_at_surface(),
            self.sea.sensors.compass_bias if isinstance(self.sea, SimulatedVehicle) else None,
        )
        self.log.sent = [event for event in self.events if isinstance(event, Tx)]
        return self.log.flight(self.operator.failure, end)

    def _is_over(self) -> bool:
        assert self.operator is not None
        if self.operator.failure:
            return True
        started = self.log.started
        if started is None:
            return False
        done = self.log.ended is not None or self.now - started > self._longest
        if not done and not (self._is_stopped and self._is_at_surface()):
            return False
        return self.operator.next_timer() is None

    def _is_under_way_up(self, end: float) -> bool:
        """Whether buoyancy may still bring up a vehicle whose mission ended under water."""
        return self.now < end + AFLOAT_S and not self._is_at_surface()

    def _is_at_surface(self) -> bool:
        self.sea.advance(self.now)
        return self.sea.truth().at_surface

    # --- estimates and true places ----------------------------------------------------------------

    def stepped(self, step: Step) -> None:
        super().stepped(step)
        self.log.step(step)
        self._is_stopped = self.program.state == STOPPED

    def told(self, estimate: Estimate) -> None:
        super().told(estimate)
        known = len(self.log.estimates)
        self.log.estimate(estimate)
        if len(self.log.estimates) > known:
            self._look_beside()

    def _look_beside(self) -> None:
        """Note the true place for the newest estimate of the log, with that estimate's home."""
        sea, home = self.sea, self._frame_home()
        if not self._seen or home != self._seen[-1][0]:
            self._seen.append((home, []))
        self._seen[-1][1].append((sea.now, *sea.place(), sea.plant.depth))

    def _frame_home(self) -> Home:
        navigation = self.program.navigation
        frame = None if navigation is None else navigation.frame
        if frame is not None and frame.origin is not self._origin:
            self._origin = origin = frame.origin
            self._home = math.radians(origin.latitude_deg), math.radians(origin.longitude_deg)
        return self._home


def _places(home: Home, seen: Sequence[Seen]) -> tuple[TruePlace, ...]:
    """Return places relative to ``home``, by the simulator's own geodesy."""
    import numpy as np

    times, latitudes, longitudes, depths = zip(*seen, strict=True)
    north, east = local(home, np.array(latitudes), np.array(longitudes), np)
    return tuple(map(TruePlace, times, north.tolist(), east.tolist(), depths))
