"""The motor boards of document 002, chapter 5: two CAN frames, broadcast to both boards.

    ID 001  DLC 7   FF  Fx Fy Fz   i16, high byte first, gram-force
    ID 002  DLC 7   FE  Mx My Mz   i16, high byte first, N m

Identifier and first byte must agree. Identifiers are the standard 11-bit ones; 500 kbit/s is
assumed (E-B14, R16). A frame's table describes its data. On a link a CAN frame is a record:

    identifier u16, high byte first | DLC u8 | data

``links.can`` sends and receives records; ``from_line`` makes one of a line ``001#FF001000200030``,
as candump writes it. Tolerance ``can_id``: the identifier expected instead of the table's two.

The adapter turns a setpoint into one force and one torque frame, to be repeated every 50 ms. The
boards stop after 200 ms of silence. They report nothing, and hold no heading, depth or attitude.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from protocol.fields import I16BE, BinaryFrame, Const, FaultKind, FrameType, Values
from protocol.framing import Frame, LinkRow
from protocol.messages import Order, Setpoint
from protocol.tolerances import Tolerances
from protocol.vehicles.adapter import SilentBoard, fraction, refuse
from protocol.vehicles.keys import Key, Keys, Wire, baud, read_wire
from protocol.vehicles.stick import stick_keys

PERIOD = 0.05  # s (R16)
SILENCE = 0.2
FORCE_ID, TORQUE_ID = 0x01, 0x02
_HEAD, _DLC = 3, 7
MOST_ID, MOST_DATA = 0x7FF, 8
_LINE = re.compile(r"(?:.*\s)?([0-9A-Fa-f]{1,8})#((?:[0-9A-Fa-f]{2})*)\s*\Z")

FORCE = BinaryFrame(
    "coreboard.CAN_FORCE",
    "002 table 5-1",
    (Const(b"\xff"), *(I16BE(f"f{axis}_g") for axis in "xyz")),
    command=True,
)
TORQUE = BinaryFrame(
    "coreboard.CAN_TORQUE",
    "002 table 5-2",
    (Const(b"\xfe"), *(I16BE(f"m{axis}_nm") for axis in "xyz")),
    command=True,
)


def record(identifier: int, data: bytes) -> bytes:
    """Return a CAN frame as the record that links and recordings carry."""
    return identifier.to_bytes(2, "big") + bytes([len(data)]) + data


def from_line(line: str) -> bytes:
    """Return ``ID#DATA`` as a record. Raises ValueError for anything else."""
    match = _LINE.match(line)
    if match is None:
        raise ValueError("write the identifier and the data in hexadecimal: 001#FF001000200030")
    if int(match[1], 16) > MOST_ID or len(match[2]) > 2 * MOST_DATA:
        raise ValueError(f"a standard frame has an identifier up to 7FF and {MOST_DATA} bytes")
    return record(int(match[1], 16), bytes.fromhex(match[2]))


class CanFrame(FrameType):
    """A table with its CAN identifier. In a stream the frame is a record; ``check`` and ``decode``
    also take its bare data."""

    def __init__(self, table: BinaryFrame, identifier: int) -> None:
        self.table, self.identifier = table, identifier
        self.name, self.title = table.name, table.title
        self.lead = identifier.to_bytes(2, "big")
        self.length = _HEAD + table.length

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        if end - at < _HEAD:
            return 0
        if data[at + 2] != _DLC:
            return FaultKind.BAD_LENGTH
        return self.length if end - at >= self.length else 0

    def check(self, raw: bytes) -> FaultKind | None:
        return self.table.check(self._data(raw))

    def decode(self, raw: bytes) -> Values:
        return self.table.decode(self._data(raw))

    def encode(self, values: Mapping[str, Any]) -> bytes:
        """Return the data alone, as the document prints it."""
        return self.table.encode(values)

    def record(self, values: Mapping[str, Any]) -> bytes:
        return record(self.identifier, self.encode(values))

    def _data(self, raw: bytes) -> bytes:
        return raw[_HEAD:] if len(raw) == self.length else raw


def can_frames(tolerances: Tolerances) -> tuple[FrameType, ...]:
    return _force_and_torque(tolerances)


def _force_and_torque(tolerances: Tolerances) -> tuple[CanFrame, CanFrame]:
    expected = tolerances["can_id"]
    force, torque = (int(expected, 0),) * 2 if expected else (FORCE_ID, TORQUE_ID)
    return CanFrame(FORCE, force), CanFrame(TORQUE, torque)


LINKS: tuple[LinkRow, ...] = (LinkRow("coreboard.can", can_frames, line=from_line),)


KEYS: Keys = (
    baud(500_000),
    *stick_keys("surge", "turn", "heave"),
    Key("surge_g", 5000, 1, 32_767, "gram-force of a full effort ahead (assumed)"),
    Key("heave_g", 5000, 1, 32_767, "gram-force of a full effort up or down (assumed)"),
    Key("turn_nm", 20, 0.01, 32_767, "N m of a full effort to turn (assumed)", whole=False),
    Key("torque_step", 1, 0.001, 1, "N m that 1 in the torque frame stands for", whole=False),
)


class MotorCodec(SilentBoard):
    """A ``VehicleCodec`` that reports nothing. x is ahead, z down: starboard turns are positive."""

    period, silence = PERIOD, SILENCE

    def __init__(
        self,
        dialect: str = "documented",
        tolerances: Tolerances | None = None,
        battery_scale: tuple[float, float] = (1.0, 1.0),
        wire: Wire | None = None,
    ) -> None:
        chosen = tolerances or Tolerances()
        super().__init__(LINKS[0].framer(chosen), _silent, wire or read_wire(KEYS, {}))
        self._force, self._torque = _force_and_torque(chosen)
        self.encode(Setpoint(turn=1.0))  # refused here if a full effort has no place in its bytes

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        """Return two records: force, then torque. Raises CannotEncode."""
        full = self._wire
        surge, turn, heave = _efforts(setpoint)
        force = {"fx_g": surge * full["surge_g"], "fy_g": 0, "fz_g": heave * full["heave_g"]}
        torque = {"mx_nm": 0, "my_nm": 0, "mz_nm": turn * full["turn_nm"] / full["torque_step"]}
        return [self._force.record(force), self._torque.record(torque)]


def _silent(frame: Frame) -> None:
    """Ignore received frames: on the bus they are other masters' commands, no reports."""


def _efforts(setpoint: Setpoint | Order) -> tuple[float, float, float]:
    if isinstance(setpoint, Order):
        return (0.0, 0.0, -1.0 if setpoint is Order.SURFACE else 0.0)
    why = "the motor boards hold nothing: they take forces and torques"
    refuse(setpoint, heading=why, depth=why, altitude=why, pitch=why, roll=why)
    heave = fraction("heave", setpoint.heave or 0.0)
    return fraction("surge", setpoint.surge), fraction("turn", setpoint.turn), heave
