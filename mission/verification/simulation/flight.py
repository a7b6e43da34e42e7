"""One flight in simulation: runtime, operator and vehicle in lock step, as fast as can be.

    Operator --bytes--> Drive --bytes--> SimulatedVehicle
             <--bytes--       <--bytes--

The loop jumps from event to event: the next byte that arrives, the next timer. There is no tick,
no clock and no thread; the same seed gives the same bytes.

What does not live here: the figures made of a flight (flightlog), the pictures (plot), the
vehicle's physics (links.simulated).
"""

from __future__ import annotations

import itertools
import math
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from links.base import Rx
from links.simulated.boards import BOARDS, SimulatedBoard
from links.simulated.geodesy import local
from links.simulated.link import HOME, START, SimulatedVehicle
from links.simulated.settings import Settings
from mission.authoring.language import digest, script
from mission.model import STOPPED, Mission, Tx
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.device_switches import LINK as NODES
from mission.onboard.runtime.runtime import VEHICLE, Runtime
from mission.onboard.store import MemoryStore, Stored
from mission.onboard.uncollected import uncollected
from mission.verification.simulation.flightlog import Flight, FlightEnd, FlightLog, TruePlace
from mission.verification.simulation.rehearsal import Operator, Said

if TYPE_CHECKING:
    from mission.model.vehicle import Vehicle
    from mission.navigation import LocalFrame
    from mission.onboard.runtime.records import Recorder

BOAT = "boat"
TOPSIDE = "topside"
Home = tuple[float, float]  # latitude, longitude
Seen = tuple[float, float, float, float]  # t, latitude, longitude, depth
LONGEST_S = 12 * 3600.0  # of a flight whose mission names no safety time
AFTER_S = 2.0  # what the last commands need to arrive
AFLOAT_S = 600.0  # what buoyancy alone may need


def fly(
    mission: Mission,
    vehicle: Vehicle,
    profile: str = "",
    seed: int = 0,
    settings: Settings | None = None,
    recorder: Recorder | None = None,
    said: Sequence[Said] = (),
    lines: Sequence[str] | None = None,
    stored: Stored | None = None,
) -> Flight:
    """``profile`` picks the dialect and the firmware together; "": the vehicle file does.
    ``settings`` are the sea and its faults; ``said`` is what the operator sends beside upload and
    start; ``lines`` go up instead of the mission's own script."""
    flown = vehicle if vehicle.codec in BOARDS or not profile else replace(vehicle, dialect=profile)
    operator = Operator(lines or script(mission), digest(mission), said)
    with uncollected():  # the collector finds nothing, and takes 2 % of a flight
        loop = _LockStep(
            mission, flown, operator, seed, settings or Settings(), recorder, stored or Stored()
        )
        begun = time.perf_counter()
        loop.run()
        return loop.flight(time.perf_counter() - begun)


