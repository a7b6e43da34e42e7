"""What the nodes switch (R13): links, and the camera's command.

A request is ``CAMERA O``. The answer is the state afterwards, ``CAMERA O\\n``; without an answer
the switch is refused after its 5 s. If the camera's command ends by itself, the node is closed:
this is logged, and reported as ``CAMERA C\\n`` unasked. The command and all that it started are one
process group, and end together. What does not live here: which switches are allowed
(node_switching).
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import shlex
import signal
from asyncio.subprocess import DEVNULL, Process
from collections.abc import Callable, Mapping
from pathlib import Path

from mission.onboard.runtime.device_switches import CLOSE, OPEN
from mission.onboard.serve.ports import Port

PATIENCE_S = 3.0  # s for a process to end by itself
BEGINS_S = 0.3  # s: a command that ends sooner was never open
CAMERA = "CAMERA"
_NICE, _GOES_FIRST = 10, 500  # of the camera: setpriority(2), oom_score_adj (proc(5))


class Processes:
    """``ports``: by the name of their node. ``camera``: a command line, None: there is none.
    ``report`` gets changes of state that nobody requested."""

    def __init__(
        self,
        ports: Mapping[str, Port],
        camera: str | None,
        tell: Callable[[str], None],
        report: Callable[[bytes], None],
    ) -> None:
        self._ports, self._camera, self._tell, self._report = ports, camera, tell, report
        self._process: Process | None = None
        self._watch: asyncio.Task[None] | None = None

    async def switch(self, request: bytes) -> bytes:
        """Switch a node; the answer, b"" if that failed."""
        name, _, letter = request.decode("ascii", "replace").partition(" ")
        on = letter == OPEN
        if name in self._ports:
            self._ports[name].switch(on)
        elif name != CAMERA or not await self._switch_camera(on):
            return b""
        return request + b"\n"

    async def begin_again(self) -> None:
        """Reset for a new runtime: every port open, no camera."""
        for port in self._ports.values():
            port.switch(True)
        await self._switch_camera(False)

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
                *shlex.split(self._camera),
                stdin=DEVNULL,
                stdout=DEVNULL,
                stderr=DEVNULL,
                start_new_session=True,
            )
        except (OSError, ValueError) as error:
            self._tell(f"CAMERA: {self._camera}: {error}")
            return False
        _give_way(self._process)
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._process.wait(), BEGINS_S)
            self._tell(f"CAMERA: {self._camera}: {_ended(self._process)} at once")
            return False
        self._watch = asyncio.ensure_future(self._until_it_ends(self._process))
        return True

    async def _until_it_ends(self, process: Process) -> None:
        await process.wait()
        if process is self._process:
            _signal(process, signal.SIGTERM)  # the processes that it left behind
            self._tell(f"CAMERA: {self._camera}: {_ended(process)} by itself")
            self._report(f"{CAMERA} {CLOSE}\n".encode())

    async def _stop(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        _signal(process, signal.SIGTERM)
        try:
            await asyncio.wait_for(process.wait(), PATIENCE_S)
        except TimeoutError:
            pass
        finally:
            _signal(process, signal.SIGKILL)  # the rest of the group
        await process.wait()


def _give_way(process: Process) -> None:
    """Lower the priorities that the camera inherits from this program's unit: X and W come first,
    and if memory is short, the camera is killed before the radio's programs."""
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PGRP, process.pid, _NICE)
        Path(f"/proc/{process.pid}/oom_score_adj").write_text(str(_GOES_FIRST))


def _signal(process: Process, number: signal.Signals) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, number)


def _ended(process: Process) -> str:
    code = process.returncode or 0
    return f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
