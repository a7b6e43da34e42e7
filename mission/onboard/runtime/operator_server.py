"""The Pi's side of the operator protocol: who may command, and the answers. Sans-IO.

    bytes --path--> command --copy? commander? idle?--> CommandTarget
    answer --path of the request (R12)--> bytes

Rules of docs/rules.md that live here: R2 (answers N), R3 and R4 (with ``uploads``), R6's relaying,
R9-R11 as far as an answer shows them, R12 (with ``copies``, ``commander``), R13 (with
``node_switching``), R14. STOP and SURFACE are always accepted, from any connection; the answer is
their outcome at the STM32.

What does not live here: what a command does to the vehicle (engine, behind ``CommandTarget``),
frames (protocol), sockets.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import replace

from mission.engine.orders import may_come_by_modem
from mission.model import AUTONOMOUS, Outcome, Result, Tx, Verdict
from mission.onboard.runtime.command_target import (
    MODEM,
    Answer,
    CommandTarget,
    Peer,
    acknowledge,
    name_of,
    one_line,
)
from mission.onboard.runtime.commander import Commander
from mission.onboard.runtime.copies import Copies
from mission.onboard.runtime.device_switches import DeviceSwitches
from mission.onboard.runtime.node_switching import NodeSwitching
from mission.onboard.runtime.operator_channels import STICK, Heard, OperatorChannel, Unfit
from mission.onboard.runtime.pending_answers import PendingAnswers
from mission.onboard.runtime.refusals import Refusals, refused_set
from mission.onboard.runtime.uploads import Uploads
from mission.onboard.store import Store, StoreError, merged
from protocol.messages import (
    Ack,
    ClearMission,
    Command,
    DataQuery,
    Emergency,
    FrameFault,
    Manual,
    MissionLine,
    NodeQuery,
    NodeSwitch,
    Order,
    Relay,
    SetOutput,
    SetSafety,
    SetTime,
    StartMission,
    StateQuery,
    StoreQuery,
)
from protocol.topside import answer

RELAY_ANSWER_S = 5.0
ORDER_ANSWER_S = 10.0
TELL_S = 1.0  # s between two reports of refused relays
YES, NO = ord("Y"), ord("N")
Query = DataQuery | StoreQuery | StateQuery | NodeQuery


class OperatorServer:
    def __init__(
        self,
        target: CommandTarget,
        store: Store,
        path: Callable[[str], OperatorChannel],
        nodes: DeviceSwitches,
        answer_no: bool = True,
    ) -> None:
        """``path`` makes the channel of a connection, by the name of its link."""
        self._target, self._store, self._new_path = target, store, path
        self._nodes, self._answer_no = nodes, answer_no  # R2
        self._uploads = Uploads(target, store)
        self._paths: dict[Peer, OperatorChannel] = {}
        self.commander = Commander()
        self.copies = Copies(self._in_force)
        self._pending = PendingAnswers()
        self._switching = NodeSwitching(target, nodes)
        self.refusals = Refusals()
        self._told = -math.inf  # when a refused relay was last reported
        self._faults = list[tuple[Peer, FrameFault]]()

    # --- connections ---------------------------------------------------------------------

    def connected(self, peer: Peer) -> None:
        if peer not in self._paths:
            self._paths[peer] = self._new_path(peer.link)

    def disconnected(self, peer: Peer, now: float) -> None:
        self._paths.pop(peer, None)
        self._pending.forget(peer)
        self.commander.forget(peer)
        if not (self._by_network or self._is_idle):
            self._switching.reopen("UACM", "the modem is the only live path", now)
            self._conclude_switches(now)

    def receive(self, peer: Peer, data: bytes, now: float, said: float) -> None:
        self.connected(peer)
        self._take(peer, self._paths[peer].receive(data, now), now, said)

    def foresee(self, peer: Peer, data: bytes, now: float) -> tuple[str, ...]:
        """The set of lines that these bytes would complete, () if none. Changes nothing."""
        if peer not in self._paths or not self._uploads.may_complete(data):
            return ()
        return self._uploads.foresee(copy.deepcopy(self._paths[peer]).receive(data, now), now)

    def changed(self, data: bytes, now: float) -> None:
        """Take in bytes of the link ``nodes``."""
        self._nodes.changed(data)
        self._settle(now)

    def handle_timer(self, now: float) -> None:
        for peer, path in list(self._paths.items()):
            self._take(peer, path.handle_timer(now), now, now)
        self._settle(now)

    def next_timer(self) -> float | None:
        first = self._nodes.next_timer()
        for path in self._paths.values():
            due = path.next_timer()
            if due is not None and (first is None or due < first):
                first = due
        return first

    def outgoing(self, now: float) -> list[Tx]:
        """Return what leaves now."""
        out = self._switching.outgoing()
        for peer, path in self._paths.items():
            for data, why in path.outgoing(now):
                out.append(Tx(now, peer.link, data, why, peer.address))
        return out

    def faults(self) -> list[tuple[Peer, FrameFault]]:
        """Return the faults (bytes that were no frame) since the last call."""
        faults, self._faults = self._faults, []
        return faults

    # --- what others report ---------------------------------------------------------------

    def relayed_answer(self, ack: Ack, now: float) -> None:
        """Pass an R acknowledgement of the STM32 on, byte for byte, to whoever asked (R14)."""
        self._answer_awaiting(ack.function, ack, now)

    def order_outcome(self, outcome: Outcome, now: float) -> None:
        """Answer a STOP or SURFACE with its outcome at the STM32. The next ``@AR`` tells of a set
        that was refused."""
        if not isinstance(outcome.command, Order):
            if outcome.result is Result.REFUSED:
                why = refused_set(outcome.frame, self._target.meaning_of_no(outcome.frame))
                self.refusals.note("ZA", why, now)
                self._target.notice(why)
            return
        letter = "X" if outcome.command is Order.STOP else "W"
        result = YES if outcome.result is Result.ACCEPTED else NO
        self._answer_awaiting(outcome.command.name, Ack(now, "Z", letter, result), now)

    def report_unasked(self, now: float, reason: str) -> None:
        """Send one @VS on every path (R11)."""
        for peer in sorted(self._paths):
            self._paths[peer].send(self._target.status(now), now, reason, unasked=True)

    # --- commands -------------------------------------------------------------------------

    def _take(self, peer: Peer, heard: list[Heard], now: float, said: float) -> None:
        for item in heard:
            if isinstance(item, FrameFault):
                self._faults.append((peer, item))
            elif isinstance(item, Unfit):
                self._refuse_unfit(peer, item, now)
            else:
                self.commander.hear(peer, now)
                self._command(peer, item, now, said)

    def _refuse_unfit(self, peer: Peer, unfit: Unfit, now: float) -> None:
        self._faults.append((peer, unfit.fault))
        self.refusals.note(unfit.code, unfit.fault.kind, now)
        if unfit.code == STICK:
            self._target.hear_stick(now)
        elif self._answer_no:
            self._send(peer, answer(unfit.code, False, now), now, unfit.fault.kind)

    def _command(self, peer: Peer, command: Command, now: float, said: float) -> None:
        if isinstance(command, Emergency):
            self.commander.ordered_at = max(said, self.commander.ordered_at)
            self._emergency(peer, command, now)
        elif isinstance(command, Query):
            if isinstance(command, StoreQuery):
                self.commander.reads_reports(peer)
            self._send(peer, self._query(peer, command, now), now, "asked")
        elif (verdict := self.copies.judge(peer, command, now)) is not None:
            self._answer_copy(peer, command, verdict, now)
        else:
            why = self.commander.why_not(peer, now, said)
            verdict = Verdict(False, why) if why else self._execute(peer, command, now)
            if isinstance(command, Manual) and verdict is not None and not verdict.accepted:
                self._target.hear_stick(now)
            if verdict is not None:
                self._conclude(peer, command, verdict, now)

    def _emergency(self, peer: Peer, command: Emergency, now: float) -> None:
        self._pending.add(peer, command.order.name, now, ORDER_ANSWER_S)
        self._hand_over(peer, now)
        self._target.decide(command, now)
        self._switching.overtake()
        self._switching.reopen("STM32", f"an operator says {command.order.name}", now)
        self._conclude_switches(now)

    def _query(self, peer: Peer, command: Query, now: float) -> Answer:
        if isinstance(command, DataQuery):
            return self._target.status(now)
        if isinstance(command, StateQuery):
            return self._target.state_report(peer, now)
        if isinstance(command, NodeQuery):
            return Ack(now, "N", "I", self._nodes.mask)
        refusal = self.refusals.told(now, self._target.doubted_at)
        return self._uploads.report(refusal, now)

    def _execute(self, peer: Peer, command: Command, now: float) -> Verdict | None:
        """The verdict, or None if it is not known yet."""
        if isinstance(command, NodeSwitch):
            return self._switch(peer, command, now)
        if isinstance(command, MissionLine):
            verdict, stored = self._uploads.take(command, now)
            if stored:
                self.refusals.end()
            return verdict
        if isinstance(command, SetTime):
            return self._set_time(peer, command, now)
        if isinstance(command, SetSafety):
            return self._set_safety(command, now)
        if isinstance(command, Relay):
            return self._relay(peer, command, now)
        if isinstance(command, Manual):
            return self._manual(peer, command, now)
        if isinstance(command, StartMission) and (why := self._cannot_start(now)):
            return Verdict(False, why)
        if peer.link == MODEM and not may_come_by_modem(command):
            return Verdict(False, f"@{name_of(command)} is not taken over the modem")
        verdict = self._target.decide(command, now)
        if isinstance(command, ClearMission) and verdict.accepted:
            self._uploads.clear()
        return verdict

    def _conclude(self, peer: Peer, command: Command, verdict: Verdict, now: float) -> None:
        if verdict.accepted and peer in self._paths:
            self._hand_over(peer, now)
        if not isinstance(command, Manual):
            self.copies.note(peer, command, verdict.accepted, now)
        self._answer(peer, command, verdict, now)

    def _answer(self, peer: Peer, command: Command, verdict: Verdict, now: float) -> None:
        if verdict.accepted:
            self.refusals.accepted(name_of(command))
        else:
            self.refusals.note(name_of(command), verdict.why, now)
        ack = acknowledge(command, verdict.accepted, now)
        if ack is not None and (verdict.accepted or self._answer_no):
            self._send(peer, ack, now, verdict.why or "accepted")

    def _answer_copy(self, peer: Peer, command: Command, verdict: Verdict, now: float) -> None:
        """Answer a copy without executing it. An R is relayed again: the STM32 answers it."""
        if isinstance(command, Relay) and command.kind != "D" and verdict.accepted:
            self._await_relay(peer, command, now)
            if self.copies.age(command, now) >= RELAY_ANSWER_S:
                self._target.relay(command.frame, f"relay of @{command.kind}, once more", False)
        self._answer(peer, command, verdict, now)

    def _in_force(self, command: Command) -> bool | None:
        """Whether the vehicle's state is what the command asks for; None if no state shows it."""
        match command:
            case StartMission():
                return self._target.state.startswith(AUTONOMOUS)
            case ClearMission():
                return self._is_idle and not (self._store.content.lines or self._uploads.total)
            case MissionLine():
                return self._uploads.holds(command)
            case SetOutput():
                return self._target.output(command.name) == command.value
            case SetSafety():
                kept = self._store.content.limits
                return merged(kept, command) == kept
            case NodeSwitch():
                return self._nodes.are(command.switches)
        return None

    def _hand_over(self, peer: Peer, now: float) -> None:
        """Give the command to ``peer`` (R12); an @AR informs the one who loses it."""
        loser = self.commander.hand_over(peer)
        if loser is not None:
            self._tell(loser, f"{peer} has taken the command", now, "the command is taken over")

    def _tell(self, peer: Peer, refusal: str, now: float, reason: str) -> None:
        self._send(peer, self._uploads.report(one_line(refusal), now), now, reason)

    # --- single commands -------------------------------------------------------------------

    def _cannot_start(self, now: float) -> str:
        if self._uploads.incomplete(now):
            return f"the upload is incomplete: lines {self._uploads.missing} missing"
        return self._deaf

    def _switch(self, peer: Peer, command: NodeSwitch, now: float) -> Verdict | None:
        why = self._switching.begin(peer, command, self._by_network, now)
        self._conclude_switches(now)
        return Verdict(False, why) if why else None  # None: answered when all have changed

    def _settle(self, now: float) -> None:
        self._switching.settle(now)
        self._conclude_switches(now)

    def _conclude_switches(self, now: float) -> None:
        for switch in self._switching.done():
            command, asked, verdict = switch.command, switch.asked, switch.verdict
            first = min(asked, key=lambda peer: (peer not in self._paths, not asked[peer]))
            if verdict.accepted and asked[first] and first in self._paths:
                self._hand_over(first, now)
            self.copies.note(first, command, verdict.accepted, now)
            for peer in asked:
                self._answer(peer, command, verdict, now)

    def _set_time(self, peer: Peer, command: SetTime, now: float) -> Verdict:
        if peer.link == MODEM:
            return Verdict(False, "the time is not set over the modem")
        if not self._is_idle:
            return Verdict(False, f"the time is set in idle only, not in {self._target.state}")
        self._target.set_clock(command.time, now)
        return Verdict(True)

    def _set_safety(self, command: SetSafety, now: float) -> Verdict:
        limits = merged(self._store.content.limits, command)
        try:
            self._store.keep_limits(limits)
        except StoreError as error:
            return Verdict(False, str(error))
        return self._target.decide(limits, now)

    def _relay(self, peer: Peer, command: Relay, now: float) -> Verdict:
        self._await_relay(peer, command, now)
        why = self._target.relay(command.frame, f"relay of @{command.kind} for {peer.link}", False)
        return self._relayed(peer, why, now)

    def _relayed(self, peer: Peer, why: str, now: float) -> Verdict:
        """No frame of the documents refuses an M, R or D: a peer that reads @AR is sent one."""
        if why and self.commander.reads(peer) and now - self._told >= TELL_S:
            self._told = now
            self._tell(peer, f"relay: {why}", now, why)
        if why:
            self._target.notice(f"not relayed for {peer}: {why}")
        return Verdict(not why, why)

    def _await_relay(self, peer: Peer, command: Relay, now: float) -> None:
        if command.kind.startswith("R"):
            self._pending.add(peer, command.kind[1], now, RELAY_ANSWER_S)

    def _manual(self, peer: Peer, command: Manual, now: float) -> Verdict:
        if peer.link == MODEM:
            return Verdict(False, "manual control does not go over the modem")
        if why := self._deaf or self._target.cannot_relay(command.frame):
            return self._relayed(peer, why, now)
        if not (verdict := self._target.decide(command, now)).accepted:
            return verdict
        why = self._target.relay(command.frame, f"relay of @{command.kind}", True)
        return self._relayed(peer, why, now)

    # --- answers ----------------------------------------------------------------------------

    @property
    def _is_idle(self) -> bool:
        return self._uploads.is_idle

    @property
    def _by_network(self) -> bool:
        """Whether there is a connection besides the modem."""
        return any(peer.link != MODEM for peer in self._paths)

    @property
    def _deaf(self) -> str:
        """Why the vehicle would receive nothing, "" if it would."""
        return "" if self._nodes.stays_open("STM32") else "node STM32 is closed"

    def _answer_awaiting(self, key: str, ack: Ack, now: float) -> None:
        """A refusal of X or W may be followed by another try; anything else is final."""
        for peer in self._pending.answered(key, now, final=ack.group != "Z" or ack.ok):
            self._send(peer, replace(ack, t=now), now, "answer of the STM32")

    def _send(self, peer: Peer, answer: Answer, now: float, reason: str) -> None:
        if peer in self._paths:
            self._paths[peer].send(answer, now, reason)
