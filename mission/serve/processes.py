"""What stands behind the nodes (R13): links that are switched, and the camera's command.

A request is ``CAMERA O``; what is so afterwards is answered as ``CAMERA O\\n``, or not at all: then
the switch is refused after its 5 s. What does not live here: which switches are allowed (topside).
"""

from __future__ import annotations

import asyncio
import contextlib
import shlex
from asyncio.subprocess import DEVNULL, Process
from collections.abc import Callable, Mapping

from mission.drive.nodes import OPEN
from mission.serve.ports import Port

PATIENCE_S = 3.0  # that a process has to end by itself


class Processes:
    """``ports``: by the name of their node. ``camera``: a command line, None: there is none."""

    def __init__(
        self, ports: Mapping[str, Port], camera: str | None, tell: Callable[[str], None]
    ) -> None:
        self._ports, self._camera, self._tell = ports, camera, tell
        self._process: Process | None = None

    async def switch(self, request: bytes) -> bytes:
        """The answer, b"" if it did not work."""
        name, _, letter = request.decode("ascii", "replace").partition(" ")
        on = letter == OPEN
        if name in self._ports:
            self._ports[name].switch(on)
        elif name != "CAMERA" or not await self._switch_camera(on):
            return b""
        return request + b"\n"

    async def end(self) -> None:
        await self._switch_camera(False)

    async def _switch_camera(self, on: bool) -> bool:
        running = self._process is not None and self._process.returncode is None
        if on == running:
            return True
        if not on:
            await self._stop()
            return True
        if self._camera is None:
            self._tell("CAMERA was to be opened, but the configuration has no command for it")
            return False
        try:
            self._process = await asyncio.create_subprocess_exec(
                *shlex.split(self._camera), stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL
            )
        except (OSError, ValueError) as error:
            self._tell(f"CAMERA: {self._camera}: {error}")
            return False
        return True

    async def _stop(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            process.terminate()
        try:
            await asyncio.wait_for(process.wait(), PATIENCE_S)
        except TimeoutError:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            await process.wait()
