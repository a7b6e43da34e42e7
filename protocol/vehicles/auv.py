"""The AUV of document 000 as the Pi sees it on its serial line to the STM32 (9600 8N1).

    STM32 -> Pi   @SD every 2 s (86 bytes), @ACK_
    Pi -> STM32   @ZA.. (protocol.motion_frame), relayed R, M and rudder frames

Units and signs are converted once, here: yaw is positive to port, so heading = -yaw; PWM 1000..
2000 us become -1..1 (no pulse is neutral; for other widths see ``sd_stream.fractions_of``);
magnetometers are uT on the wire. Actuators in order: left main, right main, rear, left and right
vertical thruster, left and right servo.

Two dialects of the Z class:

    documented   every command sets its own axis
    as-built     one horizontal mode (F B L R H), one vertical mode (U D S E), one speed for both;
                 a heading is held while moving by @ZAH-20,4$ only; A does nothing

The commands of a setpoint reach it from any earlier state. Only @ZAX0$ clears axes that the
setpoint does not control, so it goes first unless the commands after it overwrite everything. It
stops the thrusters for a moment. Between two sets that control the same axes ``change`` leaves it
out, so that thrust is not interrupted while a leg steers.

What does not live here: retries and gaps (the runtime's frontseat), frames to and from topside.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from protocol.ack_frame import AckFrame
from protocol.checksum import SD_DEFAULT, sd_profile
from protocol.codec import CannotEncode, Granularity, Received
from protocol.fields import F32LE, U16LE, BinaryFrame, Check, Const, FrameType
from protocol.framing import Frame, LinkRow, Shortcut, no_stretch
from protocol.messages import Ack, Order, Setpoint, Telemetry
from protocol.modem import IDLE as MODEM_IDLE
from protocol.modem import modem_frames
from protocol.motion_frame import MotionFrame
from protocol.tolerances import Tolerances
from protocol.topside import (
    EMERGENCIES,
    ack_of,
    relayed_frames,
    to_pi_frames,
    to_topside_frames,
)
from protocol.vehicles.auv_outputs import CHANNELS, frames_of
from protocol.vehicles.channels import at_rest
from protocol.vehicles.keys import Keys, Wire, baud
from protocol.vehicles.sd_stream import fractions_of, sd_reader

KEYS: Keys = (baud(9600),)

MAGNETOMETERS = tuple(
    f"mag_{place}_{axis}" for place in ("front", "left", "right") for axis in "xyz"
)
ACTUATORS = (
    *("left_main", "right_main", "rear_vert", "left_vert", "right_vert"),
    *("servo_left", "servo_right"),
)


def sd_frame(tolerances: Tolerances) -> BinaryFrame:
    """``@SD``, 86 bytes (000 table 3.2; E-V17, E-V19, E-V20)."""
    profile = sd_profile(tolerances["sd_crc"])
    return BinaryFrame(
        "auv.SD",
        "000 table 3.2",
        (
            Const(b"@SD"),
            F32LE("roll_deg", -90, 90),  # starboard down positive
            F32LE("pitch_deg", -180, 180),  # nose up positive
            F32LE("yaw_deg", -180, 180),  # 0 north, +90 west
            F32LE("temperature_c"),
            F32LE("depth_m"),
            F32LE("altitude_m"),
            *(F32LE(name, -100, 100) for name in MAGNETOMETERS),  # uT
            *(U16LE(f"pwm_{name}") for name in ACTUATORS),  # us
            U16LE("battery_control"),
            U16LE("battery_power"),
            Check(profile.compute, "I", first=profile.first),
            Const(b"$"),
        ),
    )


SD = sd_frame(Tolerances())


def from_stm32_frames(tolerances: Tolerances) -> tuple[FrameType, ...]:
    return (sd_frame(tolerances), AckFrame("RZ", tolerances))


def to_stm32_frames(tolerances: Tolerances) -> tuple[FrameType, ...]:
    return (MotionFrame(tolerances), *relayed_frames(tolerances))


def _any_frames(tolerances: Tolerances) -> tuple[FrameType, ...]:
    to_pi = (frame for frame in to_pi_frames(tolerances) if frame.name != "auv.ZA")
    to_topside = (frame for frame in to_topside_frames(tolerances) if frame.name != "auv.ACK")
    up = (sd_frame(tolerances), AckFrame("NASRZ", tolerances), *to_topside)
    return (*up, *to_pi, MotionFrame(tolerances), *modem_frames(tolerances))


LINKS: tuple[LinkRow, ...] = (
    LinkRow("auv.any", _any_frames, splice=("auv.SD", "auv.ACK")),
    LinkRow("auv.from_stm32", from_stm32_frames, splice=("auv.SD", "auv.ACK")),
    LinkRow("auv.modem", modem_frames, idle=MODEM_IDLE),
    LinkRow("auv.to_pi", to_pi_frames),
    LinkRow("auv.to_stm32", to_stm32_frames),
    LinkRow("auv.to_topside", to_topside_frames),
)
FROM_STM32 = LINKS[1]

# --- Telemetry in ---

BatteryScale = tuple[float, float]  # V per count: control, power
_TURN = 2 * math.pi
_DEGREE = math.pi / 180
_ATTITUDE = ("roll_deg", "pitch_deg", "yaw_deg")


def telemetry(raw: bytes, t: float, battery_scale: BatteryScale = (1.0, 1.0)) -> Telemetry:
    """Convert an accepted ``@SD`` to SI. NaN and infinity become None; ``faults`` names doubtful
    fields."""
    values = SD.decode(raw)
    roll, pitch, yaw = (
        None if values[name] is None else values[name] * _DEGREE for name in _ATTITUDE
    )
    magnetic = tuple(values[name] for name in MAGNETOMETERS)
    return Telemetry(
        t=t,
        depth=values["depth_m"],
        altitude=values["altitude_m"],
        heading=None if yaw is None else -yaw % _TURN,
        pitch=pitch,
        roll=roll,
        temperature_c=values["temperature_c"],
        magnetic=None if None in magnetic else tuple(value * 1e-6 for value in magnetic),
        actuators=fractions_of([values[f"pwm_{name}"] for name in ACTUATORS]),
        batteries=(
            values["battery_control"] * battery_scale[0],
            values["battery_power"] * battery_scale[1],
        ),
        faults=tuple(values["flags"]),
    )


def shortcut(tolerances: Tolerances, battery_scale: BatteryScale) -> Shortcut:
    """Return the fast path for ``@SD``, used if the checksum is the normative one: the values of
    ``telemetry``, fast enough for logs."""
    usual = tolerances["sd_crc"] == SD_DEFAULT

    def message(frame: Frame) -> Telemetry | Ack:
        if frame.type.name == SD.name:
            return telemetry(frame.raw, frame.t, battery_scale)
        return ack_of(frame)

    read = sd_reader(SD.layout, *battery_scale) if usual else no_stretch
    return Shortcut(SD.lead, SD.length, read, message)


# --- Setpoint out ---

# document, 2.2.1: S, E, H and A carry whole numbers, in m and degrees
GRANULARITY: Granularity = Granularity(1.0, 1.0, math.radians(1.0), math.radians(1.0))


def _gear(axis: str, fraction: float) -> int:
    if not -1 <= fraction <= 1:
        raise CannotEncode(f"{axis}: {fraction} is outside -1..1")
    return round(fraction * 12)


def _integer(axis: str, value: float, high: int) -> int:
    if not 0 <= value <= high:
        raise CannotEncode(f"{axis}: {value} m is outside 0..{high} m")
    return round(value)


def _yaw_deg(heading: float) -> int:
    if not math.isfinite(heading):
        raise CannotEncode(f"heading: {heading} is no angle")
    return -round(math.degrees(math.remainder(heading, _TURN)))


def _pair(gear: int, positive: str, negative: str) -> str:
    return f"{positive if gear >= 0 else negative}{abs(gear)}"


def _vertical(setpoint: Setpoint) -> str | None:
    """Return the command of the vertical axis, None if it is not controlled."""
    given = [setpoint.depth, setpoint.altitude, setpoint.heave]
    if sum(value is not None for value in given) > 1:
        raise CannotEncode("depth, altitude and heave: at most one of them can be held")
    if setpoint.depth is not None:
        return f"S{_integer('depth', setpoint.depth, 9999)}"
    if setpoint.altitude is not None:
        return f"E{_integer('altitude', setpoint.altitude, 9999)}"
    if setpoint.heave is not None:
        return _pair(_gear("heave", setpoint.heave), "D", "U")
    return None


def _documented(setpoint: Setpoint) -> list[str]:
    vertical, surge = _vertical(setpoint), _gear("surge", setpoint.surge)
    turn = _gear("turn", setpoint.turn)
    if setpoint.heading is not None and turn:
        raise CannotEncode("turn: the heading is held, so nothing else can turn the vehicle")
    words = [_pair(surge, "F", "B"), _pair(turn, "R", "L")]
    if setpoint.heading is not None:
        words.append(f"H{_yaw_deg(setpoint.heading)}")
    if vertical is not None:
        words.append(vertical)
    attitude = (setpoint.pitch, setpoint.roll)
    if attitude != (None, None):
        words.append(_attitude(setpoint))
    complete = setpoint.heading is not None and vertical is not None and attitude != (None, None)
    if complete:
        return words
    return ["X0", *(word for word in words if word[1:] != "0" or word[0] not in "FBLRUD")]


def _attitude(setpoint: Setpoint) -> str:
    pitch, roll = (math.degrees(angle or 0.0) for angle in (setpoint.pitch, setpoint.roll))
    if not (abs(pitch) <= 180 and abs(roll) <= 90):
        raise CannotEncode(f"pitch {pitch:g} and roll {roll:g} deg: outside +-180 and +-90")
    return f"A{round(pitch)};{round(roll)}"


def _as_built(setpoint: Setpoint) -> list[str]:
    if setpoint.pitch is not None or setpoint.roll is not None:
        raise CannotEncode("pitch and roll: as built, this vehicle ignores @ZAA")
    vertical, horizontal, speed = _vertical(setpoint), *_horizontal(setpoint)
    if vertical is not None and vertical[0] in "UD":
        gear = int(vertical[1:])
        if gear == 0:
            vertical = None
        elif horizontal is not None and gear != speed:
            raise CannotEncode(
                f"heave: gear {gear} beside gear {speed} ahead; as built, both share one speed"
            )
    words = [word for word in (vertical, horizontal) if word is not None]
    return words if len(words) == 2 else ["X0", *words]


def _horizontal(setpoint: Setpoint) -> tuple[str | None, int]:
    """Return the command of the one horizontal mode, None for none, and its gear."""
    surge, turn = _gear("surge", setpoint.surge), _gear("turn", setpoint.turn)
    if setpoint.heading is not None:
        if turn:
            raise CannotEncode("turn: the heading is held, so nothing else can turn the vehicle")
        if surge < 0:
            raise CannotEncode("surge: as built, a heading is held ahead only, not astern")
        return f"H{_yaw_deg(setpoint.heading)},{surge}", surge
    if surge and turn:
        raise CannotEncode("surge and turn: as built, one horizontal mode at a time")
    if surge:
        return _pair(surge, "F", "B"), abs(surge)
    if turn:
        return _pair(turn, "R", "L"), abs(turn)
    return None, 0


_CLEAR = EMERGENCIES[Order.STOP]
_AXES = {"B": "F", "L": "R", "D": "U"}  # opposite commands of one axis


def _axes(frames: list[bytes]) -> list[str]:
    """Return the axis that each command sets, as a letter."""
    return [_AXES.get(letter, letter) for letter in (chr(frame[3]) for frame in frames)]


def change(wanted: list[bytes], held: list[bytes]) -> list[bytes]:
    """Return the frames of ``wanted`` for a vehicle that holds all of ``held``: without the @ZAX0$
    that clears, if both control the same axes. Unchanged commands are sent too, for a board that
    has lost them since."""
    alike = wanted[0] == _CLEAR and _axes(wanted) == _axes(held)
    return wanted[1:] or wanted if alike else wanted


DIALECTS: dict[str, Callable[[Setpoint], list[str]]] = {
    "documented": _documented,
    "as-built": _as_built,
}

# What an N to a command of a dialect probably means: the board speaks the other dialect.
MEANINGS = {
    ("as-built", b"H"): "probably built to the letter, where no gear stands behind "
    "a heading; then the vehicle file is auv-documented",
    ("documented", b"A"): "probably as built, where no attitude is followed; then the "
    "vehicle file is auv",
}


def dialect_of(answer: Ack) -> str:
    """Return the dialect that an answer to ``@ZAX0$`` shows, "" if it is no such answer. An STM32
    that follows the document names the command that it answers; as built it sends A for all."""
    builds = {"X": "documented", "A": "as-built"}
    return builds.get(answer.function, "") if answer.group == "Z" else ""


class AuvCodec:
    """A ``VehicleCodec``. ``battery_scale``: volts per count of control and power battery."""

    def __init__(
        self,
        dialect: str = "as-built",
        tolerances: Tolerances | None = None,
        battery_scale: BatteryScale = (1.0, 1.0),
        wire: Wire | None = None,
    ) -> None:
        if dialect not in DIALECTS:
            raise ValueError(f"no dialect {dialect!r}; there are: {', '.join(DIALECTS)}")
        self._words, self._dialect = DIALECTS[dialect], dialect
        chosen = tolerances or Tolerances()
        self.levels = at_rest(CHANNELS)
        self.framer = FROM_STM32.framer(chosen, shortcut(chosen, battery_scale))

    def receive(self, data: bytes, now: float) -> list[Received]:
        found: list[Any] = self.framer.receive(data, now)  # the shortcut turns frames into messages
        return found

    def next_timer(self) -> float | None:
        return self.framer.next_timer()

    def flush(self, now: float) -> list[Received]:
        found: list[Any] = self.framer.flush(now)
        return found

    def meaning_of_no(self, frame: bytes) -> str:
        return MEANINGS.get((self._dialect, frame[3:4]), "") if frame[:3] == b"@ZA" else ""

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        if isinstance(setpoint, Order):
            return [EMERGENCIES[setpoint]]
        return [f"@ZA{word}$".encode("ascii") for word in self._words(setpoint)]

    def take_outputs(self, levels: Mapping[str, float]) -> dict[str, bytes]:
        self.levels = {**self.levels, **levels}
        return frames_of(levels, self.levels)
