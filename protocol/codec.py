"""What the drive asks of every codec, and nothing else. The rows are in ``protocol.vehicles``.

A codec is sans-IO: bytes and times go in, messages come out. A candidate frame that stays
unfinished is given up after an idle time (G3): that is what ``next_timer`` is for.
"""

from __future__ import annotations

from typing import Protocol

from protocol.messages import Ack, FrameFault, Order, Setpoint, Telemetry

Received = Telemetry | Ack | FrameFault


class CannotEncode(ValueError):
    """The vehicle has no word for this value; says which field, why, and what is possible."""


class VehicleCodec(Protocol):
    """Telemetry in, Setpoint out, for one link to one vehicle."""

    def receive(self, data: bytes, now: float) -> list[Received]:
        """Everything that is complete with these bytes, in their order."""
        ...

    def next_timer(self) -> float | None:
        """When ``flush`` is due, or None."""
        ...

    def flush(self, now: float) -> list[Received]:
        """Give up what has been unfinished for the idle time, and yield what it held back."""
        ...

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        """Frames to send in this order, each after the answer to the one before.

        Raises CannotEncode for what the vehicle cannot follow.
        """
        ...
