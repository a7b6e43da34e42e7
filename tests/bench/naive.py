"""The same loop made of naive parts, to measure against: nothing of ours but the firmware.

The plant in small numpy arrays, a byte-wise framer with a table CRC, pynmea2 on every line, an EKF
by its book, every guard a condition of the machine, dispatched on every tick: the edges of the
legs, and the limits that the mission and the vehicle file set, on the state around them. There is
one tick for everything, that of the dynamics (0.05 s, as in the simulation that it is held to).
It flies the same legs on the same simulated boards, sends the same ZA words, and its guards see
values that come from its own decoders and its own filter. It does less than the engine where that
costs it nothing: no acknowledge is awaited, no sensor doubted, nothing uploaded or logged.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pynmea2
from filterpy.kalman import ExtendedKalmanFilter
from transitions.extensions import HierarchicalMachine
from transitions.extensions.nesting import NestedState

from links.simulated.link import SimulatedVehicle
from links.simulated.plant import STEP, Body, Plant
from links.simulated.settings import Settings
from mission.legs import Surface
from mission.model import AUTONOMOUS, And, By, Chart, Comparison, Edge, Expression, Not, Or
from mission.model.vehicle import Vehicle

RADIUS = 6371000.0
SILENCE, BLIND, MARGIN = 5.0, 6.0, 1.0  # s without @SD, s without a reading, m beyond a depth


class NaivePlant(Plant):
    """Fossen's equations as matrices of numpy, the same parameters."""

    def __init__(self, body: Body, *, floor: float) -> None:
        super().__init__(body, floor=floor)
        b = body
        self.mass = np.diag([b.mass_u, b.mass_v, b.mass_w, b.inertia_p, b.inertia_q, b.inertia_r])

    def run(self, steps: int) -> None:
        for _ in range(steps):
            self._step()

    def _step(self) -> None:
        b = self.body
        nu = np.array([self.u, self.v, self.w, self.p, self.q, self.r])
        eta = np.array([self.north, self.east, self.depth, self.roll, self.pitch, self.yaw])
        coriolis = self._coriolis(nu, self.mass)
        damping = np.diag(np.array(b.linear) + np.array(b.quadratic) * np.abs(nu))
        damping[4, 4] += b.fin_damping * abs(nu[0])
        damping[5, 5] += b.fin_damping * abs(nu[0])
        surge, heave, roll, pitch, yaw = self._forces
        lift, z = self.buoyancy, heave
        if eta[2] < b.draft:
            lift -= b.waterplane * (b.draft - eta[2])
            z -= b.surface_damping * nu[2]
        sr, cr, sp, cp = np.sin(eta[3]), np.cos(eta[3]), np.sin(eta[4]), np.cos(eta[4])
        restoring = np.array(
            [-lift * sp, lift * cp * sr, lift * cp * cr, b.righting * cp * sr, b.righting * sp, 0.0]
        )
        fins = np.array(
            [0.0, 0.0, 0.0, 0.0, -b.fin_pitch * nu[0] * nu[2], b.fin_yaw * nu[0] * nu[1]]
        )
        rudder_pitch, rudder_roll = self._rudders
        tau = np.array(
            [surge, 0.0, z, roll + rudder_roll * nu[0] ** 2, pitch + rudder_pitch * nu[0] ** 2, yaw]
        )
        force = tau + fins - coriolis @ nu - damping @ nu - restoring
        nu = nu + STEP * np.linalg.solve(self.mass, force)
        eta_dot = self._transform(eta) @ nu
        eta_dot[:2] += (self.current_north, self.current_east)
        eta = eta + STEP * eta_dot
        if eta[2] > self.floor - b.floor_clearance:
            eta[2], nu[:3], eta_dot[2] = self.floor - b.floor_clearance, 0.0, 0.0
        self.u, self.v, self.w, self.p, self.q, self.r = (float(x) for x in nu)
        self.north, self.east, self.depth, self.roll, self.pitch, self.yaw = (float(x) for x in eta)
        self.depth_rate = float(eta_dot[2])

    @staticmethod
    def _coriolis(nu: Any, mass: Any) -> Any:
        def skew(a: Any) -> Any:
            return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])

        linear, angular = mass[:3, :3] @ nu[:3], mass[3:, 3:] @ nu[3:]
        return np.block([[np.zeros((3, 3)), -skew(linear)], [-skew(linear), -skew(angular)]])

    @staticmethod
    def _transform(eta: Any) -> Any:
        sr, cr = np.sin(eta[3]), np.cos(eta[3])
        sp, cp, tp = np.sin(eta[4]), np.cos(eta[4]), np.tan(eta[4])
        sy, cy = np.sin(eta[5]), np.cos(eta[5])
        rotation = np.array(
            [
                [cy * cp, -sy * cr + cy * sp * sr, sy * sr + cy * cr * sp],
                [sy * cp, cy * cr + sr * sp * sy, -cy * sr + sp * sy * cr],
                [-sp, cp * sr, cp * cr],
            ]
        )
        rates = np.array([[1, sr * tp, cr * tp], [0, cr, -sr], [0, sr / cp, cr / cp]])
        return np.block([[rotation, np.zeros((3, 3))], [np.zeros((3, 3)), rates]])


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        crc = byte << 24
        for _ in range(8):
            crc = (crc << 1 ^ 0x04C11DB7 if crc & 0x80000000 else crc << 1) & 0xFFFFFFFF
        table.append(crc)
    return table


