"""Ghost flights: each in a process of its own, which ends with the page that asked for it.

    /ws/ghost   page -> {"do": "fly", "text", "source", "settings", "seed"} | {"do": "cancel"}
                        {"do": "plan", "text", "source"}    the same in still water: what is planned

The console's loop never waits for a flight: it runs in another process and is limited in time and
number. A new flight of the same page replaces it. Flights in still water share a single place, and
wait for it; the last few results are kept.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
from collections.abc import Awaitable, Callable

from mission.console.asked import BODY, Said

LONGEST_S = 300.0
AT_ONCE = 2  # flights of all pages together
KEPT = 8  # results in still water
OUTPUT = 8 << 20  # bytes
LEAVE_TICKS, TICK_S = 200, 0.01
_MODULE = "mission.console.flying"
Tell = Callable[[Said], Awaitable[None]]


class Ghosts:
    """The flights of a console's pages. ``longest``: s that one may take."""

    def __init__(self, longest: float = LONGEST_S) -> None:
        self._longest = longest
        self.under_way = 0
        self._place = asyncio.Semaphore(1)
        self._alive = set[asyncio.subprocess.Process]()
        self._known: dict[bytes, Said] = {}

    async def fly(self, said: Said, vehicle: str | None, tell: Tell) -> None:
        """Tell ``flying``, then ``done`` or ``refused``; a cancellation ends the process."""
        if self.under_way >= AT_ONCE:
            await tell({"is": "refused", "says": f"{AT_ONCE} flights are under way already"})
            return
        self.under_way += 1
        try:
            await tell({"is": "flying"})
            await tell(await self._flown(_job(said, vehicle), self._longest))
        finally:
            self.under_way -= 1

    async def end(self) -> None:
        """End all flights with the console, and wait for them."""
        for process in self._alive:
            _kill(process)
        for _ in range(LEAVE_TICKS):
            if not self._alive:
                return
            await asyncio.sleep(TICK_S)

    async def plan(self, said: Said, vehicle: str | None, tell: Tell) -> None:
        """Tell ``planned`` or ``refused``."""
        await tell(await self.planned(said, vehicle))

    async def planned(self, said: Said, vehicle: str | None) -> Said:
        job = _job({**said, "settings": (), "seed": 0}, vehicle, "plan")
        async with self._place:
            if (known := self._known.pop(job, None)) is None:
                known = await self._flown(job, self._longest)
            if known["is"] != "refused":
                self._known[job] = known
            if len(self._known) > KEPT:
                del self._known[next(iter(self._known))]
            return known

    async def _flown(self, job: bytes, longest: float) -> Said:
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", _MODULE, limit=OUTPUT,
            stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
        )  # fmt: skip
        self._alive.add(process)
        try:
            async with asyncio.timeout(longest):
                out, error = await process.communicate(job)
        except TimeoutError:
            return {"is": "refused", "says": f"it takes longer than {longest:g} s"}
        finally:
            _kill(process)
            await process.communicate()  # read its pipes to the end, so that they are closed
            self._alive.discard(process)
        if process.returncode:
            last = error.decode(errors="replace").strip().rpartition("\n")[2][:200]
            return {"is": "refused", "says": f"the flight ended: {last}"}
        found = json.loads(out)
        return {"is": "refused", **found} if "says" in found else found


def _kill(process: asyncio.subprocess.Process) -> None:
    with contextlib.suppress(ProcessLookupError):
        process.kill()
    if process.stdin is not None:
        process.stdin.close()


def _job(said: Said, vehicle: str | None, do: str = "fly") -> bytes:
    """Raises KeyError, TypeError or ValueError for a malformed request."""
    text, source, settings = str(said["text"]), str(said["source"]), list(said["settings"])
    if len(text) > BODY or len(settings) > 100:
        raise ValueError("that is no flight")
    job = {
        "do": do,
        "text": text,
        "source": source,
        "vehicle": vehicle,
        "settings": [str(one) for one in settings],
        "seed": int(said["seed"]),
    }
    return json.dumps(job).encode()
