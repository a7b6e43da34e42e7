"""What each vehicle's line is to this proof: the bytes that it reports in, and those it is told in.

    AUV        @SD every 2 s, an acknowledge of each Z; its words are those of the laws
    a board    of documents 002 to 004: its own report, by the table of its codec and at its own
               period; no acknowledge. What it is told is put in the words of the laws

    what a frame means                                         its word
    X, full thrust upward, full thrust downward                @ZAX0$, @ZAU12$, @ZAD12$
    anything else that the engine asks for                     @ZA= and what moves
    what the stick asks for, and neutral 600 ms behind it      @M= and what moves
    nothing that moves: an output's own word                   @O= and the frame

What does not live here: the sea (wire), when anything is said (world), what frames mean (speech).
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
HELD = " (held)"  # what the reason of what is said again ends with
LET_GO = "no M for 600 ms"  # what the reason of neutral behind a stick begins with
# What an event, a way or a law may need of a vehicle, beside what its file says that it reports.
ANSWERS, WATER, GPS, THRUSTERS = "answers", "water", "gps", "thrusters"
REPEATS = "repeats"  # what holds is said again and again
NO_TEMPERATURE = "temperature unknown"  # its frame can say that none is known
PUSHES = "pushes told"  # its reports say which way the verticals push


class Line(Protocol):
    """``board``: what repeats what holds; None: it acknowledges. ``word``: bytes that leave, in
    the words of the laws; ``words``: those of a command; ``stops``: nothing turns behind it;
    ``steers``: there are frames for this M."""

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
    """The STM32's."""

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
    """That of a board of documents 002 to 004."""

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
        """Under the stick, too."""
        return word == X or word in [STICK + _shown(m) for m in self.speech.words[X]]

    def words(self, command: Setpoint | Order) -> tuple[bytes, ...]:
        """() for what it cannot be told."""
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
    """What an event needs that is about a reading."""
    return frozenset({sensor})


def ways_of(line: Line) -> tuple[bytes, ...]:
    """What its ascents try in turn, by the last word of each."""
    return tuple(line.words(way)[-1] for way in vehicle_row(line.vehicle.codec).ways)


def surface_word(line: Line) -> bytes:
    """What W says on it."""
    return line.words(Order.SURFACE)[0]


def upward(line: Line) -> list[bytes]:
    """What says full thrust upward; on the ground a stop."""
    return list(line.words(UPWARD)) or [X]


# --- what a board reports ------------------------------------------------------------------------

_NEWS_DEG = 1e-6  # by which one place of an INS differs from the next
_FULL_V = 24.0
_FULL_RPM = 500  # of a thruster that pushes; the sign is its way


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
SPOKEN = ("auv", *_BOARDS)  # the codecs whose frames this proof knows
assert set(_BOARDS) <= set(MOTION)


def line_of(vehicle: Vehicle) -> Line:
    """Raises KeyError for a codec that is not SPOKEN."""
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
    """The same table, in which what is broken can be said, too."""
    fields = (
        replace(field, low=None, high=None, choices=()) if isinstance(field, Number) else field
        for field in frame.fields
    )
    return BinaryFrame(frame.name, frame.title, tuple(fields))
