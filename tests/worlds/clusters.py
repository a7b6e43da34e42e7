"""A Dask cluster of this machine: schedulers and workers in processes of their own, which end with
the test; and another program than this one."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from served import soon

ROOT = Path(__file__).resolve().parents[2]
UNFORGIVING = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}


@dataclass(frozen=True)
class Begun:
    """A program of Dask's. ``word``: what followed the awaited words; ``log``: all it has said."""

    process: subprocess.Popen[bytes]
    word: str
    log: Path

    def kill(self) -> None:
        """With the processes that it has begun."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()

    def times(self, words: str) -> int:
        """How often its log has these words."""
        return self.log.read_text().count(words)


@contextmanager
def begun(
    call: list[str], folder: Path, path: str, words: str, settings: dict[str, str]
) -> Iterator[Begun]:
    """A program of Dask's from when its log has the ``words``, to the end of the block.
    ``settings``: of Dask's own, as its environment says them."""
    log = folder / f"{call[0]}{len(list(folder.iterdir()))}.log"
    with log.open("wb") as file:
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{call[0]}", *call[1:]],
            stdout=file, stderr=file, cwd=folder, start_new_session=True,
            env={**os.environ, "PYTHONPATH": path, **settings},
        )  # fmt: skip

    def told() -> list[str]:
        assert process.poll() is None, f"{call[0]} ended: {log.read_text()}"
        return re.findall(re.escape(words) + r"(.*)\n", log.read_text())

    program = Begun(process, "", log)
    try:
        soon(lambda: bool(told()), f"{words!r} of {call[0]}")
        yield Begun(process, told()[0].strip(), log)
    finally:
        program.kill()


@contextmanager
def worker(
    address: str,
    folder: Path,
    *options: str,
    tree: Path = ROOT,
    threads: int = 1,
    protocol: str = "tcp",
    **settings: str,
) -> Iterator[Begun]:
    call = ["dask_worker", f"{protocol}://{address}", "--nthreads", str(threads), "--no-dashboard"]
    path = os.pathsep.join([str(tree), str(ROOT / "tests" / "worlds")])
    with begun([*call, *options], folder, path, "Registered to", settings) as program:
        yield program


@contextmanager
def scheduling(folder: Path, *options: str, port: int = 0, **settings: str) -> Iterator[Begun]:
    """``word``: its address, HOST:PORT."""
    call = ["dask_scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
    with begun([*call, *options], folder, str(ROOT), "Scheduler at:", settings) as program:
        yield Begun(program.process, program.word.partition("://")[2], program.log)


def processes_of(address: str) -> dict[str, int]:
    """The process of each worker, by its address."""
    import distributed  # and what it brings, where it is used

    with distributed.Client(f"tcp://{address}", set_as_default=False) as client:
        found: dict[str, int] = client.run(os.getpid)
        return found


@contextmanager
def stopped(*pids: int) -> Iterator[None]:
    """They stand still, as long as the block lasts."""
    for pid in pids:
        os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        for pid in pids:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)


def other_program(folder: Path) -> Path:
    """A copy of the program in which one source differs."""
    tree = same_program(folder)
    heavier(tree)
    return tree


def same_program(folder: Path) -> Path:
    for package in ("mission", "links", "protocol", "missions"):
        half = shutil.ignore_patterns("*.pyc.*")  # what another process just compiles
        shutil.copytree(ROOT / package, folder / package, ignore=half)
    return folder


def heavier(tree: Path) -> None:
    with (tree / "links" / "simulated" / "plant.py").open("a") as plant:
        plant.write("# heavier\n")
