"""The robot of document 004: Raspberry Pi and STM32 on USART1, 115200 8N1 assumed.

    Pi -> STM32   AA | address | command | length | user 0..5 | sum | DD     12 bytes
    STM32 -> Pi   AA | speed | voltage | sum | DD                             7 bytes

The sum is over everything before it, mod 255 (E-P2, E-P6). A change of a byte between 00 and FF is
not detected: "stop" and "handshake" have the same sum. Tolerance ``mod``: 256, or either, while
commissioning.
Numbers are low byte first: speed i16 mm/s, angles i16 0.01 deg, voltage u16 mV, alarm values u32
thousandths (E-P4, E-P5). Answers to the power queries and the handshake have no frame (E-P8).

    address  1 robot  2 gimbal  3 arm  4 power  5 IMU  6 sensor    (3, 5, 6 have no table)

Setpoints: the robot drives on the ground: ahead, back or a spin on the spot, at a speed; nothing
else. SURFACE stops it, since it cannot dive. Commands are sent every 100 ms; the robot stops after
300 ms of silence (R17).

What does not live here: framing (protocol.framing), the power module's own serial line.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from protocol.checksum import Checksum, sum255, sum256
from protocol.codec import CannotEncode, Received
from protocol.fields import (
    I16LE,
    U8,
    U16LE,
    BinaryFrame,
    Check,
    Const,
    FaultKind,
    FrameType,
    Raw,
    Values,
)
from protocol.framing import Frame, LinkRow
from protocol.messages import Order, Setpoint, Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles.adapter import SilentBoard, fights, fraction, refuse
from protocol.vehicles.keys import Key, Keys, Wire, baud, read_wire
from protocol.vehicles.robot_outputs import (
    CHANNELS,
    GIMBAL,
    HANDSHAKE,
    POWER,
    ROBOT,
    commands,
    sets,
)
from protocol.vehicles.stick import stick_keys

PERIOD = 0.1  # s (R17)
SILENCE = 0.3
KEYS: Keys = (
    baud(115_200),
    *stick_keys("surge", "turn"),
    Key("full_speed", 1000, 1, 32_767, "mm/s at surge or turn 1 (assumed; E-P5)", whole=False),
    Key("speed_step", 1, 0.1, 1000, "mm/s that 1 of command 20 and of its report is", whole=False),
)

STOP: Final = 0
FORWARD: Final = 1
BACK: Final = 2
SPIN_RIGHT: Final = 9
SPIN_LEFT: Final = 10
SPEED: Final = 0x20
USER = 6  # bytes


@dataclass(frozen=True, slots=True)
class Item:
    """One number in the user bytes: at ``at``, of ``size`` bytes, low byte first."""

    name: str
    at: int
    size: int
    low: int
    high: int
    listed: bool = False  # an enumeration: any other number is a wrong code
    decimals: int = 0  # 3: it counts thousandths
    words: tuple[str, ...] = ()  # the power module's names of the values, from ``low`` on

    def doubt(self, user: bytes) -> FaultKind | None:
        if self.low <= self.read(user) <= self.high:
            return None
        return FaultKind.BAD_ENUM if self.listed else FaultKind.OUT_OF_RANGE

    def told(self, user: bytes) -> str:
        """Return the text that the power module takes: a name, or a number (36000 as 36)."""
        value = self.read(user)
        if self.words:
            return self.words[value - self.low]
        whole, rest = divmod(value, 10**self.decimals)
        return f"{whole}.{rest:0{self.decimals}}".rstrip("0") if rest else str(whole)

    def read(self, user: bytes) -> int:
        return int.from_bytes(user[self.at : self.at + self.size], "little", signed=self.low < 0)

    def write(self, value: Any) -> bytes:
        if not isinstance(value, int) or isinstance(value, bool):
            raise CannotEncode(f"{self.name}: a whole number is needed, not {value!r}")
        if not self.low <= value <= self.high:
            raise CannotEncode(f"{self.name}: {value} is outside {self.low}..{self.high}")
        return value.to_bytes(self.size, "little", signed=self.low < 0)


@dataclass(frozen=True, slots=True)
class Command:
    """A row of the document's command tables. ``at``: start of the text to the power module."""

    address: int
    command: int
    name: str
    items: tuple[Item, ...] = ()
    at: str = ""

    @property
    def length(self) -> int:
        return sum(item.size for item in self.items)

    def line(self, user: bytes) -> str:
        """Return the text that is sent on to the power module, with value and line end (E-P7)."""
        values = "".join(f"+{item.told(user)}" for item in self.items)
        return f"{self.at}{values}\r\n"


