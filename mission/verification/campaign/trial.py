"""One disturbed flight in lock step: the loop of ``flight``, with all that may happen beside it.

    disturbances --> boats, modem --bytes--> OnBoard --bytes--> SimulatedVehicle
                           <--bytes--         <--bytes--

Everything that laws and audit need is kept as events in their order: what was said, what was
heard of the vehicle, what was decided, what was sent. It ends when nothing more can happen and
the vehicle is at the surface, or when it should long have been.

What does not live here: what is disturbed (draw, disturbances), what is asked of the flight (laws,
audit).
"""

from __future__ import annotations

import heapq
import math
import re
import traceback
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from links.base import Rx
from links.simulated.faults import FAULTS
from links.simulated.geodesy import local, moved
from links.simulated.link import HOME, START, SimulatedVehicle, Truth
from links.simulated.plant import DEAD_BAND_PWM, NEUTRAL_PWM
from links.simulated.settings import FaultEvent, Settings
from mission.authoring.language import digest, script
from mission.model import AUTONOMOUS, STOPPED, SURFACED, Estimate, Mission, Step, Tx
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.device_switches import LINK as NODES
from mission.onboard.runtime.records import Recorder
from mission.onboard.runtime.runtime import GPS, VEHICLE
from mission.verification.campaign.disturbances import BOAT, MODEM, PORT, TOPSIDE, Act, Disturbance
from mission.verification.campaign.onboard import Death, FillableStore, OnBoard
from mission.verification.simulation.rehearsal import Operator

WATCHED = 20.0  # s that a fault is watched at least
FOREVER = 1e6  # s: longer than any flight
QUIET = 20.0  # s at the surface with nothing under way
ASCENT = 900.0  # s that the way up may take at most, when all faults are over
OPERATOR_AFTER = 15.0  # s in which a board that lives on can be brought to idle
UPLOAD = 200.0  # s until the operator has started the mission, or given up
RADIO = 0.1  # s until the operator's program has answered an answer
RESTART = 3.0  # s until a program that died by itself is begun anew
_WAITS = (Act.SAY, Act.JOIN, Act.PART, Act.END, Act.HURRY)  # for a program that stands still
_DEATHS = {Act.DIE_BEFORE: Death.BEFORE, Act.DIE_AFTER: Death.AFTER}
AUTO_NODE = re.compile(rb"@NS[OC]{5}([OC])\$")
_GPS_NODE = re.compile(rb"BDGPS ([OC])")
_AT_REST = ("idle/", STOPPED, SURFACED)
_AFLOAT = 0.5  # m (R7)


@dataclass(frozen=True, slots=True)
class Said:
    """Bytes that reached the program from outside."""

    t: float
    link: str
    address: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Heard:
    """Bytes of the vehicle that reached the program."""

    t: float
    data: bytes


@dataclass(frozen=True, slots=True)
class Told:
    """A telemetry that was taken, with the estimate that came of it."""

    t: float
    estimate: Estimate


@dataclass(frozen=True, slots=True)
class Done:
    """A disturbance that is no bytes."""

    t: float
    act: Act


Event = Said | Heard | Told | Done | Step | Tx


@dataclass(frozen=True, slots=True)
class Trial:
    """What came of it. ``raised`` is the traceback of a fault of the program, "" if none."""

    events: tuple[Event, ...]
    track: tuple[Truth, ...]  # one a second
    home: tuple[float, float]  # rad
    truth: Truth  # at the end
    state: str
    failure: str  # why the operator could not start the mission, ""
    started: float | None
    raised: str
    turning: bool  # some thruster is on at the end


def try_out(
    mission: Mission,
    vehicle: Vehicle,
    profile: str,
    seed: int,
    settings: Settings,
    disturbances: Sequence[Disturbance] = (),
    *,
    offset: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    recorder: Callable[[], Recorder | None] = lambda: None,
    board: OnBoard | None = None,
    configuration: Configuration | None = None,
) -> Trial:
    """``disturbances`` are at the flight's times. ``offset``: m north and east of home where it
    begins; ``recorder`` makes one for each life of the program. ``board`` lives already, and lives
    on: it is given ``OPERATOR_AFTER`` s before the operator begins."""
    flown = replace(vehicle, dialect=profile)
    where = offset, heading
    loop = _Loop(
        mission, flown, seed, settings, disturbances, where, recorder, board, configuration
    )
    return loop.run()


