"""Each vehicle's line in this proof: the bytes of its reports and of the frames that it receives.

    AUV        @SD every 2 s, an acknowledgement of each Z; its commands are those of the laws
    a board    of documents 002 to 004: its own report, by the table of its codec and at its own
               period; no acknowledgement. Its frames are translated into the commands of the laws

    what a frame means                                         its word, as the laws read it
    X, full thrust upward, full thrust downward                @ZAX0$, @ZAU12$, @ZAD12$
    anything else that the engine asks for                     @ZA= and what moves
    what the stick asks for, and neutral 600 ms after it       @M= and what moves
    the own command of an output, which moves nothing          @O= and the frame

What does not live here: the sea (wire), when anything is sent (world), what frames mean (speech).
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Protocol

from mission.model import Position
from mission.model.vehicle import Vehicle
from mission.verification.exhaustive.wire import Land, Sea, answer, place_of, sd
from mission.verification.rig.speech import MOTION, Motion, Speech
from protocol.codec import VehicleCodec
from protocol.fields import BinaryFrame, Number
from protocol.messages import UPWARD, Order, Setpoint
from protocol.tolerances import Tolerances
from protocol.vehicles import codec, coreboard, robot, rov, vehicle_row
from protocol.vehicles.adapter import SilentBoard

_Values = Callable[[Sea, Position, Tolerances], Mapping[str, Any]]
X, W, U12, D12 = b"@ZAX0$", b"@ZAWF$", b"@ZAU12$", b"@ZAD12$"
STICK, OUTPUT = b"@M=", b"@O="
HELD = " (held)"  # the end of the reason of a frame that repeats a command in force
LET_GO = "no M for 600 ms"  # the beginning of the reason of neutral after the stick
# What an event, a way or a law may need of a vehicle, besides the reports that its file lists.
ANSWERS, WATER, GPS, THRUSTERS = "answers", "water", "gps", "thrusters"
REPEATS = "repeats"  # commands in force are sent repeatedly
NO_TEMPERATURE = "temperature unknown"  # its report can leave the temperature unknown
PUSHES = "pushes told"  # its reports show which way the vertical thrusters push


class Line(Protocol):
    """A vehicle's line. ``board``: the codec of a board that is sent the command in force
    repeatedly; None: the board acknowledges. ``word`` translates bytes that leave into the words
    of the laws; ``words``: the words of a command; ``stops``: whether nothing turns after it;
    ``steers``: whether there are frames for this M. ``period``: s between two reports."""

    @property
    def vehicle(self) -> Vehicle: ...
    @property
    def period(self) -> float: ...
    @property
    def has(self) -> frozenset[str]: ...
    @property
    def board(self) -> SilentBoard | None: ...
    def sea(self) -> Sea: ...
    def report(self, sea: Sea, home: Position) -> bytes: ...
    def answer(self, frame: bytes, letter: str) -> bytes: ...
    def stops(self, word: bytes) -> bool: ...
    def words(self, command: Setpoint | Order) -> tuple[bytes, ...]: ...
    def word(self, data: bytes, reason: str) -> bytes: ...
    def steers(self, word: bytes) -> bool: ...


@dataclass(frozen=True, slots=True, eq=False)
class AuvLine:
    """The line of the AUV's STM32."""

    vehicle: Vehicle
    codec: VehicleCodec
    has: frozenset[str]
    period: float = 2.0  # s
    board: SilentBoard | None = None

    def sea(self) -> Sea:
        return Sea()

    def report(self, sea: Sea, home: Position) -> bytes:
        return sd(sea)

    def answer(self, frame: bytes, letter: str) -> bytes:
        return answer(frame, letter, self.vehicle.dialect)

    def stops(self, word: bytes) -> bool:
        return word == X

    def words(self, command: Setpoint | Order) -> tuple[bytes, ...]:
        return tuple(self.codec.encode(command))

    def word(self, data: bytes, reason: str) -> bytes:
        return data

    def steers(self, word: bytes) -> bool:
        return True


@dataclass(frozen=True, slots=True, eq=False)
class BoardLine:
    """The line of a board of documents 002 to 004."""

    vehicle: Vehicle
    speech: Speech
    frame: BinaryFrame
    values: _Values
    tolerances: Tolerances
    has: frozenset[str]
    period: float

    @property
    def board(self) -> SilentBoard | None:
        return self.speech.board

    def sea(self) -> Sea:
        return (Land if self.vehicle.drives else Sea)(control_v=_FULL_V)

    def report(self, sea: Sea, home: Position) -> bytes:
        values = self.values(sea, home, self.tolerances).items()
        told = {name: None if value != value else value for name, value in values}
        return self.frame.encode(told)

    def answer(self, frame: bytes, letter: str) -> bytes:
        return b""

    def stops(self, word: bytes) -> bool:
        """Whether it is X, or what the stick sends to stop."""
        return word == X or word in [STICK + _shown(m) for m in self.speech.words[X]]

    def words(self, command: Setpoint | Order) -> tuple[bytes, ...]:
        """Return the words of a command; () if the board has no frame for it."""
        return tuple(self._word(motion) for motion in self.speech.motions(command))

    def word(self, data: bytes, reason: str) -> bytes:
        motion = self.speech.motion(data)
        if not motion:
            return OUTPUT + data
        if reason.startswith(("relay of", LET_GO)):
            return STICK + _shown(motion)
        return self.speech.word(data) or b"@ZA=" + _shown(motion)

    def _word(self, motion: Motion) -> bytes:
        meant = (word for word, motions in self.speech.words.items() if motion in motions)
        return next(meant, b"@ZA=" + _shown(motion))

    def steers(self, word: bytes) -> bool:
        return self.speech.steers(word)


