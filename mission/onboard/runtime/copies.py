"""Commands that arrive twice (R1, R12): by the other path, late by modem, or repeated.

    accepted less than 2 min ago, then or now by modem     -->  a copy
    refused less than 2 min ago, and now by modem          -->  a copy
    a copy:  it is still in force   -->  answered as done, not executed
             it is not              -->  refused: it was meant for the state of then

The bytes do not show whether a command is a copy or a new wish. An operator who means it sends it
by network, and once more 5 s after a refusal there (the tries of one request by network last only
3 s); or waits until the 2 min are over; or sends something else. Exceptions:

- A refused @AC or mission line may be repeated at once (R7, R3).
- By modem, an @AC that the network refused is a copy: one press by both paths is no second wish.
- X, W and M are never copies, nor is @ST, which is refused by modem.
- By network alone nothing is a copy: a connection keeps its order, with one request at a time.

What does not live here: what is in force (operator_server), who may command (commander).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mission.model import Verdict
from mission.onboard.runtime.command_target import MODEM, Peer
from protocol.messages import ClearMission, Command, MissionLine, Relay, SetTime

LATE_S = 120.0  # s: a copy may come this late
TWICE_S = 5.0  # s between an increment and its copy by the other path
AGAIN_S = 5.0  # s after a refusal: longer than the tries of one command last
REMEMBERED = 20_000  # commands: two of the longest uploads


@dataclass(slots=True)
class _Said:
    peer: Peer
    t: float
    accepted: bool
    refused: float | None = None  # when a copy by network was first refused


class Copies:
    def __init__(self, in_force: Callable[[Command], bool | None]) -> None:
        """``in_force``: None if no state shows it; then the newest command of its kind decides."""
        self._in_force = in_force
        self.said: dict[Command, _Said] = {}  # the newest last

    def note(self, peer: Peer, command: Command, accepted: bool, now: float) -> None:
        """Note that the command was executed, or refused."""
        kept = self.said
        kept.pop(command, None)
        kept[command] = _Said(peer, now, accepted)
        while now - kept[oldest := next(iter(kept))].t >= LATE_S or len(kept) > REMEMBERED:
            del kept[oldest]

    def age(self, command: Command, now: float) -> float:
        """Seconds since the command was received. Raises KeyError if it was not."""
        return now - self.said[command].t

    def judge(self, peer: Peer, command: Command, now: float) -> Verdict | None:
        """The answer to a copy; None if the command is no copy, or is meant."""
        said = self.said.get(command)
        if said is None or not _may_be_copy(said, peer, command, now):
            return None
        in_force = self._in_force(command)
        if in_force is None:
            lasts = not _adds(command) or now - said.t < TWICE_S
            in_force = lasts and self._is_newest(command)
        if in_force:
            return Verdict(True, "accepted before")
        how = f"say it by the network, or in {said.t + LATE_S - now:.0f} s"
        if peer.link != MODEM:
            how = f"say it again in {AGAIN_S:g} s"
            said.refused = now if said.refused is None else said.refused
            if now - said.refused >= AGAIN_S:
                return None
        return Verdict(False, f"said {now - said.t:.0f} s ago, and not in force since; {how}")

    def _is_newest(self, command: Command) -> bool:
        """Whether it was accepted, and no later command of its kind was."""
        accepted = (c for c in reversed(self.said) if self.said[c].accepted)
        return command == next((c for c in accepted if _kind(c) == _kind(command)), None)


def _kind(command: Command) -> object:
    return command.kind if isinstance(command, Relay) else type(command)


def _adds(command: Command) -> bool:
    """Whether the command is an increment: no state shows that it was executed."""
    return isinstance(command, Relay) and command.frame.startswith(b"@DA")


def _may_be_copy(said: _Said, peer: Peer, command: Command, now: float) -> bool:
    if MODEM not in (peer.link, said.peer.link) or isinstance(command, SetTime):
        return False
    if isinstance(command, MissionLine) and peer.link != MODEM:
        return False
    if not said.accepted and (peer.link != MODEM or _may_be_repeated(said, command)):
        return False
    return now - said.t < LATE_S


def _may_be_repeated(said: _Said, command: Command) -> bool:
    """Whether a refused command may be repeated by modem at once."""
    by_modem = said.peer.link == MODEM
    return isinstance(command, MissionLine) or (isinstance(command, ClearMission) and by_modem)
