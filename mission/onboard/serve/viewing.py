"""The monitor's port of a running serve: viewers' bytes in, frames out, five times a second.

The port is its own, and shares no buffer with the operator's. No byte of a viewer reaches the
runtime. No frame is made while no viewer can be sent one.

What does not live here: who is sent what (monitor), the content of a state (view).
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable, Mapping
from datetime import UTC, datetime
from typing import Any

from mission.onboard.serve.monitor import Monitor, Unwelcome
from mission.onboard.serve.ports import Port

MONITOR = "monitor"
EVERY_S = 0.2
TRACK_S = 1.0

Seen = tuple[float, Mapping[str, Any], Iterable[str]]
"""The engine's time, the state (view), and the lines of the mission in the store."""


class Viewing:
    """``look`` returns what there is to see, None if nothing; ``tell`` gets a line for each viewer
    that is disconnected."""

    def __init__(
        self,
        url: str,
        look: Callable[[], Seen | None],
        tell: Callable[[str], None],
        wall: Callable[[], float] = time.time,
    ) -> None:
        self.monitor, self._look, self.tell, self._wall = Monitor(), look, tell, wall
        self.port = Port(MONITOR, url, self._readable, lambda port: self._meet(), tell)
        self._tracked = 0.0
        self._seen = 0.0  # the engine's time

    def told(self, tell: Callable[[str], None]) -> Callable[[str], None]:
        """Return a ``tell`` that sends each line of the journal to viewers, too."""

        def both(line: str) -> None:
            tell(line)
            stamp = datetime.fromtimestamp(self._wall(), UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
            self.monitor.event(f"{stamp} {line}")

        return both

    async def keep(self) -> None:
        """Run until cancelled."""
        port = asyncio.get_running_loop().create_task(self.port.keep_open())
        try:
            while True:
                await asyncio.sleep(EVERY_S)
                self._serve(time.monotonic())
        finally:
            port.cancel()
            await asyncio.gather(port, return_exceptions=True)

    def _serve(self, now: float) -> None:
        event = self.port.next_event()
        if event is not None and event <= now:
            self._readable(self.port)
        for address in self.monitor.silent(now):
            self._send_away(address, "it reads nothing")
        due = self.monitor.due(now)
        if not due and now < self._tracked + TRACK_S:
            return
        seen = self._look()
        if seen is None:
            return
        t, state, lines = seen
        if t < self._seen:
            self.monitor.begin_again()
        self._seen = t
        self._track(now, state)
        self.monitor.load(lines)
        for address in due:
            if frame := self.monitor.frame(address, state, t, now):
                self.port.send(frame, now, address)
        self._meet()

    def _track(self, now: float, state: Mapping[str, Any]) -> None:
        self._tracked = now
        self.monitor.past.take(state)
        if state["latitude"] is not None and (t := state["report_at"]) is not None:
            self.monitor.track.add(t, state["latitude"], state["longitude"], state["depth"])

    def _readable(self, port: Port) -> None:
        now = time.monotonic()
        heard = port.receive(now)
        self._meet()
        for rx in heard:
            try:
                self.monitor.receive(rx.address, rx.data, now)
            except Unwelcome as why:
                self._send_away(rx.address, str(why))
            else:
                port.vouch(rx.address)
        self._meet()

    def _meet(self) -> None:
        """Note connections that have opened and closed."""
        there, known = set(self.port.peers), set(self.monitor.viewers)
        for address in there - known:
            self.monitor.connected(address, time.monotonic())
        for address in known - there:
            self.monitor.disconnected(address)

    def _send_away(self, address: str, why: str) -> None:
        self.tell(f"monitor: {address} is sent away: {why}")
        self.port.drop_peer(address)
        self.monitor.disconnected(address)
