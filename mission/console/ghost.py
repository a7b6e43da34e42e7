"""Ghost flights: each in a process of its own, which ends with who asked for it.

    /ws/ghost   page -> {"do": "fly", "text", "source", "settings", "seed"} | {"do": "cancel"}

The console's loop never waits for one: it flies elsewhere, is bounded in time and in number, and
the next of the same page takes its place.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
from collections.abc import Awaitable, Callable

from mission.console.asked import BODY, Said

LONGEST_S = 300.0
AT_ONCE = 2  # of all pages
OUTPUT = 8 << 20  # bytes
_MODULE = "mission.console.flying"
Tell = Callable[[Said], Awaitable[None]]


class Ghosts:
    """Those that fly for a console's pages. ``longest``: s that one may take."""

    def __init__(self, longest: float = LONGEST_S) -> None:
        self._longest = longest
        self.under_way = 0

    async def fly(self, said: Said, vehicle: str | None, tell: Tell) -> None:
        """Tells ``flying``, and then ``done`` or ``refused``; a cancellation ends the process."""
        if self.under_way >= AT_ONCE:
            await tell({"is": "refused", "says": f"{AT_ONCE} flights are under way already"})
            return
        self.under_way += 1
        try:
            await tell({"is": "flying"})
            await tell(await self._flown(_job(said, vehicle)))
        finally:
            self.under_way -= 1

    async def _flown(self, job: bytes) -> Said:
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", _MODULE, limit=OUTPUT,
            stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
        )  # fmt: skip
        try:
            async with asyncio.timeout(self._longest):
                out, error = await process.communicate(job)
        except TimeoutError:
            return {"is": "refused", "says": f"it takes longer than {self._longest:g} s"}
        finally:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            await process.wait()
        if process.returncode:
            last = error.decode(errors="replace").strip().rpartition("\n")[2][:200]
            return {"is": "refused", "says": f"the flight ended: {last}"}
        found = json.loads(out)
        return {"is": "refused", **found} if "says" in found else {"is": "done", **found}


def _job(said: Said, vehicle: str | None) -> bytes:
    """Raises KeyError, TypeError or ValueError for what no page says."""
    text, source, settings = str(said["text"]), str(said["source"]), list(said["settings"])
    if len(text) > BODY or len(settings) > 100:
        raise ValueError("that is no flight")
    job = {
        "text": text,
        "source": source,
        "vehicle": vehicle,
        "settings": [str(one) for one in settings],
        "seed": int(said["seed"]),
    }
    return json.dumps(job).encode()
