"""The closed parts of black boxes into their last form, beside a serve that has other things to do.

A process of its own: what it computes takes nothing from the loop, and whenever it is killed each
part is there, in one form or the other. What does not live here: what it does (blackbox.closed).
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
        if any(part != but for part in folder.glob("*.mcap")):
            _RUNNING.append(_begun(folder, but))


def _begun(folder: Path, but: Path | None) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "mission.onboard.blackbox", str(folder), str(but or "")],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
