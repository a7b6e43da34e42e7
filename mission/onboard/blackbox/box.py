"""The writer of a black box, record by record.

A file that has reached its limit is closed, and the recording continues in the next part. A failing
disk must not stop the vehicle: nothing here raises after opening, nor when a shell stores. Bytes
that cannot be written wait, up to ``WAITING``. Further records are counted as lost, and their
numbers are missing in the file.

What does not live here: the bytes (form), the conversion of a closed part (closed).
"""

from __future__ import annotations

import errno
import os
from pathlib import Path

from mission.model import Record
from mission.onboard.blackbox.form import LIMIT, NS, BlackBoxError, count, foot, head, pack
from mission.onboard.blackbox.parts import free, part_path
from mission.onboard.runtime.records import START

WAITING = 16 << 20  # bytes kept while the disk cannot be written
_BATCH = 1 << 16


class BlackBox:
    """A Recorder. ``wall``: s since 1970 UTC at the engine's time 0 (0: none, as in simulation).

    ``shell`` False: ``record`` writes the file itself, in batches, never synced. Raises
    BlackBoxError if the file cannot be created.

    ``shell`` True: ``record`` only buffers. The shell calls ``take`` in the same thread, and gives
    the bytes to ``store`` in another thread, one call at a time. The first ``store`` creates the
    file under a free name; if that fails, the next ``store`` tries again.
    """

    def __init__(
        self, path: Path, wall: float = 0.0, limit: int = LIMIT, shell: bool = False
    ) -> None:
        self.path, self.failure, self.lost = path, "", 0
        self._base, self._wanted, self._part, self._limit = path, path, 1, limit
        self._wall, self._shell, self._logged = round(wall * NS), shell, 0
        self._pending, self._start, self._number = bytearray(), b"", 0
        self._unwritten = bytearray()
        self.fd, self._size, self._closed = -1, 0, False
        if not shell:
            self._open()

    def record(self, record: Record) -> None:
        number, self._number = self._number, self._number + 1
        t = round(record.t * NS)
        self._logged = max(self._logged, self._wall + t)
        message = pack(record.kind, record.payload, number, self._logged, t)
        if record.kind == START:
            self._start = message
        if self._shell and len(self._pending) > WAITING:
            self.lost += 1
            return
        self._pending += message
        if not self._shell and len(self._pending) > _BATCH:
            self.store(self.take())

    def take(self) -> bytes:
        """Return the records since the last call, as whole messages."""
        data, self._pending = bytes(self._pending), bytearray()
        return data

    def store(self, data: bytes, sync: bool = False) -> None:
        """Write the data. Never raises: ``failure`` is the disk's last error, "" if all is well."""
        if len(self._unwritten) > WAITING:
            self.lost += count(data)
            data = b""
        try:
            self._write(data)
            if sync:
                os.fdatasync(self.fd)
            self.failure = ""
        except BlackBoxError as error:
            self.failure = str(error)
        except OSError as error:
            self.failure = f"{self.path}: {error.strerror or error}"

    def close(self) -> None:
        """Write the rest and close the file; a second call does nothing."""
        if self._closed:
            return
        self.store(self.take())
        self._closed = True
        fd, self.fd = self.fd, -1
        if fd >= 0:
            self._finish(fd)

    def _open(self) -> None:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if self._shell:
                self.path = self._base = free(self._wanted)
            self.fd, self._size = _begin(self.path)
        except OSError as error:
            why = error.strerror or error
            raise BlackBoxError(f"the black box {self.path} cannot be made: {why}") from error

    def _write(self, data: bytes) -> None:
        """Write the bytes left over from earlier writes, then the data: no record is split."""
        filled = self._size > 2 * len(head()) and self._size + len(data) > self._limit
        if not self._unwritten and filled:
            self._unwritten = bytearray(data)
            self._next_part()
        else:
            self._unwritten += data
        if self.fd < 0:
            self._open()
        while self._unwritten:
            written = os.write(self.fd, self._unwritten)
            self._size += written
            del self._unwritten[:written]

    def _next_part(self) -> None:
        path = part_path(self._base, self._part + 1)
        fd, self._size = _begin(path)
        old, self.fd, self.path, self._part = self.fd, fd, path, self._part + 1
        self._unwritten[:0] = self._start
        self._finish(old)

    def _finish(self, fd: int) -> None:
        try:
            os.write(fd, foot())
            os.fsync(fd)
        except OSError as error:
            self.failure = f"{self.path}: {error.strerror or error}"
        finally:
            os.close(fd)


def _begin(path: Path) -> tuple[int, int]:
    """Create a file with its head; return descriptor and size."""
    fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o644)
    try:
        if (written := os.write(fd, head())) < len(head()):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    except OSError:
        os.close(fd)
        path.unlink()  # so that the next try finds the name free
        raise
    return fd, written
