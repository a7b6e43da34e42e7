"""Which way leads to the vehicle, and how fast its line is.

What does not live here: the two ways themselves (frontseat, repeater).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from links import baud_of
from mission.model.vehicle import Output
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.repeater import Repeater
from protocol.codec import VehicleCodec
from protocol.messages import Outputs
from protocol.vehicles.adapter import SilentBoard


def line_to(
    codec: VehicleCodec,
    link: str,
    url: str,
    bits_per_s: float,
    outputs: Sequence[Output] = (),
) -> Frontseat | Repeater:
    """``bits_per_s`` where the ``url`` of the ``link`` tells no rate of its own."""
    channels = {output.name: output.channel for output in outputs}
    codec.take_outputs({output.channel: output.safe for output in outputs})

    def take(wanted: Outputs) -> Mapping[str, bytes]:
        return codec.take_outputs({channels[name]: level for name, level in wanted.levels})

    rate = baud_of(url, bits_per_s)
    if not isinstance(codec, SilentBoard):
        return Frontseat(codec.encode, link, rate, take)
    awake, stick = codec.kept_awake, codec.stick
    return Repeater(codec.encode, codec.period, link, rate, awake, stick, take)
