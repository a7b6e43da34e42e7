"""What a running serve writes to the disk: the black box of its runtime, and its health.

    records --FLUSH_S--> black box        Health --EVERY_S--> status.json
    configuration --once it has worked--> working
    closed parts --> closing

One thread does all of it, so that nothing else waits for the disk. A failing disk is reported, and
stops nothing. What does not live here: the files' formats (blackbox, health).
"""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mission.onboard.blackbox import FLUSH_S, BlackBox, file_name
from mission.onboard.serve import health
from mission.onboard.serve.journal import Tally
from mission.onboard.serve.provision import Provision
from mission.onboard.serve.working import find
from mission.onboard.stream.sinks import Sinks

ClosesParts = Callable[[Path, Path | None], None]  # folder, the part that is being written


def leave_parts(folder: Path, but: Path | None) -> None:
    """Leave closed parts as they are; they can be converted later."""


class Recording:
    def __init__(self, tell: Callable[[str], None], close_parts: ClosesParts = leave_parts) -> None:
        self._tell, self._close_parts = tell, close_parts
        self._part: Path | None = None  # the one that is being written
        self.sinks, self.tally = Sinks(tell), Tally()  # what the runtime writes to
        self.sinks.put("the count of faults", self.tally)
        self.box: BlackBox | None = None
        self._failure = ""  # as it was last reported
        self.free: int | None = None  # bytes on the disk, None: not known
        self._disk = ThreadPoolExecutor(1, "black box")

    @property
    def path(self) -> str:
        """The path of the black box, "" if there is none."""
        return str(self.box.path) if self.box is not None else ""

    def begin(self, folder: Path, wall: float) -> None:
        """Start a black box for a new runtime. The disk's thread closes the previous one and makes
        this one, so that the first command waits for neither."""
        if self.box is not None:
            self._disk.submit(self.box.close)
        self.box = BlackBox(folder / file_name(wall), wall, shell=True)
        self._disk.submit(self.box.store, b"")
        self.sinks.put("the black box", self.box)

    async def keep_box(self) -> None:
        """Run until cancelled."""
        while True:
            await asyncio.sleep(FLUSH_S)
            box = self.box
            if box is None or not ((data := box.take()) or box.failure):
                continue
            # shielded: what was taken is written even when this task is cancelled
            stored = self._disk.submit(box.store, data, True)
            await asyncio.shield(asyncio.wrap_future(stored))
            if box is not self.box:  # another box has begun meanwhile
                continue
            if box.path != self._part:  # a new part: those before it are closed
                self._part = box.path
                self._close_parts(box.path.parent, box.path)
            if box.failure != self._failure:
                self._failure = box.failure
                until = "" if box.fd >= 0 else " - nothing will be recorded until that is mended"
                self._tell(f"black box: {self._failure or 'it is written now'}{until}")

    async def keep_status(self, folder: Path, look: Callable[[], health.Health | None]) -> None:
        """Run until cancelled."""
        loop = asyncio.get_running_loop()
        writing: asyncio.Future[None] | None = None
        while True:
            how = look()  # it also reports alarms, however slow the disk
            if how is not None and (writing is None or writing.done()):
                writing = loop.run_in_executor(self._disk, self._put, folder, how)
            await asyncio.sleep(health.EVERY_S)

    def _put(self, folder: Path, how: health.Health) -> None:
        health.write(folder, how)
        self.free = _free(folder)

    async def keep_working(self, got: Provision, heard: Callable[[], bool]) -> None:
        """Keep the configuration once it has worked; run until then."""
        loop = asyncio.get_running_loop()
        is_first = await loop.run_in_executor(self._disk, find, got.homes) is None
        while not (is_first or heard()):
            await asyncio.sleep(health.EVERY_S)
        try:
            await loop.run_in_executor(self._disk, got.keep)
        except OSError as error:
            self._tell(f"should the configuration break, this one cannot be kept for then: {error}")

    async def shut(self) -> None:
        box, self.box = self.box, None
        if box is not None:
            await asyncio.get_running_loop().run_in_executor(self._disk, box.close)
            self._close_parts(box.path.parent, None)

    def end(self) -> None:
        self._disk.shutdown()


def _free(folder: Path) -> int | None:
    try:
        return shutil.disk_usage(folder).free
    except OSError:
        return None
