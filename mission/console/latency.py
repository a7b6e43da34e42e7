"""The round-trip time of one connection, measured with the beat (@AE), which is sent anyway.
Sans-IO.

    @AE leaves --asked--> waiting --its answer, in the same order (TCP keeps it)--> s of the way

On a slow link a retry brings no earlier answer. And a request that is given up before its answer
can arrive would be reported as failed though it was done.
"""

from __future__ import annotations

from collections import deque

from mission.topside.upload import ANSWER_S
from protocol.messages import StateReport
from protocol.topside import ConsoleCodec

OF = 8  # answers: the slowest of them counts
WAITING = 60  # beats: a program without @AE answers none


class Latency:
    """``unknown_s``: how long the first answer may take."""

    def __init__(self, unknown_s: float) -> None:
        self._unknown = unknown_s
        self._took: deque[float] = deque(maxlen=OF)
        self.connected()

    def connected(self) -> None:
        """Reset: earlier requests are no longer answered."""
        self._codec = ConsoleCodec()
        self._asked: deque[float] = deque(maxlen=WAITING)
        self._has_heard = False

    def asked(self, now: float) -> None:
        self._asked.append(now)

    def heard(self, data: bytes, now: float) -> StateReport | None:
        """Return the last state in the data."""
        found, self._has_heard = None, True
        for answer in self._codec.receive(data, now):
            if isinstance(answer, StateReport):
                found = answer
                if self._asked:
                    self._took.append(now - self._asked.popleft())
        return found

    @property
    def way_s(self) -> float:
        """Round-trip time; 0 if not measured."""
        return max(self._took, default=0.0)

    @property
    def patience_s(self) -> float:
        """How long to wait for an answer before asking again."""
        is_known = self._took or self._has_heard
        return ANSWER_S + self.way_s if is_known else self._unknown
