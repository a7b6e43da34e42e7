"""Program, simulated vehicle, links and operators in lock step, and the disturbances of them.

    operator --bytes--> Program --bytes--> SimulatedVehicle
             <--bytes--         <--bytes--
    disturbances --> boats, modem, cable, disk, power, the program itself

Every simulated flight is a rig; its caller plans the disturbances and decides when it is over.
``events`` has what the rig saw, in order. Heard, Located and Told are kept only if the rig is
``judged``.

What does not live here: which disturbances there are (campaign.disturbances), when a flight is over
and its results (simulation.flight, campaign.trial), the exhaustive proof (exhaustive.world).
"""

from __future__ import annotations

import heapq
import re
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

from links.base import Link, Rx
from links.simulated.link import SimulatedVehicle
from mission.model import Estimate, Step, Tx
from mission.onboard.runtime.device_switches import LINK as NODES
from mission.onboard.runtime.receivers import RECEIVERS
from mission.onboard.runtime.runtime import SENSORS, VEHICLE
from mission.verification.rig.acts import BOAT, MODEM, PORT, TOPSIDE, Act, Disturbance
from mission.verification.rig.lockstep import Due, LockStep
from mission.verification.rig.program import Death, Program
from mission.verification.rig.rehearsal import Operator
from mission.verification.rig.trace import Done, Event, Heard, Located, Said, Told
from mission.verification.rig.vehicle import Simulated

RESTART = 3.0  # s until a program that died by itself is restarted
_WAITS = (Act.SAY, Act.JOIN, Act.PART, Act.END, Act.HURRY)  # while the program is stalled
_DEATHS = {Act.DIE_BEFORE: Death.BEFORE, Act.DIE_AFTER: Death.AFTER}
_PORTS = (VEHICLE, SENSORS, *RECEIVERS)  # links of the vehicle, not of operators
_GPS_NODE = re.compile(rb"BDGPS ([OC])")


def _beside(sea: Simulated) -> Iterator[Link]:
    """The links of added sensors and of a second receiver."""
    if isinstance(sea, SimulatedVehicle):
        yield from (link for link in (sea.added_link, sea.second_link) if link is not None)


