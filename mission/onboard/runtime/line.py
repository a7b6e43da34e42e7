"""Which way leads to the vehicle, and how fast its line is.

What does not live here: the two ways themselves (frontseat, repeater).
"""

from __future__ import annotations

from collections.abc import Mapping

from links import baud_of
from mission.model.vehicle import Vehicle
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.outer_loop import LoopCloser
from mission.onboard.runtime.repeater import Repeater
from protocol.codec import VehicleCodec
from protocol.messages import Outputs
from protocol.vehicles import line_rate
from protocol.vehicles.adapter import SilentBoard


def line_to(codec: VehicleCodec, link: str, url: str, vehicle: Vehicle) -> Frontseat | Repeater:
    """``vehicle``: that which ``codec`` speaks to; its rate where the ``url`` tells none."""
    outputs, outer_loop = vehicle.outputs, vehicle.outer_loop
    channels = {output.name: output.channel for output in outputs}
    codec.take_outputs({output.channel: output.safe for output in outputs})

    def take(wanted: Outputs) -> Mapping[str, bytes]:
        return codec.take_outputs({channels[name]: level for name, level in wanted.levels})

    rate = baud_of(url, line_rate(vehicle.codec, vehicle.wire))
    if not isinstance(codec, SilentBoard):
        return Frontseat(codec.encode, link, rate, take)
    awake, stick = codec.kept_awake, codec.stick
    closer = LoopCloser(outer_loop) if outer_loop is not None and outer_loop.confirmed else None
    return Repeater(codec.encode, codec.period, link, rate, awake, stick, take, closer)
