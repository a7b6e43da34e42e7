"""A command in a process of its own, as a shell begins it, that is interrupted by Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from served import PATIENCE, soon

CODE = 128 + signal.SIGINT
AT_ONCE = 2.0  # s that a command may take to end, with its processes, after Ctrl-C
SLOWER = 30.0  # or as many times as long as a command that does nothing, on a machine that is slow


@contextmanager
def begun(*call: str, **settings: str) -> Iterator[subprocess.Popen[str]]:
    """Python with these arguments, to the end of the block at the latest. In a process group of its
    own, and with Ctrl-C heard, as a terminal has it: who runs the tests in the background may have
    it ignored. ``settings``: of its environment."""
    process = subprocess.Popen(
        [sys.executable, *call],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        env={**os.environ, **settings},
    )
    with process:
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def group_of(process: subprocess.Popen[str]) -> list[int]:
    """The processes of its group that live."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, group = stat.read_text().rpartition(")")[2].split()[:3]
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(group) == process.pid and state != "Z":
            found.append(int(stat.parent.name))
    return found


def interrupted(process: subprocess.Popen[str]) -> tuple[int, list[str]]:
    """Exit code, and the lines on stderr after Ctrl-C but those of progress. It ends at once, with
    its processes."""
    since = time.monotonic()
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE)
    soon(lambda: not group_of(process), "nobody is left")
    took = time.monotonic() - since
    assert took < AT_ONCE or took < SLOWER * _nothing_takes(), f"{took:.1f} s to end"
    return process.returncode, [line for line in said.splitlines() if " s left" not in line]


def _nothing_takes() -> float:
    since = time.monotonic()
    subprocess.run([sys.executable, "-m", "mission", "--help"], capture_output=True, check=True)
    return time.monotonic() - since
