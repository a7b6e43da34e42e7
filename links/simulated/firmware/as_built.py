"""Profile `as-built`: the board as it exists, with all its faults.

- One burst is one frame. It begins with ``@``, ends with ``$`` and has at most 99 bytes; otherwise
  it is lost. Of two commands in one burst the board executes the first.
- Numbers are read as C's ``atoi`` does: text that is no number is 0. Only upper bounds are checked.
- Every answer has ``A`` in place of the code, and may land in the middle of an ``@SD``.
- There is one horizontal mode (off, F, B, L, R, H), one vertical mode (off, U, D, S, E), and one
  speed for both. H carries the speed itself (``ZAH-20,4``); without it the speed becomes 0. S and E
  do not change the speed and only push down, with gear 0..10.
- ``WF`` turns the verticals upward but does not change the mode: the next control loop continues as
  before. ``U12`` does set the upward mode. A does nothing, V is refused.
- Automatic mode has no dead-man timeout. Manual mode ends after 600 ms with everything off. In
  manual mode there is no ``@SD``. Batteries are constants. Rudders are servo 1 or 2.

What does not live here: what both profiles share (stm32.py).
"""

from __future__ import annotations

import enum
import re
from random import Random

from links.simulated.firmware.controllers import dive_gear, turn_gear
from links.simulated.firmware.manual import THRUSTERS, Manual
from links.simulated.firmware.stm32 import (
    GEAR_MAX,
    Mode,
    Stm32,
    heading_of,
    level_pwm,
    pwm_of,
)
from links.simulated.plant import Plant
from links.simulated.sensors import Sensors

BURST_MAX = 99  # bytes in the receive buffer
PUSH_MAX = 10.0  # gears downward in depth and altitude hold
SPLICE = 0.5  # probability that an answer due during an @SD lands inside it
_MANUAL = Mode.MANUAL
_RI_RADIO = 1 << 6  # in this build the radio is bit 6, and bit 4 a manipulator that is off

_NUMBER = re.compile(r"\s*([+-]?\d+)")
_PAIR = re.compile(r"\s*([+-]?\d+),\s*([+-]?\d+)")


class Horizontal(enum.Enum):
    OFF = ""
    AHEAD = "F"
    ASTERN = "B"
    PORT = "L"
    STARBOARD = "R"
    HEADING = "H"


class Vertical(enum.Enum):
    OFF = ""
    UP = "U"
    DOWN = "D"
    DEPTH = "S"
    ALTITUDE = "E"


_SIGNS = {  # left and right main thruster
    Horizontal.OFF: (0, 0),
    Horizontal.AHEAD: (1, 1),
    Horizontal.ASTERN: (-1, -1),
    Horizontal.PORT: (-1, 1),
    Horizontal.STARBOARD: (1, -1),
}


def atoi(text: str) -> int:
    found = _NUMBER.match(text)
    return int(found[1]) if found else 0


