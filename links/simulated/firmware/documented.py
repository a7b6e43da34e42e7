"""Profile `documented`: exactly as in document 000, with the N readings of docs/protocol.md.

- Frames are delimited by ``@`` and ``$``, however they are split into bursts. An ``@`` starts a new
  frame. CR LF between frames is ignored. A frame has at most 64 bytes.
- The commands are independent axes: surge (F B), turn or heading (L R H), one of heave, depth and
  altitude (U D S E), attitude (A). Each keeps its value until a command of its own axis.
- ``X0`` stops everything. ``WF`` stops the mains and drives upward until another vertical command
  or ``X0``. Depth and altitude hold drive in both directions.
- Answers name the code: ``@ACK_ZFY$``; ``N`` for a value out of range, and always for V.
- ``@SD`` is sent in every mode. There is no dead-man timeout. Batteries discharge.

What does not live here: what both profiles share (stm32.py).
"""

from __future__ import annotations

import re
from math import inf, isnan, radians
from random import Random

from links.simulated.firmware.controllers import dive_gear, lean_gear, turn_gear
from links.simulated.firmware.manual import THRUSTERS, Manual
from links.simulated.firmware.stm32 import GEAR_MAX, Mode, Stm32, heading_of, level_pwm
from links.simulated.plant import Plant
from links.simulated.sensors import Sensors

FRAME_MAX = 64  # bytes

_FRAME = re.compile(rb"@[^@$]{0,%d}\$" % (FRAME_MAX - 2))
_INTEGER = re.compile(r"-?[0-9]{1,5}")
_PAIR = re.compile(r"(-?[0-9]{1,5}),(-?[0-9]{1,5})")
_ATTITUDE = re.compile(r"(-?[0-9]{1,5});(-?[0-9]{1,5})")
_MANUAL = Mode.MANUAL
_RI_ALWAYS = 0b0010001  # CTD and radio cannot be switched off


def integer(text: str, low: int, high: int) -> int | None:
    """The integer; None if it does not fit the grammar or is out of range."""
    if _INTEGER.fullmatch(text) is None:
        return None
    value = int(text)
    return value if low <= value <= high else None


