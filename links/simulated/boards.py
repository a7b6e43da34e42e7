"""The other vehicles, simulated: a board of documents 002 to 004 on the plant, or on the ground.

    send --> board --> thrusters --> plant (20 Hz) --> sensors --> report --> receive

The caller gives the time, as in link.py, and SimulatedBoard has the same members as
SimulatedVehicle. There is no GPS receiver: a core board reports its own position. Battery voltages
fall with use.

What does not live here: frames and what a board does with them (firmware/boards.py), faults
(board_faults.py).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import atan2, cos, hypot, inf, pi, sin, sqrt
from random import Random

from links.base import LinkClosed, Rx
from links.simulated.board_faults import OF_BOARDS
from links.simulated.firmware.boards import CoreBoard, RobotBoard, RovBoard, WaterBoard
from links.simulated.firmware.motors import MotorBoards
from links.simulated.firmware.sensor_board import SensorBoard
from links.simulated.firmware.uart import Chunk
from links.simulated.geodesy import moved
from links.simulated.ground import Ground
from links.simulated.link import HOME, Truth
from links.simulated.plant import STEP, TICK_STEPS, Plant
from links.simulated.schedule import InForce, edges
from links.simulated.settings import Settings
from links.simulated.waves import Waves
from protocol.tolerances import Tolerances
from protocol.vehicles import vehicle_row
from protocol.vehicles.keys import read_wire

BYTE_TIME = 10 / 115200  # s
SECOND_STEPS = 20
TURNING = 0.05  # N, m/s, rad/s
HOTEL_W, W_PER_N, WHEELS_W = 30.0, 4.0, 150.0  # W, W/N of a thruster, W at 1 m/s
DOCUMENTED: Mapping[str, str] = {}
BOARDS: dict[str, type[WaterBoard] | type[RobotBoard]] = {
    "coreboard": CoreBoard,
    "rov": RovBoard,
    "robot": RobotBoard,
}
ON_BUS: dict[str, type[WaterBoard]] = {"motorcan": MotorBoards, "mainboard": SensorBoard}


@dataclass(slots=True)
class BoardLink:
    """The board's serial line, both directions."""

    vehicle: SimulatedBoard
    name: str = "vehicle"
    closed: bool = False

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        self.closed = True

    def receive(self, now: float) -> list[Rx]:
        self._reach(now)
        queue, out = self.vehicle.queue, []
        while queue and queue[0].end <= now:
            chunk = queue.popleft()
            out.append(Rx(chunk.start, self.name, chunk.data))
        return out

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._reach(now)
        if not self.vehicle.board.troubles.deaf:
            self.vehicle.board.receive(data, now)
            self.vehicle.answer(now)

    def next_event(self) -> float | None:
        queue = self.vehicle.queue
        return queue[0].end if queue else self.vehicle.next_report

    def _reach(self, now: float) -> None:
        if self.closed:
            raise LinkClosed(f"{self.name}: the link was closed")
        self.vehicle.advance(now)


@dataclass(frozen=True, slots=True)
class NoReceiver:
    """In place of the AUV's GPS line: a line on which nothing is ever sent."""

    name: str = "gps"

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        pass

    def receive(self, now: float) -> list[Rx]:
        return []

    def send(self, data: bytes, now: float, address: str = "") -> None:
        pass

    def next_event(self) -> float | None:
        return None


