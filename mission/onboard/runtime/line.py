"""Choose the path to the vehicle, and the bit rate of its line.

What does not live here: the two paths themselves (frontseat, repeater).
"""

from __future__ import annotations

from collections.abc import Mapping

from links import baud_of
from mission.model.vehicle import OuterLoop, Vehicle
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.outer_loop import LoopCloser
from mission.onboard.runtime.repeater import Repeater
from protocol.codec import VehicleCodec
from protocol.messages import Outputs
from protocol.vehicles import line_rate
from protocol.vehicles.adapter import SilentBoard


def line_to(codec: VehicleCodec, link: str, url: str, vehicle: Vehicle) -> Frontseat | Repeater:
    """``vehicle``: the one that ``codec`` speaks to; its bit rate counts if ``url`` has none."""
    channels = {output.name: output.channel for output in vehicle.outputs}
    codec.take_outputs(vehicle.safe_levels)

    def take(wanted: Outputs) -> Mapping[str, bytes]:
        return codec.take_outputs({channels[name]: level for name, level in wanted.levels})

    rate = baud_of(url, line_rate(vehicle.codec, vehicle.wire))
    if not isinstance(codec, SilentBoard):
        return Frontseat(codec.encode, link, rate, take)
    awake, stick = codec.kept_awake, codec.stick
    closer = closer_of(vehicle.outer_loop)
    return Repeater(codec.encode, codec.period, link, rate, awake, stick, take, closer)


def closer_of(loop: OuterLoop | None) -> LoopCloser | None:
    """The loop closer; None until axes and signs are confirmed (R17)."""
    return LoopCloser(loop) if loop is not None and loop.confirmed else None
