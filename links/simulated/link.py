"""The simulated AUV: plant, sensors, board and GPS on one clock, and its links.

    send --> uart burst --> firmware --> PWMs --> plant (20 Hz) --> sensors --> @SD --> receive
                            controls at 5 Hz                        2 s    \\--> GGA, RMC  1 s

The caller gives the time: ``advance`` brings everything to it. The output does not depend on the
size of the steps. ``receive`` returns a frame when its last byte has been sent, with the time of
its first byte. ``next_event`` predicts when that is, so a loop in lock step can jump from frame to
frame.

What does not live here: real time (pty.py).
"""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from math import atan2, cos, hypot, inf, pi, radians, sin
from random import Random
from typing import NamedTuple

from links.base import LinkClosed, Rx
from links.simulated.added import COMPLETE as ADDED_COMPLETE
from links.simulated.added import AddedSensors
from links.simulated.faults import FAULTS
from links.simulated.firmware.as_built import AsBuilt
from links.simulated.firmware.documented import Documented
from links.simulated.firmware.gps import ANTENNA, COMPLETE, GpsReceiver
from links.simulated.firmware.stm32 import Stm32
from links.simulated.firmware.uart import BYTE_TIME, Chunk
from links.simulated.geodesy import local, moved
from links.simulated.plant import TICK, TICK_STEPS, Plant
from links.simulated.schedule import InForce, edges
from links.simulated.sensors import Sensors
from links.simulated.settings import SettingError, Settings
from links.simulated.waves import Waves

PROFILES: dict[str, type[Stm32]] = {"documented": Documented, "as-built": AsBuilt}
HOME = (radians(30.2874595), radians(120.1535765))
HOME_DECLINATION = radians(-6.05)  # World Magnetic Model 2025, June 2025
START = datetime(2025, 6, 1, 8, 0, tzinfo=UTC)

REPORT_TICKS = 10  # 2 s
FIRST_REPORT = 5  # tick of the first @SD
SECOND_TICKS = 5
REPORT_TIME = 86 * BYTE_TIME
TWO_PI = 2 * pi
_NEVER = 1 << 62


class Truth(NamedTuple):
    """The true state; angles in rad. A tuple, because one is made every second."""

    t: float
    origin: tuple[float, float]  # latitude and longitude of the start
    latitude: float
    longitude: float
    depth: float
    altitude: float
    heading: float
    pitch: float
    roll: float
    speed: float  # m/s through the water, along the bow
    depth_rate: float
    ground_speed: float
    course: float
    current: tuple[float, float]  # north, east
    aground: bool
    used: float = 0.0  # J, by the thrusters until the last report

    @property
    def local(self) -> tuple[float, float]:
        """North and east of the start, m."""
        return local(self.origin, self.latitude, self.longitude)

    @property
    def at_surface(self) -> bool:
        """The antenna is out of the water."""
        return self.depth <= ANTENNA


class _Pace:
    """Intervals between reports: a firmware waits 2 s after each report, and other work delays it.
    Some boards are mostly early, others mostly late."""

    def __init__(self, uneven: float, seed: int) -> None:
        most = round(uneven / TICK)
        self._rng = Random(f"pace {seed}")  # of its own: nothing else changes
        self._early, self._late = self._rng.randint(0, most), self._rng.randint(0, most)

    def ticks(self) -> int:
        """Ticks to the next report."""
        if not (self._early or self._late):
            return REPORT_TICKS
        return REPORT_TICKS + self._rng.randint(-self._early, self._late)


