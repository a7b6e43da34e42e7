"""Vehicles whose file names every channel that their board's frames carry."""

from __future__ import annotations

import math
from dataclasses import replace

from mission.model.shipped import load_vehicle
from mission.model.vehicle import Output, Vehicle
from protocol.vehicles import VEHICLES
from protocol.vehicles.channels import Channel

FILES = {"motorcan": "motorboards"}  # of codecs, where it has another name


def with_every_output(codec: str) -> Vehicle:
    """The shipped vehicle; an output has the name and the bounds of its channel."""
    outputs = tuple(_output(channel) for channel in VEHICLES[codec].channels)
    return replace(load_vehicle(FILES.get(codec, codec)), outputs=outputs)


def _output(channel: Channel) -> Output:
    return Output(
        channel.name,
        channel.name,
        channel.low,
        channel.high,
        channel.low if math.isnan(channel.rest) else channel.rest,
        channel.unit,
        channel.whole,
        channel.needed,
        channel.excludes,
        channel.final,
        None,
        channel.choices,
    )
