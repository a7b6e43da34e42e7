"""The STM32 board: what both profiles share.

    boot -> DEFAULT --any ZA--> AUTO --any M--> MANUAL --any ZA--> AUTO
    every change of mode stops all thrusters first; a hang ends in a restart (watchdog)

``control`` is called every 0.2 s and gives the seven PWMs; ``due`` says when ``process`` has to be
called (a burst is closed, a dead man runs out); ``report`` sends the ``@SD`` that is due every 2 s.

What does not live here: how a profile reads a burst, moves and answers (documented.py,
as_built.py), sensors and their errors.
"""

from __future__ import annotations

import enum
from abc import ABC, abstractmethod
from math import degrees, floor, inf, pi
from random import Random
from struct import Struct

from links.simulated.firmware.uart import Receiver, Transmitter, turned_over
from links.simulated.plant import GEAR_PWM, NEUTRAL, NEUTRAL_PWM, SERVO_PWM, Plant
from links.simulated.sensors import Health, Sensor, Sensors
from protocol.checksum import crc32_stm32

ACK_DELAY = 0.002  # s from the end of a burst to the first byte of its answer
REPORT_PERIOD = 2.0  # s
SERVO_LOW, SERVO_HIGH = -15, 22  # deg
GEAR_MAX = 12

_FULL = float(GEAR_MAX)  # mixed with integers: twice the time
_NEUTRAL = NEUTRAL_PWM + 0.5  # rounds
_DATA = Struct("<15f9H")
_CRC = Struct("<I")
_MICROTESLA = 1e6


class Mode(enum.Enum):
    DEFAULT = "default"
    AUTO = "auto"
    MANUAL = "manual"


_DEFAULT = Mode.DEFAULT  # looked at five times a second: a member's look-up is a call


def pwm_of(gear: float) -> int:
    """us; gears beyond +-12 are cut off, fractions allowed."""
    if not -_FULL <= gear <= _FULL:
        gear = _FULL if gear > 0.0 else -_FULL
    return int(_NEUTRAL + gear * GEAR_PWM)


def level_pwm(left: float, right: float, up: float, servos: tuple[int, int]) -> tuple[int, ...]:
    """us of gears: the two mains, the three verticals alike, and the rudders as they are."""
    full, (servo_left, servo_right) = _FULL, servos
    if -full <= left <= full and -full <= right <= full and -full <= up <= full:
        neutral, gear = _NEUTRAL, GEAR_PWM
        port, starboard = floor(neutral + left * gear), floor(neutral + right * gear)
        vertical = floor(neutral + up * gear)
    else:
        port, starboard, vertical = pwm_of(left), pwm_of(right), pwm_of(up)
    return (port, starboard, vertical, vertical, vertical, servo_left, servo_right)