class SimulatedVehicle:
    def __init__(
        self,
        profile: str = "as-built",
        seed: int = 0,
        settings: Settings | None = None,
        *,
        position: tuple[float, float] = HOME,
        heading: float = 0.0,
        declination: float = HOME_DECLINATION,
        start: datetime = START,
    ) -> None:
        """``position`` is latitude and longitude, ``declination`` that of the place (east positive)
        unless ``settings`` has another, all in rad. ``start`` is the wall clock at time 0."""
        if profile not in PROFILES:
            raise ValueError(f"no profile {profile!r}; known: {', '.join(PROFILES)}")
        self.profile, self.seed, self.position = profile, seed, position
        self.settings = settings or Settings()
        rng = Random(seed)
        as_built = profile == "as-built"
        self.sea = sea = self.settings.sea
        self.plant = Plant(
            self.settings.pushed(self.settings.body), floor=sea.floor_under(position)
        )
        self.plant.yaw = heading
        self.sensors = Sensors(
            self.settings.errors, rng, repeats_when_silent=as_built, declination=declination
        )
        if sea.waves[0]:
            self.sensors.waves = Waves(*sea.waves, seed)
        self.stm32 = PROFILES[profile](self.sensors, rng)
        if self.settings.splice is not None:
            self.stm32.splice = self.settings.splice
        self.usual_splice = self.stm32.splice
        self.stm32.answers_late = self.settings.answers_late, Random(f"answers {seed}")
        self.gps = GpsReceiver(self.settings.errors, rng, start, self.settings.sentences)
        self.second_gps = _second_gps(self.settings, seed, start)
        self.second_link = None if self.second_gps is None else SecondLink(self, self.second_gps)
        self.added = AddedSensors(self.settings.added, seed) if self.settings.added else None
        self.added_link = None if self.added is None else AddedLink(self, self.added)
        speed, direction = sea.current
        self.current = (speed * cos(direction), speed * sin(direction))
        self._sheared = sea.deep_current is not None
        self.track: list[Truth] = []  # one a second
        self.vehicle_link = VehicleLink(self)
        self.gps_link = GpsLink(self)
        self._tick = 0
        self._next_report, self._next_second = FIRST_REPORT, SECOND_TICKS
        self._pace = _Pace(self.settings.uneven, seed)
        self._anchor = (*position, 0.0, 0.0)  # latitude, longitude at plant north, east
        self.edges = edges(self.settings.faults, FAULTS, TICK, "the AUV")
        self._in_force = InForce(FAULTS)
        self._refuse_lacking()
        self._next_edge = self.edges[-1].tick if self.edges else _NEVER
        self._foretell()
        self._flow()
        self.track.append(self.truth())

    # --- time ------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        return self._tick * TICK

    def advance(self, to_t: float) -> None:
        """Simulate everything up to ``to_t``, inclusive."""
        stm32, last = self.stm32, int(to_t / TICK + 1e-6)
        while True:
            due = stm32.due
            if due <= to_t and due < (self._tick + 1) * TICK:
                stm32.process(due)
                continue
            if self._tick >= last:
                return
            stop = self._next_stop if self._next_stop < last else last
            if due < inf:
                stop = min(stop, max(int(due / TICK), self._tick + 1))
            self._run(stop - self._tick)
            self._tick = stop
            if stop == self._next_stop:
                self._at_tick(stop)

    def _run(self, ticks: int) -> None:
        plant, control = self.plant, self.stm32.control
        drive, run = plant.drive, plant.run
        sheared = self._sheared
        for _ in range(ticks):
            run(TICK_STEPS)
            if sheared:
                self._flow()
            drive(control(plant))

    def _at_tick(self, tick: int) -> None:
        if tick == self._next_edge:
            self._switch_faults(tick)
        if tick == self._next_second:
            self._next_second += SECOND_TICKS
            self._second(tick * TICK)
        if tick == self._next_report:
            self._next_report += self._pace.ticks()
            self.stm32.report(self.plant, tick * TICK)
        self._foretell()

    def _second(self, now: float) -> None:
        plant = self.plant
        place, velocity = self.place(), plant.ground_velocity()
        self._anchor = (*place, plant.north, plant.east)
        plant.floor = self.sea.floor_under(place)
        self.track.append(self._truth(now, place, velocity))
        felt = self.sensors.felt(plant, now)
        velocity = velocity[0] + felt.north, velocity[1] + felt.east
        for receiver in (self.gps, self.second_gps):
            if receiver is not None:
                receiver.powered = self.stm32.power[2]
                receiver.report(now, plant.depth + felt.head, place, velocity)
        if self.added is not None:
            self.added.report(now, plant, place)

    def _flow(self) -> None:
        """Set the current at the vehicle's depth."""
        plant, sea = self.plant, self.settings.sea
        north, east = self.current
        if sea.deep_current is not None:
            speed, direction = sea.deep_current
            share = min(max(plant.depth / sea.floor, 0.0), 1.0)
            north += share * (speed * cos(direction) - north)
            east += share * (speed * sin(direction) - east)
        plant.current_north, plant.current_east = self._water = north, east

    # --- faults ----------------------------------------------------------------------------

    def _refuse_lacking(self) -> None:
        """Raise SettingError for a fault of a sensor that is not fitted."""
        for event in self.settings.faults:
            needs = FAULTS[event.name].needs
            if not self.settings.has(needs):
                raise SettingError(f"fault={event.name}: it has none; --set {needs}=SIGMA adds it")

    def _switch_faults(self, tick: int) -> None:
        while self.edges and self.edges[-1].tick <= tick:
            self._in_force.switch(self.edges.pop(), self)
        self._next_edge = self.edges[-1].tick if self.edges else _NEVER
        self._flow()

    # --- truth -----------------------------------------------------------------------------

    def truth(self) -> Truth:
        return self._truth(self.now, self.place(), self.plant.ground_velocity())

    def place(self) -> tuple[float, float]:
        """True latitude and longitude."""
        latitude, longitude, north, east = self._anchor
        return moved(latitude, longitude, self.plant.north - north, self.plant.east - east)

    def _truth(
        self, now: float, place: tuple[float, float], velocity: tuple[float, float]
    ) -> Truth:
        plant = self.plant
        latitude, longitude = place
        over_north, over_east = velocity
        return Truth(
            now,
            self.position,
            latitude,
            longitude,
            plant.depth,
            plant.floor - plant.depth,
            plant.yaw % TWO_PI,
            plant.pitch,
            plant.roll,
            plant.u,
            plant.depth_rate,
            hypot(over_north, over_east),
            atan2(over_east, over_north) % TWO_PI,
            self._water,
            plant.aground,
            self.sensors.used,
        )

    # --- predictions for the links ---------------------------------------------------------

    def _foretell(self) -> None:
        """Set the next tick to stop at, and when the next output of each kind will be complete."""
        self._next_stop = min(self._next_report, self._next_second, self._next_edge)
        self.report_through = self._next_report * TICK + REPORT_TIME
        self.epoch_through = self._next_second * TICK + COMPLETE
        self.second_through = self._next_second * TICK + ADDED_COMPLETE

    def next_start(self) -> float:
        """The earliest time at which something new can begin to be sent."""
        return min(self.stm32.due, min(self._next_report, self._next_second) * TICK)


