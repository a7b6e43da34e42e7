"""How long a vehicle's answer takes over one connection, by the beat that is asked anyway. Sans-IO.

    @AE leaves --asked--> waiting --its answer, in the same order (TCP keeps it)--> s of the way

What is asked over a long way is no sooner answered for being asked again, and what is given up
before its answer can be there is told to have come to nothing though it was done.
"""

from __future__ import annotations

from collections import deque

from mission.topside.upload import ANSWER_S
from protocol.messages import StateReport
from protocol.topside import ConsoleCodec

OF = 8  # answers: the slowest of them counts
WAITING = 60  # a program that knows no @AE answers none


class Latency:
    """``unknown_s``: how long the first answer may take."""

    def __init__(self, unknown_s: float) -> None:
        self._unknown = unknown_s
        self._took: deque[float] = deque(maxlen=OF)
        self.connected()

    def connected(self) -> None:
        """Anew: what was asked before is not answered any more."""
        self._codec = ConsoleCodec()
        self._asked: deque[float] = deque(maxlen=WAITING)
        self._has_heard = False

    def asked(self, now: float) -> None:
        self._asked.append(now)

    def heard(self, data: bytes, now: float) -> StateReport | None:
        """The last state that it tells."""
        found, self._has_heard = None, True
        for answer in self._codec.receive(data, now):
            if isinstance(answer, StateReport):
                found = answer
                if self._asked:
                    self._took.append(now - self._asked.popleft())
        return found

    @property
    def way_s(self) -> float:
        """There and back; 0 where it was not measured."""
        return max(self._took, default=0.0)

    @property
    def patience_s(self) -> float:
        """For an answer, before it is asked for again."""
        is_known = self._took or self._has_heard
        return ANSWER_S + self.way_s if is_known else self._unknown
