"""The messages between topside and the Pi (document 000, chapters 1.1, 1.2, 2.1).

    TopsideCodec   the Pi's side:        bytes -> Command | FrameFault
    ConsoleCodec   the topside's side:   bytes -> Answer | FrameFault
    encode         any of these messages -> one frame

R and rudder commands and every M are relayed to the STM32 unchanged (``Relay`` and ``Manual`` keep
the frame). ``@ZAX0$`` and ``@ZAWF$`` are accepted from topside as well (R7).

What does not live here: the frame tables (``protocol.topside_frames``, ``protocol.status_frame``),
who may command and which answer follows (``mission.onboard.runtime.operator_server``), the modem's
envelope.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from protocol import topside_frames as tables
from protocol.ack_frame import AckFrame
from protocol.codec import CannotEncode
from protocol.fields import FrameType, Values
from protocol.framing import Frame, Framer
from protocol.messages import (
    Ack,
    Command,
    Emergency,
    Fix,
    FrameFault,
    Manual,
    Order,
    Relay,
    StateReport,
    Status,
    StoreReport,
    Telemetry,
)
from protocol.motion_frame import MotionFrame
from protocol.operator_words import WORDS, OperatorWord
from protocol.state_frame import MOST, StateFrame, fitted, values_of
from protocol.status_frame import NAMES, TABLE, StatusFrame
from protocol.tables import derived
from protocol.tolerances import Tolerances

Answer = Ack | StoreReport | StateReport | Status

EMERGENCIES = {Order.STOP: b"@ZAX0$", Order.SURFACE: b"@ZAWF$"}
IDLE = 0.05  # s; a network delivers whole frames
_USUAL = Tolerances()


def relayed_frames(tolerances: Tolerances) -> tuple[FrameType, ...]:
    """Return the frames for the STM32 that the Pi relays (tables 1.2.1 and 1.2.2)."""
    sticks = (tables.stick("MS", "speed", tolerances), tables.stick("MP", "force", tolerances))
    power = (tables.RS, tables.RI)
    return (*power, tables.MT, tables.MD, tables.D, tables.MM, tables.MR, *sticks)


def to_pi_frames(tolerances: Tolerances) -> tuple[FrameType, ...]:
    own = tuple(word.frame(tolerances) for word in WORDS.values())
    emergency = MotionFrame(tolerances, codes="XW")
    return (*own, *relayed_frames(tolerances), emergency)


def to_topside_frames(tolerances: Tolerances) -> tuple[FrameType, ...]:
    acks = AckFrame("NASRZ", tolerances, "XW")  # the Z codes are X and W (R7)
    status: tuple[FrameType, ...] = (StatusFrame(tolerances),)
    if tolerances.on("vs_no_vs"):
        status += (StatusFrame(tolerances, bare=True),)
    return (acks, tables.StoreFrame(), StateFrame(), *status)


# --- the Pi's side ---


_RELAYED = frozenset(("RS", "RI", "D"))


@derived(WORDS)
def _words_by_frame() -> dict[str, OperatorWord]:
    return {word.name: word for word in WORDS.values()}


@derived(WORDS)
def _words_by_code() -> dict[str, OperatorWord]:
    return {word.code: word for word in WORDS.values()}


def _letter(code: str) -> str:
    """Return the result letter for done; also of RS, which the STM32 answers."""
    return "S" if code == "RS" else _words_by_code()[code].letter


@derived(WORDS)
def _usual_frames() -> dict[type, FrameType]:
    """Return the frame types of the commands under the N readings."""
    return {word.message: word.frame(_USUAL) for word in WORDS.values()}


@derived(WORDS)
def _acks() -> AckFrame:
    return AckFrame("NASRZ", _USUAL)


def command_of(frame: Frame) -> Command:
    """Return the message of a frame of ``to_pi_frames``."""
    if (word := _words_by_frame().get(frame.type.name)) is not None:
        read: Command = word.read(frame.values())
        return read
    if frame.type.name == "auv.ZA":
        return Emergency(Order.STOP if frame.values()["code"] == "X" else Order.SURFACE)
    kind = frame.type.name.removeprefix("auv.")
    return (Relay if kind in _RELAYED else Manual)(kind, frame.raw)


class TopsideCodec:
    """The Pi's codec. One per connection, as each is a stream of its own."""

    def __init__(self, tolerances: Tolerances | None = None) -> None:
        self.framer = Framer(to_pi_frames(tolerances or Tolerances()), idle=IDLE)

    def receive(self, data: bytes, now: float) -> list[Command | FrameFault]:
        return _commands(self.framer.receive(data, now))

    def next_timer(self) -> float | None:
        return self.framer.next_timer()

    def flush(self, now: float) -> list[Command | FrameFault]:
        return _commands(self.framer.flush(now))


