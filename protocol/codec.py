"""The interface that the runtime needs of a vehicle's codec. The rows are in ``protocol.vehicles``.

A codec is sans-IO: bytes and times go in, messages come out. An unfinished candidate frame is given
up after an idle time (G3): ``next_timer`` returns when.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from protocol.messages import Ack, FrameFault, Order, Setpoint, Telemetry

Received = Telemetry | Ack | FrameFault


class CannotEncode(ValueError):
    """No frame can carry this value. The text names the field, the reason and what is possible."""


@dataclass(frozen=True, slots=True)
class Granularity:
    """Steps of the values that a vehicle can be asked to hold, m and rad; 0: as fine as a float.

    ``encode`` rounds a value to the nearest step.
    """

    depth: float = 0.0
    altitude: float = 0.0
    heading: float = 0.0
    attitude: float = 0.0  # pitch and roll


FINE = Granularity()


class VehicleCodec(Protocol):
    """Telemetry in, Setpoint out, for one link to one vehicle. ``levels``: the present level of
    each of its channels, by name."""

    levels: Mapping[str, float]

    def receive(self, data: bytes, now: float) -> list[Received]:
        """Return the messages that these bytes complete, in order."""
        ...

    def next_timer(self) -> float | None:
        """Return when ``flush`` is due, or None."""
        ...

    def flush(self, now: float) -> list[Received]:
        """Give up a candidate that was unfinished for the idle time. Return what it held back."""
        ...

    def meaning_of_no(self, frame: bytes) -> str:
        """Return why the vehicle has probably refused this frame, "" if nothing is known."""
        ...

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        """Return frames to send in this order, each after the answer to the one before.

        Raises CannotEncode if the vehicle cannot follow the setpoint.
        """
        ...

    def take_outputs(self, levels: Mapping[str, float]) -> dict[str, bytes]:
        """Set these output channels from now on (protocol.vehicles.channels). Return the frames to
        send for them, by what each frame sets. Channels that the motion's frames carry are in every
        later ``encode`` instead. Raises CannotEncode."""
        ...
