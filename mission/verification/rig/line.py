"""The rule of the serial line that every trace is judged by, a whole flight or one cell.

What does not live here: laws that need the truth of a whole flight (campaign), or the configuration
that a cell began in (exhaustive).
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

from mission.model import Tx

BYTE_S = 10 / 9600  # 8N1
GAP_S = 0.02  # as built: two frames at once would be one burst, which is read as one frame
_ROUNDED_S = 1e-6


class Crowded(NamedTuple):
    """Of a frame, when it left and behind what."""

    t: float
    says: str


def crowded(frames: Iterable[Tx]) -> Crowded | None:
    """The first frame to the STM32 that leaves too soon behind another."""
    for one, other in pairwise(frames):
        short = one.t + len(one.data) * BYTE_S + GAP_S - other.t
        if short > _ROUNDED_S:
            says = f"{other.data!r} leaves {short:.3f} s too soon behind {one.data!r}"
            return Crowded(other.t, says)
    return None