class _Side:
    """The common part of the vehicle's links: in memory, on its clock."""

    name: str

    def __init__(self, vehicle: SimulatedVehicle) -> None:
        self._vehicle = vehicle
        self._closed = False

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        self._closed = True

    def _received(self, chunks: list[Chunk]) -> list[Rx]:
        return [Rx(chunk.start, self.name, chunk.data) for chunk in chunks] if chunks else []

    def _reach(self, now: float) -> None:
        if self._closed:
            raise LinkClosed(f"{self.name}: the link was closed")
        self._vehicle.advance(now)


class VehicleLink(_Side):
    """The serial line to the STM32."""

    name = "vehicle"

    def receive(self, now: float) -> list[Rx]:
        self._reach(now)
        return self._received(self._vehicle.stm32.tx.take(now))

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._reach(now)
        self._vehicle.stm32.receive(data, now)

    def next_event(self) -> float | None:
        stm32 = self._vehicle.stm32
        queue, event, due = stm32.tx.queue, self._vehicle.report_through, stm32.due
        if queue and queue[0].end < event:
            event = queue[0].end
        return due if due < event else event


class GpsLink(_Side):
    """The line of the GPS receiver, which is sent nothing."""

    name = "gps"

    def receive(self, now: float) -> list[Rx]:
        self._reach(now)
        return self._received(self._vehicle.gps.take(now))

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._reach(now)

    def next_event(self) -> float | None:
        queue = self._vehicle.gps.queue
        return queue[0].end if queue else self._vehicle.epoch_through


def _second_gps(settings: Settings, seed: int, start: datetime) -> GpsReceiver | None:
    """The second receiver. Its own random generator leaves everything else as it is without it."""
    if settings.second_gps is None:
        return None
    errors = replace(settings.errors, fix_noise=settings.second_gps)
    return GpsReceiver(errors, Random(f"gps2 {seed}"), start, settings.sentences)


class SecondLink(_Side):
    """The line of a second GPS receiver."""

    name = "gps2"

    def __init__(self, vehicle: SimulatedVehicle, receiver: GpsReceiver) -> None:
        super().__init__(vehicle)
        self._receiver = receiver

    def receive(self, now: float) -> list[Rx]:
        self._reach(now)
        return self._received(self._receiver.take(now))

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._reach(now)

    def next_event(self) -> float | None:
        queue = self._receiver.queue
        return queue[0].end if queue else self._vehicle.epoch_through


class AddedLink(_Side):
    """The line of the added sensors, which are sent nothing."""

    name = "sensors"

    def __init__(self, vehicle: SimulatedVehicle, added: AddedSensors) -> None:
        super().__init__(vehicle)
        self._added = added

    def receive(self, now: float) -> list[Rx]:
        self._reach(now)
        return self._received(self._added.take(now))

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._reach(now)

    def next_event(self) -> float | None:
        queue = self._added.queue
        return queue[0].end if queue else self._vehicle.second_through
