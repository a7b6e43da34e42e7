"""A serial port: 8N1, exclusive, never blocking. ``serial:///dev/ttyUSB0?baud=9600``.

``fileno`` is for the event loop's ``add_reader``. Bytes that the driver does not take at once wait
here for the next ``send`` or ``receive``. If more than ``BACKLOG`` bytes wait, nobody reads them,
and the link is closed. What does not live here: gaps between frames, retries.
"""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path

import serial

from links import SERIAL_BAUD, Address, LinkAddressError
from links.base import LinkAbsent, LinkBusy, LinkClosed, LinkError, Rx

BACKLOG = 4096  # bytes, four seconds at 9600
_CHUNK = 4096
_BUSY = (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK)
_ABSENT = (errno.ENOENT, errno.ENODEV, errno.ENXIO, errno.EIO)


class SerialLink:
    def __init__(self, name: str, device: str, baud: int = SERIAL_BAUD) -> None:
        self.name, self.device = name, device
        self._waiting = bytearray()
        try:
            self._port: serial.Serial | None = serial.Serial(
                device, baud, timeout=0, write_timeout=0, exclusive=True
            )
        except ValueError as error:
            raise LinkAddressError(f"{name}: {device}: {error}") from error
        except Exception as error:  # also termios.error: the device was unplugged meanwhile
            raise _why(name, device, error) from error

    def fileno(self) -> int:
        return -1 if self._port is None else int(self._port.fileno())

    def receive(self, now: float) -> list[Rx]:
        self._flush()
        fd, out = self._fd(), bytearray()
        while True:
            try:
                data = os.read(fd, _CHUNK)
            except BlockingIOError:
                break
            except OSError as error:
                raise self._gone(error) from error
            if not data:
                if not out:
                    self._check_present()
                break
            out += data
            if len(data) < _CHUNK:
                break
        return [Rx(now, self.name, bytes(out))] if out else []

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._waiting += data
        self._flush()
        if len(self._waiting) > BACKLOG:
            self.close()
            raise LinkClosed(f"{self.name}: {self.device} takes no bytes any more")

    def next_event(self) -> float | None:
        return None

    def close(self) -> None:
        port, self._port = self._port, None
        self._waiting.clear()
        if port is not None:
            port.close()

    def _flush(self) -> None:
        while self._waiting:
            try:
                written = os.write(self._fd(), self._waiting)
            except BlockingIOError:
                return
            except OSError as error:
                raise self._gone(error) from error
            del self._waiting[:written]

    def _fd(self) -> int:
        if self._port is None:
            raise LinkClosed(f"{self.name}: {self.device} was closed")
        return int(self._port.fileno())

    def _check_present(self) -> None:
        """Close and raise LinkClosed if the device was pulled out. An empty read means silence or
        that; another device may have taken the same name since."""
        if not Path(self.device).exists() or _is_hung_up(self._fd()):
            self.close()
            raise LinkClosed(f"{self.name}: {self.device} went away: is the cable in?")

    def _gone(self, error: OSError) -> LinkClosed:
        self.close()
        return LinkClosed(f"{self.name}: {self.device} went away: {error.strerror or error}")


def _is_hung_up(fd: int) -> bool:
    if sys.platform == "win32":
        return False  # there reads fail instead
    import termios

    try:
        termios.tcgetattr(fd)
    except termios.error:
        return True
    return False


def _why(name: str, device: str, error: Exception) -> LinkError:
    number = error.args[0] if error.args else None
    if number in _BUSY or "exclusively lock" in str(error):
        return LinkBusy(f"{name}: {device} is in use by another program: close that one first")
    if number in _ABSENT:
        return LinkAbsent(f"{name}: no device {device}: is it plugged in? See `ls /dev/tty*`")
    if number == errno.EACCES:
        return LinkAbsent(
            f"{name}: no permission for {device}: add the user to its group, e.g. dialout"
        )
    if number == errno.ENOTTY or os.strerror(errno.ENOTTY) in str(error):
        return LinkAbsent(f"{name}: {device} is no serial port: see `ls /dev/tty*`")
    return LinkAbsent(f"{name}: {device} cannot be opened: {error}")


def settings(address: Address) -> tuple[str, int]:
    """The device and its bit rate. Raises LinkAddressError."""
    if address.host or not address.path:
        raise LinkAddressError(
            f"{address.url}: write three slashes and a device, e.g. serial:///dev/ttyUSB0?baud=9600"
        )
    device = address.path
    if sys.platform == "win32":
        device = device.lstrip("/")  # serial:///COM3
    return device, int(address.number("baud", SERIAL_BAUD, 50, 4_000_000))


def open_url(name: str, address: Address) -> SerialLink:
    return SerialLink(name, *settings(address))
