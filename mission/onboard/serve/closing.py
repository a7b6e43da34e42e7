"""Convert closed parts of black boxes to their final form, in the background of a running serve.

A separate process does this: it takes no time from the event loop, and if it is killed, each part
is there, in one form or the other. It gets the list of parts: a part that begins meanwhile is left
to the next process. What does not live here: the conversion (blackbox.closed).
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
from pathlib import Path

_RUNNING: list[subprocess.Popen[bytes]] = []


def close_in_background(folder: Path, but: Path | None) -> None:
    """Convert all parts in the folder except ``but``, which is being written. Without such parts no
    process is started. Never raises: if none can be started, the parts stay readable as they are.
    """
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