class SimulatedBoard:
    def __init__(
        self,
        name: str,
        seed: int = 0,
        settings: Settings | None = None,
        *,
        position: tuple[float, float] = HOME,
        heading: float = 0.0,
        tolerances: Mapping[str, str] = DOCUMENTED,
        wire: Mapping[str, str] = DOCUMENTED,
    ) -> None:
        """``name`` is the codec's, ``position`` latitude and longitude in rad. ``tolerances`` and
        ``wire``: how the board was built, as in a vehicle file. Raises SettingError for a fault
        that this board cannot have."""
        chosen = settings or Settings()
        self._sea = chosen.sea
        self.name, self.seed, self.position = name, seed, position
        built = read_wire(vehicle_row(name).keys, wire)
        self.board = {**BOARDS, **ON_BUS}[name](Random(seed), Tolerances.parse(tolerances), built)
        self.plant: Plant | Ground = Ground(sqrt(chosen.thrust))
        if isinstance(self.board, WaterBoard):
            speed, direction = chosen.sea.current
            body = replace(chosen.pushed(self.board.body), buoyancy=chosen.body.buoyancy)
            self.board.air = chosen.errors.depth_bias or 0.0
            if chosen.sea.waves[0]:
                self.board.waves = Waves(*chosen.sea.waves, seed)
            self.plant = Plant(body, floor=chosen.sea.floor_under(position))
            self.plant.yaw = heading
            self.plant.current_north = speed * cos(direction)
            self.plant.current_east = speed * sin(direction)
        self.queue: deque[Chunk] = deque()
        self.track: list[Truth] = []
        self.vehicle_link, self.gps_link = BoardLink(self), NoReceiver()
        self._edges = edges(chosen.faults, OF_BOARDS[name], STEP, name)
        self._in_force = InForce(OF_BOARDS[name])
        self._faults = Random(f"faults {seed}")  # of its own: faults change no other draw
        self._free = 0.0
        self._step, self._report_steps = 0, round(self.board.period / STEP)
        self.thrust_used = 0.0  # J, without the power at rest (HOTEL_W)
        self._anchor = (*position, 0.0, 0.0)
        self.track.append(self.truth())

    @property
    def now(self) -> float:
        return self._step * STEP

    @property
    def next_report(self) -> float:
        done = self._step // self._report_steps
        return (done + 1) * self._report_steps * STEP

    def advance(self, to_t: float) -> None:
        last = int(to_t / STEP + 1e-6)
        while self._step < last:
            self.plant.run(1)
            self._step += 1
            while self._edges and self._edges[-1].tick <= self._step:
                self._in_force.switch(self._edges.pop(), self)
            self._control()
            if self._step % self._report_steps == 0:
                self._say(self._report())
            if self._step % SECOND_STEPS == 0:
                self.board.used += self._power()
                self.thrust_used += self._power() - HOTEL_W
                place = self.place()
                self._anchor = (*place, self.plant.north, self.plant.east)
                if isinstance(self.plant, Plant):
                    self.plant.floor = self._sea.floor_under(place)
                self.track.append(self.truth())

    def answer(self, now: float) -> None:
        """Answer a handshake by one ordinary report (E-P8)."""
        if isinstance(self.board, RobotBoard) and self.board.asked:
            self.board.asked = False
            self._say(self._report(), now)

    def restart(self) -> None:
        """Restart after a power cut: neutral until the next good frame."""
        self.board.heard = -inf

    @property
    def turning(self) -> bool:
        """Whether a thruster pushes, or the robot moves."""
        plant = self.plant
        if isinstance(plant, Ground):
            return max(abs(plant.u), abs(plant.v), abs(plant.r)) > TURNING
        return any(abs(newtons) > TURNING for newtons in plant.thrust)

    def place(self) -> tuple[float, float]:
        latitude, longitude, north, east = self._anchor
        return moved(latitude, longitude, self.plant.north - north, self.plant.east - east)

    def truth(self) -> Truth:
        plant = self.plant
        north, east = plant.ground_velocity()
        return Truth(
            self.now,
            self.position,
            *self.place(),
            plant.depth,
            plant.floor - plant.depth,
            plant.yaw % (2.0 * pi),
            plant.pitch,
            plant.roll,
            plant.u,
            plant.depth_rate,
            hypot(north, east),
            atan2(east, north) % (2.0 * pi),
            (plant.current_north, plant.current_east),
            plant.aground,
            self.thrust_used,
        )

    def _power(self) -> float:
        """W: hotel load and thrusters, or the robot's wheels."""
        plant = self.plant
        if isinstance(plant, Ground):
            return HOTEL_W + WHEELS_W * hypot(plant.u, plant.v)
        return HOTEL_W + W_PER_N * sum(abs(newtons) for newtons in plant.thrust)

    def _control(self) -> None:
        board, plant = self.board, self.plant
        if isinstance(board, RobotBoard):
            assert isinstance(plant, Ground)
            plant.drive(board.control(plant, self.now))
        elif self._step % TICK_STEPS == 0:
            assert isinstance(plant, Plant)
            plant.drive(board.control(plant, self.now))

    def _report(self) -> bytes:
        board, plant = self.board, self.plant
        if isinstance(board, RobotBoard):
            assert isinstance(plant, Ground)
            return board.report(plant)
        assert isinstance(plant, Plant)
        return board.report(plant, self.place(), self.now)

    def _say(self, data: bytes, now: float = -inf) -> None:
        troubles = self.board.troubles
        if troubles.silent or not data:
            return
        if self._faults.random() < troubles.corrupt:
            at = self._faults.randrange(len(data))
            data = data[:at] + bytes([data[at] ^ (1 << self._faults.randrange(8))]) + data[at + 1 :]
        start = max(self.now, now, self._free)
        self._free = start + len(data) * BYTE_TIME
        self.queue.append(Chunk(start, self._free, data))
