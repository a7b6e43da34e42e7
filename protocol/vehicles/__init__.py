"""The registry: one row per vehicle. A new vehicle is one file and its row here.

``codec`` makes what the runtime asks of a vehicle; ``links`` is what ``decode --link`` knows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from protocol import nmea_frame
from protocol.codec import FINE, Granularity, VehicleCodec
from protocol.fields import FrameType
from protocol.framing import LinkRow
from protocol.messages import UPWARD, Order, Setpoint
from protocol.tables import Table
from protocol.tolerances import Tolerances
from protocol.vehicles import (
    auv,
    auv_outputs,
    coreboard,
    mainboard,
    motorcan,
    robot,
    robot_outputs,
    rov,
)
from protocol.vehicles.channels import Channel, Source
from protocol.vehicles.keys import Keys, Wire, read_wire

BatteryScale = tuple[float, float]
NO_WIRE: Mapping[str, str] = {}


class UnknownVehicle(ValueError):
    """Says which there are."""


class UnknownDialect(ValueError):
    """Says which this vehicle has."""


@dataclass(frozen=True, slots=True)
class VehicleRow:
    """``make(dialect, tolerances, battery_scale, wire)``, with one of its ``dialects`` and values
    of its ``keys``. ``ways``: what an ascent tries, in turn (R7); no two are the same bytes.
    ``channels`` can be set beside the motion, ``sources`` be read beside the telemetry. ``links``
    are those that ``decode`` knows; ``examples`` one good frame of each type. ``manual_ends``: how
    the journal puts it that a stop ends the board's own manual; "" where it has none."""

    name: str
    make: Callable[[str, Tolerances, BatteryScale, Wire], VehicleCodec]
    dialects: tuple[str, ...]
    keys: Keys
    granularity: Granularity = FINE
    ways: tuple[Setpoint | Order, ...] = (Order.SURFACE, UPWARD, Order.STOP)
    channels: tuple[Channel, ...] = ()
    sources: tuple[Source, ...] = ()
    links: tuple[LinkRow, ...] = ()
    examples: tuple[tuple[str, bytes], ...] = ()
    manual_ends: str = ""


_THRUST_OR_NONE = (Order.SURFACE, Order.STOP)  # its SURFACE is full vertical thrust


def silent(
    name: str,
    make: Callable[[str, Tolerances, BatteryScale, Wire], VehicleCodec],
    keys: Keys,
    ways: tuple[Setpoint | Order, ...] = _THRUST_OR_NONE,
    channels: tuple[Channel, ...] = (),
    sources: tuple[Source, ...] = (),
    links: tuple[LinkRow, ...] = (),
    examples: tuple[tuple[str, bytes], ...] = (),
) -> VehicleRow:
    """A board that acknowledges nothing, and is spoken to as its document says."""
    return VehicleRow(
        name, make, ("documented",), keys, FINE, ways, channels, sources, links, examples
    )


VEHICLES: Table[str, VehicleRow] = Table(
    lambda row: row.name,
    (
        VehicleRow(
            "auv",
            auv.AuvCodec,
            tuple(auv.DIALECTS),
            auv.KEYS,
            auv.GRANULARITY,
            channels=auv_outputs.CHANNELS,
            sources=auv_outputs.SOURCES,
            links=auv.LINKS,
            manual_ends="the STM32 back to automatic",
        ),
        silent(
            "coreboard",
            coreboard.CoreboardCodec,
            coreboard.KEYS,
            channels=coreboard.CHANNELS,
            sources=coreboard.SOURCES,
            links=coreboard.LINKS,
        ),
        silent("motorcan", motorcan.MotorCodec, motorcan.KEYS, links=motorcan.LINKS),
        silent(
            "mainboard",
            mainboard.MainboardCodec,
            mainboard.KEYS,
            channels=mainboard.CHANNELS,
            sources=mainboard.SOURCES,
        ),
        silent(
            "rov",
            rov.RovCodec,
            rov.KEYS,
            channels=rov.CHANNELS,
            sources=rov.SOURCES,
            links=rov.LINKS,
        ),
        silent(
            "robot",
            robot.RobotCodec,
            robot.KEYS,
            (Order.SURFACE,),
            robot_outputs.CHANNELS,
            robot_outputs.SOURCES,
            robot.LINKS,
        ),
    ),
    lambda row, others: _fault(row, others),
)


def _fault(row: VehicleRow, others: Iterable[VehicleRow]) -> str:
    taken = {link.name for other in others for link in other.links}
    twice = sorted(taken & {link.name for link in row.links})
    return f"{row.name}: the link {twice[0]} is there already" if twice else ""


def links() -> tuple[LinkRow, ...]:
    """Of all vehicles, in their order."""
    return tuple(link for row in VEHICLES.values() for link in row.links)


READ_ONLY = (nmea_frame.LINK,)  # no vehicle's: nothing is encoded for these


def codec(
    name: str,
    dialect: str,
    tolerances: Mapping[str, str],
    battery_scale: BatteryScale = (1.0, 1.0),
    wire: Mapping[str, str] = NO_WIRE,
) -> VehicleCodec:
    """A fresh codec. Raises UnknownVehicle, UnknownDialect, UnknownTolerance or UnknownKey."""
    row = vehicle_row(name)
    if dialect not in row.dialects:
        known = ", ".join(row.dialects)
        raise UnknownDialect(f"no dialect {dialect!r} of {name}; there are: {known}")
    read = read_wire(row.keys, wire)
    return row.make(dialect, Tolerances.parse(tolerances), battery_scale, read)


def line_rate(name: str, wire: Mapping[str, str] = NO_WIRE) -> int:
    """bit/s of the vehicle's line. Raises UnknownVehicle or UnknownKey."""
    rate: int = read_wire(vehicle_row(name).keys, wire)["baud"]
    return rate


def vehicle_row(name: str) -> VehicleRow:
    """Raises UnknownVehicle."""
    row = VEHICLES.get(name)
    if row is None:
        raise UnknownVehicle(f"no vehicle {name!r}; there are: {', '.join(VEHICLES)}")
    return row


def link(name: str) -> LinkRow:
    """Raises UnknownVehicle, which names the links there are."""
    rows = (*links(), *READ_ONLY)
    for row in rows:
        if row.name == name:
            return row
    raise UnknownVehicle(f"no link {name!r}; there are: {', '.join(r.name for r in rows)}")


def frame_types(tolerances: Tolerances | None = None) -> dict[str, FrameType]:
    """Every type of every link by its name; where links differ in scope, the widest one."""
    found: dict[str, FrameType] = {}
    for row in links():
        for frame in row.frames(tolerances or Tolerances()):
            found.setdefault(frame.name, frame)
    return found