class NaiveFramer:
    """One byte at a time, the CRC by a table."""

    TABLE = _crc_table()

    def __init__(self) -> None:
        self.buffer = bytearray()

    def feed(self, data: bytes) -> list[dict[str, float]]:
        found = []
        for byte in data:
            self.buffer.append(byte)
            while self.buffer and not b"@SD".startswith(self.buffer[:3]):
                del self.buffer[0]
            if self.buffer[:3] == b"@SD" and len(self.buffer) == 86:
                if (
                    self.buffer[85] == 0x24
                    and self._crc() == struct.unpack("<I", self.buffer[81:85])[0]
                ):
                    found.append(self._fields())
                self.buffer.clear()
        return found

    def _crc(self) -> int:
        crc = 0xFFFFFFFF
        padded = bytes(self.buffer[3:81]) + b"\0\0"
        for i in range(0, 80, 4):
            for byte in reversed(padded[i : i + 4]):
                crc = (crc << 8 & 0xFFFFFFFF) ^ self.TABLE[crc >> 24 ^ byte]
        return crc

    def _fields(self) -> dict[str, float]:
        names = ["roll", "pitch", "yaw", "temperature", "depth", "altitude"]
        names += [f"magnetic{i}" for i in range(9)] + [f"pwm{i}" for i in range(7)]
        names += ["control", "power"]
        return dict(zip(names, struct.unpack("<15f9H", self.buffer[3:81]), strict=True))


