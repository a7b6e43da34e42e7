"""The part of the protocol reference about channels and sources (protocol.vehicles.channels)."""

from __future__ import annotations

from collections.abc import Iterator

from protocol.drawing import table
from protocol.vehicles import VEHICLES
from protocol.vehicles.channels import Channel


def channel_tables() -> Iterator[str]:
    yield "## Channels"
    yield ""
    yield "What a vehicle file may give a name, bounds and a safe state under `outputs`: legs set"
    yield "it (`output lamp 80`), and operators (`auvmission output lamp 80`)."
    yield ""
    rows = [
        (row.name, f"`{channel.name}`", channel.unit, _values(channel), _meaning(channel))
        for row in VEHICLES.values()
        for channel in row.channels
    ]
    yield from table(("codec", "channel", "unit", "values", "means"), rows)
    yield ""
    yield "What a vehicle file may give a name under `readings`, for guards:"
    yield ""
    sources = [
        (row.name, f"`{source.name}`", source.unit, source.meaning)
        for row in VEHICLES.values()
        for source in row.sources
    ]
    yield from table(("codec", "source", "unit", "means"), sources)
    yield ""


def _values(channel: Channel) -> str:
    if channel.choices:
        return ", ".join(f"{choice:g}" for choice in channel.choices)
    return f"{channel.low:g}..{channel.high:g}"


def _meaning(channel: Channel) -> str:
    if channel.needed:
        return f"{channel.meaning}; by no mission: {channel.needed}"
    if channel.excludes:
        return f"{channel.meaning}; at rest beside {', '.join(channel.excludes)}"
    return channel.meaning
