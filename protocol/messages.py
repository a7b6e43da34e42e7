"""The messages that every codec returns and accepts, whatever the bytes look like.

All values are in SI units and radians; the codecs convert degrees, gears and counts. ``None`` means
"not reported". Terms: heading is where the bow points (clockwise from north, [0, 2 pi)), depth is
below the surface, altitude above the bottom, heave is positive down (SNAME).

What does not live here: layouts (the vehicle's file), framing, rules of retry.
"""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass
from typing import NamedTuple


class Telemetry(NamedTuple):
    """One report of the vehicle's own sensors. A tuple, as a log has thousands.

    ``t`` is the engine's time at the arrival of the frame's first byte (R10). ``heading`` is as
    the compass gives it (magnetic, uncorrected). ``actuators`` are fractions -1..1 of full thrust
    in the order of the vehicle's row, rudders in rad where the vehicle reports them so.
    ``velocity`` is through the water, body axes (forward, starboard, down). ``faults`` names
    fields that were kept but are doubtful (``field:reason``). ``board`` has the report's other
    values, by the names and in the units of the vehicle's sources (protocol.vehicles.channels).
    """

    t: float
    depth: float | None = None
    altitude: float | None = None
    heading: float | None = None
    pitch: float | None = None  # nose up positive
    roll: float | None = None  # starboard down positive
    temperature_c: float | None = None
    magnetic: tuple[float, ...] | None = None  # T, three axes per magnetometer
    actuators: tuple[float, ...] | None = None
    batteries: tuple[float | None, ...] | None = None  # V: control, power
    position: tuple[float, float] | None = None  # latitude, longitude, rad
    velocity: tuple[float, float, float] | None = None
    leak: bool | None = None
    faults: tuple[str, ...] = ()
    board: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Fix:
    """One valid position from a GPS receiver; an invalid one never becomes a Fix."""

    t: float
    latitude: float  # rad
    longitude: float  # rad
    accuracy: float  # m, horizontal, one sigma per axis
    speed: float | None = None  # m/s over ground
    course: float | None = None  # rad over ground
    hdop: float | None = None
    elevation: float | None = None  # m
    satellites: int | None = None
    utc: str | None = None  # YYYY-MM-DDThh:mm:ss, where the sentence carries a date


@dataclass(frozen=True, slots=True)
class Aid:
    """A reading of a sensor that was added to the vehicle (protocol.added). ``values`` by kind:
    ``water`` speed ahead through the water, m/s; ``ground`` speed ahead and to starboard over
    ground, m/s; ``place`` latitude and longitude, rad; ``range`` number of the beacon and one-way
    travel time of sound, s."""

    t: float
    kind: str
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Setpoint:
    """A complete setpoint: all that the vehicle shall hold. An axis that is None is not controlled.

    ``surge`` and ``turn`` (starboard positive) are fractions -1..1. At most one of ``depth``,
    ``altitude`` and ``heave`` (positive down, -1..1) is set.
    """

    surge: float = 0.0
    turn: float = 0.0
    heave: float | None = None
    heading: float | None = None  # rad
    depth: float | None = None  # m
    altitude: float | None = None  # m
    pitch: float | None = None  # rad
    roll: float | None = None  # rad


class Order(enum.Enum):
    """The two safety commands. They are not setpoints, and go before everything else."""

    STOP = "stop"  # all thrusters off (AUV: ZAX0)
    SURFACE = "surface"  # emergency surfacing (AUV: ZAWF)


@dataclass(frozen=True, slots=True)
class Outputs:
    """The level of every output that the vehicle file names, in the units of its channel: lamps,
    servos, switches. Outputs are apart from motion: no setpoint and no order changes them."""

    levels: tuple[tuple[str, float], ...]


UPWARD = Setpoint(heave=-1.0)  # full vertical thrust and nothing else (AUV: ZAX0, ZAU12)


@dataclass(frozen=True, slots=True)
class Ack:
    """An acknowledgement ``@ACK_`` class function result.

    ``result`` is the raw byte: the command's own letter (as ``S`` for NS) or ``N``, ``Y``/``N`` for
    Z, a mask for NI and RI.
    """

    t: float
    group: str  # N A S R Z
    function: str  # second letter; for Z the code that is acknowledged (as-built: always A)
    result: int

    @property
    def ok(self) -> bool:
        return self.result != ord("N")


