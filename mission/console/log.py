"""The console's log of requests and their results, one JSON object per line; restarts add to it.

    <folder>/console.jsonl     {"wall", "vehicle", ...}, renamed to console-1.jsonl at ``MOST``

A renamed file replaces the one before it. A failed write stops nothing: the vehicle's own black box
records what was sent to it.
"""

from __future__ import annotations

import contextlib
import json
import time
from pathlib import Path
from typing import Any

FILE, BEFORE = "console.jsonl", "console-1.jsonl"
MOST = 10_000_000  # bytes


class Log:
    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def note(self, vehicle: str, **said: Any) -> None:
        line = json.dumps({"wall": round(time.time(), 3), "vehicle": vehicle, **said})
        path = self._folder / FILE
        with contextlib.suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True)
            if path.exists() and path.stat().st_size > MOST:
                path.replace(self._folder / BEFORE)
            with path.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")