class NaiveFilter:
    """North, east, heading, speed, current north and east, depth, scale: filterpy's EKF."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self.kf = ExtendedKalmanFilter(dim_x=8, dim_z=3)
        self.kf.x = np.zeros((8, 1))
        self.kf.x[7] = 1.0
        self.kf.P = np.diag([25.0, 25.0, 0.1, 0.1, 0.04, 0.04, 1.0, 0.01])
        self.t = 0.0

    def predict(self, now: float) -> None:
        dt, self.t = now - self.t, now
        north, east, heading, speed, cn, ce, depth, scale = self.kf.x[:, 0]
        c, s = np.cos(heading), np.sin(heading)
        f = np.eye(8)
        f[0, 2], f[0, 3], f[0, 4], f[0, 7] = (
            -scale * speed * s * dt,
            scale * c * dt,
            dt,
            speed * c * dt,
        )
        f[1, 2], f[1, 3], f[1, 5], f[1, 7] = (
            scale * speed * c * dt,
            scale * s * dt,
            dt,
            speed * s * dt,
        )
        self.kf.F = f
        self.kf.Q = np.diag([0.01, 0.01, 0.01, 0.01, 1e-6, 1e-6, 0.1, 1e-6]) * dt
        self.kf.predict()
        self.kf.x = np.array(
            [
                [north + (scale * speed * c + cn) * dt],
                [east + (scale * speed * s + ce) * dt],
                [heading],
                [speed],
                [cn],
                [ce],
                [depth],
                [scale],
            ]
        )

    def telemetry(self, now: float, sd: dict[str, float]) -> None:
        self.predict(now)
        gear = (sd["pwm0"] + sd["pwm1"] - 3000) / 1000 * 12
        heading = math.radians(-sd["yaw"])
        error = (heading - self.kf.x[2, 0] + math.pi) % (2 * math.pi) - math.pi
        z = np.array(
            [[self.kf.x[2, 0] + error], [self.vehicle.speed_by_gear.at(gear)], [sd["depth"]]]
        )
        h = np.zeros((3, 8))
        h[0, 2] = h[1, 3] = h[2, 6] = 1.0
        self.kf.update(z, lambda x: h, lambda x: h @ x, R=np.diag([0.003, 0.01, 0.01]))

    def fix(self, now: float, north: float, east: float) -> None:
        self.predict(now)
        h = np.zeros((2, 8))
        h[0, 0] = h[1, 1] = 1.0
        z = np.array([[north], [east]])
        self.kf.update(z, lambda x: h, lambda x: h @ x, R=np.eye(2) * 6.25)


class _State(NestedState):
    separator = "/"


class _Machine(HierarchicalMachine):
    state_cls = _State


class NaiveFlight:
    """The chart of a mission of hold legs, as conditions of one machine, on one tick."""

    def __init__(
        self,
        chart: Chart,
        vehicle: Vehicle,
        words: Callable[[Any], list[bytes]],
        settings: Settings,
    ) -> None:
        self.chart, self.vehicle, self.words = chart, vehicle, words
        self.sea = SimulatedVehicle("documented", 0, settings)
        self.sea.plant = NaivePlant(self.sea.settings.body, floor=self.sea.settings.sea.floor)
        self.framer, self.filter = NaiveFramer(), NaiveFilter(vehicle)
        self.line = b""
        self.readings: dict[str, float] = {}
        self.now, self.entered, self.travelled, self.heard = 0.0, 0.0, 0.0, 0.0
        self.rounds: dict[str, int] = {}
        self.queue: list[tuple[float, bytes]] = []
        self.left = 0
        self.machine = self._machine()
        self._enter(chart.initial)

    # --- the machine: every edge a transition with conditions, all on the trigger "tick" -----

    def _machine(self) -> HierarchicalMachine:
        transitions = [
            {
                "trigger": "tick",
                "source": edge.source,
                "dest": edge.target if edge.target.startswith(AUTONOMOUS) else "over",
                "conditions": [self._condition(edge)],
                "after": [self._after(edge)],
            }
            for edge in self.chart.edges
            if edge.by not in (By.ON, By.UNCERTAIN)
        ]
        transitions += [
            {"trigger": "tick", "source": AUTONOMOUS, "dest": "emergency", "conditions": [limit]}
            for limit in self._limits()
        ]
        return _Machine(
            self,
            states=[self._tree(AUTONOMOUS), "over", "emergency"],
            transitions=transitions,
            auto_transitions=False,
            initial=self.chart.initial,
            ignore_invalid_triggers=True,
        )

    def _tree(self, path: str) -> dict[str, Any]:
        inside = [self._tree(s.path) for s in self.chart.states if s.parent == path]
        return {"name": path.rpartition("/")[2], "children": inside}

    def _limits(self) -> list[Callable[[], bool]]:
        safety, hard, seen = self.chart.mission.safety, self.vehicle.limits, self.readings
        return [
            lambda: seen.get("depth", 0.0) > (safety.depth or hard.depth) + MARGIN,
            lambda: seen.get("depth", 0.0) > hard.depth + MARGIN,
            lambda: seen.get("range", 0.0) > (safety.radius or hard.radius),
            lambda: abs(seen.get("roll", 0.0)) > hard.roll,
            lambda: self.now > (safety.time or hard.time),
            lambda: self.now - self.heard > SILENCE,
        ]

    def _condition(self, edge: Edge) -> Callable[[], bool]:
        leg = self.chart.state(edge.source).leg
        assert leg is not None

        def holds() -> bool:
            for loop in edge.loops:
                group = self.chart.state(loop.group).group
                assert group is not None
                if (self.rounds.get(loop.group, 1) < group.repeat) is not loop.again:
                    return False
            elapsed = self.now - self.entered
            if edge.guard is not None:
                return self._true(edge.guard.expression)
            if edge.by is By.ELSE:
                return self.now - self.heard > BLIND
            if edge.by is By.FOR:
                return elapsed >= (leg.duration or 0.0)
            if edge.by is By.TIMEOUT:
                return elapsed >= (leg.timeout or math.inf)
            return self.readings.get("depth", 9.0) < 0.5

        return holds

    def _after(self, edge: Edge) -> Callable[[], None]:
        def moved() -> None:
            for loop in edge.loops:
                self.rounds[loop.group] = self.rounds.get(loop.group, 1) + 1 if loop.again else 1
            self.left += 1
            if edge.target.startswith(AUTONOMOUS):
                self._enter(edge.target)

        return moved

    def _true(self, expression: Expression) -> bool:
        match expression:
            case Comparison(name, operator, bound):
                value = self.readings.get(name)
                if value is None:
                    return False
                return {
                    "<": value < bound,
                    "<=": value <= bound,
                    ">": value > bound,
                    ">=": value >= bound,
                }[operator]
            case Not(operand):
                return not self._true(operand)
            case And(operands):
                return all(self._true(o) for o in operands)
            case Or(operands):
                return any(self._true(o) for o in operands)

    def _enter(self, path: str) -> None:
        self.entered, self.travelled = self.now, 0.0
        state = self.chart.state(path)
        ascends = state.leg is not None and isinstance(state.leg.kind, Surface)
        frames = [b"@ZAWF$"] if ascends else self.words(state.setpoint)
        self.queue = [(self.now + 0.1 * (n + 1), frame) for n, frame in enumerate(frames)]

    # --- the loop, tick by tick --------------------------------------------------------------

    def fly(self, until: float) -> None:
        while self.now < until and self.state.startswith(AUTONOMOUS):
            self.now += STEP
            self._receive()
            while self.queue and self.queue[0][0] <= self.now:
                self.sea.vehicle_link.send(self.queue.pop(0)[1], self.now)
            self.readings["elapsed"] = self.now - self.entered
            self.trigger("tick")

    def _receive(self) -> None:
        for rx in self.sea.vehicle_link.receive(self.now):
            for sd in self.framer.feed(rx.data):
                self._telemetry(sd)
        for rx in self.sea.gps_link.receive(self.now):
            for byte in rx.data:
                self.line += bytes([byte])
                if byte == 10:
                    self._sentence(self.line.decode().strip())
                    self.line = b""

    def _telemetry(self, sd: dict[str, float]) -> None:
        before = self.filter.kf.x[:2, 0].copy()
        self.filter.telemetry(self.now, sd)
        self.heard = self.now
        moved = self.filter.kf.x[:2, 0] - before
        self.travelled += float(np.hypot(*moved))
        north, east = self.filter.kf.x[:2, 0]
        self.readings |= {
            "depth": sd["depth"],
            "roll": math.radians(sd["roll"]),
            "altitude": sd["altitude"],
            "battery": sd["control"],
            "travelled": self.travelled,
            "range": float(np.hypot(north, east)),
        }

    def _sentence(self, text: str) -> None:
        message = pynmea2.parse(text, check=True)
        if message.sentence_type != "GGA" or not message.gps_qual:
            return
        lat, lon = self.sea.position
        north = (math.radians(message.latitude) - lat) * RADIUS
        east = (math.radians(message.longitude) - lon) * RADIUS * math.cos(lat)
        self.filter.fix(self.now, north, east)
