"""Which way leads to the vehicle, and how fast its line is.

What does not live here: the two ways themselves (frontseat, repeater).
"""

from __future__ import annotations

from links import baud_of
from mission.onboard.runtime import frontseat, repeater
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.repeater import Repeater
from protocol.codec import VehicleCodec


def line_to(codec: VehicleCodec, link: str, url: str) -> Frontseat | Repeater:
    """``url`` of the ``link``, which may tell its baud rate."""
    period: float | None = getattr(codec, "period", None)  # boards that answer nothing
    if period is None:
        return Frontseat(codec.encode, link, baud_of(url, frontseat.BITS_PER_S))
    return Repeater(codec.encode, period, link, baud_of(url, repeater.BITS_PER_S))
