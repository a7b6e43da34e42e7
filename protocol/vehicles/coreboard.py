"""The core board of document 002 (12 March 2019), serial 115200 or network.

    main board -> PC            FE EF .. FA AF   90 bytes   table 3-1
    PC -> main board            FE EF .. FA AF   62 bytes   table 3-2
    main board -> sensor board  FE EF .. FD DF   37 bytes   table 4-1
    sensor board -> main board  FE EF .. FA AF  155 bytes   table 4-2

Floats are low byte first, 16-bit integers high byte first (E-B1, E-B2; tolerance ``float_order``);
the checksum is the XOR of everything before it, header included. Bytes 50-61 and 83-86 of 3-1,
124-126 and the undefined 12-13 and 18-22 of 4-2 are passed through. Leak: 1 is a leak (E-B5); the
older byte 23 of 4-2 has the opposite sense and is only compared.

The adapter acts as the PC: telemetry from table 3-1, setpoints by table 3-2 at 10 Hz. Angles are
read as aerospace ones: in the document's text x is north and y east, so z is down, yaw clockwise,
roll starboard down, TZ positive down. The mode stays ROV, in which the six forces act. The board
closes its heading and depth loops together, or neither. Neutral is 100 on the wire, never 0 (E-B9).

What does not live here: the CAN bus behind the main board (protocol.vehicles.motorcan).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from protocol.checksum import xor8
from protocol.codec import CannotEncode, Received
from protocol.fields import (
    F32LE,
    F64LE,
    I8,
    I16BE,
    U8,
    U16BE,
    BinaryFrame,
    Check,
    Const,
    Field,
    FrameType,
    Number,
    Raw,
    Values,
)
from protocol.framing import Frame, LinkRow
from protocol.messages import Order, Setpoint, Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles.adapter import SilentBoard, fraction, heading_of, radians_of, refuse
from protocol.vehicles.channels import Channel, Source, of_board, told
from protocol.vehicles.keys import Key, Keys, Octets, Wire, baud, read_wire
from protocol.vehicles.stick import stick_keys

PERIOD = 0.1  # s between frames to the board (R16)
SILENCE = 0.5  # s after which the board goes neutral
LEAK_FRAMES = 3  # so many more frames with a leak than without one confirm it (R16)

HEAD, TAIL, SENSOR_TAIL = Const(b"\xfe\xef"), b"\xfa\xaf", b"\xfd\xdf"
XOR = Check(xor8, "B")
SWITCH = (0, 1)
USBL_PHASES = tuple(I16BE(f"usbl{n}", scale=10) for n in range(1, 7))  # deg
VOLTAGES = (U16BE("control_v", scale=100), U16BE("power_v", scale=100))
VALID_BITS = ("DVL", "GPS", "INS", "VO", "USBL")  # bit 0 first


def _order(tolerances: Tolerances) -> str:
    return "<" if tolerances["float_order"] == "low" else ">"


def _floats(order: str, *names: str, bound: float | None = None) -> tuple[Number, ...]:
    low = None if bound is None else -bound
    return tuple(F32LE(name, low, bound, order=order) for name in names)


def _place(tolerances: Tolerances) -> tuple[Number, ...]:
    order = _order(tolerances)
    place = F64LE("lat_deg", -90, 90, order=order), F64LE("lon_deg", -180, 180, order=order)
    return place if tolerances["place002"] == "lat" else place[::-1]


def _tail(tail: bytes, tolerances: Tolerances) -> Const:
    """Return the table's tail, which is sent; the other one may be accepted too (E-B3b)."""
    other = SENSOR_TAIL if tail == TAIL else TAIL
    return Const(tail, also=other if tolerances["tail002"] == "either" else b"")


def main_to_pc(tolerances: Tolerances) -> BinaryFrame:
    """Main board to PC, 90 bytes (002 table 3-1)."""
    order = _order(tolerances)
    fields: tuple[Field, ...] = (
        HEAD,
        *_floats(order, "roll_deg", "pitch_deg", "yaw_deg", bound=360),
        *_place(tolerances),
        *_floats(order, "x_m", "y_m", "depth_m", "altitude_m", "avoid_m"),
        Raw("reserved50", 12),
        U8("mode"),
        I16BE("temperature_c", scale=100),
        *VOLTAGES,
        U8("leak", choices=SWITCH),
        *USBL_PHASES,
        U8("ins_aligned", choices=SWITCH),
        Raw("reserved83", 4),
        XOR,
        _tail(TAIL, tolerances),
    )
    return BinaryFrame("coreboard.MAIN_TO_PC", "002 table 3-1", fields)


