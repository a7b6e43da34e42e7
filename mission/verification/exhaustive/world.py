"""A runtime with a vehicle on its serial line, GPS receiver and operators, and what was seen.

Time jumps from event to event: the next timer, the next answer of the STM32, the next report.

What does not live here: physics (events set the state of the sea), simulated firmware (links).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from links.base import Rx
from mission.engine.engine import Engine
from mission.model import Estimate, Position, Step, Tx
from mission.model.copies import held
from mission.model.vehicle import Beacon, Vehicle
from mission.navigation import Navigation
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.runtime.command_target import MODEM
from mission.onboard.runtime.receivers import GPS as RECEIVER
from mission.onboard.runtime.receivers import GPS2 as SECOND
from mission.onboard.runtime.runtime import SENSORS, VEHICLE, Runtime
from mission.onboard.store import MemoryStore, Stored
from mission.verification.exhaustive.fork import Fork
from mission.verification.exhaustive.lines import (
    ANSWERS,
    GPS,
    HELD,
    OUTPUT,
    Line,
    line_of,
)
from mission.verification.rig.acts import BOAT, TOPSIDE
from mission.verification.rig.lockstep import Due, LockStep
from protocol.modem import Sender, wrap

TENDER = "tender"  # a second connection, beside the boat's
_SLOW = 1.0  # s between reports, from which on a jump of the depth counts as no leap
_LATENCY = 0.02  # s until the STM32 answers
_STOP = b"@ZAX0$"
_CONFIGURATION = Configuration(links=LinkUrls(modem="memory://modem"))


_BEACONS = {"1": Beacon(math.radians(30.2885), math.radians(120.1545), 5.0)}
_BEGUN: dict[object, Fork[World]] = {}  # restarted worlds, by all that a runtime depends on


@dataclass(slots=True)
class Notes:
    """What the observer of the runtime recorded."""

    steps: list[Step] = field(default_factory=list)

    def step(self, step: Step) -> None:
        self.steps.append(step)

    def estimate(self, estimate: Estimate) -> None:
        pass

    def notice(self, text: str) -> None:
        """Ignored here."""


class World(LockStep):
    """``answers``: the letter of the STM32's acknowledgements, "" for none. ``rises_by``: the
    beginning of a command after which the vehicle comes up. ``sent`` is in the commands of the
    laws: a command that a board is sent repeatedly is there once, and each time in ``paced``.
    ``line``: by default the vehicle's."""

    def __init__(
        self,
        vehicle: Vehicle,
        stored: Stored,
        home: Position,
        now: float = 0.0,
        line: Line | None = None,
    ) -> None:
        super().__init__(now)
        vehicle = replace(vehicle, beacons=_BEACONS)
        self.vehicle, self.home, self.line = vehicle, home, line or line_of(vehicle)
        self.sea, self.notes = self.line.sea(), Notes()
        self.store = MemoryStore(stored)
        self.runtime = Runtime(_CONFIGURATION, vehicle, self.store, observer=self.notes)
        self.answers = "Y"
        self.reports = True
        self.spoils = False  # one bit of each report is flipped on its way
        self.rises_by = b""
        self.sent: list[Tx] = []
        self.states: list[tuple[float, str]] = [(now, self.runtime.state)]
        self.depths = [self.sea.depth]  # the true depth at each of the states
        self.left = [0]  # for each state, len(sent) before the input that led to it
        self.last_fix = self.last_stick = -1e9
        self.ended_in, self.ended_after = "", 0  # told to end: the state, and len(sent), then
        self.at_once = ""  # the state right after the first input since this was set to ""
        self._owed: list[tuple[float, bytes]] = []
        self.paced: list[tuple[float, int]] = []  # time and bytes of all that left for the vehicle
        self._saying: list[bytes] = []  # the commands in force, which a board is sent repeatedly
        self._report_due = now + self.line.period
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

    @property
    def deep(self) -> float:
        """A depth in m. For the AUV, more than a body sinks in one report period; for a board, not
        so deep that a leg of a shipped mission ends."""
        return 3.0 if ANSWERS in self.line.has else 2.4

    def come_to(self, depth: float) -> None:
        """Put the vehicle at a depth as if it had been there for long: navigation forgets all
        other depths."""
        self.sea.depth = depth
        navigation = self.engine.core.vehicle_state.navigation
        if isinstance(navigation, Navigation):
            navigation.forget_depth()

    def put(self, depth: float) -> None:
        """Move the vehicle to a depth between two reports. If they are too frequent for a body to
        do so, do what ``come_to`` does."""
        if self.line.period < _SLOW:
            self.come_to(depth)
        self.sea.depth = depth

    def go(self, deeper: float, seconds: float) -> None:
        """Move the vehicle ``deeper`` m, evenly over ``seconds``, in steps of the report period."""
        parts = max(round(seconds / self.line.period), 1)
        for _ in range(parts):
            self.sea.depth += deeper / parts
            self.wait(seconds / parts)

    # --- input ---------------------------------------------------------------------------------

    def say(self, data: bytes, address: str = BOAT) -> None:
        if data.startswith(b"@M"):
            self.last_stick = self.now
        self._take(self.runtime.receive(Rx(self.now, TOPSIDE, data, address)))

    def say_below(self, frame: bytes) -> None:
        """Send a frame over the acoustic modem, in its envelope."""
        self.hear_modem(wrap(frame, Sender.TOPSIDE))

    def hear_modem(self, data: bytes) -> None:
        """Give the runtime any bytes from the modem."""
        self._take(self.runtime.receive(Rx(self.now, MODEM, data, "")))

    def hear(self, data: bytes) -> None:
        """Give the runtime bytes from the vehicle."""
        self._take(self.runtime.receive(Rx(self.now, VEHICLE, data, "")))

    def hear_added(self, data: bytes) -> None:
        """Give the runtime bytes from an added sensor."""
        self._take(self.runtime.receive(Rx(self.now, SENSORS, data)))

    def hear_second(self, data: bytes) -> None:
        """Give the runtime bytes from a second receiver."""
        self._take(self.runtime.receive(Rx(self.now, SECOND, data)))

    def report(self) -> None:
        data = self.line.report(self.sea, self.home)
        at = len(data) // 2
        self.hear(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :] if self.spoils else data)

    def fix(self) -> None:
        """Give the runtime a fix of the receiver, or a report with the vehicle's own place."""
        self.last_fix = self.now
        if GPS not in self.line.has:
            self.sea.placed = True
            self.report()
            self.sea.placed = False
            return
        self._take(
            self.runtime.receive(Rx(self.now, RECEIVER, self.sea.sentences(self.home, self.now)))
        )

    def line_is_back(self) -> None:
        """Tell the runtime that the vehicle's port was disconnected and is back at once."""
        self._take(self.runtime.connected(VEHICLE, "", self.now))

    def node(self, line: bytes) -> None:
        """Give the runtime a line from the process of a node."""
        self._take(self.runtime.receive(Rx(self.now, "nodes", line, "")))

    def restart(self) -> None:
        """Kill the program and restart it with the content of the store, without navigation."""
        kept = self.store.content
        key = (self.line, kept, self.home)
        if key not in _BEGUN:
            _BEGUN[key] = Fork(World(self.vehicle, kept, self.home, line=self.line))
        again = _BEGUN[key].copy()
        again.left[:] = [*self.left, *(n + len(self.sent) for n in again.left)]
        again.notes.steps[:0] = self.notes.steps
        again.sent[:0], again.states[:0] = self.sent, self.states
        again.depths[:0] = self.depths
        again.sea, again.answers = self.sea, self.answers
        for name, value in held(again).items():
            setattr(self, name, value)

    def end(self, *, at_once: bool = False) -> None:
        """Tell the program to end."""
        self.ended_in, self.ended_after = self.state, len(self.sent)
        self._take(self.runtime.end(self.now, at_once=at_once))

    def wait(self, seconds: float) -> None:
        """Let time pass. Timers, answers and reports come when they are due."""
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
        self._report_due = self.now + self.line.period
        if self.reports:
            self.report()

    # --- output --------------------------------------------------------------------------------

    def _take(self, sent: list[Tx]) -> None:
        before = len(self.sent)
        for tx in sent:
            said = self._said(tx) if tx.link == VEHICLE else tx
            if said is not None:
                self.sent.append(said)
            if said is not None and tx.link == VEHICLE:
                self._obey(said.data)
        self.at_once = self.at_once or self.runtime.state
        if self.states[-1][1] != self.runtime.state:
            self.states.append((self.now, self.runtime.state))
            self.depths.append(self.sea.depth)
            self.left.append(before)

    def _said(self, tx: Tx) -> Tx | None:
        """Translate a frame into the commands of the laws; None if it repeats one in force."""
        self.paced.append((tx.t, len(tx.data)))
        word = self.line.word(tx.data, tx.reason)
        if tx.reason.endswith(HELD):
            if word in self._saying:
                return None
        elif word.startswith(OUTPUT):
            return replace(tx, data=word)
        elif self.paced[-2:-1] and self.paced[-2][0] < tx.t:
            self._saying = []
        self._saying.append(word)
        return replace(tx, data=word)

    def _obey(self, word: bytes) -> None:
        """Let the vehicle obey a command, and answer it."""
        if self.rises_by and word.startswith(self.rises_by):
            self.put(0.2)
            self.rises_by = b""
        if word.startswith((b"@ZA", b"@M")):
            self.sea.stopped = self.line.stops(word)
        if ANSWERS not in self.line.has:
            return
        if word.startswith(b"@ZA") and self.answers:
            self._owed.append((self.now + _LATENCY, self.line.answer(word, self.answers)))
        elif word.startswith(b"@RS"):
            self._owed.append((self.now + _LATENCY, b"@ACK_RSS$"))