def _shown(motion: Motion) -> bytes:
    return json.dumps(dict(motion), sort_keys=True).encode()


def told(sensor: str) -> frozenset[str]:
    """Return what an event about this reading needs."""
    return frozenset({sensor})


def ways_of(line: Line) -> tuple[bytes, ...]:
    """Return what ascents try in turn on this line, by the last word of each way."""
    return tuple(line.words(way)[-1] for way in vehicle_row(line.vehicle.codec).ways)


def surface_word(line: Line) -> bytes:
    """Return the word of W on this line."""
    return line.words(Order.SURFACE)[0]


def upward(line: Line) -> list[bytes]:
    """Return the words of full thrust upward; for a vehicle on the ground, X."""
    return list(line.words(UPWARD)) or [X]


# --- what a board reports ------------------------------------------------------------------------

_NEWS_DEG = 1e-6  # by which each position of an INS differs from the one before
_FULL_V = 24.0
_FULL_RPM = 500  # of a thruster that pushes; the sign is its direction


def _coreboard(sea: Sea, home: Position, tolerances: Tolerances) -> Mapping[str, Any]:
    told, (latitude, longitude) = sea.told(), place_of(sea, home)
    wet = int(tolerances["leak002"])
    return {
        "roll_deg": told["roll"],
        "pitch_deg": told["pitch"],
        "yaw_deg": _clockwise(told["yaw"]),
        "lat_deg": math.degrees(latitude) + _NEWS_DEG * (sea.count % 5),
        "lon_deg": math.degrees(longitude),
        **dict.fromkeys(("x_m", "y_m"), 0.0),
        "depth_m": told["depth"],
        "altitude_m": told["altitude"],
        "avoid_m": 50.0,
        "reserved50": "00" * 12,
        "mode": 0,
        "temperature_c": sea.temperature,
        "control_v": sea.control_v,
        "power_v": 48.0,
        "leak": wet if sea.leak else 1 - wet,
        **{f"usbl{n}": 0.0 for n in range(1, 7)},
        "ins_aligned": int(sea.placed),
        "reserved83": "00" * 4,
    }


def _rov(sea: Sea, home: Position, tolerances: Tolerances) -> Mapping[str, Any]:
    told = sea.told()
    on = _FULL_RPM if sea.pushes else 0
    up = -on if sea.dives else on
    return {
        **dict.fromkeys(("ax_g", "ay_g", "gx_dps", "gy_dps", "gz_dps"), 0.0),
        "az_g": -1.0,
        "ex_deg": told["roll"],
        "ey_deg": told["pitch"],
        "ez_deg": _clockwise(told["yaw"]),
        "depth_m": told["depth"],
        **dict.fromkeys(("rpm_left_front", "rpm_right_front"), on),
        **dict.fromkeys(("rpm_left_up", "rpm_right_up"), up),
        "temperature_c": round(sea.temperature),
        "metal_pct": 0,
    }


def _robot(sea: Sea, home: Position, tolerances: Tolerances) -> Mapping[str, Any]:
    return {
        "speed_mm_s": 500 if sea.pushes else 0,
        "voltage_mv": round(1000 * sea.control_v),
    }


def _clockwise(yaw: float) -> float:
    """The AUV's yaw grows to port."""
    return -yaw


_Made = tuple[Callable[[Tolerances], BinaryFrame], _Values, frozenset[str]]
_BOARDS: Mapping[str, _Made] = MappingProxyType(
    {
        "coreboard": (coreboard.main_to_pc, _coreboard, frozenset({WATER})),
        "rov": (rov.up, _rov, frozenset({WATER, THRUSTERS})),
        "robot": (robot.up, _robot, frozenset()),
    }
)
SPOKEN = ("auv", *_BOARDS)  # the codecs whose frames this proof has
assert set(_BOARDS) <= set(MOTION)


def line_of(vehicle: Vehicle) -> Line:
    """Return the line of a vehicle. Raises KeyError for a codec that is not in SPOKEN."""
    if vehicle.codec == "auv":
        own = {ANSWERS, WATER, GPS, THRUSTERS, NO_TEMPERATURE, PUSHES}
        return AuvLine(vehicle, codec(*vehicle.speaks), vehicle.reports | own)
    make, values, own_of = _BOARDS[vehicle.codec]
    tolerances = Tolerances.parse(vehicle.tolerances)
    return BoardLine(
        vehicle,
        Speech(vehicle),
        _unbounded(make(tolerances)),
        values,
        tolerances,
        vehicle.reports | own_of | {REPEATS},
        vehicle.sensors.telemetry_period,
    )


def _unbounded(frame: BinaryFrame) -> BinaryFrame:
    """Return the same frame without bounds of its values, so that broken ones can be sent, too."""
    fields = (
        replace(field, low=None, high=None, choices=()) if isinstance(field, Number) else field
        for field in frame.fields
    )
    return BinaryFrame(frame.name, frame.title, tuple(fields))