def pc_to_main(tolerances: Tolerances) -> BinaryFrame:
    """PC to main board, 62 bytes (002 table 3-2; E-B6a, E-B8 to E-B11)."""
    order = _order(tolerances)
    fields: tuple[Field, ...] = (
        HEAD,
        *_place(tolerances),
        *_floats(order, "x_m", "y_m", "depth_m"),
        *_floats(order, "heading_deg", bound=360),
        U8("nav", choices=(0, 1, 2, 3, 4)),  # off, dead reckoning, its EKF, VO, VO EKF
        *(U8(name, -100, 100, bias=100) for name in ("tx", "ty", "tz", "mx", "my", "mz")),
        U8("mode", choices=(0, 1)),  # ROV, DPROV
        U8("closed_loop", choices=SWITCH),
        *(U8(f"{name}_on", choices=SWITCH) for name in ("ins", "dvl", "usbl")),
        U8("usbl_khz"),
        I8("angle_error_deg"),
        Raw("passthrough", 11),
        XOR,
        _tail(TAIL, tolerances),
    )
    return BinaryFrame("coreboard.PC_TO_MAIN", "002 table 3-2", fields, command=True)


SENSOR_SWITCHES = (
    *("ins", "dvl", "usbl", "modem", "altimeter", "depth", "side_scan", "forward_sonar"),
    *("adcp", "ctd", "drop_weight"),
)


def main_to_sensor(tolerances: Tolerances) -> BinaryFrame:
    """Main board to sensor board, 37 bytes, tail FD DF (002 table 4-1; E-B3b, E-B13)."""
    fields: tuple[Field, ...] = (
        HEAD,
        *(U8(name, choices=SWITCH) for name in SENSOR_SWITCHES),
        *(U8(f"led{n}", 0, 100) for n in range(1, 5)),  # %
        U8("ptz"),
        Raw("passthrough", 16),
        XOR,
        _tail(SENSOR_TAIL, tolerances),
    )
    return BinaryFrame("coreboard.MAIN_TO_SENSOR", "002 table 4-1", fields, command=True)


def sensor_to_main(tolerances: Tolerances) -> BinaryFrame:
    """Sensor board to main board, 155 bytes (002 table 4-2; E-B4, E-B5, E-B12).

    A frame of the older layout passes every check; then ``flags`` names ``leak_legacy_raw`` and
    angles."""
    order = _order(tolerances)
    fields: tuple[Field, ...] = (
        HEAD,
        I16BE("temperature_c", scale=100),
        *(U16BE(f"ad{n}") for n in range(1, 5)),
        Raw("reserved12", 2),
        *_floats(order, "depth_m"),
        Raw("reserved18", 5),
        U8("leak_legacy_raw", choices=SWITCH),
        *_floats(order, "roll_deg", "pitch_deg", "yaw_deg", bound=360),
        *_floats(order, "p", "q", "r", "ax", "ay", "az", "mx", "my", "mz"),
        *_floats(order, "dvl_x", "dvl_y", "dvl_z"),
        *_place(tolerances),
        *_floats(order, "vo_x", "vo_y", "vo_z", "usbl_x_m", "usbl_y_m", "altitude_m"),
        Raw("reserved124", 3),
        I16BE("temperature2_c", scale=100),
        *VOLTAGES,
        U8("leak", choices=SWITCH),
        *USBL_PHASES,
        U8("ins_aligned", choices=SWITCH),
        Raw("buf", 4),
        U8("valid", 0, 31),
        XOR,
        _tail(TAIL, tolerances),
    )
    name, title = "coreboard.SENSOR_TO_MAIN", "002 table 4-2"
    alike = tolerances["leak002"] == tolerances["leak23"]  # not so in the document (E-B5)

    def doubts(values: Values) -> None:
        bits = enumerate(VALID_BITS)
        values["valid_bits"] = [name for bit, name in bits if values["valid"] >> bit & 1]
        if (values["leak"] == values["leak_legacy_raw"]) != alike:
            values["flags"].append("leak_legacy_raw:disagrees")

    return BinaryFrame(name, title, fields, derive=doubts)