class _LockStep:
    def __init__(
        self,
        mission: Mission,
        vehicle: Vehicle,
        operator: Operator,
        seed: int,
        settings: Settings,
        recorder: Recorder | None,
        stored: Stored,
    ) -> None:
        position, home = HOME, mission.home
        if home is not None:
            position = math.radians(home.latitude_deg), math.radians(home.longitude_deg)
        self.sea: SimulatedVehicle | SimulatedBoard = (
            SimulatedBoard(
                vehicle.codec,
                seed,
                settings,
                position=position,
                tolerances=vehicle.tolerances,
                wire=vehicle.wire,
            )
            if vehicle.codec in BOARDS
            else SimulatedVehicle(vehicle.dialect, seed, settings, position=position)
        )
        self.log = FlightLog(mission)
        self.runtime = Runtime(
            Configuration(),
            vehicle,
            MemoryStore(stored),
            recorder,
            wall=START.timestamp(),
            observer=self.log,
        )
        self.operator = operator
        self.now = 0.0
        self._home = position  # of the frame of the estimate
        self._seen: list[tuple[Home, list[Seen]]] = []  # at each of the log's estimates
        self._looks = 0
        self._frame: LocalFrame | None = None  # of the estimate, when it was last looked at
        self._longest = LONGEST_S if mission.safety.time is None else 2.0 * mission.safety.time
        self._digest = digest(mission)
        self._navigation = self.runtime.make_navigation()
        self._send(self.runtime.set_navigation(self._navigation, 0.0))
        self._send(self.runtime.connected(TOPSIDE, BOAT, 0.0))
        self._runtime_due = self.runtime.next_timer()
        self._operator_due = operator.next_timer()
        self._links = self.sea.vehicle_link, self.sea.gps_link
        self._arrivals: list[float | None] = [None, None]  # as each of the two foretells

    def run(self) -> None:
        while not self._is_over():
            self._to_next_event()
        end = self.now
        while self._next_event() <= end + AFTER_S:
            self._to_next_event()
        while self.log.started is not None and self._is_under_way_up(end):
            self._to_next_event()

    def flight(self, wall: float) -> Flight:
        track = [(p.t, p.latitude, p.longitude, p.depth) for p in self.sea.track]
        end = FlightEnd(
            self.now,
            self._digest,
            wall,
            self.runtime.state,
            _places(self._frame_home(), track),
            tuple(itertools.chain.from_iterable(_places(*part) for part in self._seen)),
            self._is_at_surface(),
        )
        return self.log.flight(self.operator.failure, end)

    # --- the loop ------------------------------------------------------------------------------

    def _is_over(self) -> bool:
        if self.operator.failure:
            return True
        started = self.log.started
        if started is None or self._operator_due is not None:
            return False
        if self.log.ended is not None or self.now - started > self._longest:
            return True
        return self.runtime.state == STOPPED and self._is_at_surface()

    def _is_under_way_up(self, end: float) -> bool:
        """A mission that was ended below leaves buoyancy to bring the vehicle up."""
        return self.now < end + AFLOAT_S and not self._is_at_surface()

    def _is_at_surface(self) -> bool:
        self.sea.advance(self.now)
        return self.sea.truth().at_surface

    def _next_event(self) -> float:
        first = math.inf
        for at, link in enumerate(self._links):
            self._arrivals[at] = due = link.next_event()
            if due is not None and due < first:
                first = due
        for due in (self._runtime_due, self._operator_due):
            if due is not None and due < first:
                first = due
        return first if first > self.now else self.now

    def _to_next_event(self) -> None:
        """Bytes before timers: what has arrived by then is known by then."""
        self.now = now = self._next_event()
        for link, due in zip(self._links, self._arrivals, strict=True):
            if due is None or due > now:
                continue
            for rx in link.receive(now):
                if sent := self.runtime.receive(rx, now):
                    self._send(sent)
            if len(self.log.estimates) > self._looks:
                self._look_beside()
        due = self._operator_due
        if due is not None and due <= now:
            for data in self.operator.handle_timer(now):
                self._send(self._say(data))
            self._operator_due = self.operator.next_timer()
        due = self.runtime.next_timer()
        if due is not None and due <= now:
            self._send(self.runtime.handle_timer(now))
            due = self.runtime.next_timer()
        self._runtime_due = due

    def _send(self, sent: list[Tx]) -> None:
        """Answers to the operator are answered in turn, until nobody has anything to say."""
        waiting = deque(sent)
        while waiting:
            tx = waiting.popleft()
            self.log.sent.append(tx)
            if tx.link == VEHICLE:
                self.sea.vehicle_link.send(tx.data, self.now)
            elif tx.link == TOPSIDE:
                for data in self.operator.receive(tx.data, self.now):
                    waiting += self._say(data)
                self._operator_due = self.operator.next_timer()
            elif tx.link == NODES:
                waiting += self.runtime.receive(Rx(self.now, NODES, tx.data + b"\n"))

    def _say(self, data: bytes) -> list[Tx]:
        return self.runtime.receive(Rx(self.now, TOPSIDE, data, BOAT))

    # --- truth -----------------------------------------------------------------------------------

    def _look_beside(self) -> None:
        """Where it truly is, for the estimate that the log has got, against the estimate's home."""
        sea, home = self.sea, self._frame_home()
        if not self._seen or home != self._seen[-1][0]:
            self._seen.append((home, []))
        self._seen[-1][1].append((sea.now, *sea.place(), sea.plant.depth))
        self._looks += 1

    def _frame_home(self) -> Home:
        frame = self._navigation.frame
        if frame is not self._frame and frame is not None:
            origin, self._frame = frame.origin, frame
            self._home = math.radians(origin.latitude_deg), math.radians(origin.longitude_deg)
        return self._home


def _places(home: Home, seen: Sequence[Seen]) -> tuple[TruePlace, ...]:
    """By the simulator's own geodesy."""
    import numpy as np

    times, latitudes, longitudes, depths = zip(*seen, strict=True)
    north, east = local(home, np.array(latitudes), np.array(longitudes), np)
    return tuple(map(TruePlace, times, north.tolist(), east.tolist(), depths))
