"""The Pi in place of document 002's main board, with sensor board and motor boards.

    motor boards   CAN, tables 5-1 and 5-2    force and torque, every 50 ms (motorcan)
    sensor board   serial 115200, table 4-1   switches, four LEDs, pan/tilt, drop weight, 16 bytes
                   table 4-2                  all sensors, 10 to 50 Hz

The codec writes both as one stream; ``links.joined`` gives each board its own. Every command to the
motors comes with a frame to the sensor board: each such frame carries the power of all sensors. A
position counts only while the valid bits report GPS or INS aligned. Velocities of DVL and visual
odometry are readings only: the document gives neither their frame nor their sign.

What does not live here: the tables (protocol.vehicles.coreboard), holding depth and heading
(mission.onboard.runtime.outer_loop).
"""

from __future__ import annotations

from collections.abc import Mapping

from protocol.codec import Received
from protocol.fields import Values
from protocol.framing import Frame
from protocol.messages import Order, Setpoint, Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles import coreboard
from protocol.vehicles.adapter import heading_of, radians_of
from protocol.vehicles.channels import Channel, Source, of_board, told
from protocol.vehicles.keys import Keys, Wire, read_wire
from protocol.vehicles.motorcan import KEYS as MOTOR_KEYS
from protocol.vehicles.motorcan import PERIOD, SILENCE, MotorCodec

_GPS, _INS = 1 << 1, 1 << 2  # of the valid bits
_MISPLACED = ("depth_m:layout", "yaw_deg:layout")
_NEEDED = {
    "ins": "attitude, heading and position come from it",
    "dvl": "what the INS knows of its way comes from it",
    "modem": "it is the operator's way to the vehicle",
    "altimeter": "what contradicts a wrong depth comes from it",
    "depth": "the limit of depth comes from it",
    "ctd": "the limit of depth comes from it",
}
_LEDS = tuple(f"led{n}" for n in range(1, 5))
_PASSED = tuple(f"passthrough{n}" for n in range(1, 17))


def _switch(name: str) -> Channel:
    what = f"power of {name.replace('_', ' ')}"
    needed = _NEEDED.get(name, "")
    return Channel(f"{name}_on", "", 0, 1, what, 1 if needed else 0, needed=needed)


CHANNELS: tuple[Channel, ...] = (
    *(_switch(name) for name in coreboard.SENSOR_SWITCHES if name != "drop_weight"),
    Channel("drop_weight", "", 0, 1, "1: lets the drop weight go", final=True),
    *(Channel(name, "%", 0, 100, "brightness of a LED") for name in _LEDS),
    Channel("ptz", "", 0, 255, "pan and tilt"),
    *(Channel(name, "", 0, 255, f"byte {at}") for at, name in enumerate(_PASSED, 18)),
)
SOURCES: tuple[Source, ...] = (
    *(of_board(f"ad{n}", "", f"AD channel {n}") for n in range(1, 5)),
    *(of_board(name, "", f"angular rate {name}, as the INS says it") for name in "pqr"),
    *(of_board(f"a{axis}", "", f"acceleration {axis}, as the INS says it") for axis in "xyz"),
    *(of_board(f"m{axis}", "", f"magnetic {axis}, as the INS says it") for axis in "xyz"),
    *(of_board(f"dvl_{axis}", "m/s", f"velocity {axis} by DVL") for axis in "xyz"),
    *(of_board(f"vo_{axis}", "m/s", f"velocity {axis} by visual odometry") for axis in "xyz"),
    *(of_board(f"usbl_{axis}_m", "m", f"place {axis} by USBL") for axis in "xy"),
    *(of_board(f"usbl{n}", "deg", f"phase difference {n} of the USBL") for n in range(1, 7)),
    of_board("temperature_c", "C", "of the sensor board"),
    of_board("temperature2_c", "C", "of the sensor board, again"),
    of_board("ins_aligned", "", "1: the INS is aligned"),
    of_board("valid", "", "bits: 1 DVL, 2 GPS, 4 INS aligned, 8 visual odometry, 16 USBL"),
)
KEYS: Keys = MOTOR_KEYS


def telemetry(
    values: Values, t: float, leak: bool, scale: tuple[float, float] = (1.0, 1.0)
) -> Telemetry:
    """Convert table 4-2 to SI. In a frame of the older layout (E-B4) the fields are elsewhere:
    depth and heading are flagged as doubtful, and no position counts."""
    flags = tuple(values["flags"])
    if older := "leak_legacy_raw:bad_enum" in flags:
        flags += _MISPLACED
    doubtful = {flag.partition(":")[0] for flag in flags}
    latitude, longitude = (radians_of(values, name) for name in ("lat_deg", "lon_deg"))
    unsure = older or doubtful & {"lat_deg", "lon_deg", "valid"}
    known = values["valid"] & (_GPS | _INS) and not unsure
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
        faults=flags,
        board=told(values, flags, SOURCES),
    )


class MainboardCodec(MotorCodec):
    """A ``VehicleCodec``."""

    period, silence = PERIOD, SILENCE
    kept_awake = "neutral: each frame carries the power of the sensors (R16)"
    channels = CHANNELS

    def __init__(
        self,
        dialect: str = "documented",
        tolerances: Tolerances | None = None,
        battery_scale: tuple[float, float] = (1.0, 1.0),
        wire: Wire | None = None,
    ) -> None:
        chosen = tolerances or Tolerances()
        self._sensors, self._scale = coreboard.main_to_sensor(chosen), battery_scale
        super().__init__(dialect, chosen, battery_scale, wire or read_wire(KEYS, {}))
        self.framer, self._message = coreboard.LINKS[3].framer(chosen), self._telemetry
        self._leaks = coreboard.Leaks(chosen)

    def _telemetry(self, frame: Frame) -> Received:
        values = frame.values()
        return telemetry(values, frame.t, self._leaks.take(values["leak"]), self._scale)

    def encode(self, setpoint: Setpoint | Order) -> list[bytes]:
        """Return force, torque and the sensor board's frame. Raises CannotEncode."""
        return [*super().encode(setpoint), self._sensors.encode(carried(self.levels))]


def carried(levels: Mapping[str, float]) -> Values:
    """Return the channels as values of table 4-1."""
    whole = {name.removesuffix("_on"): int(level) for name, level in levels.items()}
    passed = bytes(whole.pop(name) for name in _PASSED)
    return whole | {"passthrough": passed.hex()}