def _one(frame: BinaryFrame) -> tuple[FrameType, ...]:
    return (frame,)


LINKS: tuple[LinkRow, ...] = (
    LinkRow("coreboard.main_to_pc", lambda t: _one(main_to_pc(t))),
    LinkRow("coreboard.main_to_sensor", lambda t: _one(main_to_sensor(t))),
    LinkRow("coreboard.pc_to_main", lambda t: _one(pc_to_main(t))),
    LinkRow("coreboard.sensor_to_main", lambda t: _one(sensor_to_main(t))),
)

# --- Telemetry in --------------------------------------------------------------------------------

SOURCES: tuple[Source, ...] = (
    of_board("avoid_m", "m", "distance to what is ahead"),
    *(of_board(f"usbl{n}", "deg", f"phase difference {n} of the USBL") for n in range(1, 7)),
    of_board("temperature_c", "C", "of the board"),
    of_board("x_m", "m", "its own dead reckoning, x"),
    of_board("y_m", "m", "its own dead reckoning, y"),
    of_board("ins_aligned", "", "1: the INS is aligned"),
    of_board("mode", "", "its mode (codes not given)"),
)


class Leaks:
    """Counts frames that report a leak against frames that report none (R16)."""

    def __init__(self, tolerances: Tolerances) -> None:
        self._dry = 1 - int(tolerances["leak002"])  # code
        self._count = 0

    def take(self, code: int) -> bool:
        """Count a frame; return whether the leak is confirmed. An unknown code counts as a leak."""
        step = -1 if code == self._dry else 1
        self._count = min(max(self._count + step, 0), 2 * LEAK_FRAMES)
        return self._count >= LEAK_FRAMES


def telemetry(
    values: Values, t: float, leak: bool, scale: tuple[float, float] = (1.0, 1.0)
) -> Telemetry:
    """Convert table 3-1 to SI. A position counts only while the INS reports that it is aligned."""
    place = (radians_of(values, "lat_deg"), radians_of(values, "lon_deg"))
    doubtful = {flag.partition(":")[0] for flag in values["flags"]}
    latitude, longitude = place
    known = values["ins_aligned"] == 1 and not doubtful & {"lat_deg", "lon_deg"}
    return Telemetry(
        t=t,
        depth=values["depth_m"],
        altitude=values["altitude_m"],
        heading=heading_of(values, "yaw_deg"),
        pitch=radians_of(values, "pitch_deg"),
        roll=radians_of(values, "roll_deg"),
        temperature_c=values["temperature_c"],
        batteries=(values["control_v"] * scale[0], values["power_v"] * scale[1]),
        position=(latitude, longitude) if known and latitude and longitude else None,
        leak=leak,
        faults=tuple(values["flags"]),
        board=told(values, tuple(values["flags"]), SOURCES),
    )


# --- Setpoint out --------------------------------------------------------------------------------

AUXILIARY: Keys = (
    Key("nav", 1, 0, 4, "navigation: 0 off, 1 dead reckoning, 2 its EKF, 3 VO, 4 its EKF"),
    Key("ins_on", 1, 0, 1, "power of the INS"),
    Key("dvl_on", 1, 0, 1, "power of the DVL"),
    Key("usbl_on", 0, 0, 1, "power of the USBL"),
    Key("usbl_khz", 30, 0, 255, "its frequency, kHz (E-B10)"),
    Key("angle_error_deg", 0, -128, 127, "error of INS against DVL, deg", whole=False),
    Key("angle_error_step", 1, 0.01, 1, "deg that 1 in its byte stands for (E-B8)", whole=False),
    Octets("passthrough", "00" * 11, "bytes 48 to 58, passed on to the sensor board"),
)
KEYS: Keys = (baud(115_200), *stick_keys("surge", "turn", "heave"), *AUXILIARY)