class Stm32(ABC):
    """One board. Sub-classes are the profiles."""

    reports_in_manual: bool
    says_a: bool  # answers every @ZA with the code A
    dead_man: float  # s without an M command in manual mode, inf: none

    def __init__(self, sensors: Sensors, rng: Random) -> None:
        self.sensors, self.rng = sensors, rng
        self.tx, self.rx = Transmitter(rng), Receiver()
        self.mode = Mode.DEFAULT
        self.pwm: tuple[int, ...] = NEUTRAL
        self.servos = [0, 0]  # deg, left and right
        self.servo_pwm = (NEUTRAL_PWM, NEUTRAL_PWM)
        self.power = [True, True, True, True, True, True, False]  # order of @RS
        self.hung = False
        self.booting = False
        self.powerless = False  # answers all, and turns no thruster
        self.deaf = False  # commands get lost
        self.garbles = 0.0  # share of commands with a bit turned over
        self.loses_acks = False
        self.answers_late = 0.0, rng  # s at most, each as drawn
        self.dives: list[str] = []  # at full power whatever is asked, each until this code, or ""
        self.ignores: set[str] = set()  # codes of @ZA that it does not hear
        self.refuses = ""  # codes of @ZA that it answers N
        self.late = 0.0  # s from a command until it is obeyed
        self.busy, self._busy_until = 0.0, 0.0  # s in which it hears nothing behind a word
        self.splice = 0.0  # chance that an answer lands inside the @SD being sent
        self._dead_man_at = self.due = inf  # due: asked for much more often than it changes

    # --- the vehicle's clockwork -----------------------------------------------------------

    def _foresee(self) -> None:
        self.due = min(self.rx.due, self._dead_man_at)

    @property
    def reporting(self) -> bool:
        running = not (self.hung or self.booting or self.tx.silent)
        return running and (self.reports_in_manual or self.mode is not Mode.MANUAL)

    def receive(self, data: bytes, now: float) -> None:
        self.rx.feed(data, now + self.late)
        self._foresee()

    def process(self, now: float) -> None:
        """Whatever ``due`` announced for ``now``."""
        if self._dead_man_at <= now:
            self._dead_man_at = inf
            if not self.hung:
                self.change(Mode.DEFAULT)
        if self.rx.due <= now:
            burst = self.rx.take()
            if self.garbles and self.rng.random() < self.garbles:
                burst = turned_over(burst, self.rng)
            if not (self.hung or self.booting or self.deaf or now < self._busy_until):
                for frame in self.frames(burst):
                    self._execute(frame, now)
                    self._busy_until = now + self.busy
        self._foresee()

    def control(self, plant: Plant) -> tuple[int, ...]:
        """The PWMs from now to the next call."""
        if self.hung:
            return self.pwm
        if self.booting or self.powerless:
            self.pwm = NEUTRAL
            return NEUTRAL
        if self.mode is not _DEFAULT:
            self.steer(plant)
        if self.dives:
            left, right, _, _, _, servo_left, servo_right = self.pwm
            down = pwm_of(-GEAR_MAX)
            self.pwm = (left, right, down, down, down, servo_left, servo_right)
        return self.pwm

    def report(self, plant: Plant, now: float) -> None:
        """Sample the sensors and send ``@SD``, if the board does that now."""
        values = self.sensors.sample(plant, now)
        if self.reporting:
            self.tx.send(self.telemetry(values), now)

    def restart(self) -> None:
        """Brown-out or watchdog: nothing is remembered."""
        self.rx.clear()
        self.hung = False
        self.servos = [0, 0]
        self._place_servos()
        self.change(Mode.DEFAULT)

    # --- frames ----------------------------------------------------------------------------

    def telemetry(self, values: list[float]) -> bytes:
        yaw = -(degrees(values[2]) % 360.0)
        if yaw < -180.0:
            yaw += 360.0
        control, power = self.batteries(values)
        data = _DATA.pack(
            degrees(values[0]),
            degrees(values[1]),
            yaw,
            values[3],
            values[4],
            values[5],
            *[value * _MICROTESLA for value in values[6:15]],
            *self.pwm,
            control,
            power,
        )
        return b"@SD" + data + _CRC.pack(crc32_stm32(data)) + b"$"

    def acknowledge(self, answer: bytes, now: float) -> None:
        if self.loses_acks:
            return
        frame, at = b"@ACK_" + answer + b"$", now + ACK_DELAY
        most, rng = self.answers_late
        if most:
            at += rng.uniform(0.0, most)
        spliced = self.splice > 0.0 and self.rng.random() < self.splice
        if not (spliced and self.tx.cut_in(frame, at)):
            self.tx.send(frame, at)

    def _execute(self, frame: bytes, now: float) -> None:
        text = frame[1:-1].decode("ascii", "replace")
        if text.startswith("ZA"):
            code = text[2:3]
            if code and code in self.ignores:
                return
            if code and code in self.refuses:
                self.acknowledge(b"ZAN" if self.says_a else b"Z%bN" % code.encode("ascii"), now)
                return
            if code and self.dives:
                self.dives = [until for until in self.dives if until != code]
            if self.mode is not Mode.AUTO:
                self.change(Mode.AUTO)
            self.automatic(code, text[3:], now)
        elif text.startswith("M"):
            if self.mode is not Mode.MANUAL:
                self.change(Mode.MANUAL)
            self._dead_man_at = now + self.dead_man
            self.manual(text[1:2], text[2:])
        elif text.startswith("D"):
            self.rudder(text[1:])
        elif text.startswith("RS"):
            self.switch(text[2:], now)
        elif text == "RI":
            self.acknowledge(b"RI" + bytes([self.mask()]), now)

    def switch(self, letters: str, now: float) -> None:
        if len(letters) != 7 or set(letters) - {"O", "C"}:
            return
        self.power = [letter == "O" for letter in letters]
        for sensor, slot in ((Sensor.ALTITUDE, 1), (Sensor.MAGNETOMETER, 5)):
            if not self.power[slot]:
                self.sensors.health[sensor] = Health.SILENT
            elif self.sensors.health.get(sensor) is Health.SILENT:
                del self.sensors.health[sensor]
        self.acknowledge(b"RSS", now)

    def change(self, mode: Mode) -> None:
        """Stops everything first; rudders stay where they are."""
        self.mode = mode
        self._dead_man_at = inf
        self._foresee()
        self.halt()
        self.drive(0.0, 0.0, 0.0, 0.0, 0.0)

    def drive(self, left: float, right: float, rear: float, front_l: float, front_r: float) -> None:
        """Gears of the five thrusters (verticals up positive); the rudders as they are."""
        five = map(pwm_of, (left, right, rear, front_l, front_r))
        self.pwm = (*five, *self.servo_pwm)

    def move_servo(self, which: tuple[int, ...], angle: int, *, add: bool) -> None:
        for i in which:
            wanted = self.servos[i] + angle if add else angle
            self.servos[i] = min(max(wanted, SERVO_LOW), SERVO_HIGH)
        self._place_servos()

    def _place_servos(self) -> None:
        left, right = self.servos
        self.servo_pwm = int(NEUTRAL_PWM + left * SERVO_PWM), int(NEUTRAL_PWM + right * SERVO_PWM)
        self.pwm = (*self.pwm[:5], *self.servo_pwm)

    # --- what a profile decides ------------------------------------------------------------

    @abstractmethod
    def frames(self, burst: bytes) -> list[bytes]:
        """The frames, ``@`` to ``$``, that the board sees in a burst."""

    @abstractmethod
    def automatic(self, code: str, parameter: str, now: float) -> None:
        """A ``@ZA``; answers it."""

    @abstractmethod
    def manual(self, code: str, parameter: str) -> None:
        """An ``@M``; never answered."""

    @abstractmethod
    def rudder(self, parameter: str) -> None:
        """``A2,-2`` or ``S3,20``; never answered."""

    @abstractmethod
    def steer(self, plant: Plant) -> None:
        """Set ``pwm`` by the set points."""

    @abstractmethod
    def halt(self) -> None:
        """Forget all set points."""

    @abstractmethod
    def mask(self) -> int:
        """The byte of ``@RI``."""

    @abstractmethod
    def batteries(self, values: list[float]) -> tuple[int, int]:
        """Counts of the control and the power battery."""


def heading_of(yaw_deg: float) -> float:
    """Wire yaw (90 west) to heading, rad."""
    return -yaw_deg * pi / 180.0
