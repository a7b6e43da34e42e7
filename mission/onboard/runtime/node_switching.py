"""An @NS from request to answer (R13): what it may close, who asked, what became of it.

    @NS --may it?--> device_switches --requests--> processes
    X, W, last boat disconnected --a node that is needed--> opened again, the pending @NS answered N

What does not live here: the state of the nodes (device_switches), who may command, and the answers
(operator_server).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from mission.model import Tx, Verdict
from mission.model.regions import IDLE
from mission.onboard.runtime.command_target import CommandTarget, Peer
from mission.onboard.runtime.device_switches import LINK, NAMES, OPEN, DeviceSwitches
from protocol.messages import NodeSwitch


@dataclass(slots=True)
class Switch:
    command: NodeSwitch
    asked: dict[Peer, bool]  # in order; whether no X or W came since
    verdict: Verdict = field(default_factory=lambda: Verdict(True))


class NodeSwitching:
    def __init__(self, target: CommandTarget, nodes: DeviceSwitches) -> None:
        self._target, self._nodes = target, nodes
        self._auto = nodes.is_open("AUTO")
        self._pending: Switch | None = None
        self._done, self._out = list[Switch](), list[Tx]()

    def begin(self, peer: Peer, command: NodeSwitch, by_network: bool, now: float) -> str:
        """Begin a switch; why not, "" if it has begun. A repeated @NS joins the pending switch.
        ``by_network``: there is a connection besides the modem."""
        if self._pending and self._pending.command == command:
            self._pending.asked[peer] = True
            return ""
        closes = {n for n, s in zip(NAMES, command.switches, strict=True) if s != OPEN}
        if "UACM" in closes and not by_network:
            return "the modem is the only live path"
        if "STM32" in closes and (why := self._needs_board()):
            return why
        self._end(Verdict(False, "overtaken by another @NS"))
        requests = self._nodes.switch(command.switches, now)
        self._out += [Tx(now, LINK, request, "operator @NS") for request in requests]
        self._pending = Switch(command, {peer: True})
        self._follow_auto(now)
        self.settle(now)
        return ""

    def overtake(self) -> None:
        """An X or W came: an @NS from before it makes nobody commander."""
        if self._pending:
            self._pending.asked = dict.fromkeys(self._pending.asked, False)

    def reopen(self, name: str, why: str, now: float) -> None:
        """Open a node that is needed, although an @NS has closed it or is about to."""
        if request := self._nodes.reopen(name):
            self._out.append(Tx(now, LINK, request, why))
            if self._nodes.next_timer() is None:  # the pending switch is given up
                self._end(Verdict(False, f"{name} is needed: {why}"))

    def settle(self, now: float) -> None:
        if (late := self._nodes.settle(now)) is not None:
            self._follow_auto(now)
            self._end(Verdict(not late, late))

    def done(self) -> list[Switch]:
        """Return the switches to answer, since the last call."""
        if not self._done:
            return []
        done, self._done = self._done, []
        return done

    def outgoing(self) -> list[Tx]:
        out, self._out = self._out, []
        return out

    def _needs_board(self) -> str:
        if not self._target.state.startswith(IDLE):
            return "the STM32 is needed until the vehicle is idle"
        under_way = self._target.under_way
        return under_way and f"the STM32 is needed: {under_way}"

    def _follow_auto(self, now: float) -> None:
        if (is_open := self._nodes.is_open("AUTO")) != self._auto:
            self._auto = is_open
            self._target.switch_auto(is_open, now)

    def _end(self, verdict: Verdict) -> None:
        if (pending := self._pending) is not None:
            pending.verdict, self._pending = verdict, None
            self._done.append(pending)
