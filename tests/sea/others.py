"""The boards of documents 002 (core board), 003 (ROV) and 004 (robot), written from the documents.

None of them acknowledges anything. A board records a word when what it is told changes, in letters of
this sea's own: `OPEN` with six forces, `CLOSED` with depth and heading, `ROV` with efforts and holds,
`ROBOT` with a command.

Room in the documents, and the way taken here: the core board's vertical force is positive downward (its
x is north and y east, so z is down) unless `upward` says otherwise; it reports 10 times a second; its
INS aligns 5 s after the power, and drifts under water. The ROV's F ("float") is positive upward, Z
turns it to starboard; it reports 10 times a second. The robot obeys its last order for 300 ms.
"""

from __future__ import annotations

import math
import random
import struct
from dataclasses import dataclass, field

from tests.sea.body import Body, Gears
from tests.sea.faults import Will
from tests.sea.receiver import EARTH, HOME
from tests.sea.stm32 import Senses, Word, wrap
from tests.sea.wire import Line


def gear(share: float, power: float) -> float:
    """The gear of `body.thrust` that has this share (-1..1) of the full force."""
    return math.copysign(10 * min(1.0, abs(share)) ** (1 / power), share)


def xor(data: bytes) -> int:
    """Checksum of 002: exclusive or of all bytes from the header on."""
    check = 0
    for byte in data:
        check ^= byte
    return check


@dataclass
class Slave:
    """What the three have in common: fixed frames by length, a silence after which they go neutral."""

    body: Body
    line: Line
    seed: int = 0
    deaf_after: float = float("inf")  # s: it hears nothing any more
    hears_again: float = float("inf")  # s: but from then on it does
    senses: Senses = field(default_factory=Senses)
    will: Will | None = None
    mute: bool = False  # it reports nothing
    words: list[Word] = field(default_factory=list)
    gears: Gears = field(default_factory=Gears)

    HEAD = b""
    LENGTH = 0
    SILENCE = 0.5
    PERIOD = 0.1

    def __post_init__(self) -> None:
        self.random = random.Random(f"{type(self).__name__} {self.seed}")
        self.buffer = b""
        self.heard_at = -1e9
        self.beats: list[float] = []  # when good frames came
        self.next_report = 1000 + self.random.uniform(0, self.PERIOD)

    def hear(self, now: float, data: bytes) -> None:
        """Bytes from the program."""
        if self.hangs(now):
            return
        self.buffer += data
        while (at := self.buffer.find(self.HEAD)) >= 0 and len(self.buffer) >= at + self.LENGTH:
            frame = self.buffer[at : at + self.LENGTH]
            if self.good(frame):
                self.buffer = self.buffer[at + self.LENGTH :]
                self.heard_at = now
                self.beats.append(now)
                self.obey(now, frame)
            else:
                self.buffer = self.buffer[at + 1 :]
        self.buffer = self.buffer[-4 * self.LENGTH :]

    def hangs(self, now: float) -> bool:
        """Whether it hears nothing, and goes on as it was told last."""
        return self.deaf_after < now < self.hears_again

    def note(self, now: float, text: str) -> None:
        """Put a word on record when it is a new one."""
        if not self.words or self.words[-1].text != text:
            self.words.append(Word(now, text, True))

    def good(self, frame: bytes) -> bool:
        """Whether checksum and tail are right."""
        raise NotImplementedError

    def obey(self, now: float, frame: bytes) -> None:
        """Take a good frame."""
        raise NotImplementedError

    def push(self) -> Gears:
        """Gears for what was told last."""
        raise NotImplementedError

    def report(self, now: float) -> bytes:
        """One frame upward."""
        raise NotImplementedError

    def control(self, now: float, dt: float) -> Gears:
        """Gears for the next dt seconds; neutral after a silence, unless the board hangs."""
        silent = now - self.heard_at > self.SILENCE and not self.hangs(now)
        self.gears = Gears() if silent else self.push()
        if self.will and self.will.rules(now):
            self.gears.up = (self.will.gear,) * 3
        return self.gears

    def tick(self, now: float) -> None:
        """Say what is due."""
        if now >= self.next_report:
            self.next_report += self.PERIOD + self.random.uniform(-0.004, 0.004)
            self.line.send(now, b"" if self.mute else self.report(now))


