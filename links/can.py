"""A CAN bus by python-can: ``can://can0?interface=socketcan&bitrate=500000``.

Bytes in and out are records, one per frame:

    identifier u16, high byte first | DLC u8 | data

The link carries only standard data frames (11-bit identifier, at most 8 bytes). It counts remote,
error, extended and FD frames in ``skipped``. Bus-off closes the link. A bus without a carrier is
absent, because the kernel drops frames on it without an error. Without ``one-shot`` an old thrust
command stays queued until boards that had no power receive it. Without ``restart-ms`` a bus-off is
permanent. python-can is an extra (auvmission[can]) and is imported when a bus is opened. Its
``virtual`` interface connects links within one process.

``can://239.74.163.2:43113?interface=udp_multicast`` is a bus between programs of one computer or
network. python-can receives every multicast group of its port: two buses need two ports.
``sensors=/dev/ttyUSB1`` joins a serial line to the bus, at ``baud`` (links.joined).

What does not live here: what identifiers mean (protocol).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from links import Address, LinkAddressError
from links.base import Link, LinkAbsent, LinkClosed, LinkError, Rx
from links.joined import JoinedLink
from links.serial import SerialLink

BITRATE = 500_000  # bit/s (R16)
SENSORS_BAUD = 115_200  # bit/s, of the serial line beside the bus
MOST_AT_ONCE = 4096  # frames per receive: a flooded bus must not block the event loop
_HEAD = 3
_STANDARD = 0x7FF
_BUS_OFF = 0x40  # CAN_ERR_BUSOFF in an error frame (linux/can/error.h)
INTERFACES = Path("/sys/class/net")  # Linux's own


class CanLink:
    def __init__(
        self,
        name: str,
        channel: str,
        *,
        interface: str = "socketcan",
        bitrate: int = BITRATE,
        port: int | None = None,
    ) -> None:
        """``port``: of a bus by UDP; None: python-can's default. Raises LinkAbsent."""
        try:
            import can
        except ImportError:
            raise LinkAbsent(f"{name}: python-can is missing: install auvmission[can]") from None
        self.name, self.skipped = name, 0
        self._message, self._error = can.Message, can.CanError
        self.bus: Any = None
        try:
            more: dict[str, Any] = {} if port is None else {"port": port}
            self.bus = can.Bus(channel=channel, interface=interface, bitrate=bitrate, **more)
        except (can.CanError, OSError, ValueError, ImportError) as error:
            raise LinkAbsent(
                f"{name}: no CAN bus {channel} by {interface}: {error}; is it up (ip link set "
                f"{channel} up type can bitrate {bitrate} restart-ms 100 one-shot on)?"
            ) from error
        if interface == "socketcan" and _is_without_carrier(channel):
            self.close()
            raise LinkAbsent(f"{name}: the CAN bus {channel} has no carrier: it is off")

    def fileno(self) -> int:
        if self.bus is None:
            return -1
        try:
            return int(self.bus.fileno())
        except NotImplementedError:  # the virtual bus
            return -1

    def receive(self, now: float) -> list[Rx]:
        bus = self._open()
        out: list[Rx] = []
        for _ in range(MOST_AT_ONCE):
            try:
                frame = bus.recv(0.0)
            except (self._error, OSError) as error:
                raise LinkClosed(f"{self.name}: {error}") from error
            if frame is None:
                break
            if frame.is_error_frame and frame.arbitration_id & _BUS_OFF:
                raise LinkClosed(f"{self.name}: the bus is off: a short, or another bit rate")
            if _carried(frame):
                head = frame.arbitration_id.to_bytes(2, "big") + bytes([frame.dlc])
                out.append(Rx(now, self.name, head + bytes(frame.data)))
            else:
                self.skipped += 1
        return out

    def send(self, data: bytes, now: float, address: str = "") -> None:
        bus = self._open()
        for identifier, payload in _records(self.name, data):
            frame = self._message(arbitration_id=identifier, data=payload, is_extended_id=False)
            try:
                bus.send(frame)
            except (self._error, OSError) as error:
                raise LinkClosed(f"{self.name}: {error}") from error

    def next_event(self) -> float | None:
        return None

    def close(self) -> None:
        if self.bus is not None:
            self.bus.shutdown()
            self.bus = None

    def _open(self) -> Any:
        if self.bus is None:
            raise LinkClosed(f"{self.name}: the link was closed")
        return self.bus


def _is_without_carrier(channel: str) -> bool:
    """Whether Linux reports no carrier for a bus that is up; False if it reports nothing."""
    try:
        return (INTERFACES / channel / "carrier").read_text().strip() == "0"
    except OSError:
        return False


def _carried(frame: Any) -> bool:
    special = frame.is_extended_id or frame.is_remote_frame or frame.is_error_frame or frame.is_fd
    return not special


def _records(name: str, data: bytes) -> list[tuple[int, bytes]]:
    out = []
    at = 0
    while at < len(data):
        head = data[at : at + _HEAD]
        size = head[2] if len(head) == _HEAD else 0
        payload = data[at + _HEAD : at + _HEAD + size]
        identifier = int.from_bytes(head[:2], "big")
        if len(head) < _HEAD or len(payload) < size or size > 8 or identifier > _STANDARD:
            raise LinkError(f"{name}: {data.hex()} is no sequence of CAN records")
        out.append((identifier, payload))
        at += _HEAD + size
    return out


def settings(address: Address) -> tuple[str, str, int, int | None]:
    """Channel, interface, bit rate and port. Raises LinkAddressError."""
    channel = address.host + address.path
    if not channel:
        raise LinkAddressError(f"{address.url}: name the bus, e.g. can://can0")
    interface = address.options.get("interface", "socketcan")
    bitrate = int(address.number("bitrate", BITRATE, 10_000, 1_000_000))
    _baud(address)
    if address.port is not None and interface != "udp_multicast":
        raise LinkAddressError(f"{address.url}: a port is of interface=udp_multicast alone")
    return channel, interface, bitrate, address.port


def _baud(address: Address) -> int:
    """The baud rate of the serial line beside the bus."""
    return int(address.number("baud", SENSORS_BAUD, 300, 4_000_000))


def open_url(name: str, address: Address) -> Link:
    channel, interface, bitrate, port = settings(address)
    bus = partial(CanLink, name, channel, interface=interface, bitrate=bitrate, port=port)
    device = address.options.get("sensors")
    if device is None:
        return bus()
    return JoinedLink(name, bus, partial(SerialLink, name, device, _baud(address)))
