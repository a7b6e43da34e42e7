"""Peers that wait for an answer of the STM32: R acknowledgements, and the outcome of X and W.

What does not live here: the answers (operator_server).
"""

from __future__ import annotations

from dataclasses import dataclass

from mission.onboard.runtime.command_target import Peer


@dataclass(frozen=True, slots=True)
class _Awaiting:
    peer: Peer
    key: str  # the function of an R acknowledgement, or the name of an Order
    until: float


class PendingAnswers:
    def __init__(self) -> None:
        self._all: list[_Awaiting] = []

    def add(self, peer: Peer, key: str, now: float, seconds: float) -> None:
        """Add a peer that waits; a repeated request is still owed one answer."""
        others = [a for a in self._all if a.until > now and (a.peer, a.key) != (peer, key)]
        self._all = [*others, _Awaiting(peer, key, now + seconds)]

    def answered(self, key: str, now: float, final: bool) -> list[Peer]:
        """Return the peers that get it. Not ``final``: another may follow, so they keep waiting."""
        peers = [a.peer for a in self._all if a.key == key and a.until > now]
        self._all = [a for a in self._all if a.until > now and not (final and a.key == key)]
        return peers

    def forget(self, peer: Peer) -> None:
        self._all = [a for a in self._all if a.peer != peer]