class Rig(LockStep):
    """``operator`` is on the boat and begins at ``operator_from`` s. ``radio``: s until his reply
    to an answer reaches the program. ``program`` is running already."""

    judged = True  # by laws, which need all Heard, Located and Told events

    def __init__(
        self,
        sea: Simulated,
        program: Program,
        operator: Operator | None = None,
        *,
        operator_from: float = 0.0,
        radio: float = 0.0,
    ) -> None:
        super().__init__()
        self.sea, self.program, self.operator = sea, program, operator
        self.events: list[Event] = []
        self.plugged, self.joined = True, set[str]()
        self.gps_open = self._lived = True
        self._operator_from, self._radio = operator_from, radio
        self._planned: list[tuple[float, int, Disturbance]] = []
        self._count = 0  # all ever planned: at one time, the first planned is done first
        self._held: list[Disturbance] | None = None  # arrived while the program is stalled
        self._unnoticed = False  # the cable is back, and the program does not know it yet
        self._links: tuple[tuple[Callable[[], float | None], Callable[[], None]], ...] = (
            (sea.vehicle_link.next_event, self._hear_vehicle),
            (sea.gps_link.next_event, self._hear_gps),
            *((link.next_event, partial(self._hear_beside, link)) for link in _beside(sea)),
        )
        program.listen(self.stepped, self.told)

    # --- who is due ------------------------------------------------------------------------------

    def dues(self) -> Sequence[Due]:
        """Bytes come before timers: at a timer, the program knows all that has arrived."""
        dues: list[Due] = [(next_event(), hear) for next_event, hear in self._links]
        if self._planned:
            dues.append((self._planned[0][0], self._do_planned))
        dues += self.operators()
        program = self.program
        if self._held is None:
            dues.append((program.next_timer(), self._handle_timer))
        if program.runtime is None and self._lived:
            dues.append((self.now, self._died))
        return dues

    def operators(self) -> Iterable[Due]:
        due = None if self.operator is None else self.operator.next_timer()
        return () if due is None else ((due + self._operator_from, self._operate),)

    def _operate(self) -> None:
        assert self.operator is not None
        for data in self.operator.handle_timer(self.now - self._operator_from):
            self.do(Disturbance(self.now, Act.SAY, data))

    def _handle_timer(self) -> None:
        self.send(self.program.handle_timer(self.now))

    def _died(self) -> None:
        """Note the death of the program. If no KILL explains it, plan the restart by the service
        manager and the boat's new connection."""
        self._lived = False
        last = next((e for e in reversed(self.events) if isinstance(e, Done)), None)
        if last is None or last.act is not Act.KILL or last.t != self.now:
            self.events.append(Done(self.now, Act.LEAVE))
            self.do(Disturbance(self.now, Act.KILL))
            self.begin_anew()

    def begin_anew(self) -> None:
        self.plan(Disturbance(self.now + RESTART, Act.BOOT))
        self.plan(Disturbance(self.now + RESTART + 1.0, Act.JOIN))

    # --- input -----------------------------------------------------------------------------------

    def join(self, address: str = BOAT, link: str = TOPSIDE) -> None:
        self.joined.add(address)
        self.send(self.program.connected(link, address, self.now))

    def say(self, link: str, address: str, data: bytes) -> list[Tx]:
        """Send bytes to the program, and return its answers. A closed connection carries none."""
        if link == PORT:
            self._hear(Rx(self.now, link, data))
            return []
        if link != MODEM and address not in self.joined:
            return []
        self.events.append(Said(self.now, link, address, data))
        return self.program.receive(Rx(self.now, link, data, address), self.now)

    def _hear_vehicle(self) -> None:
        for rx in self.sea.vehicle_link.receive(self.now):
            if self.plugged:
                self._hear(rx)

    def _hear_gps(self) -> None:
        for rx in self.sea.gps_link.receive(self.now):
            if self.gps_open:
                self._hear(rx)

    def _hear_beside(self, link: Link) -> None:
        for rx in link.receive(self.now):
            self._hear(rx)

    def _hear(self, rx: Rx) -> None:
        """Give the program bytes of the vehicle, its GPS or an added sensor."""
        if self._held is not None:
            self._held.append(Disturbance(self.now, Act.SAY, rx.data, rx.link, rx.address))
            return
        if self.judged and rx.link == VEHICLE:
            self.events.append(Heard(self.now, rx.data))
        elif self.judged and rx.link in RECEIVERS:
            self.events.append(Located(self.now, rx.link, rx.data))
        self.send(self.program.receive(rx, self.now))

    # --- output ----------------------------------------------------------------------------------

    def send(self, sent: list[Tx]) -> None:
        """Deliver these bytes, then the answers to them, until nobody answers any more."""
        if not sent:
            return  # the usual case
        waiting = deque(sent)
        while waiting:
            tx = waiting.popleft()
            self.events.append(tx)
            if tx.link == VEHICLE:
                if self.plugged:
                    self.sea.vehicle_link.send(tx.data, self.now)
            elif tx.link == TOPSIDE and tx.address in self.joined:
                waiting += self.answered(tx)
            elif tx.link == NODES:
                if (switched := _GPS_NODE.match(tx.data)) is not None:
                    self.gps_open = switched[1] == b"O"
                waiting += self.program.receive(Rx(self.now, NODES, tx.data + b"\n"), self.now)

    def answered(self, tx: Tx) -> list[Tx]:
        """Return what the program sends because of the operator's reply to these bytes."""
        out: list[Tx] = []
        if self.operator is None or tx.address != BOAT:
            return out
        for data in self.operator.receive(tx.data, self.now - self._operator_from):
            if self._radio:
                self.plan(Disturbance(self.now + self._radio, Act.SAY, data))
            else:
                out += self.say(TOPSIDE, BOAT, data)
        return out

    # --- disturbances ----------------------------------------------------------------------------

    def plan(self, disturbance: Disturbance) -> None:
        self._count += 1
        heapq.heappush(self._planned, (disturbance.after, self._count, disturbance))

    def _do_planned(self) -> None:
        while self._planned and self._planned[0][0] <= self.now:
            self.do(heapq.heappop(self._planned)[2])

    def do(self, disturbance: Disturbance) -> None:
        """Carry out a disturbance. If it needs the program and the program is stalled, hold the
        disturbance until the program runs again."""
        act = disturbance.act
        if self._held is not None and act in _WAITS:
            self._held.append(disturbance)
            return
        if act is Act.SAY:
            self.send(self.say(disturbance.link, disturbance.address, disturbance.data))
        elif act is not (Act.BOOT if self.program.lives else Act.STALL):
            # no second program is started, and a dead one cannot be stalled
            self.events.append(Done(self.now, act))
            self._carry_out(disturbance)

    def _carry_out(self, disturbance: Disturbance) -> None:
        now, act = self.now, disturbance.act
        match act:
            case Act.STALL:
                self._held = [] if self._held is None else self._held
            case Act.RUN:
                self._run_again()
            case Act.POWER:
                self._cut_power()
            case Act.DIE_BEFORE | Act.DIE_AFTER:
                self.program.store.death = _DEATHS[act]
            case Act.FILL | Act.FREE:
                self.program.store.full = act is Act.FILL
            case Act.JOIN:
                self.join(disturbance.address, disturbance.link)
            case Act.PART:
                self.joined.discard(disturbance.address)
                self.send(self.program.disconnected(disturbance.link, disturbance.address, now))
            case Act.KILL:
                self.program.kill()
                self._are_gone()
            case Act.END | Act.HURRY:
                self.send(self.program.end(now, at_once=act is Act.HURRY))
            case Act.BOOT:
                self.program.boot(now)
                self._lived = True
            case Act.UNPLUG | Act.PLUG:
                self.plugged = self._unnoticed = act is Act.PLUG
                self._notice_line()

    def _cut_power(self) -> None:
        self.sea.advance(self.now)
        if isinstance(self.sea, SimulatedVehicle):
            self.sea.stm32.restart()
        else:
            self.sea.restart()

    def _notice_line(self) -> None:
        if self._unnoticed and self._held is None:
            self._unnoticed = False
            self.send(self.program.connected(VEHICLE, "", self.now))

    def _are_gone(self) -> None:
        """Reset what ends with the program: connections, node switches, bytes that are not read."""
        self.joined.clear()
        self.gps_open, self._held, self._unnoticed = True, None, False

    def _run_again(self) -> None:
        """Give the program what arrived while it was stalled: the bytes of each port as one piece,
        then what connections did, in order."""
        held, self._held = self._held or [], None
        self._notice_line()
        ports: dict[str, bytes] = {}
        for disturbance in held:
            if disturbance.link in _PORTS:
                ports[disturbance.link] = ports.get(disturbance.link, b"") + disturbance.data
        for link, data in ports.items():
            self._hear(Rx(self.now, link, data))
        for disturbance in held:
            if disturbance.link not in ports:
                self.do(disturbance)

    # --- recorded events -------------------------------------------------------------------------

    def stepped(self, step: Step) -> None:
        self.events.append(step)

    def told(self, estimate: Estimate) -> None:
        if self.judged:
            self.events.append(Told(self.now, estimate))
