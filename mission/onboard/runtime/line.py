"""Which way leads to the vehicle, and how fast its line is.

What does not live here: the two ways themselves (frontseat, repeater).
"""

from __future__ import annotations

from links import baud_of
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.repeater import Repeater
from protocol.codec import VehicleCodec
from protocol.vehicles.adapter import SilentBoard


def line_to(codec: VehicleCodec, link: str, url: str, bits_per_s: float) -> Frontseat | Repeater:
    """``bits_per_s`` where the ``url`` of the ``link`` tells no rate of its own."""
    rate = baud_of(url, bits_per_s)
    if not isinstance(codec, SilentBoard):
        return Frontseat(codec.encode, link, rate)
    awake, stick = codec.kept_awake, codec.stick
    return Repeater(codec.encode, codec.period, link, rate, awake, stick)
