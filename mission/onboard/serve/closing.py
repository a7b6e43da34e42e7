"""The closed parts of black boxes into their last form, beside a serve that has other things to do.

A process of its own: what it computes takes nothing from the loop, and whenever it is killed each
part is there, in one form or the other. It is told which parts those are: what begins while it does
is another's. What does not live here: what it does (blackbox.closed).
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
from pathlib import Path

_RUNNING: list[subprocess.Popen[bytes]] = []


def close_in_background(folder: Path, but: Path | None) -> None:
    """Never raises; without a process to be had the parts stay as they are, which can be read. None
    is begun where nothing but the part that is being written is there."""
    _RUNNING[:] = [process for process in _RUNNING if process.poll() is None]
    with contextlib.suppress(OSError):
        if parts := [part for part in sorted(folder.glob("*.mcap")) if part != but]:
            _RUNNING.append(_begun(parts))


def _begun(parts: list[Path]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "mission.onboard.blackbox", *map(str, parts)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