def _commands(items: Sequence[Frame | FrameFault]) -> list[Command | FrameFault]:
    return [i if isinstance(i, FrameFault) else command_of(i) for i in items]


# --- encoding: every message that crosses this link ---

_STORE, _STATE, _STATUS = tables.StoreFrame(), StateFrame(), StatusFrame(_USUAL)


def encode(message: Command | Answer, tolerances: Tolerances = _USUAL) -> bytes:
    """Encode one frame under the N readings; ``tolerances`` set the units of ``@VS``. Raises
    CannotEncode."""
    match message:
        case Relay(frame=frame) | Manual(frame=frame):
            return frame
        case Emergency(order=order):
            return EMERGENCIES[order]
        case Ack():
            return encode_ack(message)
        case Status():
            return _STATUS.encode(status_values(message, tolerances))
        case StateReport():
            return _encode_state(message)
        case StoreReport():
            return _STORE.encode(dataclasses.asdict(message))
        case _:
            kind = type(message)
            return _usual_frames()[kind].encode(WORDS[kind].write(message))


def _encode_state(report: StateReport) -> bytes:
    """Encode the report with its texts cut to fit."""
    size = len(_STATE.lead) + len(_STATE.format(values_of(report))) + 1
    return _STATE.encode(values_of(fitted(report, size) if size > MOST else report))


def encode_ack(ack: Ack) -> bytes:
    """Return the nine bytes; a mask is any raw byte. Raises CannotEncode."""
    raw = b"@ACK_%b%b%c$" % (ack.group.encode(), ack.function.encode(), ack.result)
    if _acks().check(raw) is not None:
        raise CannotEncode(f"no acknowledgement reads {ack}")
    return raw


def answer(code: str, ok: bool, now: float) -> Ack:
    """Return the Ack to the command of this code; if it was refused, the result is N (R2)."""
    return Ack(now, code[0], code[1], ord(_letter(code) if ok else "N"))


# units per m/s and per T, and the number of decimals (E-V16, E-V18)
_SPEEDS = {"cm/s": (100, 0), "m/s": (1.0, 2), "km/h": (3.6, 2), "kn": (3600 / 1852, 2)}
_MAGNETIC = {"nT": (1e9, 0), "uT": (1e6, 3)}


def status_values(status: Status, tolerances: Tolerances = _USUAL) -> Values:
    """Return the 30 values of ``@VS`` in wire units. A value that is unknown or outside the table's
    range is None: one broken sensor must not hide the other fields (G4)."""
    speed, field = _SPEEDS[tolerances["vs_speed"]], _MAGNETIC[tolerances["vs_mag"]]
    fix, telemetry = status.fix, status.telemetry or Telemetry(0.0)
    values: Values = {"time": status.time}
    values |= {
        "lon_deg": _degrees(fix.longitude) if fix else None,
        "lat_deg": _degrees(fix.latitude) if fix else None,
        "elevation_m": _rounded(fix.elevation, 2) if fix else None,
        "ground_speed": _scaled(fix.speed, *speed) if fix else None,
        "ground_course_deg": _degrees(fix.course, 2) if fix else None,
        "heading_deg": _yaw(telemetry.heading),
        "pitch_deg": _degrees(telemetry.pitch, 2),
        "roll_deg": _degrees(telemetry.roll, 2),
        "temperature_c": _rounded(telemetry.temperature_c, 2),
        "depth_m": _rounded(telemetry.depth, 3),
        "altitude_m": _rounded(telemetry.altitude, 3),
    }
    lists = (telemetry.batteries, telemetry.magnetic, telemetry.actuators)
    batteries, magnetic, actuators = (x or () for x in lists)
    tail = [_rounded(b, 3) for b in _filled(batteries, 2)]
    tail += [_scaled(m, *field) for m in _filled(magnetic, 9)]
    tail += [None if a is None else _scaled(3 + a, 500) for a in _filled(actuators, 7)]
    names = [item for item in NAMES if item not in values]
    values |= dict(zip(names, tail, strict=True))
    for item in TABLE:
        value = values[item.name]
        if isinstance(value, int | float) and not (
            item.low <= value <= item.high and abs(value) < _ABSURD
        ):
            values[item.name] = None
    return values


