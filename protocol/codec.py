"""What the runtime asks of every codec, and nothing else. The rows are in ``protocol.vehicles``.

A codec is sans-IO: bytes and times go in, messages come out. A candidate frame that stays
unfinished is given up after an idle time (G3): that is what ``next_timer`` is for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from protocol.messages import Ack, FrameFault, Order, Setpoint, Telemetry

Received = Telemetry | Ack | FrameFault


class CannotEncode(ValueError):
    """The vehicle has no word for this value; says which field, why, and what is possible."""


@dataclass(frozen=True, slots=True)
class Granularity:
    """The steps in which a vehicle can be told what to hold, m and rad; 0: as fine as a float.

    ``encode`` takes what lies between two steps and sends the nearer one.
    """

    depth: float = 0.0
    altitude: float = 0.0
    heading: float = 0.0
    attitude: float = 0.0  # pitch and roll


FINE = Granularity()


class VehicleCodec(Protocol):
    """Telemetry in, Setpoint out, for one link to one vehicle. ``levels``: what its channels are,
    by name."""

    levels: Mapping[str, float]

    def receive(self, data: bytes, now: float) -> list[Received]:
        """Everything that is complete with these bytes, in their order."""
        ...

    def next_timer(self) -> float | None:
        """When ``flush`` is due, or None."""
        ...

    def flush(self, now: float) -> list[Received]:
        """Give up what has been unfinished for the idle time, and yield what it held back."""
        ...

    def meaning_of_no(self, frame: bytes) -> str:
        """Why the vehicle has probably refused this frame, "" if nothing is known."""
        ...

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        """Frames to send in this order, each after the answer to the one before.

        Raises CannotEncode for what the vehicle cannot follow.
        """
        ...

    def take_outputs(self, levels: Mapping[str, float]) -> dict[str, bytes]:
        """What these channels beside the motion shall be from now on (protocol.vehicles.channels):
        the frames that say so by themselves, by what they set; what rides with the motion is in
        every later ``encode``. Raises CannotEncode."""
        ...