class AsBuilt(Stm32):
    reports_in_manual = False
    says_a = True
    dead_man = 0.6

    def __init__(self, sensors: Sensors, rng: Random) -> None:
        super().__init__(sensors, rng)
        self.splice = SPLICE
        self.horizontal, self.vertical = Horizontal.OFF, Vertical.OFF
        self._signs = _SIGNS[Horizontal.OFF]
        self.speed = 0
        self.heading = 0.0  # rad
        self.level = 0  # m, of depth or altitude hold
        self.stick = Manual()

    def frames(self, burst: bytes) -> list[bytes]:
        whole = burst[:1] == b"@" and burst[-1:] == b"$" and len(burst) <= BURST_MAX
        return [burst] if whole else []

    def halt(self) -> None:
        self.horizontal, self.vertical, self.speed = Horizontal.OFF, Vertical.OFF, 0
        self._signs = _SIGNS[Horizontal.OFF]
        self.stick.halt()

    def automatic(self, code: str, parameter: str, now: float) -> None:
        accepted = self._obey(code, parameter)
        self.acknowledge(b"ZA" + (b"Y" if accepted else b"N"), now)

    def _obey(self, code: str, parameter: str) -> bool:
        value = atoi(parameter)
        if code in "FBLR" and code:
            if value > GEAR_MAX:
                return False
            self.horizontal, self.speed = Horizontal(code), value
            self._signs = _SIGNS[self.horizontal]
        elif code in "UD" and code:
            if value > GEAR_MAX:
                return False
            self.vertical, self.speed = Vertical(code), value
        elif code in "SE" and code:
            self.vertical, self.level = Vertical(code), value
        elif code == "H":
            return self._hold_heading(parameter)
        elif code == "A":
            return _PAIR.match(parameter) is not None
        elif code == "X":
            return self._stop(parameter)
        elif code == "W":
            return self._surface(parameter)
        else:
            return False
        return True

    def _hold_heading(self, parameter: str) -> bool:
        pair = _PAIR.match(parameter)
        speed = int(pair[2]) if pair else 0
        if speed > GEAR_MAX:
            return False
        self.horizontal, self.speed = Horizontal.HEADING, speed
        self.heading = heading_of(atoi(parameter))
        return True

    def _stop(self, parameter: str) -> bool:
        if parameter[:1] != "0":
            return False
        self.halt()
        self.drive(0.0, 0.0, 0.0, 0.0, 0.0)
        return True

    def _surface(self, parameter: str) -> bool:
        if parameter[:1] != "F":
            return False
        up = pwm_of(GEAR_MAX)  # until the next control loop: the mode is unchanged
        left, right, _, _, _, servo_left, servo_right = self.pwm
        self.pwm = (left, right, up, up, up, servo_left, servo_right)
        return True

    def steer(self, plant: Plant) -> None:
        if self.mode is _MANUAL:
            self.stick.steer(self.sensors.heading(plant), plant)
            self.drive(*self.stick.gears)
            return
        speed = float(self.speed)
        if self.horizontal is Horizontal.HEADING:
            turn = turn_gear(self.heading, self.sensors.heading(plant), plant.r)
            left, right = speed + turn, speed - turn
        else:
            sign_left, sign_right = self._signs
            left, right = speed * sign_left, speed * sign_right
        self.pwm = level_pwm(left, right, self._vertical_gear(plant), self.servo_pwm)

    def _vertical_gear(self, plant: Plant) -> float:
        """Gear, up positive."""
        vertical = self.vertical
        if vertical is Vertical.OFF:
            return 0.0
        if vertical is Vertical.DEPTH:
            down = dive_gear(self.level - self.sensors.depth(plant), plant.depth_rate)
        elif vertical is Vertical.ALTITUDE:
            down = dive_gear(self.sensors.altitude(plant) - self.level, plant.depth_rate)
        else:
            return self.speed if vertical is Vertical.UP else -self.speed
        if down <= 0.0:
            return 0.0
        return -PUSH_MAX if down > PUSH_MAX else -down

    def manual(self, code: str, parameter: str) -> None:
        way, numbers = parameter[:1], parameter[1:]
        pair = _PAIR.match(parameter)
        if code == "T" and pair and int(pair[1]) in THRUSTERS and int(pair[2]) <= GEAR_MAX:
            self.stick.thruster(int(pair[1]), int(pair[2]))
        elif code == "M" and way in ("F", "B", "U", "D") and atoi(numbers) <= GEAR_MAX:
            self.stick.translate(way, atoi(numbers))
        elif code == "R" and way in ("L", "R", "F", "B", "U", "D") and atoi(numbers) <= 5:
            self.stick.rotate(way, atoi(numbers))
        elif code == "S" and pair and int(pair[1]) <= 120:
            self.stick.stick(int(pair[1]), int(pair[2]))
        elif code == "P" and pair and int(pair[1]) <= 120:
            self.stick.lean_stick(int(pair[1]), int(pair[2]))
        elif code == "D":
            self.rudder(parameter)

    def rudder(self, parameter: str) -> None:
        pair = _PAIR.match(parameter[1:])
        if pair and int(pair[1]) in (1, 2) and parameter[:1] in ("A", "S"):
            self.move_servo((int(pair[1]) - 1,), int(pair[2]), add=parameter[0] == "A")

    def mask(self) -> int:
        """The switches of the last ``@RS``, unescaped: the byte can be ``$`` or 0."""
        bits = (0, 1, 2, 3, None, 5, None)
        mask = _RI_RADIO if self.power[4] else 0
        for bit, on in zip(bits, self.power, strict=True):
            if bit is not None and on:
                mask |= 1 << bit
        return mask

    def batteries(self, values: list[float]) -> tuple[int, int]:
        return 12, 48
