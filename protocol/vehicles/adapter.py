"""The common part of the adapters of boards that acknowledge nothing.

The boards of documents 002, 003 and 004 acknowledge no command. The frames of a setpoint are sent
again every ``period`` seconds while it is in force; after ``silence`` seconds without a frame the
board goes neutral by itself (R16, R17).

What does not live here: any vehicle's table, units or signs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from protocol.codec import CannotEncode, Received
from protocol.fields import Values
from protocol.framing import Frame, Framer
from protocol.messages import Order, Setpoint
from protocol.vehicles.channels import Channel, at_rest
from protocol.vehicles.keys import Wire
from protocol.vehicles.stick import steered


class SilentBoard:
    """A ``VehicleCodec`` that also takes the stick's commands. ``message`` returns None for a frame
    that reports nothing. ``wire``: the values of its keys."""

    period: float  # s between repetitions of the setpoint in force
    silence: float  # s without a frame after which the board goes neutral
    kept_awake = ""  # why neutral is sent before any command; "": it is not sent
    channels: tuple[Channel, ...] = ()

    def __init__(
        self, framer: Framer, message: Callable[[Frame], Received | None], wire: Wire
    ) -> None:
        self.framer, self._message, self._wire = framer, message, wire
        self.levels = at_rest(self.channels)

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        raise NotImplementedError

    def take_outputs(self, levels: Mapping[str, float]) -> dict[str, bytes]:
        self.levels = {**self.levels, **levels}
        return {}

    def meaning_of_no(self, frame: bytes) -> str:
        """Return "": these boards send no refusals."""
        return ""

    def stick(self, held: Setpoint, word: bytes) -> Setpoint:
        """Return the setpoint after the M command ``word``; ``held``: the stick's setpoint before.
        Raises CannotEncode."""
        return steered(held, word, self._wire)

    def receive(self, data: bytes, now: float) -> list[Received]:
        return self._messages(self.framer.receive(data, now))

    def next_timer(self) -> float | None:
        return self.framer.next_timer()

    def flush(self, now: float) -> list[Received]:
        return self._messages(self.framer.flush(now))

    def _messages(self, items: Sequence[Any]) -> list[Received]:
        read = (self._message(item) if isinstance(item, Frame) else item for item in items)
        return [message for message in read if message is not None]


def radians_of(values: Values, name: str) -> float | None:
    degrees = values[name]
    return None if degrees is None else math.radians(degrees)


def heading_of(values: Values, name: str) -> float | None:
    """Return a clockwise yaw in degrees as a heading in [0, 2 pi)."""
    degrees = values[name]
    return None if degrees is None else math.radians(degrees) % math.tau


def fraction(axis: str, value: float) -> float:
    if not -1.0 <= value <= 1.0:
        raise CannotEncode(f"{axis}: {value} is outside -1..1")
    return value


def refuse(setpoint: Setpoint, **reasons: str) -> None:
    """Raise CannotEncode if the setpoint uses an axis that the vehicle lacks; ``reasons``: why, by
    axis. 0 of surge, turn or heave asks for nothing; 0 of heading, depth, altitude, pitch or roll
    does."""
    for axis, why in reasons.items():
        value = getattr(setpoint, axis)
        if value is None or (value == 0.0 and axis in ("surge", "turn", "heave")):
            continue
        raise CannotEncode(f"{axis}: {why}")


def fights(channel: Channel, setpoint: Setpoint | Order) -> bool:
    """Whether the channel excludes axes and must be at rest now: for any order, or while the
    setpoint uses one of them."""
    if isinstance(setpoint, Order):
        return bool(channel.excludes)
    values = (getattr(setpoint, axis) for axis in channel.excludes)
    return any(value is not None and value != 0.0 for value in values)
