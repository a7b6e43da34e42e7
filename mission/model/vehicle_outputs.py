"""The tables ``outputs`` and ``readings`` of a vehicle file: names for what its frames carry.

    outputs:  {lamp: {channel: led_pct, high: 80, safe: 0}}
    readings: {metal: metal_pct}

Bounds lie within those of the channel. ``safe`` is the value from the start and in every emergency;
by default it is the channel's own at rest. What does not live here: YAML (vehicle_file), when an
output is set (mission.engine.outputs).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Protocol

from mission.model.vehicle import Output
from mission.model.vehicle_ranges import Range
from protocol.codec import CannotEncode, VehicleCodec
from protocol.topside_frames import OutputFrame
from protocol.vehicles import vehicle_row
from protocol.vehicles.channels import Channel

OUTPUT = re.compile(r"outputs\.[^.]+")  # the table of one output
OUTPUT_KEYS = frozenset({"channel", "low", "high", "safe", "irreversible", "ascent"})
_ANY = Range("", -1e6, 1e6)
_NAME = "letters, digits and _, 24 at most, a letter first"


class Tables(Protocol):
    """What these readers need of the file."""

    def names(self, table: str) -> list[str]: ...

    def text(self, key: str) -> str: ...

    def flag(self, key: str) -> bool: ...

    def number_in(self, key: str, wanted: Range, default: float) -> float: ...

    def refuse(self, key: str, message: str, hint: str) -> None: ...


def read_outputs(file: Tables, codec: str, board: VehicleCodec) -> tuple[Output, ...]:
    channels = {channel.name: channel for channel in vehicle_row(codec).channels}
    found: dict[str, Output] = {}
    for name in file.names("outputs"):
        key = f"outputs.{name}"
        channel = channels.get(file.text(f"{key}.channel"))
        if channel is None:
            there = ", ".join(channels) or "none"
            file.refuse(key, "no channel of that name", f"{codec} has: {there}")
        elif (other := found.get(channel.name)) is not None:
            file.refuse(key, f"{other.name} has this channel already", "keep one of them")
        else:
            found[channel.name] = _output(file, name, channel, board.levels[channel.name])
            if fault := _fault(found[channel.name], channel, board):
                file.refuse(key, fault, "docs/protocol.md has what each channel can be")
    return tuple(found.values())


def _output(file: Tables, name: str, channel: Channel, rest: float) -> Output:
    key = f"outputs.{name}"
    ascent = file.number_in(f"{key}.ascent", _ANY, math.nan)
    return Output(
        name,
        channel.name,
        file.number_in(f"{key}.low", _ANY, channel.low),
        file.number_in(f"{key}.high", _ANY, channel.high),
        file.number_in(f"{key}.safe", _ANY, rest),
        channel.unit,
        channel.whole,
        channel.needed,
        channel.excludes,
        file.flag(f"{key}.irreversible"),
        None if math.isnan(ascent) else ascent,
        channel.choices,
    )


def _fault(output: Output, channel: Channel, board: VehicleCodec) -> str:
    """Return the first error of an output, "" if there is none."""
    if not OutputFrame.NAME.fullmatch(output.name):
        return f"{output.name:.40} is no name: {_NAME}"
    if math.isnan(output.safe):
        return "say what it is in an emergency (safe): its document does not tell"
    for word, value in (("low", output.low), ("high", output.high)):
        if fault := channel.fault(value):
            return f"{word} {fault}, which {channel.name} can carry"
    if output.low > output.high:
        return f"low {output.low:g} is above high {output.high:g}"
    for word, level in (("safe", output.safe), ("ascent", output.ascent)):
        if level is not None and (fault := output.fault(level)):
            return f"{word}: {fault}"
    if channel.final and not output.irreversible:
        return f"{channel.name} cannot be taken back: say irreversible: true"
    if output.ascent is not None and not output.irreversible:
        return "ascent is for what is irreversible: true; an emergency takes all others to safe"
    try:
        board.take_outputs({channel.name: output.high})
    except CannotEncode as error:
        return str(error)
    return ""


def read_readings(file: Tables, codec: str) -> Mapping[str, str]:
    """Return the source of each name in the file."""
    sources = [source.name for source in vehicle_row(codec).sources]
    found = {name: file.text(f"readings.{name}") for name in file.names("readings")}
    for name, source in found.items():
        if not OutputFrame.NAME.fullmatch(name):
            file.refuse(f"readings.{name}", f"{name:.40} is no name", _NAME)
        if source not in sources:
            there = ", ".join(sources) or "nothing"
            message = f"{codec} reports no {source:.40}"
            file.refuse(f"readings.{name}", message, f"it reports: {there}")
    return found
