"""Bytes on their way: pseudo-terminals at the pace of their baud rate, checksums, and the record.

A byte takes ten bit times. What the program writes is taken to begin when the sea sees it, so two
writes are as far apart on the line as they are in time.
"""

from __future__ import annotations

import array
import fcntl
import os
import random
import termios
import time
import tty
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

BURST_GAP = 0.008  # s of silence that end a burst (the board waits for 20 ms and finds it by then)

HANDFUL = 0.03  # s of line time that reach the program at once (a UART's FIFO and its driver)


FULL = 3500  # bytes that a pseudo-terminal holds for a program that does not read

PATIENCE = 2.0  # real seconds for the kernel to move bytes; a program that ended takes none


def crc_modbus(data: bytes) -> int:
    """CRC-16, polynomial A001 reflected, init FFFF: `123456789` gives 4B37 (protocols, 1.3)."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ 0xA001 if crc & 1 else crc >> 1
    return crc


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        crc = byte << 24
        for _ in range(8):
            crc = (crc << 1) ^ 0x04C11DB7 if crc & 0x80000000 else crc << 1
        table.append(crc & 0xFFFFFFFF)
    return table


CRC_TABLE = _crc_table()


def crc_stm32(data: bytes) -> int:
    """CRC-32 of the STM32's unit: words low byte first, zeros appended (E-V19)."""
    data += bytes(-len(data) % 4)
    crc = 0xFFFFFFFF
    for start in range(0, len(data), 4):
        for byte in reversed(data[start : start + 4]):
            crc = ((crc << 8) ^ CRC_TABLE[(crc >> 24) ^ byte]) & 0xFFFFFFFF
    return crc


def modem_frame(content: bytes, address: int = 1) -> bytes:
    """The envelope of the acoustic modem; address 1: from topside, 2: from the vehicle."""
    body = b"\x23\x02" + len(content).to_bytes(2, "little") + bytes([address]) + content
    return body + crc_modbus(body).to_bytes(2, "little")


@dataclass
class Line:
    """A serial line: `path` is the program's end, this object is the device's."""

    baud: int
    master: int = -1
    slave: int = -1
    path: str = ""
    plugged: bool = True
    noise: float = 0.0  # share of the bytes to the program that arrive wrong
    taken: int = 0  # bytes from the program
    _out: list[tuple[float, bytes]] = field(default_factory=list)
    _free_out: float = 0.0
    _free_in: float = 0.0
    _burst: bytes = b""
    _burst_ends: float = 0.0

    def __post_init__(self) -> None:
        self._open()
        self.path = os.ttyname(self.slave)
        self._dice = random.Random(self.baud)

    def _open(self) -> None:
        self.master, self.slave = os.openpty()
        for fd in (self.master, self.slave):
            tty.setraw(fd)
        os.set_blocking(self.master, False)

    def send(self, now: float, data: bytes) -> None:
        """Put bytes on the line behind those that are on it."""
        start = max(now, self._free_out)
        byte = 10 / self.baud
        self._free_out = start + len(data) * byte
        step = max(1, int(HANDFUL / byte))
        for at in range(0, len(data), step):
            self._out.append((start + min(at + step, len(data)) * byte, data[at : at + step]))

    def pump(self, now: float, taken: Callable[[], float]) -> bool:
        """Hand what has arrived by now to the program; whether there was something.

        The kernel moves bytes through a pseudo-terminal in its own time: wait until they are there,
        or until the program, which counts what it has `taken`, has them.
        """
        data = b""
        while self._out and self._out[0][0] <= now:
            data += self._out.pop(0)[1]
        if not (data and self.plugged):
            return False
        if self.noise:
            wrong = (self._dice.random() < self.noise for _ in data)
            data = bytes(b ^ 0x55 if bad else b for b, bad in zip(data, wrong, strict=True))
        before = self._unread()
        if before + len(data) > FULL:
            return False
        taken_before = taken()
        wanted = before + taken_before + os.write(self.master, data)
        patience = time.monotonic() + PATIENCE
        while self._unread() + taken() < wanted and time.monotonic() < patience:
            os.sched_yield()
        return True

    def _unread(self) -> int:
        count = array.array("i", [0])
        fcntl.ioctl(self.slave, termios.FIONREAD, count)
        return count[0]

    def receive(self) -> bytes:
        """The bytes that the program has written since the last look."""
        try:
            data = os.read(self.master, 65536)
        except OSError:  # nothing there
            return b""
        self.taken += len(data)
        return data if self.plugged else b""

    def bursts(self, now: float, data: bytes) -> list[bytes]:
        """Add what was received; the bursts that a UART with idle detection has seen end."""
        ended: list[bytes] = []
        if data:
            start = max(now, self._free_in)
            if self._burst and start - self._burst_ends >= BURST_GAP:
                ended.append(self._burst)
                self._burst = b""
            self._burst += data
            self._free_in = self._burst_ends = start + len(data) * 10 / self.baud
        elif self._burst and now - self._burst_ends >= BURST_GAP:
            ended.append(self._burst)
            self._burst = b""
        return ended

    def vanish(self) -> None:
        """The device is gone, and with it its name; what it sends meanwhile is lost."""
        self.receive()
        self.close()
        Path(self.path).unlink()
        self.plugged = False
        self._open()

    def come_back(self) -> None:
        """It is there again, as another device; `path`, a link as udev makes one, leads to it."""
        Path(self.path).symlink_to(os.ttyname(self.slave))
        self.plugged = True

    def link(self, path: Path) -> None:
        """Be known by a link from now on, as `/dev/serial0` is one."""
        path.symlink_to(self.path)
        self.path = str(path)

    def flush(self) -> None:
        """Forget what nobody has read, as a driver does between close and open."""
        termios.tcflush(self.slave, termios.TCIFLUSH)

    def close(self) -> None:
        """Give both ends back."""
        os.close(self.master)
        os.close(self.slave)
