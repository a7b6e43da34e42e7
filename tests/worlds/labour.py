"""Jobs that other processes do, well or badly. A job is what to do and a folder or a number."""

from __future__ import annotations

import os
import resource
import signal
import time
from pathlib import Path
from typing import Any

from mission.verification.workers.code import code

Job = tuple[str, Any]


def do(job: Job) -> Any:
    what, of = job
    return globals()[what](of)


def square(number: int) -> float:
    time.sleep(0.02 * (number % 3))  # they do not end in their order
    return number * number + 0.1


def sources(_: int) -> str:
    """Of the program that does it."""
    time.sleep(0.02)
    return code()["sources"]


def process(_: int) -> int:
    """The one that does it."""
    time.sleep(0.02)
    return os.getpid()


def dies(_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def dies_later(_: object) -> None:
    """When others wait for its worker."""
    time.sleep(0.3)
    dies(_)


def dies_of(number: int) -> None:
    os.kill(os.getpid(), number)


def hangs(_: object) -> None:
    time.sleep(1e6)


def eats(_: object) -> int:
    resource.setrlimit(resource.RLIMIT_AS, (1 << 31, 1 << 31))
    return len(bytearray(1 << 33))


def eats_too_much(folder: Path) -> None:
    """As a worker without a limit of its own says it."""
    noted(folder)
    raise MemoryError


def outgrows(_: object) -> int:
    """The limit of its worker, but not the memory of this machine; then it waits for its end."""
    full = bytearray(b"x") * (600 << 20)
    time.sleep(1e6)
    return len(full)


def fails(folder: Path) -> None:
    noted(folder)
    raise KeyError("no such leg")


def sends_what_cannot_be_sent(_: object) -> object:
    return lambda: None


class Unreadable:
    """Whoever reads it back fails."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _cannot_be_read, ()


def _cannot_be_read() -> None:
    raise LookupError("no such thing here")


def sends_what_cannot_be_read(_: object) -> object:
    return Unreadable()


def waits_for(file: Path) -> bool:
    while not file.exists():
        time.sleep(0.01)
    return True


def dies_once(folder: Path) -> str:
    return "lived" if noted(folder) > 1 else str(dies(folder))


def stops_once(folder: Path) -> str:
    if noted(folder) == 1:
        os.kill(os.getpid(), signal.SIGSTOP)
    return "lived"


def hangs_once(folder: Path) -> str:
    return "answered" if noted(folder) > 1 else str(hangs(folder))


def noted(folder: Path) -> int:
    """How often it was tried, this time included."""
    (folder / f"{time.time_ns()}.{os.getpid()}").touch()
    return len(list(folder.iterdir()))


def lives(folder: Path) -> bool:
    """Whether the process that has tried it there does."""
    (note,) = folder.iterdir()
    return Path("/proc", note.suffix[1:]).exists()


def tells_its_process(folder: Path) -> int:
    noted(folder)
    return os.getpid()