_ABSURD = 1e8  # far above any reading of this vehicle


def _filled(values: Sequence[float | None], count: int) -> list[float | None]:
    return [*values[:count], *[None] * (count - len(values))]


def _rounded(value: float | None, places: int) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, places)


def _scaled(value: float | None, factor: float, places: int = 0) -> float | None:
    if value is None or not math.isfinite(value):
        return None
    return round(value * factor, places) if places else round(value * factor)


def _degrees(angle: float | None, places: int = 7) -> float | None:
    return None if angle is None else _rounded(math.degrees(angle), places)


def _yaw(heading: float | None) -> float | None:
    """Convert a compass heading, rad, to the yaw of ``@SD``, deg (E-V8, E-V10)."""
    if heading is None:
        return None
    return _degrees(-math.remainder(heading, 2 * math.pi), 2)


# --- the topside's side ---


def answer_of(frame: Frame, tolerances: Tolerances = _USUAL) -> Answer:
    """Return the message of a frame of ``to_topside_frames``."""
    if frame.type.name == "auv.ACK":
        return ack_of(frame)
    values = frame.values()
    if frame.type.name == "auv.VS":
        return status_of(values, frame.t, tolerances)
    return StateReport(**values) if frame.type.name == "auv.AES" else StoreReport(**values)


def ack_of(frame: Frame) -> Ack:
    raw = frame.raw
    return Ack(frame.t, chr(raw[5]), chr(raw[6]), raw[7])


def status_of(values: Values, now: float, tolerances: Tolerances = _USUAL) -> Status:
    """Convert the values of ``@VS`` to SI; ``now``: time of their arrival."""
    radians = {k: None if v is None else math.radians(v) for k, v in values.items() if _is_angle(k)}
    fix = None
    if radians["lon_deg"] is not None and radians["lat_deg"] is not None:
        speed = values["ground_speed"]
        fix = Fix(
            t=now,
            latitude=radians["lat_deg"],
            longitude=radians["lon_deg"],
            accuracy=math.inf,
            speed=None if speed is None else speed / _SPEEDS[tolerances["vs_speed"]][0],
            course=radians["ground_course_deg"],
            elevation=values["elevation_m"],
        )
    yaw, tesla = radians["heading_deg"], _MAGNETIC[tolerances["vs_mag"]][0]
    magnetic = _known([values[name] for name in NAMES if name.startswith("mag_")], tesla)
    pulses = [values[name] for name in NAMES if name.startswith("pwm_")]
    told = next((i for i, width in enumerate(pulses) if width is None), len(pulses))
    widths = pulses[:told]  # a vehicle with fewer thrusters leaves the last ones empty
    telemetry = Telemetry(
        t=now,
        depth=values["depth_m"],
        altitude=values["altitude_m"],
        heading=None if yaw is None else -yaw % (2 * math.pi),
        pitch=radians["pitch_deg"],
        roll=radians["roll_deg"],
        temperature_c=values["temperature_c"],
        magnetic=magnetic,
        actuators=tuple((w - 1500) / 500 for w in widths) or None,
        batteries=(values["battery_control"], values["battery_power"]),
        faults=tuple(f for f in values["flags"] if not f.endswith(":empty")),
    )
    return Status(values["time"], fix, telemetry)


def _is_angle(name: str) -> bool:
    return name.endswith("_deg")


def _known(values: Sequence[float | None], divisor: float) -> tuple[float, ...] | None:
    known = [v / divisor for v in values if v is not None]
    return tuple(known) if len(known) == len(values) else None


class ConsoleCodec:
    """The topside's codec. One per connection to a vehicle."""

    def __init__(self, tolerances: Tolerances | None = None) -> None:
        self._tolerances = chosen = tolerances or Tolerances()
        acks = AckFrame("NASRZ", chosen)  # Z: the STM32's own answer to X and W (R7)
        self.framer = Framer((acks, *to_topside_frames(chosen)[1:]), idle=IDLE)

    def receive(self, data: bytes, now: float) -> list[Answer | FrameFault]:
        return self._answers(self.framer.receive(data, now))

    def next_timer(self) -> float | None:
        return self.framer.next_timer()

    def flush(self, now: float) -> list[Answer | FrameFault]:
        return self._answers(self.framer.flush(now))

    def _answers(self, items: Sequence[Frame | FrameFault]) -> list[Answer | FrameFault]:
        known = self._tolerances
        return [i if isinstance(i, FrameFault) else answer_of(i, known) for i in items]
