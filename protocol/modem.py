"""The envelope of the acoustic modem (document 000, tables 1.3 and 2.3), 115200 baud.

    0x23 0x02 | length u16 | address | content (1..3200) | CRC-16/MODBUS, low byte first

One content may hold several whole ``@...$`` frames (R15). The address is the sender's: 1 the
topside host, 2 the vehicle host (E-M3). The length is low byte first (E-M1). With ``order_modem =
auto`` the decoder takes the order whose CRC is right, and tries the shorter candidate first.

An unfinished frame is given up (G3) after 1 s without a byte, and 1 s plus twice the line time of
the longest frame after its first byte.

What does not live here: when to send and to repeat (``protocol.arq``), what the content means.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from protocol.checksum import crc16_modbus
from protocol.codec import CannotEncode
from protocol.fields import FaultKind, FrameType, Values, required
from protocol.framing import Framer
from protocol.messages import FrameFault
from protocol.tolerances import Tolerances

MOST = 3200  # bytes of content
OVERHEAD = 7
IDLE = 1.0  # s (G3)
BAUD = 115200
BITS_PER_BYTE = 10  # 8N1


class Sender(enum.IntEnum):
    """The address byte (E-M3)."""

    TOPSIDE = 1
    VEHICLE = 2


@dataclass(frozen=True, slots=True)
class Envelope:
    """One good modem frame; ``t``: arrival of its first byte."""

    t: float
    address: int
    content: bytes


class ModemFrame(FrameType):
    name, title, lead = "auv.MODEM", "000 tables 1.3 and 2.3", b"\x23\x02"
    _HEAD = 5

    def __init__(self, order: str = "low", covers: str = "frame") -> None:
        """``order``: which byte of the length is first. ``covers``: what the CRC covers, frame or
        content (E-M2)."""
        self._little = order == "low"
        self._covered = 0 if covers == "frame" else self._HEAD

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        if end - at < self._HEAD:
            return 0
        low, high = (2, 3) if self._little else (3, 2)
        count = data[at + low] | data[at + high] << 8
        if not 1 <= count <= MOST:
            return FaultKind.BAD_LENGTH
        if data[at + 4] not in (Sender.TOPSIDE, Sender.VEHICLE):
            return FaultKind.BAD_ENUM
        return count + OVERHEAD if end - at >= count + OVERHEAD else 0

    def check(self, raw: bytes) -> FaultKind | None:
        right = crc16_modbus(raw[self._covered : -2]) == raw[-2] | raw[-1] << 8
        return None if right else FaultKind.BAD_CHECKSUM

    def decode(self, raw: bytes) -> Values:
        content = raw[self._HEAD : -2]
        return {"address": raw[4], "length": len(content), "content": content.hex()}

    def encode(self, values: Mapping[str, Any]) -> bytes:
        try:
            content = bytes.fromhex(required(values, "content", self.name))
        except (TypeError, ValueError) as error:
            if isinstance(error, CannotEncode):
                raise
            raise CannotEncode(f"{self.name}: content is hexadecimal") from None
        if values.get("length", len(content)) != len(content):
            raise CannotEncode(f"{self.name}: length says {values['length']}, not {len(content)}")
        return self.wrap(content, required(values, "address", self.name))

    def wrap(self, content: bytes, address: int) -> bytes:
        """Return ``content`` in an envelope. Raises CannotEncode."""
        if not 1 <= len(content) <= MOST:
            raise CannotEncode(f"{self.name}: content has 1..{MOST} bytes, not {len(content)}")
        if address not in (Sender.TOPSIDE, Sender.VEHICLE):
            raise CannotEncode(f"{self.name}: address is 1 or 2, not {address!r}")
        length = len(content).to_bytes(2, "little" if self._little else "big")
        frame = self.lead + length + bytes([address]) + content
        return frame + crc16_modbus(frame[self._covered :]).to_bytes(2, "little")


def modem_frames(tolerances: Tolerances) -> tuple[FrameType, ...]:
    order, covers = tolerances["order_modem"], tolerances["modem_crc"]
    orders = ("low", "high") if order == "auto" else (order,)
    return tuple(ModemFrame(each, covers) for each in orders)


def wrap(content: bytes, address: int) -> bytes:
    """Return whole frames in the normative envelope. Raises CannotEncode."""
    return ModemFrame().wrap(content, address)


class ModemCodec:
    """Bytes of the modem's serial port in, envelopes and faults out."""

    def __init__(self, tolerances: Tolerances | None = None, baud: float = BAUD) -> None:
        longest = (MOST + OVERHEAD) * BITS_PER_BYTE / baud
        frames = modem_frames(tolerances or Tolerances())
        self.framer = Framer(frames, idle=IDLE, patience=IDLE + 2.0 * longest)

    def receive(self, data: bytes, now: float) -> list[Envelope | FrameFault]:
        return [self._envelope(item) for item in self.framer.receive(data, now)]

    def next_timer(self) -> float | None:
        return self.framer.next_timer()

    def flush(self, now: float) -> list[Envelope | FrameFault]:
        return [self._envelope(item) for item in self.framer.flush(now)]

    @staticmethod
    def _envelope(item: Any) -> Envelope | FrameFault:
        if isinstance(item, FrameFault):
            return item
        return Envelope(item.t, item.raw[4], item.raw[5:-2])
