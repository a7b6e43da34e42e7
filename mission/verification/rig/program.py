"""The program on board, on the rig's clock: a runtime that can be killed and restarted.

Each runtime's time begins at 0, as at sea; here all times are the rig's. While no runtime is alive,
bytes are lost. The next runtime knows only what the one before made durable. A runtime may die
inside a write of its store; what it would have sent after the write is never sent.

What does not live here: when the program is killed, where its bytes go (rig).
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial

from links.base import Rx
from mission.model import Estimate, Step, Tx
from mission.model.vehicle import Vehicle
from mission.navigation import Navigation
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.mission_validator import MissionValidator
from mission.onboard.runtime.records import Recorder
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore, Stored, StoreError

NAVIGATION_AFTER = 2.0  # s from a start until the filter is loaded, on the Pi
_SAME = 1e-6  # s
LEAVES_WITHIN = 290.0  # s, from SIGTERM to the last commands (serve: leaving)
LAST_WORDS = 3.0  # s that the last commands have, to leave
DEAD = "dead"  # the state while no runtime is alive


class Died(Exception):
    """The program was killed inside a write."""


class Death(enum.Enum):
    BEFORE = "the old content stays"
    AFTER = "the new content is durable, and nobody was told"


class FillableStore(MemoryStore):
    """A disk that may be full for a while. ``death``: how the next write kills the program."""

    def __init__(self, content: Stored | None = None) -> None:
        super().__init__(content)
        self.full = False
        self.death: Death | None = None

    def write(self, content: Stored) -> None:
        if self.full:
            raise StoreError("no space left on device")
        death, self.death = self.death, None
        if death is not Death.BEFORE:
            super().write(content)
        if death is not None:
            raise Died


class Program:
    """A runtime, or none while it is dead. ``wall``: the wall clock at the rig's time 0, s since
    1970 UTC. ``recorder`` is called once for each runtime. ``judge``: the validator of all
    runtimes; None: each has its own. Steps and estimates go nowhere until ``listen`` is called."""

    def __init__(
        self,
        vehicle: Vehicle,
        store: FillableStore,
        wall: float,
        recorder: Callable[[], Recorder | None] = lambda: None,
        configuration: Configuration | None = None,
        judge: MissionValidator | None = None,
    ) -> None:
        self._vehicle, self.store, self._wall, self._judge = vehicle, store, wall, judge
        self._configuration = configuration or Configuration()
        self._recorder = recorder
        self.listen(lambda step: None, lambda estimate: None)
        self._zero = 0.0
        self.starts = 0
        self.runtime: Runtime | None = None
        self.navigation: Navigation | None = None  # of the runtime now, once it is loaded
        self._navigation_due: float | None = None
        self._leaves: float | None = None  # when the last commands are due
        self._gone: float | None = None  # when the program ends, at the latest

    @property
    def lives(self) -> bool:
        return self.runtime is not None

    @property
    def state(self) -> str:
        return self.runtime.state if self.runtime else DEAD

    def boot(self, now: float, navigation_after: float = NAVIGATION_AFTER) -> None:
        """Start the program. If it dies in the first write, start again: the store kills once."""
        self._zero, wall = now, self._wall + now
        self.starts += 1
        while self.runtime is None:
            with suppress(Died):
                self.runtime = Runtime(
                    self._configuration,
                    self._vehicle,
                    self.store,
                    self._recorder(),
                    wall=wall,
                    observer=self,
                )
        if self._judge is not None:
            self.runtime.judge = self._judge
        self._navigation_due = now + navigation_after

    def kill(self) -> None:
        self.runtime = self.navigation = self._navigation_due = self._leaves = self._gone = None

    def navigate(self, now: float) -> list[Tx]:
        """Give the runtime its navigation, since the filter is loaded; return what it sends."""
        self._navigation_due = None
        if self.runtime is None:
            return []
        self.navigation = navigation = self.runtime.make_navigation()
        return self._shifted(Runtime.set_navigation, now, navigation)

    def end(self, now: float, *, at_once: bool = False) -> list[Tx]:
        """Tell the program to end, as SIGTERM does. It ends by itself once the vehicle can be left
        alone (serve: leaving)."""
        if self.runtime is None or (at_once and self._leaves is None):
            return []
        self._leaves = now if at_once else now + LEAVES_WITHIN
        out = self._shifted(partial(Runtime.end, at_once=at_once), now)
        self._leave(now, said=at_once)
        return out

    @property
    def is_leaving(self) -> bool:
        """Whether the program was told to end and is still alive."""
        return self._leaves is not None

    def _leave(self, now: float, *, said: bool = False) -> None:
        """End the program if it was told to end and may. ``said``: its last commands were sent."""
        runtime = self.runtime
        if runtime is None or self._leaves is None:
            return
        if self._gone is None and (said or runtime.engine.settled):
            self._gone = now + LAST_WORDS
        if self._gone is not None and (now >= self._gone or runtime.said_all):
            self.kill()

    def listen(self, step: Callable[[Step], None], estimate: Callable[[Estimate], None]) -> None:
        """Pass each step and estimate to these from now on, in the rig's time."""
        self._tell_step, self._tell_estimate = step, estimate

    def begin_again(self, now: float) -> None:
        """Move the program to another rig, whose time 0 is ``now`` here. It continues to run, and
        keeps nothing of the rig that it leaves."""
        self.listen(lambda step: None, lambda estimate: None)
        self._zero -= now
        if self._navigation_due is not None:
            self._navigation_due -= now
        self._leaves = None if self._leaves is None else self._leaves - now
        self._gone = None if self._gone is None else self._gone - now
        self._wall += now

    # --- as a runtime -----------------------------------------------------------------------------

    def receive(self, rx: Rx, now: float) -> list[Tx]:
        if self.runtime is None:
            return []
        if self._zero or self._leaves is not None:
            rx = rx._replace(t=max(rx.t - self._zero, 0.0))
            return self._shifted(Runtime.receive, now, rx)
        try:
            return self.runtime.receive(rx, now)  # the usual case
        except Died:
            self.kill()
            return []

    def connected(self, link: str, address: str, now: float) -> list[Tx]:
        return self._shifted(Runtime.connected, now, link, address)

    def disconnected(self, link: str, address: str, now: float) -> list[Tx]:
        return self._shifted(Runtime.disconnected, now, link, address)

    def handle_timer(self, now: float) -> list[Tx]:
        out: list[Tx] = []
        if self._navigation_due is not None and now >= self._navigation_due:
            out = self.navigate(now)
        if self._gone is None and self._leaves is not None and now >= self._leaves:
            out += self.end(now, at_once=True)
        return out + self._shifted(Runtime.handle_timer, now)

    def next_timer(self) -> float | None:
        first = self.runtime.next_timer() if self.runtime else None
        if first is not None:
            first += self._zero
        if self._navigation_due is self._leaves is None:
            return first
        for due in (self._navigation_due, self._gone or self._leaves):
            if due is not None and (first is None or due < first):
                first = due
        return first

    def _shifted(self, call: Callable[..., list[Tx]], now: float, *given: object) -> list[Tx]:
        """Call a method of the runtime in the runtime's own time, which is the last argument.
        Return what it sends, in the rig's time."""
        if self.runtime is None:
            return []
        at = now - self._zero
        if self._zero:
            due = self.runtime.next_timer()
            if due is not None and at < due < at + _SAME:  # the sum was rounded
                at = due
        try:
            out = call(self.runtime, *given, at)
            if self._zero:
                out = [replace(tx, t=now) for tx in out]
        except Died:
            self.kill()
            return []
        if self._leaves is not None:
            self._leave(now)
        return out

    # --- as the runtime's observer ----------------------------------------------------------------

    def step(self, step: Step) -> None:
        self._tell_step(replace(step, t=step.t + self._zero) if self._zero else step)

    def estimate(self, estimate: Estimate) -> None:
        if self._zero:
            estimate = estimate._replace(t=estimate.t + self._zero)
        self._tell_estimate(estimate)

    def notice(self, text: str) -> None:
        """Ignore notices."""