class CoreBoard(Slave):
    """Document 002: 62 bytes down, 90 bytes up."""

    HEAD = b"\xfe\xef"
    LENGTH = 62
    PERIOD = 0.1
    upward = False  # whether a positive TZ pushes up

    def __post_init__(self) -> None:
        super().__post_init__()
        self.forces = [0] * 6
        self.closed = False
        self.wanted = (0.0, 0.0)
        self.drift = [0.0, 0.0]
        self.volts = (24.0, 48.0)
        self.leak = 0.0

    def good(self, frame: bytes) -> bool:
        return frame[59] == xor(frame[:59]) and frame[60:] == b"\xfa\xaf"

    def obey(self, now: float, frame: bytes) -> None:
        if max(frame[35:41]) > 200:
            return
        self.forces = [byte - 100 for byte in frame[35:41]]
        self.wanted = struct.unpack_from("<ff", frame, 26)
        self.closed = frame[42] == 1
        text = " ".join(f"{force:+d}" for force in self.forces)
        if self.closed:
            text += f" depth {self.wanted[0]:.1f} heading {self.wanted[1]:.0f}"
        self.note(now, ("CLOSED " if self.closed else "OPEN ") + text)

    def push(self) -> Gears:
        tx, _, tz, _, _, mz = (force / 100 for force in self.forces)
        up = tz if self.upward else -tz
        turn = mz
        if self.closed:
            depth = self.senses.depth(self.now, self.body.depth)
            up = max(-1.0, min(1.0, 0.8 * (depth - self.wanted[0]) + 1.2 * self.body.rate()))
            error = wrap(self.wanted[1] - self.body.attitude()[2])
            turn = max(-0.6, min(0.6, 0.02 * error - 1.0 * self.body.pose.w[2]))
        g = gear(up, 1.5)
        return Gears(gear(tx + turn, 2.0), gear(tx - turn, 2.0), (g, g, g))

    now = 1000.0

    def report(self, now: float) -> bytes:
        self.now = now
        draw, pose = self.random, self.body.pose
        if self.body.depth > 0.5:
            self.drift = [d + draw.gauss(0, 0.02) for d in self.drift]
        else:
            self.drift = [0.9 * d for d in self.drift]
        roll, pitch, heading = self.body.attitude()
        north, east = pose.x + self.drift[0], pose.y + self.drift[1]
        latitude = HOME[0] + math.degrees(north / EARTH)
        longitude = HOME[1] + math.degrees(east / EARTH) / math.cos(math.radians(HOME[0]))
        depth = self.senses.depth(now, self.body.depth + draw.gauss(0, self.senses.depth_noise))
        altitude = self.senses.altitude(now, self.body.altitude)
        control = self.senses.control(now, self.volts[0])
        leak = self.senses.leak(now, self.leak)
        data = struct.pack(
            "<2s3f2d5f12sB",
            b"\xfe\xef",
            self.senses.roll(now, roll + draw.gauss(0, 0.2)),
            self.senses.pitch(now, pitch + draw.gauss(0, 0.2)),
            self.senses.heading(now, wrap(heading + draw.gauss(0, 0.3))),
            latitude,
            longitude,
            north,
            east,
            depth,
            altitude,
            0.0,
            bytes(12),
            0,
        )
        data += struct.pack(
            ">hHHB6h", 1150, round(control * 100), round(self.volts[1] * 100), round(leak), *[0] * 6
        )
        data += bytes([1 if now > 1005 else 0]) + bytes(4)
        return data + bytes([xor(data)]) + b"\xfa\xaf"


class CoreBoardUpward(CoreBoard):
    """The same, with the other sign of its vertical force."""

    upward = True