_POSITION = "the position, and with it the limit of radius, comes from it"
PASSED_ON = tuple(f"passthrough{n}" for n in range(1, 12))
CHANNELS: tuple[Channel, ...] = (
    Channel("usbl_on", "", 0, 1, "power of the USBL"),
    Channel("usbl_khz", "kHz", 0, 255, "frequency of the USBL (E-B10)"),
    Channel("ins_on", "", 0, 1, "power of the INS", needed=_POSITION),
    Channel("dvl_on", "", 0, 1, "power of the DVL", needed=_POSITION),
    Channel("nav", "", 0, 4, "the board's own navigation", needed=_POSITION),
    *(
        Channel(name, "", 0, 255, f"byte {at}, passed on to the sensor board")
        for at, name in enumerate(PASSED_ON, 48)
    ),
)

NEUTRAL: Values = {
    **dict.fromkeys(("lat_deg", "lon_deg", "x_m", "y_m", "depth_m", "heading_deg"), 0.0),
    **dict.fromkeys(("tx", "ty", "tz", "mx", "my", "mz"), 0),
    "mode": 0,
    "closed_loop": 0,
}


def auxiliary(wire: Wire) -> Values:
    """Return the values of table 3-2 beside the motion, as configured."""
    values = {key.name: wire[key.name] for key in AUXILIARY}
    values["angle_error_deg"] /= values.pop("angle_error_step")
    return values


def levels_of(wire: Wire) -> dict[str, float]:
    """Return the levels of the channels, as configured."""
    passed = zip(PASSED_ON, bytes.fromhex(wire["passthrough"]), strict=True)
    switched = (row.name for row in CHANNELS if row.name in wire)
    return {name: wire[name] for name in switched} | dict(passed)


def carried(levels: Mapping[str, float]) -> Values:
    """Return the channels as values of table 3-2."""
    whole = {name: int(level) for name, level in levels.items()}
    passed = bytes(whole.pop(name) for name in PASSED_ON)
    return whole | {"passthrough": passed.hex()}


def command(setpoint: Setpoint | Order) -> Values:
    """Return the values of table 3-2 for the motion. Raises CannotEncode."""
    if setpoint is Order.STOP:
        return NEUTRAL
    if setpoint is Order.SURFACE:
        return NEUTRAL | {"tz": -100}
    refuse(
        setpoint,
        altitude="the board holds no altitude; hold a depth",
        pitch="the board has a torque about this axis, but no loop that holds an angle",
        roll="the board has a torque about this axis, but no loop that holds an angle",
    )
    heave = setpoint.heave or 0.0
    values = NEUTRAL | {
        "tx": round(100 * fraction("surge", setpoint.surge)),
        "mz": round(100 * fraction("turn", setpoint.turn)),
        "tz": round(100 * fraction("heave", heave)),
    }
    if setpoint.heading is None and setpoint.depth is None:
        return values
    if setpoint.heading is None or setpoint.depth is None:
        missing = "heading" if setpoint.heading is None else "depth"
        raise CannotEncode(f"{missing}: the board holds heading and depth together, or neither")
    if setpoint.turn or heave:
        raise CannotEncode("turn and heave: nothing else can move what a loop holds")
    heading = math.degrees(math.remainder(setpoint.heading, math.tau))
    return values | {"closed_loop": 1, "heading_deg": heading, "depth_m": setpoint.depth}


class CoreboardCodec(SilentBoard):
    """A ``VehicleCodec``."""

    period, silence = PERIOD, SILENCE
    kept_awake = "neutral: the board powers its INS as each frame says (R16)"
    channels = CHANNELS

    def __init__(
        self,
        dialect: str = "documented",
        tolerances: Tolerances | None = None,
        battery_scale: tuple[float, float] = (1.0, 1.0),
        wire: Wire | None = None,
    ) -> None:
        chosen = tolerances or Tolerances()
        super().__init__(LINKS[0].framer(chosen), self._telemetry, wire or read_wire(KEYS, {}))
        self._frame = pc_to_main(chosen)
        self._scale = battery_scale
        self._auxiliary = auxiliary(self._wire)
        self.levels = levels_of(self._wire)
        self.encode(Order.STOP)  # refused here if the configured values do not fit
        self._leaks = Leaks(chosen)

    def _telemetry(self, frame: Frame) -> Received:
        values = frame.values()
        return telemetry(values, frame.t, self._leaks.take(values["leak"]), self._scale)

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        values = self._auxiliary | carried(self.levels) | command(setpoint)
        return [self._frame.encode(values)]