class Documented(Stm32):
    reports_in_manual = True
    says_a = False
    dead_man = inf

    def __init__(self, sensors: Sensors, rng: Random) -> None:
        super().__init__(sensors, rng)
        self._buffer = b""
        self._forget()
        self.stick = Manual()

    def _forget(self) -> None:
        self.surge = self.turn = self.heave = 0.0  # gears; heave up positive
        self.heading: float | None = None
        self.depth: float | None = None
        self.altitude: float | None = None
        self.attitude: tuple[float, float] | None = None  # rad, pitch and roll

    def halt(self) -> None:
        self._forget()
        self.stick.halt()

    def frames(self, burst: bytes) -> list[bytes]:
        stream = self._buffer + burst
        found = list(_FRAME.finditer(stream))
        rest = stream[found[-1].end() :] if found else stream
        self._buffer = rest[rest.rfind(b"@") :][:FRAME_MAX] if b"@" in rest else b""
        return [match[0] for match in found]

    def automatic(self, code: str, parameter: str, now: float) -> None:
        if not ("A" <= code <= "Z"):
            return
        accepted = self._obey(code, parameter)
        self.acknowledge(f"Z{code}{'Y' if accepted else 'N'}".encode("ascii"), now)

    def _obey(self, code: str, parameter: str) -> bool:
        if code in "FBLRUD":
            value = integer(parameter, 0, GEAR_MAX)
            return value is not None and self._move(code, value)
        if code in "SE":
            level = integer(parameter, 0, 9999)
            return level is not None and self._level(code, level)
        if code == "H":
            yaw = integer(parameter, -180, 180)
            if yaw is None:
                return False
            self.heading, self.turn = heading_of(yaw), 0.0
            return True
        if code == "A":
            return self._lean(parameter)
        if (code, parameter) in (("X", "0"), ("W", "F")):
            self._forget()
            self.heave = float(GEAR_MAX) if code == "W" else 0.0
            self.drive(0.0, 0.0, self.heave, self.heave, self.heave)
            return True
        return False

    def _move(self, code: str, gear: int) -> bool:
        if code in "FB":
            self.surge = float(gear if code == "F" else -gear)
        elif code in "LR":
            self.turn, self.heading = float(gear if code == "R" else -gear), None
        else:
            self.heave = float(gear if code == "U" else -gear)
            self.depth = self.altitude = None
        return True

    def _level(self, code: str, level: int) -> bool:
        self.heave = 0.0
        self.depth, self.altitude = (float(level), None) if code == "S" else (None, float(level))
        return True

    def _lean(self, parameter: str) -> bool:
        found = _ATTITUDE.fullmatch(parameter)
        if found is None or abs(int(found[1])) > 180 or abs(int(found[2])) > 90:
            return False
        self.attitude = radians(int(found[1])), radians(int(found[2]))
        return True

    def steer(self, plant: Plant) -> None:
        if self.mode is _MANUAL:
            self.stick.steer(self.sensors.heading(plant), plant)
            self.drive(*self.stick.gears)
            return
        turn, attitude = self.turn, self.attitude
        if self.heading is not None:
            compass = self.sensors.heading(plant)
            turn = 0.0 if compass != compass else turn_gear(self.heading, compass, plant.r)
        vertical = self._vertical_gear(plant)
        left, right = self.surge + turn, self.surge - turn
        if attitude is None:
            self.pwm = level_pwm(left, right, vertical, self.servo_pwm)
            return
        pitch = lean_gear(attitude[0], plant.pitch, plant.q)
        roll = lean_gear(attitude[1], plant.roll, plant.p)
        front = vertical + pitch
        self.drive(left, right, vertical - pitch, front + roll, front - roll)

    def _vertical_gear(self, plant: Plant) -> float:
        """Gear, up positive. A silent sensor (NaN) stops the hold."""
        if self.depth is not None:
            below = self.depth - self.sensors.depth(plant)
        elif self.altitude is not None:
            below = self.sensors.altitude(plant) - self.altitude
        else:
            return self.heave
        return 0.0 if below != below else -dive_gear(below, plant.depth_rate)

    def manual(self, code: str, parameter: str) -> None:
        way, numbers = parameter[:1], parameter[1:]
        pair = _PAIR.fullmatch(parameter)
        one, two = (int(pair[1]), int(pair[2])) if pair else (0, 0)
        gear = integer(numbers, 0, GEAR_MAX)
        if code == "T" and one in THRUSTERS and abs(two) <= GEAR_MAX:
            self.stick.thruster(one, two)
        elif code == "M" and way in ("F", "B", "U", "D") and gear is not None:
            self.stick.translate(way, gear)
        elif code == "R" and way in ("L", "R", "F", "B", "U", "D") and gear is not None:
            if gear <= 5:
                self.stick.rotate(way, gear)
        elif code == "S" and 1 <= one <= 120 and abs(two) <= 180:
            self.stick.stick(one, two)
        elif code == "P" and 1 <= one <= 120 and abs(two) <= 180:
            self.stick.lean_stick(one, two)
        elif code == "D":
            self.rudder(parameter)

    def rudder(self, parameter: str) -> None:
        pair = _PAIR.fullmatch(parameter[1:])
        if pair is None or not 1 <= int(pair[1]) <= 3 or parameter[:1] not in ("A", "S"):
            return
        angle, add = int(pair[2]), parameter[0] == "A"
        limits = (-37, 37) if add else (-15, 22)
        if limits[0] <= angle <= limits[1]:
            which = {1: (0,), 2: (1,), 3: (0, 1)}[int(pair[1])]
            self.move_servo(which, angle, add=add)

    def mask(self) -> int:
        switched = sum(1 << bit for bit, on in enumerate(self.power) if on)
        return switched | _RI_ALWAYS

    def batteries(self, values: list[float]) -> tuple[int, int]:
        control, power = values[15], values[16]
        return count(control), count(power)


def count(volts: float) -> int:
    """Counts: one is one volt (E-V17); an unknown voltage is 0."""
    return 0 if isnan(volts) else min(max(round(volts), 0), 0xFFFF)
