"""A Topside between a vessel that says what it is told to and operators' bytes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mission.model import Tx, Verdict
from mission.onboard.runtime.command_target import MissionRefused, Peer
from mission.onboard.runtime.device_switches import DeviceSwitches
from mission.onboard.runtime.operator_channels import operator_channels
from mission.onboard.runtime.operator_server import OperatorServer
from mission.onboard.store import MemoryStore
from protocol.messages import ClearMission, Command, MissionLine, StartMission, StateReport, Status
from protocol.modem import ModemCodec, Sender, wrap
from protocol.tolerances import Tolerances
from protocol.topside import encode

BOAT, OTHER, WATER = Peer("topside", "boat:1"), Peer("topside", "other:2"), Peer("modem", "")
LINES = ("mission a vehicle auv", "ZAF6", "wait 10s")
GOOD, BAD = b"@ACK_%b$", b"@ACK_%bN$"
STATE = StateReport("autonomous", "asker", 1, 2, 3, 4, 5, 6, 7, 8, 9.5, 0, "X", "row")


@dataclass
class FakeVessel:
    state: str = "idle/empty"
    digest: str = ""
    under_way: str = ""
    doubted_at: float = -math.inf
    decided: list[Command] = field(default_factory=list)
    relayed: list[bytes] = field(default_factory=list)
    accepted: list[tuple[str, ...]] = field(default_factory=list)
    auto: list[bool] = field(default_factory=list)
    sticks: list[float] = field(default_factory=list)  # that were refused
    clock: str = ""
    refuses: str = ""  # what decide says
    refuses_mission: str = ""
    refuses_relay: str = ""  # what relay says
    has_none: str = ""  # what cannot_relay says
    notices: list[str] = field(default_factory=list)
    store: MemoryStore = field(default_factory=MemoryStore)

    def decide(self, command: Command, now: float) -> Verdict:
        self.decided.append(command)
        if not self.refuses and isinstance(command, StartMission):
            self.state = "autonomous/a"
        elif not self.refuses and isinstance(command, ClearMission):
            self.state = "idle/empty"
            self.store.keep_lines(())
        return Verdict(not self.refuses, self.refuses)

    def switch_auto(self, is_open: bool, now: float) -> None:
        self.auto.append(is_open)

    def hear_stick(self, now: float) -> None:
        self.sticks.append(now)

    def cannot_relay(self, frame: bytes) -> str:
        return self.has_none

    def meaning_of_no(self, frame: bytes) -> str:
        return "it is deaf" if frame == b"@ZAH0,4$" else ""

    def notice(self, text: str) -> None:
        self.notices.append(text)

    def relay(self, frame: bytes, reason: str, manual: bool) -> str:
        if self.refuses_relay:
            return self.refuses_relay
        self.relayed.append(frame)
        return ""

    def accept(self, lines: tuple[str, ...], now: float) -> None:
        if self.refuses_mission:
            raise MissionRefused(self.refuses_mission)
        self.store.keep_lines(lines)
        self.accepted.append(lines)
        self.state, self.digest = "idle/ready", "0123456789abcdef" * 4

    def status(self, now: float) -> Status:
        return Status("2025-01-19T23:26:25")

    def state_report(self, asker: Peer, now: float) -> StateReport:
        return STATE

    def set_clock(self, time: str, now: float) -> None:
        self.clock = time


class Pi:
    """A Topside with its vessel, and what came back to whom."""

    def __init__(self, answer_no: bool = True, failures: dict[int, str] | None = None) -> None:
        self.target = FakeVessel(store=MemoryStore(failures=failures or {}))
        nodes = DeviceSwitches(frozenset({"STM32", "BDGPS", "UACM"}))
        self.topside = OperatorServer(
            self.target,
            self.target.store,
            operator_channels(Tolerances()),
            nodes,
            answer_no,
        )
        for peer in (BOAT, OTHER, WATER):
            self.topside.connected(peer)

    def hear(
        self,
        command: Command | bytes,
        now: float = 0.0,
        peer: Peer = BOAT,
        said: float | None = None,
    ) -> list[bytes]:
        """What goes back to that peer at once (under water: when its turn comes)."""
        data = command if isinstance(command, bytes) else encode(command)
        sent = wrap(data, Sender.TOPSIDE) if peer is WATER else data
        self.topside.receive(peer, sent, now, now if said is None else said)
        out = self.topside.outgoing(now)
        if peer is WATER:
            out += self.later(now + 0.2)
        return [tx.data for tx in out if (tx.link, tx.address) == (peer.link, peer.address)]

    def later(self, now: float) -> list[Tx]:
        self.topside.handle_timer(now)
        return self.topside.outgoing(now)

    def upload(self, lines: tuple[str, ...] = LINES, now: float = 0.0) -> list[bytes]:
        total = len(lines)
        return [self.hear(MissionLine(total, i + 1, t), now)[0] for i, t in enumerate(lines)]


def opened(data: list[bytes]) -> bytes:
    """The content of one envelope."""
    (envelope,) = ModemCodec().receive(b"".join(data), 0.0)
    return envelope.content  # type: ignore[union-attr]
