"""The rule of the serial line that every trace must keep, of a whole flight and of one cell.

What does not live here: laws that need the true state in a whole flight (campaign), or the
configuration in which a cell began (exhaustive).
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

from mission.model import Tx

BYTE_S = 10 / 9600  # 8N1
GAP_S = 0.02  # as built, the STM32 reads two frames without a gap as one
_ROUNDED_S = 1e-6


class Crowded(NamedTuple):
    """A frame that left too soon: the time in s, and a message that names the frame before it."""

    t: float
    says: str


def crowded(frames: Iterable[Tx]) -> Crowded | None:
    """Return the first frame to the STM32 that leaves less than GAP_S after the frame before."""
    for one, other in pairwise(frames):
        short = one.t + len(one.data) * BYTE_S + GAP_S - other.t
        if short > _ROUNDED_S:
            says = f"{other.data!r} leaves {short:.3f} s too soon behind {one.data!r}"
            return Crowded(other.t, says)
    return None