def _alarm(command: int, at: str, most: int) -> Command:
    return Command(POWER, command, at, (Item("thousandths", 0, 4, 0, most, decimals=3),), at)


_ANGLES = (Item("yaw_cdeg", 0, 2, -32768, 32767), Item("pitch_cdeg", 2, 2, -32768, 32767))
_MODE = Item("alarm_mode", 0, 1, 1, 5, words=("OVERV", "UNDERV", "OVERC", "UNDERC", "OVERP"))
COMMANDS = (
    *(
        Command(ROBOT, code, name)
        for code, name in enumerate(
            (
                *("stop", "forward", "back", "right up", "left up", "right down", "left down"),
                *("right", "left", "spin right", "spin left"),
            )
        )
    ),
    Command(ROBOT, SPEED, "speed", (Item("speed_mm_s", 0, 2, -32768, 32767),)),
    Command(ROBOT, HANDSHAKE, "handshake"),
    Command(GIMBAL, 0, "centre"),
    Command(GIMBAL, 1, "video", (Item("video", 0, 1, 1, 3, True),)),  # visible, infrared, both
    Command(GIMBAL, 2, "angles", _ANGLES),
    Command(GIMBAL, 3, "zoom", (Item("zoom", 0, 1, 0, 255),)),
    *(Command(POWER, code, at, at=at) for code, at in enumerate(("AT", "AT+V", "AT+C", "AT+P"))),
    Command(POWER, 4, "AT+MAXC", (Item("max_current_a", 0, 1, 0, 255),), "AT+MAXC"),
    Command(POWER, 5, "AT+MODE", (_MODE,), "AT+MODE"),
    _alarm(6, "AT+OVERVERR", 36_000),
    _alarm(7, "AT+UNDERVERR", 36_000),
    _alarm(8, "AT+OVERCERR", 40_000),
    _alarm(9, "AT+UNDERCERR", 40_000),
    _alarm(10, "AT+OVERPERR", 1_080_000),
)
_ROWS = {(row.address, row.command): row for row in COMMANDS}
_TABLED = frozenset(row.address for row in COMMANDS)


def _check(tolerances: Tolerances) -> Check:
    sums: dict[str, tuple[Checksum, Checksum | None]] = {
        "255": (sum255, None),
        "256": (sum256, None),
        "either": (sum255, sum256),
    }
    compute, also = sums[tolerances["mod"]]
    return Check(compute, "B", also=also)


class DownFrame(BinaryFrame):
    """Pi to STM32, 12 bytes (004, frame format; E-P1, E-P3). ``encode`` writes the user bytes if
    they are given, else the named items of the command."""

    def __init__(self, tolerances: Tolerances) -> None:
        fields = (
            Const(b"\xaa"),
            U8("address", 1, 255),
            U8("command"),
            U8("length", 0, USER),
            Raw("user", USER),
            _check(tolerances),
            Const(b"\xdd"),
        )
        super().__init__("robot.DOWN", "004 frame format", fields, command=True)

    def check(self, raw: bytes) -> FaultKind | None:
        fault = super().check(raw)
        if fault is not None or raw[1] not in _TABLED:
            return fault
        row = _ROWS.get((raw[1], raw[2]))
        if row is None:
            return FaultKind.BAD_ENUM
        if raw[3] < row.length:
            return FaultKind.BAD_LENGTH  # it does not cover all bytes of the value (G4)
        return next(filter(None, (item.doubt(raw[4:10]) for item in row.items)), None)

    def decode(self, raw: bytes) -> Values:
        values = super().decode(raw)
        row = _ROWS.get((raw[1], raw[2]))
        flags = []
        if row is not None:
            values |= {item.name: item.read(raw[4:10]) for item in row.items}
            if row.at:
                values["at"] = row.line(raw[4:10])
            if raw[3] != row.length:
                flags.append("length:disagrees")
            if any(raw[4 + row.length : 10]):
                flags.append("user:not_zero")
        values["flags"] = flags
        return values

    def encode(self, values: Mapping[str, Any]) -> bytes:
        full = dict(values)
        row = _ROWS.get((full.get("address", 0), full.get("command", -1)))
        if "user" not in full:
            items = row.items if row is not None else ()
            missing = next((item.name for item in items if item.name not in full), None)
            if missing is not None:
                raise CannotEncode(f"{self.name}: the value {missing} is missing")
            user = b"".join(item.write(full[item.name]) for item in items)
            full["user"] = user.ljust(USER, b"\0").hex()
        full.setdefault("length", row.length if row is not None else 0)
        raw = super().encode(full)
        fault = self.check(raw)
        if fault is not None:
            raise CannotEncode(f"{self.name}: address, command or user bytes: {fault.value}")
        return raw


