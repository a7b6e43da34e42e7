"""Who is owed an answer that only the STM32 can give: R acknowledges, and what became of X and W.

What does not live here: the answers (topside).
"""

from __future__ import annotations

from dataclasses import dataclass

from mission.onboard.runtime.command_target import Peer


@dataclass(frozen=True, slots=True)
class _Awaiting:
    peer: Peer
    key: str  # the function of an R acknowledge, or the name of an Order
    until: float


class PendingAnswers:
    def __init__(self) -> None:
        self._all: list[_Awaiting] = []

    def add(self, peer: Peer, key: str, now: float, seconds: float) -> None:
        """Asked again, it is still one answer that is owed."""
        others = [a for a in self._all if a.until > now and (a.peer, a.key) != (peer, key)]
        self._all = [*others, _Awaiting(peer, key, now + seconds)]

    def answered(self, key: str, now: float, final: bool) -> list[Peer]:
        """Who hears it. Not ``final``: another answer may follow, so they go on waiting."""
        peers = [a.peer for a in self._all if a.key == key and a.until > now]
        self._all = [a for a in self._all if a.until > now and not (final and a.key == key)]
        return peers

    def forget(self, peer: Peer) -> None:
        self._all = [a for a in self._all if a.peer != peer]
