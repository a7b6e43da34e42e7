"""The STM32 of document 000, as built and as documented.

As built: one UART burst is one frame; every Z is answered `@ACK_ZAY$` or `N`; one
horizontal mode, one vertical mode, one speed for both; W starts the verticals for a millisecond; depth
and altitude holds only push down; no `@SD` in manual; a dead man of 600 ms there and none in automatic;
batteries 12 and 48 for ever; an acknowledgement may land in the middle of an `@SD`.
As documented (seed 000): a stream of frames, an axis each, W that holds, holds that push both ways.

Where the documents leave room this board takes its own way: the first `@SD` comes at any phase, later
ones with 60 ms of jitter; roll and pitch in the ranges of the seed (upside down is a pitch of 180);
an acknowledgement comes 5 to 60 ms late; it starts in automatic with everything stopped.
"""

from __future__ import annotations

import math
import random
import re
import struct
from dataclasses import dataclass, field

from tests.sea.body import Body, Gears, pwm
from tests.sea.faults import Lie, Will, honest
from tests.sea.wire import Line, crc_stm32

PERIOD = 2.0  # s between reports (3.2)
DEAD_MAN = 0.6  # s without M
LONGEST = 99  # bytes of a burst that is still understood
RANGE = 30.0  # m, of the altimeter


def wrap(angle: float) -> float:
    """An angle in degrees, -180..180."""
    return (angle + 180) % 360 - 180


@dataclass
class Word:
    """What the board has understood: when, the bytes, and whether it said Y."""

    at: float
    text: str
    done: bool


@dataclass
class Senses:
    """What is told of each quantity; `honest` unless a scene says otherwise."""

    depth: Lie = honest
    altitude: Lie = honest
    heading: Lie = honest
    roll: Lie = honest
    pitch: Lie = honest
    control: Lie = honest
    leak: Lie = honest
    depth_noise: float = 0.03  # m
    heading_bias: float = 6.0  # deg, compass of the JY901 class