def up(tolerances: Tolerances) -> BinaryFrame:
    """STM32 to Pi, 7 bytes (004, sending; E-P5, E-P6)."""
    return BinaryFrame(
        "robot.UP",
        "004 frame format of the answer",
        (
            Const(b"\xaa"),
            I16LE("speed_mm_s"),
            U16LE("voltage_mv"),
            _check(tolerances),
            Const(b"\xdd"),
        ),
        flags=False,
    )


def _up(tolerances: Tolerances) -> tuple[FrameType, ...]:
    return (up(tolerances),)


def _down(tolerances: Tolerances) -> tuple[FrameType, ...]:
    return (DownFrame(tolerances),)


LINKS: tuple[LinkRow, ...] = (LinkRow("robot.down", _down), LinkRow("robot.up", _up))

# --- Telemetry in, Setpoint out ------------------------------------------------------------------


def telemetry(
    values: Values, t: float, control_scale: float = 1.0, speed_step: float = 1.0
) -> Telemetry:
    return Telemetry(
        t=t,
        velocity=(values["speed_mm_s"] * speed_step / 1000.0, 0.0, 0.0),
        batteries=(values["voltage_mv"] / 1000.0 * control_scale, None),
    )


def motion(setpoint: Setpoint | Order) -> tuple[int, float]:
    """Return command and share of the full speed. Raises CannotEncode."""
    if isinstance(setpoint, Order):
        return STOP, 0.0
    ground = "the robot drives on the ground"
    refuse(
        setpoint,
        heave=ground,
        depth=ground,
        altitude=ground,
        pitch=ground,
        roll=ground,
        heading="the robot has no compass",
    )
    surge, turn = fraction("surge", setpoint.surge), fraction("turn", setpoint.turn)
    if surge and turn:
        raise CannotEncode("surge and turn: the robot drives straight or spins, not both at once")
    if surge:
        return (FORWARD if surge > 0 else BACK), abs(surge)
    if turn:
        return (SPIN_RIGHT if turn > 0 else SPIN_LEFT), abs(turn)
    return STOP, 0.0


class RobotCodec(SilentBoard):
    """A ``VehicleCodec``."""

    period, silence = PERIOD, SILENCE
    channels = CHANNELS

    def __init__(
        self,
        dialect: str = "documented",
        tolerances: Tolerances | None = None,
        battery_scale: tuple[float, float] = (1.0, 1.0),
        wire: Wire | None = None,
    ) -> None:
        chosen = tolerances or Tolerances()
        super().__init__(LINKS[1].framer(chosen), self._telemetry, wire or read_wire(KEYS, {}))
        self._frame, self._scale = DownFrame(chosen), battery_scale[0]
        self.encode(Setpoint(surge=1.0))  # refused here if a full speed does not fit in its bytes

    def _telemetry(self, frame: Frame) -> Received:
        return telemetry(frame.values(), frame.t, self._scale, self._wire["speed_step"])

    def take_outputs(self, levels: Mapping[str, float]) -> dict[str, bytes]:
        self._speed(levels.get("side_speed_mm_s", 0.0))  # refused here if it does not fit
        super().take_outputs(levels)
        told = commands(levels, self.levels)
        return {sets(values): self._frame.encode(values) for values in told}

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        """Return the speed first, then the motion, which so begins at the right speed."""
        command, share = motion(setpoint)
        speed = share * self._wire["full_speed"]
        if command == STOP and not fights(CHANNELS[0], setpoint):
            command, speed = int(self.levels["side"]), self.levels["side_speed_mm_s"]
        frames = [self._frame.encode({"address": ROBOT, "command": command})]
        if command != STOP:
            frames.insert(0, self._speed(speed))
        return frames

    def _speed(self, mm_s: float) -> bytes:
        told = round(mm_s / self._wire["speed_step"])
        return self._frame.encode({"address": ROBOT, "command": SPEED, "speed_mm_s": told})
