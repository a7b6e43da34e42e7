"""The motion of the robot of document 004 on dry ground: ahead, sideways, and turns on the spot.

It has the attributes of a plant, so the same code can read both; the depth is always 0.
"""

from __future__ import annotations

from math import cos, exp, sin

from links.simulated.plant import STEP

LEVER = 0.6  # m: at a wheel speed of 1 m/s it turns on the spot by 1.67 rad/s
LAG = 0.2  # s, time constant of the drive


class Ground:
    lever = LEVER

    def __init__(self, share: float = 1.0) -> None:
        """``share`` of the commanded speeds that it reaches."""
        self._of_asked = share
        self.north = self.east = self.yaw = 0.0
        self.u = self.v = self.r = 0.0
        self.depth = self.depth_rate = self.roll = self.pitch = self.floor = 0.0
        self.current_north = self.current_east = 0.0
        self.aground = False  # its antenna is always above ground
        self._asked = (0.0, 0.0, 0.0)
        self._share = 1.0 - exp(-STEP / LAG)

    def drive(self, asked: tuple[float, float, float]) -> None:
        """Set the commanded speeds: m/s ahead and to starboard, rad/s to starboard."""
        ahead, aside, turn = asked
        share = self._of_asked
        self._asked = (share * ahead, share * aside, share * turn)

    def run(self, steps: int) -> None:
        for _ in range(steps):
            self.u += self._share * (self._asked[0] - self.u)
            self.v += self._share * (self._asked[1] - self.v)
            self.r += self._share * (self._asked[2] - self.r)
            self.yaw += STEP * self.r
            north, east = self.ground_velocity()
            self.north += STEP * north
            self.east += STEP * east

    def ground_velocity(self) -> tuple[float, float]:
        ahead, aside = (cos(self.yaw), sin(self.yaw)), (-sin(self.yaw), cos(self.yaw))
        return self.u * ahead[0] + self.v * aside[0], self.u * ahead[1] + self.v * aside[1]
