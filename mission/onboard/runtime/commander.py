"""Who commands (R12): the connection whose command was accepted last, until it is silent.

    nobody --accepted--> A --accepted from B: A closed, or silent for 10 s--> B
                         A --X or W from B, at any time--> B

A command that was sent before the last X or W, whoever gave that, is refused (R7).

What does not live here: what a command does, and the answers (operator_server).
"""

from __future__ import annotations

import math

from mission.onboard.runtime.command_target import MODEM, Peer

COMMANDER_SILENT_S = 10.0


class Commander:
    def __init__(self) -> None:
        self.peer: Peer | None = None
        self.heard_at = -math.inf  # when any operator last sent a good frame
        self.ordered_at = -math.inf  # when the last X or W was sent
        self._heard: dict[Peer, float] = {}
        self._readers: set[Peer] = set()

    def hear(self, peer: Peer, now: float) -> None:
        self._heard[peer] = self.heard_at = now

    def reads_reports(self, peer: Peer) -> None:
        """Note that the peer has asked for an @AR, so it understands one."""
        self._readers.add(peer)

    def reads(self, peer: Peer) -> bool:
        return peer in self._readers

    def knows(self, peer: Peer) -> bool:
        """Whether the connection has sent a good frame."""
        return peer in self._heard

    def forget(self, peer: Peer) -> None:
        self._heard.pop(peer, None)
        self._readers.discard(peer)
        if self.peer == peer:
            self.peer = None

    def at(self, now: float) -> Peer | None:
        """Who commands at ``now``: None if the commander has been silent."""
        silent = now - self._heard.get(self.peer, -math.inf) if self.peer else math.inf
        return self.peer if silent <= COMMANDER_SILENT_S else None

    def why_not(self, peer: Peer, now: float, said: float) -> str:
        """Why ``peer`` may not command, "" if it may. ``said``: when the command came; it may have
        been held since."""
        if said < self.ordered_at:
            return "an X or W, said behind it, has overtaken it"
        other = self.at(now)
        if other is None or other == peer:
            return ""
        return f"{other} commands; others read until it closes or is silent 10 s"

    def hand_over(self, peer: Peer) -> Peer | None:
        """Give the command to ``peer``. Return who lost it, if it can be informed: a plain topside
        knows no frame for that, and under water nobody sends unasked (R15)."""
        loser, self.peer = self.peer, peer
        if loser is None or loser == peer or loser.link == MODEM or loser not in self._readers:
            return None
        return loser
