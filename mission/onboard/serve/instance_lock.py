"""Only one serve may use a folder: two would both command the vehicle and overwrite each other's
state.

The lock is on the folder itself and ends with the process, however that ends. On a disk without
locks serve begins all the same, because it may have a vehicle to surface. What does not live here:
the exclusive use of a port (links).
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from mission.onboard.serve import health


class AnotherServe(OSError):
    """Another process has the folder; the message names it. The operator must act."""


@contextlib.contextmanager
def only_one(folder: Path) -> Iterator[None]:
    """Hold the folder's lock. Raises AnotherServe."""
    descriptor = _locked(folder)
    try:
        yield
    finally:
        if descriptor >= 0:
            os.close(descriptor)


def _locked(folder: Path) -> int:
    """Lock the folder; its descriptor, or -1 if it cannot be locked."""
    try:
        import fcntl

        descriptor = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    except (ImportError, OSError):
        return -1
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        who = health.process(folder)
        raise AnotherServe(
            f"another serve{f' (process {who})' if who else ''} runs with the folder {folder}: "
            "stop that one first (systemctl stop auvmission), or give --folder"
        ) from None
    except OSError:
        os.close(descriptor)
        return -1
    return descriptor