class FrameFault(NamedTuple):
    """Bytes that belong to no accepted frame. A value, never an exception; a tuple for speed, as
    noise gives one for every few bytes."""

    offset: int  # of the first byte, from the start of the stream
    kind: str  # docs/protocol.md: truncated, bad_header, bad_checksum, ...
    length: int  # bytes


# --- commands of an operator (document 000, tables 1.1 and 1.2), and the reports ---


@dataclass(frozen=True, slots=True)
class NodeSwitch:  # @NS
    switches: str  # six letters O/C: Pi, STM32, BDGPS, UACM, CAMERA, AUTO


@dataclass(frozen=True, slots=True)
class NodeQuery:  # @NI
    pass


@dataclass(frozen=True, slots=True)
class StartMission:  # @AA
    pass


@dataclass(frozen=True, slots=True)
class ClearMission:  # @AC
    pass


@dataclass(frozen=True, slots=True)
class MissionLine:  # @AW
    total: int
    current: int  # from 1
    payload: str


@dataclass(frozen=True, slots=True)
class StoreQuery:  # @AQ (R4)
    pass


@dataclass(frozen=True, slots=True)
class StoreReport:  # @AR (R4)
    state: str  # empty, staging, ready, running
    total: int
    have: int
    missing: str  # "3-5.9" or ""
    digest: str  # 16 hex digits or ""
    refusal: str  # the last one, "" if none


@dataclass(frozen=True, slots=True)
class StateQuery:  # @AE (R4)
    pass


@dataclass(frozen=True, slots=True)
class StateReport:  # @AE,1 (R4); None: not known. Ages count to the time of the answer.
    state: str  # region/substate, "autonomous" for every leg
    commander: str  # nobody, asker, network, modem
    report_age: float | None  # s
    fix_age: float | None  # s
    uncertainty_m: float | None  # 95 % radius
    north_m: float | None  # of the estimate from the last fix
    east_m: float | None
    to_depth_m: float | None  # left to the limit
    to_radius_m: float | None
    to_time: float | None  # min
    to_voltage_v: float | None
    alarms: int  # mask, one bit per alarm
    setpoint: str
    leg: str


@dataclass(frozen=True, slots=True)
class SetTime:  # @ST
    time: str  # YYYY-MM-DDThh:mm:ss, local time of the topside


@dataclass(frozen=True, slots=True)
class SetSafety:  # @SP; None keeps the previous value
    radius: float | None = None  # m
    time: float | None = None  # s
    depth: float | None = None  # m
    voltage: float | None = None  # V


@dataclass(frozen=True, slots=True)
class SetOutput:  # @AO (R4)
    name: str  # of the vehicle file
    value: float


@dataclass(frozen=True, slots=True)
class DataQuery:  # @DU
    pass


@dataclass(frozen=True, slots=True)
class Relay:
    """A frame for the STM32 that the Pi passes on unchanged: R, rudder ``@DA``/``@DS``."""

    kind: str  # RS, RI, D
    frame: bytes


@dataclass(frozen=True, slots=True)
class Manual:
    """Any M command: it is relayed unchanged, and puts the vehicle in manual (R6)."""

    kind: str  # MT MD MM MR MS MP
    frame: bytes

    @property
    def neutral(self) -> bool:
        """Whether it asks for no motion: its gear, speed, force or angle is 0."""
        numbers = re.findall(rb"-?\d+", self.frame[3:])
        first = self.kind in ("MS", "MP")  # speed or force, then the direction
        return bool(numbers) and int(numbers[0 if first else -1]) == 0


@dataclass(frozen=True, slots=True)
class Emergency:
    """``@ZAX0$`` or ``@ZAWF$`` from a topside connection (R7)."""

    order: Order


Command = (
    NodeSwitch
    | NodeQuery
    | StartMission
    | ClearMission
    | MissionLine
    | StoreQuery
    | StateQuery
    | SetTime
    | SetSafety
    | SetOutput
    | DataQuery
    | Relay
    | Manual
    | Emergency
)


@dataclass(frozen=True, slots=True)
class Status:
    """Contents of one ``@VS`` (document 000, table 2.1.2): the last fix and the newest telemetry.

    ``time`` is that of the telemetry (R10), None if the field is empty. A fix from ``@VS`` has an
    infinite ``accuracy``: the frame does not carry it.
    """

    time: str | None  # YYYY-MM-DDThh:mm:ss
    fix: Fix | None = None
    telemetry: Telemetry | None = None
