"""A vehicle of the console: what is known of it, which commands it takes, and over which
connection.

    monitor (a thread) ------------> Watched <--- looks by the command port, where there is none
    line of orders:   X, W           always open           (by modem one line does both)
    line of commands: all else, M    open while a page looks: who is heard keeps the command (R12)

What does not live here: recordings (recorded), what pages are sent (board), intents (intents).
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
import traceback
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mission.console import plans
from mission.console.board import Board
from mission.console.clock import VehicleClock
from mission.console.line import Line
from mission.console.log import Log
from mission.console.orders import Orders
from mission.console.steering import Steering
from mission.topside.contacts import SILENT_S, Contacts
from mission.topside.looking import Looked, look
from mission.topside.monitor import Watched
from mission.topside.sources import ASK_S, ASK_UNDER_WATER_S, frame_of, from_monitor
from mission.topside.upload import OperatorError

TICK_S = 0.1
LEAVE_S = 3.0  # after the last page
AGAIN_S = 1.0  # after a failure
FRAME = 4000  # bytes: 3 s of a radio of 12 kbit/s
COMMANDERS = {"asker": "us", "nobody": "nobody", "network": "other", "modem": "other"}


@dataclass(frozen=True, slots=True)
class Given:
    """``monitor``: "" if there is none. ``vehicle``: its file or the name of a shipped one; None:
    the one that the mission names. ``speed``: of a simulated vehicle, times real time."""

    name: str
    to: str
    monitor: str = ""
    vehicle: str | None = None
    speed: float = 1.0
    checklist: tuple[str, ...] = ()
    simulated: bool = False


class Vehicle:
    """Raises WrongAddress. Create and use it in one event loop."""

    def __init__(self, ident: str, given: Given, memory: Path) -> None:
        self.ident, self.given, self.log = ident, given, Log(memory)
        self.board = Board()
        self.commands = Line(given.to)
        self.under_water = self.commands.acoustics is not None
        self._orders_line = self.commands if self.under_water else Line(given.to)
        self.orders = Orders(self._orders_line)
        self.steering = Steering(self.commands)
        remembered = "" if given.simulated else given.to  # a simulated vehicle is never missed
        self.contacts = Contacts(remembered, memory, given.vehicle)
        self.checked: dict[str, float] = {}
        self._source = from_monitor(given.monitor, FRAME, "before") if given.monitor else None
        self._looked = Watched()
        self._heard, self._clock = self._looked, VehicleClock(given.speed)
        self._look_problem = ""
        self._plan = dict(plans.EMPTY)
        self._planned: tuple[str, tuple[str, ...]] | None = None
        self._known: dict[str, dict[str, Any]] = {}  # plans uploaded from here
        self._mine: list[dict[str, Any]] = []
        self._up_by: float | None = None
        self._began = time.monotonic()

    # --- what is known -------------------------------------------------------------------------

    @property
    def watched(self) -> Watched:
        return self._looked if self._source is None or self._looks else self._source.watched

    @property
    def _looks(self) -> bool:
        """Whether looks by the command port are shown: no monitor, or it is silent and the port is
        not."""
        if self._source is None:
            return True
        now = time.monotonic()
        silence, other = self._source.watched.silence(now), self._looked.silence(now)
        return (silence is None or silence > SILENT_S) and (other is not None and other <= SILENT_S)

    def about(self) -> dict[str, Any]:
        return {
            "id": self.ident,
            "name": self.given.name,
            "to": self.given.to,
            "source": "frames" if self._looks else "monitor",
            "under_water": self.under_water,
            "simulated": self.given.simulated,
            "speed": self.given.speed,
            "silent_s": self.contacts.silent_s,
            "checklist": list(self.given.checklist),
        }

    def plan(self) -> dict[str, Any]:
        return self._plan

    def frame(self, page: str, now: float) -> bytes:
        """b"" if nothing is new."""
        watched = self.watched
        if watched is not self._heard:
            self._heard, self._clock = watched, VehicleClock(self.given.speed)
        state = {**watched.state, **self._extras(watched, now)}
        if watched.at is not None:
            self._clock.hear(watched.at)
        return self.board.frame(page, watched, state, self._clock.now(now), now)

    def _extras(self, watched: Watched, now: float) -> dict[str, Any]:
        silence, state = watched.silence(now), self.commands.state
        return {
            "wall": int(time.time()),
            "silence": _rounded(silence),
            "problem": self._problem,
            "alarms": [*self._mine, *(watched.state.get("alarms") or ())],
            "command": {
                "is": COMMANDERS[state.commander] if state is not None else "unknown",
                "age": _rounded(self.commands.silence(now)),
            },
            "lines": {
                "orders": _rounded(self._orders_line.silence(now)),
                "commands": _rounded(self.commands.silence(now)),
            },
            "orders": self.orders.as_objects(now),
            "checked": self.checked,
            "plan": self._plan["digest"],
            "up_by": self._up_by,
        }

    @property
    def _problem(self) -> str:
        if self._looks:
            return self._look_problem
        return self._source.problem if self._source is not None else ""

    # --- while time passes -----------------------------------------------------------------------

    async def run(self) -> None:
        """Run until cancelled."""
        if self._source is not None:
            threading.Thread(target=self._source.run, daemon=True).start()
        parts = [self._orders_line.keep, self._tick, self._follow]
        if not self.under_water:
            parts.append(self._keep_commands)
        try:
            async with asyncio.TaskGroup() as group:
                for part in parts:
                    group.create_task(self._again(part))
        finally:
            self.orders.end()
            if self._source is not None:
                self._source.stopped.set()

    async def _again(self, part: Callable[[], Awaitable[None]]) -> None:
        """Run a part without end. A part that fails is logged and restarted; the others, X and W,
        continue."""
        while True:
            try:
                await part()
            except Exception as error:
                traceback.print_exc()
                self.log.note(self.given.name, failed=repr(error))
            await asyncio.sleep(AGAIN_S)

    async def _keep_commands(self) -> None:
        while True:
            while not self.board.pages:
                await asyncio.sleep(TICK_S)
            keeping = asyncio.get_running_loop().create_task(self._again(self.commands.keep))
            try:
                await self._nobody_looks()
            finally:
                keeping.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await keeping

    async def _nobody_looks(self) -> None:
        """Wait until no page has looked for ``LEAVE_S``, and no conversation is active."""
        last = time.monotonic()
        while time.monotonic() < last + LEAVE_S:
            if self.board.pages or self.commands.is_busy:
                last = time.monotonic()
            await asyncio.sleep(TICK_S)

    async def _tick(self) -> None:
        due = 0.0
        while True:
            now = time.monotonic()
            self.steering.hold(now)
            if now >= due:
                due = now + 1.0
                self.contacts.remember(self.watched, now)
                self._mine = [asdict(a) for a in self.contacts.alarms(self.watched, now, True)]
                self._up_by = _rounded(self.contacts.due())
            await asyncio.sleep(TICK_S)

    async def _follow(self) -> None:
        """Read the mission on board, and look if there is no monitor."""
        every = ASK_UNDER_WATER_S if self.under_water else ASK_S
        due = 0.0
        while True:
            now = time.monotonic()
            silence = None if self._source is None else self._source.watched.silence(now)
            is_dumb = silence is None or silence > SILENT_S
            if is_dumb and now >= due and now > self._began + SILENT_S * (self._source is not None):
                due = now + every
                await self._look()
            await self._read_plan()
            await asyncio.sleep(TICK_S)

    async def _look(self) -> None:
        found: list[Looked] = []
        script = look(found.append, under_water=self.under_water, now=time.monotonic)
        try:
            await self.commands.say(script, idle=True)
        except OperatorError as error:
            self._look_problem = str(error)
            return
        self._look_problem = ""
        now = time.monotonic()
        self._looked.take(frame_of(found[0], now - self._began), now)

    async def _read_plan(self) -> None:
        watched = self.watched
        key = str(watched.state.get("mission") or ""), watched.plan
        if key == self._planned:
            return
        self._planned = key
        if key[0] and self._plan["digest"] == key[0]:
            return  # the same by its digest, also while its lines are sent again
        if (known := self._known.get(key[0])) is not None:
            self._plan = known
            return
        found = await asyncio.to_thread(plans.on_board, key[1], self.given.vehicle)
        if key[0] and found["digest"] != key[0]:
            why = "the vehicle holds a mission; its lines have not been told here so far"
            found = {**found, "digest": "", "problem": found["problem"] if key[1] else why}
        self._plan = found

    def uploaded(self, plan: Mapping[str, Any]) -> None:
        self._known[plan["digest"]] = dict(plan)
        self._planned = None


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 1)
