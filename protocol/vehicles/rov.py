"""The ROV of document 003 (20 September 2022), serial 115200 or TCP.

    55 AA | CmdType | DateLen | Command Function Reserved ... | sum | 0D 0A
    01 board -> PC, unsolicited, 71 bytes   (003 3.2.1)
    11 PC -> board, no answer,   30 bytes   (003 3.3.1)

DateLen counts Command and Date, so a frame has DateLen + 7 bytes (E-R1); the sum is over Command
and Date, mod 256. Numbers are low byte first (E-R3, tolerance ``float_order``). ``len003 = loose``
ignores DateLen and trusts the length of the type.

Signs follow from the document's own sample. At rest az = -0.981 g, so z points down. Roll -6.4 deg
goes with ay = +0.11 g = -sin(roll), pitch -0.33 deg with ax = -0.007 g = sin(pitch). So Euler X is
roll, starboard down positive; Euler Y is pitch, nose up positive; Euler Z is, by the right-hand
rule, a yaw that grows clockwise.

Setpoints: X ahead, Z turn to starboard, F up ("float"), each -1..1 of full effort (E-R8). The two
hold flags hold the present heading and depth; they take no value, so no setpoint can ask for one.
The document gives no sign and no full speed of r/min: the keys have both, and ``doctor --signs``
finds them. Sent at 20 Hz; the board goes neutral after 500 ms of silence (R17).

What does not live here: framing and checks (protocol.framing, protocol.fields).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from protocol.checksum import sum256
from protocol.codec import CannotEncode, Received
from protocol.fields import (
    F32LE,
    I8,
    I32LE,
    U8,
    BinaryFrame,
    Check,
    Const,
    FaultKind,
    FrameType,
    Number,
    Pad,
    Values,
)
from protocol.framing import Frame, LinkRow
from protocol.messages import Order, Setpoint, Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles.adapter import (
    SilentBoard,
    fights,
    fraction,
    heading_of,
    radians_of,
    refuse,
)
from protocol.vehicles.channels import Channel, Source, of_board, told
from protocol.vehicles.keys import Key, Keys, UnknownKey, Wire, baud, read_wire
from protocol.vehicles.stick import stick_keys

PERIOD = 0.05  # s (R17)
SILENCE = 0.5
FULL_SPEED = 1000  # r/min, the field's range
THRUSTERS = ("left_front", "right_front", "left_up", "right_up")

KEYS: Keys = (
    baud(115_200),
    *stick_keys("surge", "turn", "heave"),
    Key("x_sign", 1, -1, 1, "1: X pushes ahead; -1: astern (E-R8)"),
    Key("z_sign", 1, -1, 1, "1: Z turns to starboard; -1: to port (E-R8)"),
    Key("f_sign", 1, -1, 1, "1: F pushes up; -1: down (E-R8)"),
    *(
        Key(
            f"{name}_rpm",
            FULL_SPEED,
            -FULL_SPEED,
            FULL_SPEED,
            f"r/min of rpm_{name} at full effort {'up' if 'up' in name else 'ahead'}; 0: not known",
        )
        for name in THRUSTERS
    ),
)

_DATE_LEN_AT, _COMMAND_AT = 3, 4
_FULL = (FULL_SPEED,) * len(THRUSTERS)
SUM, TAIL = Check(sum256, "B", first=_COMMAND_AT), Const(b"\r\n")


class RovFrame(BinaryFrame):
    """``loose``: any DateLen is accepted (E-R1)."""

    loose = False

    def check(self, raw: bytes) -> FaultKind | None:
        if self.loose:
            right = (self.length - 7).to_bytes(1, "big")
            raw = raw[:_DATE_LEN_AT] + right + raw[_COMMAND_AT:]
        return super().check(raw)


def _floats(tolerances: Tolerances, *names: str, bound: float | None = None) -> tuple[Number, ...]:
    order = "<" if tolerances["float_order"] == "low" else ">"
    low = None if bound is None else -bound
    return tuple(F32LE(name, low, bound, order=order) for name in names)


def full_effort(tolerances: Tolerances) -> float:
    """Return the value of X, Z and F at full effort (E-R8)."""
    return float(tolerances["effort003"])


def up(tolerances: Tolerances) -> RovFrame:
    """CmdType 01, 71 bytes (003 3.2.1; E-R2); the older layout has 50 (E-R1)."""
    legacy = tolerances["layout003"] == "legacy"
    later = (
        *(I32LE(f"rpm_{name}", -1000, 1000) for name in THRUSTERS),
        I32LE("temperature_c", 0, 100),
        U8("metal_pct", 0, 100),
    )
    frame = RovFrame(
        "rov.UP",
        "003 3.2.1",
        (
            Const(b"\x55\xaa\x01"),
            Const(b"\x2b" if legacy else b"\x40", FaultKind.BAD_LENGTH),
            Const(b"\x01\x01", FaultKind.BAD_ENUM),  # command, function
            Pad(1),
            *_floats(tolerances, "ax_g", "ay_g", "az_g"),
            *_floats(tolerances, "gx_dps", "gy_dps", "gz_dps"),
            *_floats(tolerances, "ex_deg", "ey_deg", "ez_deg", bound=360),
            *_floats(tolerances, "depth_m"),
            *(() if legacy else later),
            SUM,
            TAIL,
        ),
    )
    frame.loose = tolerances["len003"] == "loose"
    return frame


def down(tolerances: Tolerances) -> RovFrame:
    """CmdType 11, 30 bytes (003 3.3.1; E-R7, E-R8); the older layout has 28 (E-R1)."""
    legacy = tolerances["layout003"] == "legacy"
    later = (U8("led_pct", 0, 100), I8("servo_deg", -30, 30))
    frame = RovFrame(
        "rov.DOWN",
        "003 3.3.1",
        (
            Const(b"\x55\xaa\x11"),
            Const(b"\x15" if legacy else b"\x17", FaultKind.BAD_LENGTH),
            Const(b"\x01\x01", FaultKind.BAD_ENUM),
            Pad(1),
            U8("hold_heading", choices=(0, 1)),
            U8("hold_depth", choices=(0, 1)),
            *(() if legacy else later),
            *_floats(tolerances, "x", "z", "f", bound=full_effort(tolerances)),
            I32LE("reserved"),
            SUM,
            TAIL,
        ),
        command=True,
    )
    frame.loose = tolerances["len003"] == "loose"
    return frame


def _up(tolerances: Tolerances) -> tuple[FrameType, ...]:
    return (up(tolerances),)


def _down(tolerances: Tolerances) -> tuple[FrameType, ...]:
    return (down(tolerances),)


LINKS: tuple[LinkRow, ...] = (LinkRow("rov.down", _down), LinkRow("rov.up", _up))

# --- Telemetry in, Setpoint out ------------------------------------------------------------------

CHANNELS: tuple[Channel, ...] = (
    Channel("led_pct", "%", 0, 100, "brightness of the LED"),
    Channel("servo_deg", "deg", -30, 30, "angle of the servo"),
    Channel("hold_heading", "", 0, 1, "1: the board holds the heading it has",
            excludes=("turn", "heading")),
    Channel("hold_depth", "", 0, 1, "1: the board holds the depth it has",
            excludes=("heave", "depth", "altitude")),
)  # fmt: skip
LATER = ("led_pct", "servo_deg")  # channels that the older layout lacks
SOURCES: tuple[Source, ...] = (
    of_board("metal_pct", "%", "metal detector"),
    of_board("temperature_c", "C", "of the board"),
    *(of_board(f"a{axis}_g", "g", f"acceleration {axis}") for axis in "xyz"),
    *(of_board(f"g{axis}_dps", "deg/s", f"rate of turn about {axis}") for axis in "xyz"),
)


def telemetry(values: Values, t: float, full: Sequence[float] = _FULL) -> Telemetry:
    """Convert CmdType 01 to SI. ``full``: r/min at full effort, by thruster; if one is 0, the
    actuators are unknown."""
    legacy = "temperature_c" not in values
    return Telemetry(
        t=t,
        depth=values["depth_m"],
        heading=heading_of(values, "ez_deg"),
        pitch=radians_of(values, "ey_deg"),
        roll=radians_of(values, "ex_deg"),
        temperature_c=None if legacy else float(values["temperature_c"]),
        actuators=None if legacy or 0 in full else _shares(values, full),
        faults=tuple(values["flags"]),
        board=told(values, tuple(values["flags"]), SOURCES),
    )


def _shares(values: Values, full: Sequence[float]) -> tuple[float, ...]:
    rates = (values[f"rpm_{name}"] / most for name, most in zip(THRUSTERS, full, strict=True))
    return tuple(max(-1.0, min(rate, 1.0)) for rate in rates)


NEUTRAL: Values = {
    "hold_heading": 0,
    "hold_depth": 0,
    "led_pct": 0,
    "servo_deg": 0,
    "x": 0.0,
    "z": 0.0,
    "f": 0.0,
    "reserved": 0,
}


def command(setpoint: Setpoint | Order) -> Values:
    """Return the values of CmdType 11. Raises CannotEncode."""
    if setpoint is Order.STOP:
        return NEUTRAL
    if setpoint is Order.SURFACE:
        return NEUTRAL | {"f": 1.0}
    refuse(
        setpoint,
        heading="the board can only hold the heading it has",
        depth="the board can only hold the depth it has",
        altitude="the board measures no altitude",
        pitch="the board controls no pitch",
        roll="the board controls no roll",
    )
    return NEUTRAL | {
        "x": fraction("surge", setpoint.surge),
        "z": fraction("turn", setpoint.turn),
        "f": -fraction("heave", setpoint.heave or 0.0),
    }


class RovCodec(SilentBoard):
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
        super().__init__(LINKS[1].framer(chosen), self._read, wire or read_wire(KEYS, {}))
        self._rpm = tuple(self._wire[f"{name}_rpm"] for name in THRUSTERS)
        self._frame, self._full = down(chosen), full_effort(chosen)
        self._legacy = chosen["layout003"] == "legacy"
        self._signs = {name: self._wire[f"{name}_sign"] for name in ("x", "z", "f")}
        if 0 in self._signs.values():
            raise UnknownKey("x_sign, z_sign and f_sign are 1 or -1")

    def take_outputs(self, levels: Mapping[str, float]) -> dict[str, bytes]:
        absent = [name for name in LATER if self._legacy and levels.get(name)]
        if absent:
            raise CannotEncode(f"{', '.join(absent)}: the older layout does not have it")
        return super().take_outputs(levels)

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        free = (row.name for row in CHANNELS if not fights(row, setpoint))
        values = command(setpoint) | {name: int(self.levels[name]) for name in free}
        efforts = {name: self._full * sign * values[name] for name, sign in self._signs.items()}
        return [self._frame.encode(values | efforts)]

    def _read(self, frame: Frame) -> Received:
        return telemetry(frame.values(), frame.t, self._rpm)
