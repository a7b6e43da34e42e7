"""The STM32 board: the part that both profiles share.

    boot -> DEFAULT --any ZA--> AUTO --any M--> MANUAL --any ZA--> AUTO
    every change of mode stops all thrusters first; a hang ends in a restart (watchdog)

``control`` is called every 0.2 s and returns the seven PWMs. ``process`` has to be called at
``due`` (the end of a burst, or the dead-man timeout). ``report`` sends the ``@SD`` every 2 s.

What does not live here: how a profile parses a burst, moves and answers (documented.py,
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

_FULL = float(GEAR_MAX)  # a float: mixing with integers takes twice the time
_NEUTRAL = NEUTRAL_PWM + 0.5  # so that truncation rounds
_DATA = Struct("<15f9H")
_CRC = Struct("<I")
_MICROTESLA = 1e6


class Mode(enum.Enum):
    DEFAULT = "default"
    AUTO = "auto"
    MANUAL = "manual"


_DEFAULT = Mode.DEFAULT  # used five times a second: looking up the member costs a call


def pwm_of(gear: float) -> int:
    """PWM of a gear, us. Gears are clamped to +-12; fractions are allowed."""
    if not -_FULL <= gear <= _FULL:
        gear = _FULL if gear > 0.0 else -_FULL
    return int(_NEUTRAL + gear * GEAR_PWM)


def level_pwm(left: float, right: float, up: float, servos: tuple[int, int]) -> tuple[int, ...]:
    """PWMs, us, from gears: two mains, three equal verticals, and the rudders unchanged."""
    full, (servo_left, servo_right) = _FULL, servos
    if -full <= left <= full and -full <= right <= full and -full <= up <= full:
        neutral, gear = _NEUTRAL, GEAR_PWM
        port, starboard = floor(neutral + left * gear), floor(neutral + right * gear)
        vertical = floor(neutral + up * gear)
    else:
        port, starboard, vertical = pwm_of(left), pwm_of(right), pwm_of(up)
    return (port, starboard, vertical, vertical, vertical, servo_left, servo_right)


class Stm32(ABC):
    """One board. The subclasses are the profiles."""

    reports_in_manual: bool
    says_a: bool  # it answers every @ZA with the code A
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
        self.powerless = False  # answers everything, but turns no thruster
        self.deaf = False  # commands are lost
        self.garbles = 0.0  # share of bursts received with a flipped bit
        self.loses_acks = False
        self.answers_late = 0.0, rng  # s: greatest random delay of an answer; its generator
        self.dives: list[str] = []  # dives at full power, each until this code; "": until its end
        self.ignores: set[str] = set()  # codes of @ZA that it ignores
        self.refuses = ""  # codes of @ZA that it answers N
        self.late = 0.0  # s by which commands are obeyed late
        self.busy, self._busy_until = 0.0, 0.0  # s after a command in which it receives nothing
        self.splice = 0.0  # probability that an answer lands inside the @SD being sent
        self._dead_man_at = self.due = inf  # due: kept, since it is read far more than it changes

    # --- time ------------------------------------------------------------------------------

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
        """Do what ``due`` announced for ``now``."""
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
        """Return the PWMs from now to the next call."""
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
        """Sample the sensors, and send ``@SD`` if the board reports in this state."""
        values = self.sensors.sample(plant, now)
        if self.reporting:
            self.tx.send(self.telemetry(values), now)

    def restart(self) -> None:
        """Restart after a brown-out or by the watchdog: the board forgets everything."""
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
        """Change the mode, stopping everything first. The rudders keep their angles."""
        self.mode = mode
        self._dead_man_at = inf
        self._foresee()
        self.halt()
        self.drive(0.0, 0.0, 0.0, 0.0, 0.0)

    def drive(self, left: float, right: float, rear: float, front_l: float, front_r: float) -> None:
        """Set the gears of the five thrusters (verticals up positive), not the rudders."""
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
        """Return the frames, ``@`` to ``$``, that the board finds in a burst."""

    @abstractmethod
    def automatic(self, code: str, parameter: str, now: float) -> None:
        """Execute a ``@ZA`` and answer it."""

    @abstractmethod
    def manual(self, code: str, parameter: str) -> None:
        """Execute an ``@M``, which is never answered."""

    @abstractmethod
    def rudder(self, parameter: str) -> None:
        """Execute a rudder command, ``A2,-2`` or ``S3,20``, which is never answered."""

    @abstractmethod
    def steer(self, plant: Plant) -> None:
        """Set ``pwm`` from the setpoints."""

    @abstractmethod
    def halt(self) -> None:
        """Forget all setpoints."""

    @abstractmethod
    def mask(self) -> int:
        """The byte in the answer to ``@RI``."""

    @abstractmethod
    def batteries(self, values: list[float]) -> tuple[int, int]:
        """Counts of the control and the power battery."""


def heading_of(yaw_deg: float) -> float:
    """Heading, rad, from the yaw on the wire (90 is west)."""
    return -yaw_deg * pi / 180.0
