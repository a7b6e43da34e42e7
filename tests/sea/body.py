"""The vehicle's body: hull, thrusters, rudders, trim, floor and surface.

Two main thrusters, three vertical ones and two stern rudders; 24 gears, of which 10 already is full
speed; below gear 5 the verticals do not overcome the buoyancy; PWM 1000..2000 us, 1500 neutral. What
thrust a gear has follows from that and from the rates of the hull: 25 N of three verticals at gear 10
lift this hull at 0.5 m/s and sink it at 0.36 m/s against a net buoyancy of 8 N; at gear 5 they have
8.8 N. Two mains at gear 10 have 25 N, which is 1.25 m/s.

The thrusters push in the axes of the body: upside down, "up" pushes down.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field, replace

from tests.sea import hull

FULL = 10  # gear
VERTICAL = 25.0  # N, three together at full speed
MAIN = 25.0  # N, two together
ARM = 0.25  # m, a main thruster from the middle
RUDDER = 9.64  # kg/(m rad), lift of a stern fin (Prestero: Z_uuds)
SPOOL = 0.3  # s, until a thruster has 63 % of a new speed


def thrust(gear: float, full: float, power: float) -> float:
    """Force in N of a group at a gear (-12..12), saturated at gear 10."""
    share = min(abs(gear), FULL) / FULL
    return math.copysign(full * share**power, gear)


def pwm(gear: float) -> int:
    """Pulse width in us that stands for a gear."""
    return round(1500 + max(-12.0, min(12.0, gear)) * 500 / 12)


@dataclass
class Gears:
    """What the thrusters are told: gears, positive ahead and up; rudders in degrees, up positive."""

    left: float = 0.0
    right: float = 0.0
    up: tuple[float, float, float] = (0.0, 0.0, 0.0)  # left front, right front, rear
    rudder: tuple[float, float] = (0.0, 0.0)

    def turning(self) -> bool:
        """Whether any thruster is told to turn."""
        return bool(self.left or self.right or any(self.up))


@dataclass
class Body:
    """The vehicle in the water. `buoyancy` (N) and `ballast` (m) may change during a scene."""

    seed: int = 0
    buoyancy: float = 8.0
    ballast: float = hull.BALLAST
    floor: float = 60.0  # m
    current: tuple[float, float] = (0.0, 0.0)  # m/s north, east
    yaw: float = 0.0  # rad
    pose: hull.Pose = field(default_factory=hull.Pose)
    deepest: float = 0.0
    _gears: list[float] = field(default_factory=lambda: [0.0] * 5)

    def __post_init__(self) -> None:
        self.random = random.Random(f"body {self.seed}")
        self.pose = replace(self.pose, q=hull.quaternion(self.yaw))

    @property
    def depth(self) -> float:
        """True depth of the hull's middle in m."""
        return self.pose.z

    @property
    def altitude(self) -> float:
        """True height above the floor in m."""
        return self.floor - self.pose.z

    def rate(self) -> float:
        """True vertical speed in m/s, downward positive."""
        row = hull.rotation(self.pose.q)[2]
        return sum(r * v for r, v in zip(row, self.pose.v, strict=True))

    def step(self, gears: Gears, dt: float) -> None:
        """Move for dt seconds (0.02 to 0.05) with these gears."""
        wanted = [gears.left, gears.right, *gears.up]
        self._gears = [
            g + (w - g) * min(1.0, dt / SPOOL) for g, w in zip(self._gears, wanted, strict=True)
        ]
        self.pose = hull.move(self.pose, self._load(gears), dt)
        if self.pose.z > self.floor - 0.1:
            self.pose = replace(self.pose, z=self.floor - 0.1, v=(0.0, 0.0, 0.0))
        self.deepest = max(self.deepest, self.pose.z)

    def _load(self, gears: Gears) -> hull.Load:
        left, right = (thrust(g, MAIN / 2, 2.0) for g in self._gears[:2])
        wet = min(1.0, max(0.0, (self.pose.z + 0.05) / 0.1))  # a screw in the air pushes nothing
        ups = [-thrust(g, VERTICAL / 3, 1.5) * wet for g in self._gears[2:]]
        u = self.pose.v[0]
        fins = RUDDER * u * abs(u) * math.radians(sum(gears.rudder)) / 2
        roll_kick = 0.02 * self.random.gauss(0, 1)
        return hull.Load(
            force=(left + right, 0.0, sum(ups)),
            moment=(
                0.15 * (ups[1] - ups[0]) + roll_kick,
                -0.4 * (ups[0] + ups[1]) + 0.8 * ups[2] + 0.6 * fins,
                ARM * (left - right),
            ),
            buoyancy=self.buoyancy,
            ballast=self.ballast,
            current=(*self.current, 0.0) if self.pose.z < self.floor - 0.2 else (0.0, 0.0, 0.0),
        )

    def attitude(self) -> tuple[float, float, float]:
        """Roll, pitch, heading in degrees, aerospace order: roll +-180, pitch +-90, heading 0..360."""
        r0, r1, r2 = hull.rotation(self.pose.q)
        roll = math.degrees(math.atan2(r2[1], r2[2]))
        pitch = math.degrees(math.asin(max(-1.0, min(1.0, -r2[0]))))
        return roll, pitch, math.degrees(math.atan2(r1[0], r0[0])) % 360

    def attitude_turned(self) -> tuple[float, float, float]:
        """The same as seed 000 ranges it: roll +-90, pitch +-180 (a sensor a quarter turn about)."""
        r0, r1, r2 = hull.rotation(self.pose.q)
        roll = math.degrees(math.asin(max(-1.0, min(1.0, r2[1]))))
        pitch = math.degrees(math.atan2(-r2[0], r2[2]))
        return roll, pitch, math.degrees(math.atan2(-r0[1], r1[1])) % 360

    def turn_over(self) -> None:
        """The ballast slides to the other side: what was the bottom comes up."""
        self.ballast = -abs(self.ballast)
        p, q, r = self.pose.w
        self.pose = replace(self.pose, w=(p + 0.5, q, r))