class Rov(Slave):
    """Document 003: 30 bytes down, 71 bytes up."""

    HEAD = b"\x55\xaa\x11"
    LENGTH = 30
    PERIOD = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        self.efforts = (0.0, 0.0, 0.0)
        self.hold_heading = self.hold_depth = False
        self.held = (0.0, 0.0)

    def good(self, frame: bytes) -> bool:
        return frame[27] == sum(frame[4:27]) & 0xFF and frame[28:] == b"\r\n"

    def obey(self, now: float, frame: bytes) -> None:
        heading, depth = frame[7] == 1, frame[8] == 1
        if (heading, depth) != (self.hold_heading, self.hold_depth):
            self.held = (self.body.attitude()[2], self.body.depth)
        self.hold_heading, self.hold_depth = heading, depth
        self.efforts = struct.unpack_from("<fff", frame, 11)
        x, z, f = self.efforts
        self.note(
            now, f"ROV {x:+.2f} {z:+.2f} {f:+.2f} {'H' if heading else '-'}{'D' if depth else '-'}"
        )

    def push(self) -> Gears:
        ahead, turn, up = self.efforts
        if self.hold_heading:
            error = wrap(self.held[0] - self.body.attitude()[2])
            turn = max(-0.5, min(0.5, 0.02 * error - self.body.pose.w[2]))
        if self.hold_depth:
            up = max(
                -1.0, min(1.0, 0.8 * (self.body.depth - self.held[1]) + 1.2 * self.body.rate())
            )
        g = gear(up, 1.5)
        return Gears(gear(ahead + turn, 2.0), gear(ahead - turn, 2.0), (g, g, g))

    def report(self, now: float) -> bytes:
        draw, (p, q, r) = self.random, self.body.pose.w
        roll, pitch, heading = self.body.attitude()
        depth = self.senses.depth(now, self.body.depth + draw.gauss(0, self.senses.depth_noise))
        floats = [0.0, 0.0, -1.0, *(math.degrees(x) for x in (p, q, r))]
        floats = [x + draw.gauss(0, 0.005) for x in floats]
        floats += [roll + draw.gauss(0, 0.2), pitch + draw.gauss(0, 0.2), wrap(heading), depth]
        gears = (self.gears.left, self.gears.right, self.gears.up[0], self.gears.up[1])
        data = b"\x01\x01\x00" + struct.pack("<10f", *floats)
        data += struct.pack("<5iB", *[round(g * 100) for g in gears], 12, 0)
        return b"\x55\xaa\x01\x40" + data + bytes([sum(data) & 0xFF]) + b"\r\n"


class RovDownward(Rov):
    """The same, with the other sign of F."""

    def push(self) -> Gears:
        ahead, turn, up = self.efforts
        self.efforts = (ahead, turn, -up)
        gears = super().push()
        self.efforts = (ahead, turn, up)
        return gears


class Robot(Slave):
    """Document 004: 12 bytes down, 7 bytes up; on land, so its `body` never sinks."""

    HEAD = b"\xaa"
    LENGTH = 12
    SILENCE = 0.3
    PERIOD = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        self.command, self.speed = 0, 0

    def good(self, frame: bytes) -> bool:
        return frame[10] == sum(frame[:10]) % 255 and frame[11] == 0xDD

    def obey(self, now: float, frame: bytes) -> None:
        if frame[1] != 1:
            return
        if frame[2] == 0x20:
            self.speed = struct.unpack_from("<h", frame, 4)[0]
        elif frame[2] != 0xFF:
            self.command = frame[2]
        self.note(now, f"ROBOT {self.command:02X} {self.speed}")

    def push(self) -> Gears:
        g = min(10.0, abs(self.speed) / 100)
        left, right = {1: (g, g), 2: (-g, -g), 9: (g, -g), 10: (-g, g)}.get(
            self.command, (0.0, 0.0)
        )
        return Gears(left, right)

    def report(self, now: float) -> bytes:
        speed = round(1000 * self.body.pose.v[0])
        volts = round(1000 * self.senses.control(now, 24.0))
        data = b"\xaa" + struct.pack("<hH", speed, volts)
        return data + bytes([sum(data) % 255, 0xDD])
