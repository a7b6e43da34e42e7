"""The boards of documents 002, 003 and 004. They receive frames and send reports unasked.

    core board   002  62 bytes in (six forces, one closed loop), 90 bytes out at 10 Hz
    ROV          003  30 bytes in (three efforts, two hold flags), 71 bytes out at 20 Hz
    robot        004  12 bytes in (one command), 7 bytes out at 10 Hz

All use 115200 8N1. A board that receives no good frame for its timeout (R16, R17) goes neutral and
leaves its closed loop. It ignores frames with any error.

What does not live here: the water (plant.py), the ground (ground.py), time and links (boards.py one
package up), the STM32 of the AUV (stm32.py).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, degrees, inf, pi, radians, remainder, sin, sqrt, tau
from random import Random
from typing import Any

from links.simulated.firmware.controllers import dive_gear, turn_gear
from links.simulated.firmware.ins import Ins, Place
from links.simulated.firmware.stm32 import GEAR_MAX, level_pwm
from links.simulated.ground import Ground
from links.simulated.plant import NEUTRAL, NEUTRAL_PWM, REAR, Body, Plant
from links.simulated.sensors import turned
from links.simulated.waves import Waves, felt
from protocol.framing import Frame, LinkRow
from protocol.tolerances import Tolerances
from protocol.vehicles import coreboard, robot, robot_outputs, rov
from protocol.vehicles.keys import Wire

DEPTH, _ANGLE, _HEADING = 0.03, radians(0.3), radians(0.5)  # one sigma, m and rad
WILD = 0.0, 60.0  # m: range of wild depths
CONTROL_V, POWER_V = 24.0, 48.0
_FULL_RPM = 1000.0

FULL_J, FLAT = 1.0e6, 0.8  # energy of a full battery; share of its voltage when it is empty


@dataclass(slots=True)
class Troubles:
    """The faults in force on a board (board_faults); 0: none."""

    silent: float = 0.0  # it sends nothing
    deaf: float = 0.0  # it receives nothing
    corrupt: float = 0.0  # share of its frames with a flipped bit
    depth_frozen: float = 0.0
    wild: float = 0.0  # share of random depths
    slow: float = 0.0  # s for which its sensors repeat one reading
    volts: float = 0.0  # V that its control battery reports, whatever the truth
    leak: float = 0.0  # water inside


# An open frame of 25 kg, as wide as it is long: no fins, slow and stiff.
ROV = Body(
    mass_u=45.0,
    mass_v=60.0,
    mass_w=70.0,
    inertia_p=3.0,
    inertia_q=3.5,
    inertia_r=4.0,
    linear=(4.0, 12.0, 14.0, 3.0, 4.0, 4.0),
    quadratic=(73.0, 140.0, 209.0, 4.0, 8.0, 21.0),
    fin_pitch=0.0,
    fin_yaw=0.0,
    fin_damping=0.0,
    righting=40.0,
    waterplane=800.0,
    surface_damping=150.0,
    main_thrust=25.0,
    vertical_thrust=22.3,
    arm_main=0.2,
    arm_front=0.0,
    rudder_pitch=0.0,
    rudder_roll=0.0,
)


class Board(ABC):
    """A board. ``period``: s between reports; ``silence``: s without a command until neutral."""

    hears: LinkRow
    period: float
    silence: float

    def __init__(self, rng: Random, tolerances: Tolerances, wire: Wire) -> None:
        """``tolerances`` and ``wire``: how this board was built, as in a vehicle file."""
        self.rng, self.tolerances, self.wire = rng, tolerances, wire
        self.heard = -inf
        self.troubles = Troubles()
        self.used = 0.0  # J
        self._framer = self.hears.framer(tolerances)

    def receive(self, data: bytes, now: float) -> None:
        timer = self._framer.next_timer()
        stale = self._framer.flush(now) if timer is not None and timer <= now else []
        for item in (*stale, *self._framer.receive(data, now)):
            if isinstance(item, Frame):
                self.heard = now
                self.take(item.values())

    def awake(self, now: float) -> bool:
        return now - self.heard <= self.silence

    def volts(self, full: float) -> float:
        """Voltage of a battery with ``full`` V when full; it falls with use."""
        left = max(1.0 - self.used / FULL_J, 0.0)
        return full * (FLAT + (1.0 - FLAT) * left)

    def control_volts(self) -> float:
        return self.troubles.volts or self.volts(CONTROL_V)

    @abstractmethod
    def take(self, values: Mapping[str, Any]) -> None:
        """Take the values of a good frame."""


class WaterBoard(Board):
    """A board that drives the thrusters of a plant, with a ``body`` of its own."""

    body = Body()
    waves: Waves | None = None
    air = 0.0  # m: depth offset from air pressure
    _depth: float | None = None  # the last reported one
    _posed: tuple[float, tuple[float, float, float, float]] | None = None  # time, s, and reading

    @abstractmethod
    def control(self, plant: Plant, now: float) -> tuple[int, ...]:
        """Return the seven PWMs from now on."""

    @abstractmethod
    def report(self, plant: Plant, place: Place, now: float) -> bytes: ...

    def _pose(self, plant: Plant, now: float) -> tuple[float, float, float, float]:
        """Roll, pitch, yaw in deg and depth in m by its sensors: the last reading again while they
        are slower than its reports."""
        slow = self.troubles.slow
        if self._posed is None or not slow or now >= self._posed[0] + slow:
            self._posed = now, self._pose_now(plant, now)
        return self._posed[1]

    def _pose_now(self, plant: Plant, now: float) -> tuple[float, float, float, float]:
        gauss, troubles = self.rng.gauss, self.troubles
        here = felt(self.waves, now, plant.depth)
        if self._depth is None or not troubles.depth_frozen:
            self._depth = plant.depth + self.air + here.head + gauss(0.0, DEPTH)
        if troubles.wild and not troubles.depth_frozen and self.rng.random() < troubles.wild:
            self._depth = self.rng.uniform(*WILD)
        yaw = plant.yaw + turned(here) + gauss(0.0, _HEADING)
        return (
            degrees(remainder(plant.roll + here.roll + gauss(0.0, _ANGLE), tau)),
            degrees(plant.pitch + here.pitch + gauss(0.0, _ANGLE)),
            degrees((yaw + pi) % (2.0 * pi) - pi),
            self._depth,
        )


def pwms(surge: float, turn: float, up: float) -> tuple[int, ...]:
    """PWMs from gears: ``turn`` positive to starboard, ``up`` upward; rudders in the middle."""
    return level_pwm(surge + turn, surge - turn, up, (NEUTRAL_PWM, NEUTRAL_PWM))


class CoreBoard(WaterBoard):
    """In closed loop the board holds heading and depth; surge stays open loop (002 table 3-2). The
    INS has no power until a frame switches it on (byte 43)."""

    hears = coreboard.LINKS[2]
    period = 0.1
    silence = coreboard.SILENCE

    def __init__(self, rng: Random, tolerances: Tolerances, wire: Wire) -> None:
        super().__init__(rng, tolerances, wire)
        self.values: Mapping[str, Any] = coreboard.NEUTRAL
        self._ins = Ins(rng)
        self._report = coreboard.main_to_pc(tolerances)

    def take(self, values: Mapping[str, Any]) -> None:
        self.values = values
        self._ins.switch(bool(values["ins_on"]), self.heard)  # it keeps its last state

    def control(self, plant: Plant, now: float) -> tuple[int, ...]:
        if not self.awake(now):
            return NEUTRAL
        v = self.values
        surge, turn, down = (GEAR_MAX * v[name] / 100.0 for name in ("tx", "mz", "tz"))
        if v["closed_loop"]:
            turn = turn_gear(radians(v["heading_deg"]), plant.yaw, plant.r)
            down = dive_gear(v["depth_m"] - self.air - plant.depth, plant.depth_rate)
        return pwms(surge, turn, -down)

    def report(self, plant: Plant, place: Place, now: float) -> bytes:
        roll, pitch, yaw, depth = self._pose(plant, now)
        own = self._ins.place(place, plant.depth, now)
        values = {
            "roll_deg": roll,
            "pitch_deg": pitch,
            "yaw_deg": yaw,
            "lat_deg": degrees(own[0]) if own else 0.0,
            "lon_deg": degrees(own[1]) if own else 0.0,
            "x_m": 0.0,
            "y_m": 0.0,
            "depth_m": depth,
            "altitude_m": plant.floor - plant.depth + self.rng.gauss(0.0, DEPTH),
            "avoid_m": 0.0,
            "reserved50": "00" * 12,
            "mode": 0,
            "temperature_c": 18.0,
            "control_v": self.control_volts(),
            "power_v": self.volts(POWER_V),
            "leak": self._leak(),
            **{f"usbl{n}": 0.0 for n in range(1, 7)},
            "ins_aligned": int(own is not None),
            "reserved83": "00" * 4,
        }
        return self._report.encode(values)

    def _leak(self) -> int:
        """The leak byte, with the digit for dry that this board was built with."""
        wet = int(self.tolerances["leak002"])
        return wet if self.troubles.leak else 1 - wet


class RovBoard(WaterBoard):
    """The flags hold the heading and depth of the moment at which they are set. It has four
    thrusters: the third vertical of the plant stands still."""

    body = ROV
    hears = rov.LINKS[0]
    period = rov.PERIOD
    silence = rov.SILENCE

    def __init__(self, rng: Random, tolerances: Tolerances, wire: Wire) -> None:
        super().__init__(rng, tolerances, wire)
        self.values: Mapping[str, Any] = rov.NEUTRAL
        self.held: dict[str, float] = {}
        self.pwm: tuple[int, ...] = NEUTRAL
        self._report = rov.up(tolerances)

    def take(self, values: Mapping[str, Any]) -> None:
        self.values = values

    def control(self, plant: Plant, now: float) -> tuple[int, ...]:
        values = self.values if self.awake(now) else rov.NEUTRAL
        full = rov.full_effort(self.tolerances)
        surge, turn, up = (GEAR_MAX * values[name] / full for name in ("x", "z", "f"))
        for flag, here in (("hold_heading", plant.yaw), ("hold_depth", plant.depth)):
            if not values[flag]:
                self.held.pop(flag, None)
            self.held = {flag: here, **self.held} if values[flag] else self.held
        if "hold_heading" in self.held:
            turn = turn_gear(self.held["hold_heading"], plant.yaw, plant.r)
        if "hold_depth" in self.held:
            up = -dive_gear(self.held["hold_depth"] - plant.depth, plant.depth_rate)
        ahead = pwms(surge, turn, up)
        self.pwm = (*ahead[:REAR], NEUTRAL_PWM, *ahead[REAR + 1 :])
        return self.pwm

    def report(self, plant: Plant, place: Place, now: float) -> bytes:
        roll, pitch, yaw, depth = self._pose(plant, now)
        turning = [round((pwm - NEUTRAL_PWM) * _FULL_RPM / 500) for pwm in self.pwm[:5]]
        values = {
            "ax_g": sin(plant.pitch),
            "ay_g": -sin(plant.roll) * cos(plant.pitch),
            "az_g": -cos(plant.roll) * cos(plant.pitch),
            "gx_dps": degrees(plant.p),
            "gy_dps": degrees(plant.q),
            "gz_dps": degrees(plant.r),
            "ex_deg": roll,
            "ey_deg": pitch,
            "ez_deg": yaw,
            "depth_m": depth,
            "rpm_left_front": turning[0],
            "rpm_right_front": turning[1],
            "rpm_left_up": turning[3],
            "rpm_right_up": turning[4],
            "temperature_c": 18,
            "metal_pct": 0,
        }
        return self._report.encode(values)


_HALF = sqrt(0.5)
WAYS = {  # by command: shares of its speed ahead, to starboard, turning to starboard
    robot.FORWARD: (1.0, 0.0, 0.0),
    robot.BACK: (-1.0, 0.0, 0.0),
    3: (_HALF, _HALF, 0.0),
    4: (_HALF, -_HALF, 0.0),
    5: (-_HALF, _HALF, 0.0),
    6: (-_HALF, -_HALF, 0.0),
    7: (0.0, 1.0, 0.0),
    8: (0.0, -1.0, 0.0),
    robot.SPIN_RIGHT: (0.0, 0.0, 1.0),
    robot.SPIN_LEFT: (0.0, 0.0, -1.0),
}


class RobotBoard(Board):
    """One motion at a time, at the last set speed. It answers a handshake at once."""

    hears = robot.LINKS[0]
    period = 0.1
    silence = robot.SILENCE

    def __init__(self, rng: Random, tolerances: Tolerances, wire: Wire) -> None:
        super().__init__(rng, tolerances, wire)
        self.motion, self.speed = robot.STOP, 0.0  # mm/s
        self.asked = False  # a handshake asks for one report
        self._report = robot.up(tolerances)

    def take(self, values: Mapping[str, Any]) -> None:
        command = values["command"]
        if values["address"] != robot_outputs.ROBOT:
            return
        if command == robot.SPEED:
            self.speed = values["speed_mm_s"] * self.wire["speed_step"]
        elif command == robot_outputs.HANDSHAKE:
            self.asked = True
        else:
            self.motion = command

    def control(self, ground: Ground, now: float) -> tuple[float, float, float]:
        """Return m/s ahead and to starboard, rad/s to starboard. On the spot, the turn rate is the
        wheel speed over the lever. "Right up" is half ahead, half to the right."""
        speed = self.speed / 1000.0 if self.awake(now) else 0.0
        ahead, aside, spin = WAYS.get(self.motion, (0.0, 0.0, 0.0))
        return ahead * speed, aside * speed, spin * speed / ground.lever

    def report(self, ground: Ground) -> bytes:
        volts = self.control_volts() + self.rng.gauss(0.0, 0.02)
        speed = 1000.0 * ground.u / self.wire["speed_step"]
        return self._report.encode(
            {"speed_mm_s": round(speed), "voltage_mv": round(1000.0 * volts)}
        )