class _Loop:
    def __init__(
        self,
        mission: Mission,
        vehicle: Vehicle,
        seed: int,
        settings: Settings,
        disturbances: Sequence[Disturbance],
        where: tuple[tuple[float, float], float],
        recorder: Callable[[], Recorder | None],
        board: OnBoard | None,
        configuration: Configuration | None,
    ) -> None:
        offset, heading = where
        home = HOME
        if mission.home is not None:
            home = math.radians(mission.home.latitude_deg), math.radians(mission.home.longitude_deg)
        self.home = home
        self.sea = SimulatedVehicle(
            vehicle.dialect, seed, settings, position=moved(*home, *offset), heading=heading
        )
        self.events: list[Event] = []
        wall = START.timestamp()
        self._boots = board is None
        self._operator_from = 0.0 if board is None else OPERATOR_AFTER
        if board is None:
            store = FillableStore()
            board = OnBoard(vehicle, store, wall, self._step, self._told, recorder, configuration)
        else:
            board.listen(self._step, self._told)
        self.board = board
        self.operator = Operator(script(mission), digest(mission))
        board.store.death = None
        self._deeds: list[tuple[float, int, Disturbance]] = []
        self._drawn = 0
        for disturbance in disturbances:
            self._plan(disturbance)
        self.now = 0.0
        self.plugged, self.joined = True, {BOAT}
        self.gps_open = self._lived = True
        self._held: list[Disturbance] | None = None  # what came while the program stands still
        self._safety = mission.safety.time or vehicle.limits.time
        ends = [t for e in settings.faults if (t := fault_ends(e)) < FOREVER]
        ends += [event.begin + WATCHED for event in settings.faults if event.begin < FOREVER]
        self._last = max([0.0, *ends, *(disturbance.after for disturbance in disturbances)])
        self._deadline = self._last + UPLOAD + OPERATOR_AFTER + ASCENT
        self._rests_since: float | None = None

    def run(self) -> Trial:
        raised = ""
        try:
            if self._boots:
                self.board.boot(0.0, 0.0)
            self._send(self.board.connected(TOPSIDE, BOAT, 0.0))
            while not self._is_over():
                self._to_next_event()
        except Exception:  # a fault of the program is what is looked for
            raised = traceback.format_exc()
        return Trial(
            tuple(self.events),
            tuple(self.sea.track),
            self.home,
            self.sea.truth(),
            self.board.state,
            self.operator.failure,
            None if self.operator.started is None else self.operator.started + self._operator_from,
            raised,
            any(abs(pwm - NEUTRAL_PWM) > DEAD_BAND_PWM for pwm in self.sea.stm32.pwm[:5]),
        )

    # --- the loop --------------------------------------------------------------------------------

    def _is_over(self) -> bool:
        if self.now > self._deadline:
            return True
        waits = self.operator.started is None and not self.operator.failure
        rests = self.board.state.startswith(_AT_REST) and self.sea.plant.depth <= _AFLOAT
        if waits or not rests or self.now < self._last:
            self._rests_since = None
            return False
        if self._rests_since is None:
            self._rests_since = self.now
        return self.now - self._rests_since > QUIET

    def _next_event(self) -> float:
        timers: tuple[float | None, ...] = (
            self.sea.vehicle_link.next_event(),
            self.sea.gps_link.next_event(),
            self.board.next_timer() if self._held is None else None,
            self._operator_due(),
            self._deeds[0][0] if self._deeds else None,
        )
        return max(self.now, min(t for t in timers if t is not None))

    def _to_next_event(self) -> None:
        """Bytes before timers: what has arrived by then is known by then."""
        self.now = now = self._next_event()
        for rx in self.sea.vehicle_link.receive(now):
            if self.plugged:
                self._hear(rx)
        for rx in self.sea.gps_link.receive(now):
            if self.gps_open:
                self._hear(rx)
        while self._deeds and self._deeds[0][0] <= now:
            self._do(heapq.heappop(self._deeds)[2])
        due = self._operator_due()
        if due is not None and due <= now:
            for data in self.operator.handle_timer(now - self._operator_from):
                self._send(self._say(TOPSIDE, BOAT, data))
        due = self.board.next_timer()
        if due is not None and due <= now and self._held is None:
            self._send(self.board.handle_timer(now))
        if self._lived and not self.board.lives:
            self._died()

    def _died(self) -> None:
        """By a disturbance, or inside a write: then the service manager and the boat do theirs."""
        self._lived = False
        last = next((e for e in reversed(self.events) if isinstance(e, Done)), None)
        if last is None or last.act is not Act.KILL or last.t != self.now:
            self._do(Disturbance(self.now, Act.KILL))
            self._plan(Disturbance(self.now + RESTART, Act.BOOT))
            self._plan(Disturbance(self.now + RESTART + 1.0, Act.JOIN))

    def _plan(self, disturbance: Disturbance) -> None:
        self._drawn += 1
        heapq.heappush(self._deeds, (disturbance.after, self._drawn, disturbance))

    def _hear(self, rx: Rx) -> None:
        """Bytes of the vehicle or its GPS."""
        if self._held is not None:
            self._held.append(Disturbance(self.now, Act.SAY, rx.data, rx.link, rx.address))
            return
        if rx.link == VEHICLE:
            self.events.append(Heard(self.now, rx.data))
        self._send(self.board.receive(rx, self.now))

    def _operator_due(self) -> float | None:
        due = self.operator.next_timer()
        return None if due is None else due + self._operator_from

    def _do(self, disturbance: Disturbance) -> None:
        now = self.now
        if self._held is not None and disturbance.act in _WAITS:
            self._held.append(disturbance)
            return
        if disturbance.act is Act.SAY:
            self._send(self._say(disturbance.link, disturbance.address, disturbance.data))
            return
        if disturbance.act is Act.BOOT and self.board.lives:
            return  # a service manager begins one program, not two
        self.events.append(Done(now, disturbance.act))
        match disturbance.act:
            case Act.STALL:
                self._held = [] if self._held is None else self._held
            case Act.RUN:
                self._run_again()
            case Act.POWER:
                self.sea.stm32.restart()
            case Act.DIE_BEFORE | Act.DIE_AFTER | Act.FILL | Act.FREE:
                self._to_disk(disturbance.act)
            case Act.JOIN:
                self.joined.add(disturbance.address)
                self._send(self.board.connected(disturbance.link, disturbance.address, now))
            case Act.PART:
                self.joined.discard(disturbance.address)
                self._send(self.board.disconnected(disturbance.link, disturbance.address, now))
            case Act.KILL:
                self.board.kill()
                self._are_gone()
            case Act.END | Act.HURRY:
                self._send(self.board.end(now, at_once=disturbance.act is Act.HURRY))
            case Act.BOOT:
                self.board.boot(now)
                self._lived = True
            case Act.UNPLUG | Act.PLUG:
                self.plugged = disturbance.act is Act.PLUG
                if self.plugged:
                    self._send(self.board.connected(VEHICLE, "", now))

    def _to_disk(self, act: Act) -> None:
        if act in _DEATHS:
            self.board.store.death = _DEATHS[act]
        else:
            self.board.store.full = act is Act.FILL

    def _are_gone(self) -> None:
        """With the program: its connections, its nodes, what it had not read yet."""
        self.joined.clear()
        self.gps_open, self._held = True, None

    def _run_again(self) -> None:
        """What came meanwhile is read in one piece a port; connections in their order."""
        held, self._held = self._held or [], None
        ports: dict[str, bytes] = {}
        for disturbance in held:
            if disturbance.link in (VEHICLE, GPS):
                ports[disturbance.link] = ports.get(disturbance.link, b"") + disturbance.data
        for link, data in ports.items():
            self._hear(Rx(self.now, link, data))
        for disturbance in held:
            if disturbance.link not in ports:
                self._do(disturbance)

    def _say(self, link: str, address: str, data: bytes) -> list[Tx]:
        """Nothing is said over a connection that is not there."""
        if link == PORT:
            self._hear(Rx(self.now, link, data))
            return []
        if link != MODEM and address not in self.joined:
            return []
        self.events.append(Said(self.now, link, address, data))
        return self.board.receive(Rx(self.now, link, data, address), self.now)

    def _send(self, sent: list[Tx]) -> None:
        waiting = deque(sent)
        while waiting:
            tx = waiting.popleft()
            self.events.append(tx)
            if tx.link == VEHICLE:
                if self.plugged:
                    self.sea.vehicle_link.send(tx.data, self.now)
            elif tx.link == TOPSIDE and tx.address == BOAT and BOAT in self.joined:
                for data in self.operator.receive(tx.data, self.now - self._operator_from):
                    self._plan(Disturbance(self.now + RADIO, Act.SAY, data))
            elif tx.link == NODES:
                if (switched := _GPS_NODE.match(tx.data)) is not None:
                    self.gps_open = switched[1] == b"O"
                waiting += self.board.receive(Rx(self.now, NODES, tx.data + b"\n"), self.now)

    # --- what is kept ----------------------------------------------------------------------------

    def _step(self, step: Step) -> None:
        self.events.append(step)
        if any(path.startswith(AUTONOMOUS) for path in step.entered):
            self._deadline = max(self._deadline, step.t + self._safety + ASCENT)

    def _told(self, estimate: Estimate) -> None:
        self.events.append(Told(self.now, estimate))


def fault_ends(event: FaultEvent) -> float:
    """At s; a fault for ever never."""
    duration = FAULTS[event.name].duration if event.duration is None else event.duration
    return math.inf if duration >= FOREVER else event.begin + duration


def from_home(trial: Trial, place: Truth) -> tuple[float, float]:
    """m north and east, by the simulator's own geodesy."""
    return local(trial.home, place.latitude, place.longitude)
