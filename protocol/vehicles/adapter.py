"""What the adapters of vehicles that answer nothing share: frames in, bounds on the way out.

The boards of documents 002, 003 and 004 acknowledge no command: a setpoint's frames are sent again
every ``period`` seconds for as long as it holds, and the board goes neutral by itself after
``silence`` (R16, R17).

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
    """A ``VehicleCodec`` with a stick. ``message`` gives None for what says
    nothing; ``wire``: the values of its keys."""

    period: float  # s between frames that say what holds
    silence: float  # s after which it goes neutral
    kept_awake = ""  # why it is told to stop though nothing is asked of it; "": it is not
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
        """It refuses nothing in words."""
        return ""

    def stick(self, held: Setpoint, word: bytes) -> Setpoint:
        """What an M asks for, upon what the stick held before. Raises CannotEncode."""
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
    """A yaw that grows clockwise as a heading in [0, 2 pi)."""
    degrees = values[name]
    return None if degrees is None else math.radians(degrees) % math.tau


def fraction(axis: str, value: float) -> float:
    if not -1.0 <= value <= 1.0:
        raise CannotEncode(f"{axis}: {value} is outside -1..1")
    return value


def refuse(setpoint: Setpoint, **reasons: str) -> None:
    """Axes that the vehicle does not have, each with the reason; 0 asks for nothing but on an
    axis that holds a value (heading, depth, altitude, pitch, roll)."""
    for axis, why in reasons.items():
        value = getattr(setpoint, axis)
        if value is None or (value == 0.0 and axis in ("surge", "turn", "heave")):
            continue
        raise CannotEncode(f"{axis}: {why}")


def fights(channel: Channel, setpoint: Setpoint | Order) -> bool:
    """Whether it has to be at rest now: an order, or an axis that it excludes."""
    if isinstance(setpoint, Order):
        return bool(channel.excludes)
    values = (getattr(setpoint, axis) for axis in channel.excludes)
    return any(value is not None and value != 0.0 for value in values)
