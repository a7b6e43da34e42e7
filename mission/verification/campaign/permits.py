"""What a Step allows to leave for the vehicle: one frame, its tries, and until when.

What does not live here: which Step gives one (audit).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

STALE = 1.5  # s after which an older set has no try left


@dataclass(slots=True)
class Permit:
    frame: bytes
    order: bool
    since: float
    lifts: bool = False  # an ascent's U12 is said again (R7)
    tries: int = 0
    begun: bool = False  # it has left, or an older one that looks the same
    ends: float = math.inf

    def sent(self, t: float) -> None:
        """Count a frame. One that leaves just as it is replaced still has its tries."""
        if not self.tries and self.ends < math.inf and not self.order:
            self.ends = t + STALE
        self.tries += 1
