"""Manual mode: five thrusters by the M commands (document 000, 1.2.2); the same in both profiles.

A command sets the thrusters that it names and does not change the others. ``MS`` (stick) moves and
holds the heading of its angle. ``MP`` leans: 90 is ahead (nose down), 0 is right.

What does not live here: parsing the text, the dead-man timeout.
"""

from __future__ import annotations

from math import cos, radians, sin

from links.simulated.firmware.controllers import turn_gear
from links.simulated.plant import Plant

STICK_GEAR = 0.1  # gears per count: 120 is gear 12
TURN_GEAR = 2.0  # MR 0..5 is thruster gear 0, 2, .. 10
THRUSTERS = {1: 0, 2: 1, 3: 3, 4: 4, 5: 2}  # MT number -> slot in the PWM list


class Manual:
    """Gears of the five thrusters in the order of the PWMs."""

    def __init__(self) -> None:
        self.gears = [0.0] * 5
        self.heading: float | None = None  # rad, held while set
        self.speed = 0.0

    def halt(self) -> None:
        self.gears = [0.0] * 5
        self.heading = None

    def thruster(self, number: int, gear: int) -> None:
        self.heading = None
        self.gears[THRUSTERS[number]] = float(gear)

    def translate(self, way: str, gear: int) -> None:
        if way in "FB":
            self.heading = None
            self.gears[:2] = [gear if way == "F" else -gear] * 2
        else:
            self.gears[2:] = [gear if way == "U" else -gear] * 3

    def rotate(self, way: str, speed: int) -> None:
        gear = TURN_GEAR * speed
        if way in "LR":
            self.heading = None
            self.gears[:2] = [-gear, gear] if way == "L" else [gear, -gear]
        elif way in "FB":  # nose up, nose down
            self._lean(gear if way == "F" else -gear, 0.0)
        else:  # lean left, lean right
            self._lean(0.0, -gear if way == "U" else gear)

    def stick(self, speed: int, angle_deg: int) -> None:
        self.heading = radians(90 - angle_deg)
        self.speed = STICK_GEAR * speed

    def lean_stick(self, force: int, angle_deg: int) -> None:
        gear, angle = STICK_GEAR * force, radians(angle_deg)
        self._lean(-gear * sin(angle), gear * cos(angle))

    def _lean(self, nose_up: float, starboard_down: float) -> None:
        self.gears[2:] = [-nose_up, nose_up + starboard_down, nose_up - starboard_down]

    def steer(self, heading: float, plant: Plant) -> None:
        if self.heading is not None:
            turn = turn_gear(self.heading, heading, plant.r)
            self.gears[:2] = [self.speed + turn, self.speed - turn]
