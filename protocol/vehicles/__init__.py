"""The registry: one row per vehicle. A new vehicle is one file and its row here.

``codec`` makes a vehicle's codec for the runtime; ``links`` returns the links of ``decode --link``.
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
    """No such vehicle or link; the text lists those that exist."""


class UnknownDialect(ValueError):
    """No such dialect; the text lists those of this vehicle."""


@dataclass(frozen=True, slots=True)
class VehicleRow:
    """One vehicle. ``make(dialect, tolerances, battery_scale, wire)`` returns its codec, for one of
    its ``dialects`` and values of its ``keys``. ``ways``: the commands that an ascent tries in turn
    (R7); no two are the same bytes. ``channels`` can be set beside the motion, ``sources`` be read
    beside the telemetry. ``links``: those for ``decode``. ``examples``: one good frame of each
    type. ``manual_ends``: the journal's words when a stop ends the board's own manual mode; "" if
    it has none."""

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
    """Return the row of a board that acknowledges nothing and has one dialect, its document's."""
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
    """Return the links of all vehicles, in the order of the vehicles."""
    return tuple(link for row in VEHICLES.values() for link in row.links)


READ_ONLY = (nmea_frame.LINK,)  # links of no vehicle, which are decoded only


def codec(
    name: str,
    dialect: str,
    tolerances: Mapping[str, str],
    battery_scale: BatteryScale = (1.0, 1.0),
    wire: Mapping[str, str] = NO_WIRE,
) -> VehicleCodec:
    """Return a new codec. Raises UnknownVehicle, UnknownDialect, UnknownTolerance or UnknownKey."""
    row = vehicle_row(name)
    if dialect not in row.dialects:
        known = ", ".join(row.dialects)
        raise UnknownDialect(f"no dialect {dialect!r} of {name}; there are: {known}")
    read = read_wire(row.keys, wire)
    return row.make(dialect, Tolerances.parse(tolerances), battery_scale, read)


def line_rate(name: str, wire: Mapping[str, str] = NO_WIRE) -> int:
    """Return the rate of the vehicle's line, bit/s. Raises UnknownVehicle or UnknownKey."""
    rate: int = read_wire(vehicle_row(name).keys, wire)["baud"]
    return rate


def vehicle_row(name: str) -> VehicleRow:
    """Return the row of a vehicle. Raises UnknownVehicle."""
    row = VEHICLES.get(name)
    if row is None:
        raise UnknownVehicle(f"no vehicle {name!r}; there are: {', '.join(VEHICLES)}")
    return row


def link(name: str) -> LinkRow:
    """Return a link by its name. Raises UnknownVehicle, whose text lists the links."""
    rows = (*links(), *READ_ONLY)
    for row in rows:
        if row.name == name:
            return row
    raise UnknownVehicle(f"no link {name!r}; there are: {', '.join(r.name for r in rows)}")


def frame_types(tolerances: Tolerances | None = None) -> dict[str, FrameType]:
    """Return all frame types of all links by name. If links differ in scope, the widest type."""
    found: dict[str, FrameType] = {}
    for row in links():
        for frame in row.frames(tolerances or Tolerances()):
            found.setdefault(frame.name, frame)
    return found
