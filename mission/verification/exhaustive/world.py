"""A runtime with a vehicle on its serial line, GPS receiver and operators, and what was seen.

Time goes from event to event: the next timer, the next answer of the STM32, the next report.

What does not live here: physics (the sea is told what it is), simulated firmware (links).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from links.base import Rx
from mission.engine.engine import Engine
from mission.model import Estimate, Position, Step, Tx
from mission.model.vehicle import Vehicle
from mission.navigation import Navigation
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.runtime.command_target import MODEM
from mission.onboard.runtime.runtime import GPS, VEHICLE, Runtime
from mission.onboard.store import MemoryStore, Stored
from mission.verification.exhaustive.fork import Fork
from mission.verification.exhaustive.wire import Sea, answer
from mission.verification.rig.acts import BOAT, TOPSIDE
from mission.verification.rig.lockstep import Due, LockStep
from protocol.modem import Sender, wrap

TENDER = "tender"  # a connection beside that of the boat
_PERIOD = 2.0  # s between reports
_LATENCY = 0.02  # s until the STM32 answers
_STOP = b"@ZAX0$"
_CONFIGURATION = Configuration(links=LinkUrls(modem="memory://modem"))


_BEGUN: dict[object, Fork[World]] = {}  # a runtime is made of nothing but these


@dataclass(slots=True)
class Notes:
    """What an observer of the runtime wrote down."""

    steps: list[Step] = field(default_factory=list)

    def step(self, step: Step) -> None:
        self.steps.append(step)

    def estimate(self, estimate: Estimate) -> None:
        pass

    def notice(self, text: str) -> None:
        """Ignored here."""


class World(LockStep):
    """``answers`` is the letter of the STM32's acknowledges, "" for none; ``rises_by`` the start
    of a frame after which the vehicle comes up."""

    def __init__(self, vehicle: Vehicle, stored: Stored, home: Position, now: float = 0.0) -> None:
        super().__init__(now)
        self.vehicle, self.home = vehicle, home
        self.sea, self.notes = Sea(), Notes()
        self.store = MemoryStore(stored)
        self.runtime = Runtime(_CONFIGURATION, vehicle, self.store, observer=self.notes)
        self.answers = "Y"
        self.reports = True
        self.spoils = False  # each report loses a bit on its way
        self.rises_by = b""
        self.sent: list[Tx] = []
        self.states: list[tuple[float, str]] = [(now, self.runtime.state)]
        self.depths = [self.sea.depth]  # the true one, at each of these
        self.left = [0]  # how many of ``sent`` had left before the input that led to each
        self.last_fix = self.last_stick = -1e9
        self.ended_in, self.ended_after = "", 0  # told to end: where, behind how many of ``sent``
        self.at_once = ""  # the state right after the first input since it was emptied
        self._owed: list[tuple[float, bytes]] = []
        self._report_due = now + _PERIOD
        self._take(self.runtime.handle_timer(now))

    @property
    def engine(self) -> Engine:
        return self.runtime.engine

    @property
    def state(self) -> str:
        return self.runtime.state

    def navigate(self, navigation: Navigation) -> None:
        self._take(self.runtime.set_navigation(navigation, self.now))
        for address in (BOAT, TENDER):
            self._take(self.runtime.connected(TOPSIDE, address, self.now))

    def come_to(self, depth: float) -> None:
        """Puts the vehicle at a depth as if it had been there for long: no other depth is
        remembered."""
        self.sea.depth = depth
        navigation = self.engine.core.vehicle_state.navigation
        if isinstance(navigation, Navigation):
            navigation.forget_depth()

    # --- what comes in -------------------------------------------------------------------------

    def say(self, data: bytes, address: str = BOAT) -> None:
        if data.startswith(b"@M"):
            self.last_stick = self.now
        self._take(self.runtime.receive(Rx(self.now, TOPSIDE, data, address)))

    def say_below(self, frame: bytes) -> None:
        """Over the acoustic modem, in its envelope."""
        self.hear_modem(wrap(frame, Sender.TOPSIDE))

    def hear_modem(self, data: bytes) -> None:
        """Whatever comes from there."""
        self._take(self.runtime.receive(Rx(self.now, MODEM, data, "")))

    def hear(self, data: bytes) -> None:
        """Something of the STM32's."""
        self._take(self.runtime.receive(Rx(self.now, VEHICLE, data, "")))

    def report(self) -> None:
        data = self.sea.report()
        self.hear(data[:40] + bytes([data[40] ^ 1]) + data[41:] if self.spoils else data)

    def fix(self) -> None:
        self.last_fix = self.now
        self._take(self.runtime.receive(Rx(self.now, GPS, self.sea.sentences(self.home, self.now))))

    def line_is_back(self) -> None:
        """Tells the runtime that the vehicle's port was away, for no time at all."""
        self._take(self.runtime.connected(VEHICLE, "", self.now))

    def node(self, line: bytes) -> None:
        """What a node's process reports."""
        self._take(self.runtime.receive(Rx(self.now, "nodes", line, "")))

    def restart(self) -> None:
        """The program dies, and begins again with what the store holds; navigation comes later."""
        kept = self.store.content
        key = (self.vehicle.dialect, kept, self.home)
        if key not in _BEGUN:
            _BEGUN[key] = Fork(World(self.vehicle, kept, self.home))
        again = _BEGUN[key].copy()
        again.left[:] = [*self.left, *(n + len(self.sent) for n in again.left)]
        again.notes.steps[:0] = self.notes.steps
        again.sent[:0], again.states[:0] = self.sent, self.states
        again.depths[:0] = self.depths
        again.sea, again.answers = self.sea, self.answers
        self.__dict__ = again.__dict__

    def end(self, *, at_once: bool = False) -> None:
        """The program is to end."""
        self.ended_in, self.ended_after = self.state, len(self.sent)
        self._take(self.runtime.end(self.now, at_once=at_once))

    def wait(self, seconds: float) -> None:
        """Lets so many seconds pass: timers, answers and reports come when they are due."""
        self.run_until(self.now + seconds)

    def dues(self) -> Iterator[Due]:
        yield self.runtime.next_timer(), self._handle_timer
        if self._owed:
            yield self._owed[0][0], self._answer
        yield self._report_due, self._report

    def _handle_timer(self) -> None:
        self._take(self.runtime.handle_timer(self.now))

    def _answer(self) -> None:
        self.hear(self._owed.pop(0)[1])

    def _report(self) -> None:
        self._report_due = self.now + _PERIOD
        if self.reports:
            self.report()

    # --- what goes out -------------------------------------------------------------------------

    def _take(self, sent: list[Tx]) -> None:
        before = len(self.sent)
        self.sent += sent
        for tx in sent:
            if tx.link != VEHICLE:
                continue
            if self.rises_by and tx.data.startswith(self.rises_by):
                self.sea.depth, self.rises_by = 0.2, b""
            if tx.data.startswith((b"@ZA", b"@M")):
                self.sea.stopped = tx.data == _STOP
            if tx.data.startswith(b"@ZA") and self.answers:
                data = answer(tx.data, self.answers, self.vehicle.dialect)
                self._owed.append((self.now + _LATENCY, data))
            elif tx.data.startswith(b"@RS"):
                self._owed.append((self.now + _LATENCY, b"@ACK_RSS$"))
        self.at_once = self.at_once or self.runtime.state
        if self.states[-1][1] != self.runtime.state:
            self.states.append((self.now, self.runtime.state))
            self.depths.append(self.sea.depth)
            self.left.append(before)
