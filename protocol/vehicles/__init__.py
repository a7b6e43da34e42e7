"""The registry: one row per vehicle, one row per link. A new vehicle is one file and its rows here.

``codec`` makes what the drive asks of a vehicle; ``LINKS`` is what ``decode --link`` knows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from protocol.codec import FINE, Granularity, VehicleCodec
from protocol.fields import FrameType
from protocol.framing import LinkRow
from protocol.messages import UPWARD, Order, Setpoint
from protocol.tolerances import Tolerances
from protocol.vehicles import auv, coreboard, motorcan, robot, rov

BatteryScale = tuple[float, float]


class UnknownVehicle(ValueError):
    """Says which there are."""


class UnknownDialect(ValueError):
    """Says which this vehicle has."""


@dataclass(frozen=True, slots=True)
class VehicleRow:
    """``make(dialect, tolerances, battery_scale)``, with one of its ``dialects``. ``ways``: what an
    ascent tries, in turn (R7); no two of them are the same bytes."""

    name: str
    make: Callable[[str, Tolerances, BatteryScale], VehicleCodec]
    dialects: tuple[str, ...]
    granularity: Granularity = FINE
    ways: tuple[Setpoint | Order, ...] = (Order.SURFACE, UPWARD, Order.STOP)


_THRUST_OR_NONE = (Order.SURFACE, Order.STOP)  # its SURFACE is full vertical thrust
_TO_THE_LETTER = ("documented",)
VEHICLES = (
    VehicleRow("auv", auv.AuvCodec, tuple(auv.DIALECTS), auv.GRANULARITY),
    VehicleRow("coreboard", coreboard.CoreboardCodec, _TO_THE_LETTER, ways=_THRUST_OR_NONE),
    VehicleRow("motorcan", motorcan.MotorCodec, _TO_THE_LETTER, ways=_THRUST_OR_NONE),
    VehicleRow("rov", rov.RovCodec, _TO_THE_LETTER, ways=_THRUST_OR_NONE),
    VehicleRow("robot", robot.RobotCodec, _TO_THE_LETTER, ways=(Order.SURFACE,)),
)

LINKS: tuple[LinkRow, ...] = (
    *auv.LINKS,
    *coreboard.LINKS,
    *motorcan.LINKS,
    *rov.LINKS,
    *robot.LINKS,
)


def codec(
    name: str,
    dialect: str,
    tolerances: Mapping[str, str],
    battery_scale: BatteryScale = (1.0, 1.0),
) -> VehicleCodec:
    """A fresh codec. Raises UnknownVehicle, UnknownDialect or UnknownTolerance."""
    row = vehicle_row(name)
    if dialect not in row.dialects:
        known = ", ".join(row.dialects)
        raise UnknownDialect(f"no dialect {dialect!r} of {name}; there are: {known}")
    return row.make(dialect, Tolerances.parse(tolerances), battery_scale)


def vehicle_row(name: str) -> VehicleRow:
    """Raises UnknownVehicle."""
    for row in VEHICLES:
        if row.name == name:
            return row
    raise UnknownVehicle(f"no vehicle {name!r}; there are: {', '.join(r.name for r in VEHICLES)}")


def link(name: str) -> LinkRow:
    """Raises UnknownVehicle, which names the links there are."""
    for row in LINKS:
        if row.name == name:
            return row
    raise UnknownVehicle(f"no link {name!r}; there are: {', '.join(r.name for r in LINKS)}")


def frame_types(tolerances: Tolerances | None = None) -> dict[str, FrameType]:
    """Every type of every link by its name; where links differ in scope, the widest one."""
    found: dict[str, FrameType] = {}
    for row in LINKS:
        for frame in row.frames(tolerances or Tolerances()):
            found.setdefault(frame.name, frame)
    return found