@dataclass
class Board:
    """The STM32 `built` as it is or as its document says, on `line`, in `body`."""

    body: Body
    line: Line
    seed: int = 0
    built: bool = True
    carried: bool = False  # the build whose H carries the speed: `@ZAH-20,4$`
    turned: bool = True  # attitude in the ranges of the seed
    senses: Senses = field(default_factory=Senses)
    will: Will | None = None
    mute: bool = False  # it reports nothing
    yes_until: float = 0.0  # s: until then it answers Y and goes on as it was
    period: float = PERIOD  # s between reports
    deaf_until: float = 0.0  # s: until then it hears nothing
    shown: Gears | None = None  # what reports show of the thrusters instead of the truth
    lag: float = 0.0  # s between a word and what it does; the acknowledgement does not wait
    words: list[Word] = field(default_factory=list)
    gears: Gears = field(default_factory=Gears)

    def __post_init__(self) -> None:
        self.random = random.Random(f"board {self.seed}")
        self.mode = "auto"
        self._stop()
        self.next_report = 1000 + self.random.uniform(0, self.period)
        self.last_m = 0.0
        self.acks: list[tuple[float, bytes]] = []
        self.trim = 0.0
        self.last_altitude = 0.0
        self.stick = Gears()
        self.buffer = b""
        self.late: list[tuple[float, str, float, str]] = []
        self.instant = 0.0  # s, of the control step under way

    def _stop(self) -> None:
        self.horizontal, self.vertical = "", ""
        self.speed = self.up_speed = 0.0
        self.wanted_depth = self.wanted_altitude = self.wanted_yaw = 0.0

    # ---- words ----------------------------------------------------------------------------

    def hear(self, now: float, data: bytes) -> None:
        """Bytes from the program, as they end."""
        bursts = self.line.bursts(now, data)
        if now < self.deaf_until:
            return
        if self.built:
            for burst in bursts:
                if burst[:1] == b"@" and burst[-1:] == b"$" and len(burst) <= LONGEST:
                    self._word(now, burst.decode("latin-1"))
                else:
                    self.words.append(Word(now, burst.decode("latin-1"), False))
            return
        self.buffer += data
        while match := re.search(rb"@[^@$]{1,62}\$", self.buffer):
            self.buffer = self.buffer[match.end() :]
            self._word(now, match.group().decode("latin-1"))

    def _word(self, now: float, text: str) -> None:
        done = True
        if text.startswith("@ZA"):
            done = self._automatic(now, text[3:4], text[4:-1])
        elif text.startswith("@M"):
            self._manual(now, text)
        elif text.startswith("@D"):
            self._rudder(text[2:])
        elif text.startswith("@RI"):
            self._answer(now, b"@ACK_RI\x53$")
        elif text.startswith("@RS"):
            self._answer(now, b"@ACK_RSS$")
        self.words.append(Word(now, text, done))

    def _answer(self, now: float, data: bytes) -> None:
        self.acks.append((now + self.random.uniform(0.005, 0.06), data))

    def _automatic(self, now: float, code: str, value: str) -> bool:
        if self.mode != "auto":
            self.mode = "auto"
            self._stop()
        number = re.match(r"-?\d+", value)
        amount = float(number.group()) if number else 0.0
        gearless = code in "SEHAVXW"
        done = code in "FBLRUDSEHAXW" and (gearless or amount <= 12)
        if done and self.will:
            self.will.heard(now, code)
        if done and now >= self.yes_until:
            self.late.append((now + self.lag, code, amount, value))
            self._catch_up(now)
        letter = "A" if self.built else code
        self._answer(now, f"@ACK_Z{letter}{'Y' if done else 'N'}$".encode())
        return done

    def _catch_up(self, now: float) -> None:
        """Obey what is due."""
        while self.late and self.late[0][0] <= now:
            self._obey(*self.late.pop(0)[1:])

    def restart(self) -> None:
        """Brown-out: everything stands still, nothing is remembered."""
        self._stop()
        self.mode, self.late, self.acks = "default", [], []

    def _obey(self, code: str, amount: float, value: str) -> None:
        if code in "FBLR":
            self.horizontal, self.speed = code, amount
        elif code in "UD":
            self.vertical, self.up_speed = code, amount
            if self.built:
                self.speed = amount
        elif code == "S":
            self.vertical, self.wanted_depth, self.trim = "S", amount, 0.0
        elif code == "E":
            self.vertical, self.wanted_altitude, self.trim = "E", amount, 0.0
        elif code == "H":
            self.horizontal, self.wanted_yaw = "H", amount
            if self.carried or "," in value:
                speed = re.match(r"-?\d+", value.partition(",")[2])
                self.speed = float(speed.group()) if speed else 0.0
        elif code == "X":
            self._stop()
        elif code == "W" and not self.built:
            self.vertical, self.up_speed = "W", 12.0

    def _manual(self, now: float, text: str) -> None:
        if self.mode != "manual":
            self.mode, self.stick = "manual", Gears()
            self._stop()
        self.last_m = now
        stick = self.stick
        if match := re.fullmatch(r"@MM([FBUD])(\d+)\$", text):
            letter, gear = match[1], float(match[2])
            gear = -gear if letter in "BD" else gear
            if letter in "FB":
                stick.left = stick.right = gear
            else:
                stick.up = (gear, gear, gear)
        elif match := re.fullmatch(r"@MR([LR])(\d)\$", text):
            gear = float(match[2]) * 2 * (1 if match[1] == "L" else -1)
            stick.left, stick.right = -gear, gear
        elif match := re.fullmatch(r"@MT([1-5]),(-?\d+)\$", text):
            number, gear = int(match[1]), float(match[2])
            if number == 1:
                stick.left = gear
            elif number == 2:
                stick.right = gear
            else:
                up = list(stick.up)
                up[number - 3] = gear
                stick.up = (up[0], up[1], up[2])
        elif text.startswith("@MD"):
            self._rudder(text[2:])

    def _rudder(self, text: str) -> None:
        match = re.fullmatch(r"D?([AS])([123]),(-?\d+)\$", text)
        if match and (match[2] != "3" or not self.built):
            now = list(self.gears.rudder)
            for index in {"1": (0,), "2": (1,), "3": (0, 1)}[match[2]]:
                value = float(match[3]) + (now[index] if match[1] == "A" else 0.0)
                now[index] = max(-15.0, min(22.0, value))
            self.gears.rudder = (now[0], now[1])

    # ---- control --------------------------------------------------------------------------

    def control(self, now: float, dt: float) -> Gears:
        """Gears of the thrusters for the next dt seconds."""
        self.instant = now
        self._catch_up(now)
        if self.mode == "manual" and now - self.last_m > DEAD_MAN:
            self.mode = "default"
            self.stick = Gears()
        if self.mode == "manual":
            left, right, up = self.stick.left, self.stick.right, self.stick.up
        else:
            left, right = self._horizontal()
            gear = self._vertical(now, dt)
            up = (gear, gear, gear)
        if self.will and self.will.rules(now):
            up = (self.will.gear,) * 3
        self.gears = Gears(left, right, up, self.gears.rudder)
        return self.gears

    def _horizontal(self) -> tuple[float, float]:
        g = self.speed
        if self.horizontal == "H":
            error = wrap(self.wanted_yaw - self._yaw(self.instant))
            rate = -math.degrees(self.body.pose.w[2])
            turn = max(-6.0, min(6.0, 0.15 * error - 0.2 * rate))
            return max(-12.0, min(12.0, g - turn)), max(-12.0, min(12.0, g + turn))
        return {"F": (g, g), "B": (-g, -g), "L": (-g, g), "R": (g, -g)}.get(
            self.horizontal, (0.0, 0.0)
        )

    def _vertical(self, now: float, dt: float) -> float:
        g = self.speed if self.built else self.up_speed
        if self.vertical in "UW" and self.vertical:
            return g
        if self.vertical == "D":
            return -g
        if self.vertical == "S":
            error = self.wanted_depth - self.senses.depth(now, self.body.depth)
        elif self.vertical == "E":
            error = self._altitude(now) - self.wanted_altitude
        else:
            return 0.0
        self.trim = max(0.0, min(8.0, self.trim + 0.6 * error * dt))
        down = 8.0 * error + self.trim - 12.0 * self.body.rate()
        return -max(0.0 if self.built else -10.0, min(10.0, down))

    # ---- reports --------------------------------------------------------------------------

    def _altitude(self, now: float) -> float:
        """Metres above the floor; out of its range the altimeter repeats its last value to the bit."""
        truth = self.body.altitude
        if truth <= RANGE:
            noise = self.random.gauss(0, 0.02)
            self.last_altitude = self.senses.altitude(now, truth + noise)
        return self.last_altitude

    def _yaw(self, now: float) -> float:
        truth = (self.body.attitude_turned() if self.turned else self.body.attitude())[2]
        return wrap(-self.senses.heading(now, truth + self.senses.heading_bias))

    def tick(self, now: float) -> None:
        """Say what is due."""
        due = [ack for at, ack in self.acks if at <= now]
        self.acks = [(at, ack) for at, ack in self.acks if at > now]
        if now >= self.next_report and (self.mode != "manual" or not self.built):
            self.next_report = now + self.period + self.random.uniform(-0.03, 0.03)
            report = b"" if self.mute else self.report(now)
            if (
                report and self.built and due and self.random.random() < 0.5
            ):  # spliced: no lock on the UART
                cut = self.random.randrange(3, 80)
                report = report[:cut] + due.pop(0) + report[cut:]
            self.line.send(now, report)
        for ack in due:
            self.line.send(now, ack)

    def report(self, now: float) -> bytes:
        """One `@SD` of 86 bytes."""
        body, senses, draw = self.body, self.senses, self.random
        roll, pitch, _ = body.attitude_turned() if self.turned else body.attitude()
        values = [
            senses.roll(now, wrap(roll + draw.gauss(0, 0.4))),
            senses.pitch(now, wrap(pitch + draw.gauss(0, 0.4))),
            wrap(self._yaw(now) + draw.gauss(0, 1.0)),
            11.5 + draw.gauss(0, 0.02),
            senses.depth(now, body.depth + draw.gauss(0, senses.depth_noise)),
            self._altitude(now),
            *[draw.gauss(30, 0.5) for _ in range(9)],
        ]
        gears = self.shown or self.gears
        front_left, front_right, rear = gears.up
        pulses = [pwm(g) for g in (gears.left, gears.right, rear, front_left, front_right)]
        pulses += [round(1500 + 10 * angle) for angle in gears.rudder]
        control = round(12.0 if self.built else senses.control(now, 12.0))
        data = struct.pack("<15f7H2H", *values, *pulses, control, 48)
        return b"@SD" + data + struct.pack("<I", crc_stm32(data)) + b"$"
