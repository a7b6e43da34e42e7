"""Frames of every row of the four documents, two values each, written from the documents alone: the
layouts and checksums here know nothing of protocol/, and nothing of protocol/ is made from them.

    FRAMES     by the frame's name: its link, and frames with the values that they say

Of @ZA and of the robot's words a row is a word: each has the values of its own.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

Values = Mapping[str, Any]
XYZ = "xyz"


@dataclass(frozen=True, slots=True)
class Written:
    link: str
    raw: bytes
    values: Values
    derived: Values = field(default_factory=dict)  # what a reader adds to them


def words_of_stm32(data: bytes) -> int:
    """CRC-32 as the STM32's unit does it, low byte of a word first (E-V19)."""
    crc = 0xFFFFFFFF
    for (word,) in struct.iter_unpack("<I", data):
        crc ^= word
        for _ in range(32):
            crc = (crc << 1 ^ 0x04C11DB7 if crc >> 31 else crc << 1) & 0xFFFFFFFF
    return crc


def modbus(data: bytes) -> int:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc


def xored(data: bytes) -> int:
    found = 0
    for byte in data:
        found ^= byte
    return found


# --- 000 -------------------------------------------------------------------------------------------

PWM = (
    *("left_main", "right_main", "rear_vert", "left_vert", "right_vert"),
    *("servo_left", "servo_right"),
)
MAGNETIC = tuple(f"mag_{side}_{axis}" for side in ("front", "left", "right") for axis in XYZ)
SD_FLOATS = ("roll_deg", "pitch_deg", "yaw_deg", "temperature_c", "depth_m", "altitude_m")
VS_ROWS = (
    *("time", "lon_deg", "lat_deg", "elevation_m", "ground_speed", "ground_course_deg"),
    *("heading_deg", "pitch_deg", "roll_deg", "temperature_c", "depth_m", "altitude_m"),
    *("battery_control", "battery_power", *MAGNETIC, *(f"pwm_{name}" for name in PWM)),
)
AES_ROWS = (
    *("state", "commander", "report_age", "fix_age", "uncertainty_m", "north_m", "east_m"),
    *("to_depth_m", "to_radius_m", "to_time", "to_voltage_v", "alarms", "setpoint", "leg"),
)


def sd(angles: tuple[float, ...], magnetic: tuple[float, ...], counts: tuple[int, ...]) -> Written:
    floats = *angles, *magnetic
    body = struct.pack("<15f9H", *floats, *counts)
    raw = b"@SD" + body + struct.pack("<I", words_of_stm32(body + bytes(2))) + b"$"
    names = (*SD_FLOATS, *MAGNETIC, *(f"pwm_{n}" for n in PWM), "battery_control", "battery_power")
    return Written("auv.from_stm32", raw, dict(zip(names, (*floats, *counts), strict=True)))


def ack(said: str, ok: bool, **rest: Any) -> Written:
    values = {"class": said[0], "func": said[1], "ok": ok, **rest}
    link = "auv.from_stm32" if said[0] in "RZ" else "auv.to_topside"
    return Written(link, f"@ACK_{said}$".encode(), values)


def mask(said: str, byte: int, name: str, letters: str) -> Written:
    link = "auv.from_stm32" if said[0] == "R" else "auv.to_topside"
    raw = b"@ACK_" + said.encode() + bytes([byte]) + b"$"
    values = {"class": said[0], "func": said[1], "mask": byte}
    return Written(link, raw, values, {name: letters})


def topside(text: str, rows: tuple[str, ...], *values: Any) -> Written:
    return Written("auv.to_topside", text.encode(), dict(zip(rows, values, strict=True)))


def vs(time: str, *numbers: float) -> Written:
    place, rest = [f"{n:.7f}" for n in numbers[:2]], map(str, numbers[2:])
    text = f"@VS{time.replace('T', '-')},{','.join((*place, *rest))}$"
    return topside(text, VS_ROWS, time, *numbers)


def to_pi(text: str, derived: Values | None = None, **values: Any) -> Written:
    return Written("auv.to_pi", text.encode("latin-1"), values, derived or {})


def za(text: str, derived: Values | None = None, **values: Any) -> Written:
    return Written("auv.to_stm32", text.encode(), {"code": text[3], **values}, derived or {})


def modem(address: int, content: bytes) -> Written:
    head = b"\x23\x02" + struct.pack("<HB", len(content), address) + content
    values = {"address": address, "length": len(content), "content": content.hex()}
    return Written("auv.modem", head + struct.pack("<H", modbus(head)), values)


_STORE = ("state", "total", "have", "missing", "digest", "refusal")
_ACKS = (
    *(ack(code, ok=True) for code in ("NSS", "AAA", "ACC", "AWW", "STT", "SPP", "RSS")),
    *(ack(code, ok=False) for code in ("NSN", "AAN", "ACN", "AWN", "STN", "SPN")),
    *(ack(f"Z{code}Y", ok=True, code=code) for code in "FBLRUDSEHAVXW"),
    *(ack(f"Z{code}N", ok=False, code=code) for code in "FBLRUDSEHAVXW"),
    mask("NI", 0x23, "nodes", "OOCCCO"),  # Pi, STM32 and AUTO
    mask("NI", 0x1D, "nodes", "OCOOOC"),
    mask("RI", 0x11, "sensors", "OCCCOCC"),  # CTD and radio
    mask("RI", 0x7B, "sensors", "OOCOOOO"),
)
OF_000: Mapping[str, tuple[Written, ...]] = {
    "auv.SD": (
        sd(
            (-12.5, 7.25, -90.0, 18.5, 3.75, 21.5),
            (53.25, -20.5, 0.5, -0.25, 33.5, -99.5, 100.0, -100.0, 0.125),
            (1500, 1501, 1502, 1503, 1504, 1505, 1506, 12, 48),
        ),
        sd(
            (12.5, -179.0, 179.5, -1.5, -0.25, 0.0),
            (-53.25, 20.5, -0.5, 0.25, -33.5, 99.5, -1.0, 1.0, -0.125),
            (1000, 1100, 1200, 1300, 1400, 1600, 1700, 11, 47),
        ),
    ),
    "auv.ACK": _ACKS,
    "auv.AR": (
        topside(
            *("@AR,staging,9,5,3-5.9,0123456789abcdef,line 3: no bound,$", _STORE),
            *("staging", 9, 5, "3-5.9", "0123456789abcdef", "line 3: no bound"),
        ),
        topside("@AR,empty,0,0,,,,$", _STORE, "empty", 0, 0, "", "", ""),
    ),
    "auv.AES": (
        topside(
            *("@AE,1,AU,Y,1,423,38,-120,45,7,860,31,1.9,0,F50%H90S3,row,$", AES_ROWS),
            *("autonomous", "asker", 1, 423, 38, -120, 45, 7, 860, 31, 1.9, 0, "F50%H90S3", "row"),
        ),
        topside(
            *("@AE,1,EU,N,2,9,3,12,-4,-5,-86,-3,-0.5,5,S3,up,$", AES_ROWS),
            *("emergency/surfacing", "network", 2, 9, 3, 12, -4, -5, -86, -3, -0.5, 5, "S3", "up"),
        ),
    ),
    "auv.VS": (
        vs(
            *("2025-01-19T23:26:25", 120.1535765, 30.2874595, 20, 100, 0.5, 10, 11, 12, 13, 14, 15),
            *(36, 360, 53191, 53192, 53193, 53194, 53195, 53196, 53197, 53198, 53199),
            *(1200, 1201, 1202, 1203, 1204, 1205, 1206),
        ),
        vs(
            *("2026-12-31T00:00:00", -0.0000001, -89.9999999, -3.5, 7, 359.5, -179.5, -45),
            *(-12.3, -1.5, 0.25, 99.125, 11.9, 47.25),
            *(-1, -2, -3, -4, -5, -6, -7, -8, -9, 1000, 1100, 1300, 1400, 1500, 1600, 1700),
        ),
    ),
    "auv.NS": (to_pi("@NSCOOCCC$", switches="COOCCC"), to_pi("@NSOCOCOC$", switches="OCOCOC")),
    **{f"auv.{word}": (to_pi(f"@{word}$"),) for word in ("NI", "AA", "AC", "AQ", "AE", "DU", "RI")},
    "auv.AW": (
        to_pi("@AW\x01\0\x01\0ZAF5$", total=1, current=1, payload="ZAF5"),
        to_pi("@AW\x64\0\x24\0ZAH-20$", total=100, current=36, payload="ZAH-20"),
        to_pi("@AW\x0f\x27\x40\x24a b$", total=9999, current=0x2440, payload="a b"),
    ),
    "auv.AO": (
        to_pi("@AO,lamp,40,$", name="lamp", value=40),
        to_pi("@AO,servo,-10.5,$", name="servo", value=-10.5),
    ),
    "auv.ST": (
        to_pi("@ST,2025/01/11 16:56:06,$", time="2025-01-11T16:56:06"),
        to_pi("@ST,2024/02/29 23:59:59,$", time="2024-02-29T23:59:59"),
    ),
    "auv.SP": (
        to_pi("@SP,1000,5,200,10,$", radius_m=1000, minutes=5, depth_m=200, low_voltage_v=10),
        to_pi("@SP,9.5,0.5,8,9,$", radius_m=9.5, minutes=0.5, depth_m=8, low_voltage_v=9),
    ),
    "auv.RS": (
        to_pi("@RSCOOCCCO$", {"effective": "OOOCOCO"}, switches="COOCCCO"),
        to_pi("@RSOCOCOOC$", {"effective": "OCOCOOC"}, switches="OCOCOOC"),
    ),
    "auv.MT": (to_pi("@MT1,-10$", thruster=1, gear=-10), to_pi("@MT5,12$", thruster=5, gear=12)),
    "auv.MD": (
        to_pi("@MDA2,-2$", mode="A", servo=2, angle=-2),
        to_pi("@MDS3,22$", mode="S", servo=3, angle=22),
    ),
    "auv.D": (
        to_pi("@DA2,-2$", mode="A", servo=2, angle=-2),
        to_pi("@DS1,-15$", mode="S", servo=1, angle=-15),
    ),
    "auv.MM": tuple(to_pi(f"@MM{way}{n}$", dir=way, speed=n) for n, way in enumerate("FBUD", 9)),
    "auv.MR": tuple(to_pi(f"@MR{way}{n}$", dir=way, speed=n) for n, way in enumerate("LRBFUD")),
    "auv.MS": (to_pi("@MS120,-90$", speed=120, angle=-90), to_pi("@MS1,180$", speed=1, angle=180)),
    "auv.MP": (to_pi("@MP120,-90$", force=120, angle=-90), to_pi("@MP79,-1$", force=79, angle=-1)),
    "auv.ZA": (
        *(za(f"@ZA{way}{gear}$", gear=gear) for gear, way in enumerate("FBLRUD", 7)),
        *(za("@ZAS9999$", depth_m=9999), za("@ZAE0$", altitude_m=0)),
        *(za("@ZAH-180$", heading_deg=-180), za("@ZAA-5;3$", pitch_deg=-5, roll_deg=3)),
        *(za("@ZAV2$", {"flags": ["not_implementable"]}, speed_mps=2), za("@ZAX0$"), za("@ZAWF$")),
    ),
    "auv.MODEM": (modem(1, b"@DU$"), modem(2, b"@ACK_NI$$@ACK_AAA$")),
}

# --- 002 -------------------------------------------------------------------------------------------

HEAD, TAIL, TAIL_41 = b"\xfe\xef", b"\xfa\xaf", b"\xfd\xdf"
PHASES = tuple(f"usbl{n}" for n in range(1, 7))
SWITCHES = (
    *("ins", "dvl", "usbl", "modem", "altimeter", "depth", "side_scan", "forward_sonar"),
    *("adcp", "ctd", "drop_weight"),
)
FORCES = ("tx", "ty", "tz", "mx", "my", "mz")


def closed(link: str, body: bytes, values: Values, tail: bytes = TAIL, **derived: Any) -> Written:
    raw = HEAD + body
    return Written(f"coreboard.{link}", raw + bytes([xored(raw)]) + tail, values, derived)


def main_to_pc(v: Values) -> Written:
    """Table 3-1."""
    floats = [v[n] for n in ("roll_deg", "pitch_deg", "yaw_deg", "lat_deg", "lon_deg")]
    floats += [v[n] for n in ("x_m", "y_m", "depth_m", "altitude_m", "avoid_m")]
    counts = [round(v[n] * 100) for n in ("temperature_c", "control_v", "power_v")]
    body = struct.pack("<3f2d5f", *floats) + bytes.fromhex(v["reserved50"]) + bytes([v["mode"]])
    body += struct.pack(">hHHB", *counts, v["leak"])
    body += struct.pack(">6hB", *(round(v[n] * 10) for n in PHASES), v["ins_aligned"])
    return closed("main_to_pc", body + bytes.fromhex(v["reserved83"]), v)


def pc_to_main(v: Values) -> Written:
    """Table 3-2."""
    place = [v[n] for n in ("lat_deg", "lon_deg", "x_m", "y_m", "depth_m", "heading_deg")]
    body = struct.pack("<2d4f", *place) + bytes([v["nav"], *(100 + v[n] for n in FORCES)])
    rest = ("mode", "closed_loop", "ins_on", "dvl_on", "usbl_on", "usbl_khz")
    body += bytes(v[n] for n in rest) + struct.pack("b", v["angle_error_deg"])
    return closed("pc_to_main", body + bytes.fromhex(v["passthrough"]), v)


def main_to_sensor(v: Values) -> Written:
    """Table 4-1."""
    rows = (*SWITCHES, "led1", "led2", "led3", "led4", "ptz")
    body = bytes(v[n] for n in rows) + bytes.fromhex(v["passthrough"])
    return closed("main_to_sensor", body, v, TAIL_41)


def sensor_to_main(v: Values, valid_bits: list[str]) -> Written:
    """Table 4-2."""
    angles = ("roll_deg", "pitch_deg", "yaw_deg", "p", "q", "r", "ax", "ay", "az", "mx", "my", "mz")
    seen = ("vo_x", "vo_y", "vo_z", "usbl_x_m", "usbl_y_m", "altitude_m")
    body = struct.pack(">h4H", round(v["temperature_c"] * 100), *(v[f"ad{n}"] for n in range(1, 5)))
    body += bytes.fromhex(v["reserved12"]) + struct.pack("<f", v["depth_m"])
    body += bytes.fromhex(v["reserved18"]) + bytes([v["leak_legacy_raw"]])
    body += struct.pack("<15f", *(v[n] for n in (*angles, "dvl_x", "dvl_y", "dvl_z")))
    body += struct.pack("<2d6f", v["lat_deg"], v["lon_deg"], *(v[n] for n in seen))
    body += bytes.fromhex(v["reserved124"])
    counts = [round(v[n] * 100) for n in ("temperature2_c", "control_v", "power_v")]
    body += struct.pack(">hHHB", *counts, v["leak"])
    body += struct.pack(">6hB", *(round(v[n] * 10) for n in PHASES), v["ins_aligned"])
    body += bytes.fromhex(v["buf"]) + bytes([v["valid"]])
    return closed("sensor_to_main", body, v, valid_bits=valid_bits)


def can(number: int, names: tuple[str, ...], *values: int) -> Written:
    """Identifier, length, and the seven bytes."""
    data = bytes([0x100 - number]) + struct.pack(">3h", *values)
    raw = struct.pack(">HB", number, len(data)) + data
    return Written("coreboard.can", raw, dict(zip(names, values, strict=True)))


def phases(*values: float) -> Values:
    return dict(zip(PHASES, values, strict=True))


_ANGLES_1 = {"roll_deg": -18.5, "pitch_deg": 14.75, "yaw_deg": -38.25}
_ANGLES_2 = {"roll_deg": 18.5, "pitch_deg": -14.75, "yaw_deg": 179.5}
_PLACE_1 = {"lat_deg": 30.2874595, "lon_deg": 120.1535765}
_PLACE_2 = {"lat_deg": -33.5, "lon_deg": -70.25}
_BOARD_1 = {"temperature_c": 38.0, "control_v": 12.34, "power_v": 47.9, "leak": 0}
_BOARD_2 = {"temperature_c": -5.25, "control_v": 655.35, "power_v": 0.0, "leak": 1}
_FORCES_1 = {"tx": 50, "ty": -50, "tz": 1, "mx": -1, "my": 2, "mz": 10}
_FORCES_2 = {"tx": -100, "ty": 100, "tz": 0, "mx": 3, "my": -4, "mz": -100}
OF_002: Mapping[str, tuple[Written, ...]] = {
    "coreboard.MAIN_TO_PC": (
        main_to_pc(
            {**_ANGLES_1, **_PLACE_1, "x_m": 12.5, "y_m": -3.25, "depth_m": 10.0}
            | {"altitude_m": 2.5, "avoid_m": 7.75, "reserved50": "00" * 12, "mode": 1, **_BOARD_1}
            | {**phases(12.5, -12.5, 0.1, -0.1, 179.9, -180.0), "ins_aligned": 1}
            | {"reserved83": "00" * 4}
        ),
        main_to_pc(
            {**_ANGLES_2, **_PLACE_2, "x_m": -12.5, "y_m": 3.25, "depth_m": -0.25}
            | {"altitude_m": 9.5, "avoid_m": 0.5, "reserved50": "0102030405060708090a0b0c"}
            | {"mode": 0, **_BOARD_2, **phases(0, 1, 2, 3, 4, 5), "ins_aligned": 0}
            | {"reserved83": "0d0e0f10"}
        ),
    ),
    "coreboard.PC_TO_MAIN": (
        pc_to_main(
            {**_PLACE_1, "x_m": 5.0, "y_m": -5.0, "depth_m": 10.5, "heading_deg": 90.0, "nav": 1}
            | {**_FORCES_1, "mode": 1, "closed_loop": 1, "ins_on": 1, "dvl_on": 1, "usbl_on": 0}
            | {"usbl_khz": 30, "angle_error_deg": -3, "passthrough": "0102030405060708090a0b"}
        ),
        pc_to_main(
            {**_PLACE_2, "x_m": -1.5, "y_m": 2.5, "depth_m": 0.5, "heading_deg": 270.5, "nav": 4}
            | {**_FORCES_2, "mode": 0, "closed_loop": 0, "ins_on": 0, "dvl_on": 0, "usbl_on": 1}
            | {"usbl_khz": 48, "angle_error_deg": 127, "passthrough": "ff" * 11}
        ),
    ),
    "coreboard.MAIN_TO_SENSOR": (
        main_to_sensor(
            {name: n % 2 for n, name in enumerate(SWITCHES)}
            | {"led1": 0, "led2": 100, "led3": 50, "led4": 1, "ptz": 255}
            | {"passthrough": bytes(range(16)).hex()}
        ),
        main_to_sensor(
            {name: 1 - n % 2 for n, name in enumerate(SWITCHES)}
            | {"led1": 7, "led2": 8, "led3": 9, "led4": 10, "ptz": 0, "passthrough": "24" * 16}
        ),
    ),
    "coreboard.SENSOR_TO_MAIN": (
        sensor_to_main(
            {"ad1": 1, "ad2": 2, "ad3": 3, "ad4": 65535, "reserved12": "0000", "depth_m": 12.5}
            | {"reserved18": "00" * 5, "leak_legacy_raw": 1, **_ANGLES_1, "p": 0.5, "q": -0.25}
            | {"r": 1.5, "ax": -1.5, "ay": 2.5, "az": 9.75, "mx": 3.5, "my": -4.5, "mz": 5.5}
            | {"dvl_x": 8.5, "dvl_y": -9.5, "dvl_z": 10.5, **_PLACE_1, "vo_x": 0.5, "vo_y": 1.25}
            | {"vo_z": 2.5, "usbl_x_m": 3.5, "usbl_y_m": -4.5, "altitude_m": 5.5}
            | {"reserved124": "00" * 3, "temperature2_c": 38.5, **_BOARD_1}
            | {**phases(1.5, -1.5, 0.0, 90.0, -90.0, 0.1), "ins_aligned": 1}
            | {"buf": "01020304", "valid": 31},
            ["DVL", "GPS", "INS", "VO", "USBL"],
        ),
        sensor_to_main(
            {"ad1": 5, "ad2": 6, "ad3": 7, "ad4": 8, "reserved12": "aabb", "depth_m": -0.25}
            | {"reserved18": "0102030405", "leak_legacy_raw": 0, **_ANGLES_2, "p": 7.5, "q": 8.5}
            | {"r": -9.5, "ax": 1.25, "ay": 2.25, "az": 3.25, "mx": 4.25, "my": 5.25, "mz": 6.25}
            | {"dvl_x": -1.0, "dvl_y": -2.0, "dvl_z": -3.0, **_PLACE_2, "vo_x": 11.0, "vo_y": 12.0}
            | {"vo_z": 13.0, "usbl_x_m": 14.0, "usbl_y_m": 15.0, "altitude_m": 16.0}
            | {"reserved124": "060708", "temperature2_c": -1.25, **_BOARD_2}
            | {**phases(0.2, 0.3, 0.4, 0.5, 0.6, 0.7), "ins_aligned": 0}
            | {"buf": "fafbfcfd", "valid": 5},
            ["DVL", "INS"],
        ),
    ),
    "coreboard.CAN_FORCE": (
        can(1, ("fx_g", "fy_g", "fz_g"), 16, 32, 48),
        can(1, ("fx_g", "fy_g", "fz_g"), -1, -32768, 32767),
    ),
    "coreboard.CAN_TORQUE": (
        can(2, ("mx_nm", "my_nm", "mz_nm"), 16, 32, 48),
        can(2, ("mx_nm", "my_nm", "mz_nm"), -1, 32767, -32768),
    ),
}

# --- 003 -------------------------------------------------------------------------------------------


def summed(link: str, head: bytes, body: bytes, values: Values) -> Written:
    return Written(link, head + body + bytes([sum(body) & 0xFF]) + b"\r\n", values)


def rov_up(v: Values) -> Written:
    units = (("a", "g"), ("g", "dps"), ("e", "deg"))
    floats = [v[f"{what}{axis}_{unit}"] for what, unit in units for axis in XYZ] + [v["depth_m"]]
    rpm = [v[f"rpm_{n}"] for n in ("left_front", "right_front", "left_up", "right_up")]
    rest = struct.pack("<10f5iB", *floats, *rpm, v["temperature_c"], v["metal_pct"])
    return summed("rov.up", b"\x55\xaa\x01\x40", b"\1\1\0" + rest, v)


def rov_down(v: Values) -> Written:
    rest = [v[n] for n in ("servo_deg", "x", "z", "f", "reserved")]
    body = bytes([1, 1, 0, v["hold_heading"], v["hold_depth"], v["led_pct"]])
    return summed("rov.down", b"\x55\xaa\x11\x17", body + struct.pack("<b3fi", *rest), v)


OF_003: Mapping[str, tuple[Written, ...]] = {
    "rov.UP": (
        rov_up(
            {"ax_g": 0.5, "ay_g": -0.25, "az_g": -1.0, "gx_dps": 1.5, "gy_dps": -2.5}
            | {"gz_dps": 3.5, "ex_deg": -6.5, "ey_deg": 7.5, "ez_deg": -179.5, "depth_m": 6.75}
            | {"rpm_left_front": -1000, "rpm_right_front": 1000, "rpm_left_up": -1}
            | {"rpm_right_up": 1, "temperature_c": 0, "metal_pct": 100}
        ),
        rov_up(
            {"ax_g": -0.5, "ay_g": 0.75, "az_g": 1.0, "gx_dps": 4.5, "gy_dps": 5.5}
            | {"gz_dps": -6.5, "ex_deg": 8.5, "ey_deg": -9.5, "ez_deg": 10.5, "depth_m": -0.25}
            | {"rpm_left_front": 10, "rpm_right_front": 20, "rpm_left_up": 30}
            | {"rpm_right_up": 40, "temperature_c": 100, "metal_pct": 0}
        ),
    ),
    "rov.DOWN": (
        rov_down(
            {"hold_heading": 1, "hold_depth": 0, "led_pct": 100, "servo_deg": -30}
            | {"x": 1.0, "z": -1.0, "f": 0.5, "reserved": 0}
        ),
        rov_down(
            {"hold_heading": 0, "hold_depth": 1, "led_pct": 1, "servo_deg": 30}
            | {"x": -0.25, "z": 0.75, "f": -1.0, "reserved": -7}
        ),
    ),
}

# --- 004 -------------------------------------------------------------------------------------------


def robot_down(address: int, command: int, user: bytes = b"", **said: Any) -> Written:
    full = user.ljust(6, b"\0")
    body = bytes([0xAA, address, command, len(user)]) + full
    values = {"address": address, "command": command, "length": len(user), "user": full.hex()}
    derived = {"at": said.pop("at")} if "at" in said else {}
    raw = body + bytes([sum(body) % 255]) + b"\xdd"
    return Written("robot.down", raw, {**values, **said}, derived)


def robot_up(speed: int, millivolts: int) -> Written:
    body = b"\xaa" + struct.pack("<hH", speed, millivolts)
    raw = body + bytes([sum(body) % 255]) + b"\xdd"
    return Written("robot.up", raw, {"speed_mm_s": speed, "voltage_mv": millivolts})


def alarm(command: int, name: str, thousandths: int, shown: str) -> Written:
    user = struct.pack("<I", thousandths)
    return robot_down(4, command, user, thousandths=thousandths, at=f"AT+{name}+{shown}\r\n")


OF_004: Mapping[str, tuple[Written, ...]] = {
    "robot.DOWN": (
        *(robot_down(1, command) for command in (*range(11), 0xFF)),
        robot_down(1, 0x20, struct.pack("<h", -500), speed_mm_s=-500),
        robot_down(1, 0x20, struct.pack("<h", 50), speed_mm_s=50),  # its sum is 255: sent as 0
        robot_down(2, 0),
        robot_down(2, 1, b"\2", video=2),
        robot_down(2, 2, struct.pack("<hh", -9000, 4550), yaw_cdeg=-9000, pitch_cdeg=4550),
        robot_down(2, 3, b"\xff", zoom=255),
        *(robot_down(4, n, at=f"AT{query}\r\n") for n, query in enumerate(("", "+V", "+C", "+P"))),
        robot_down(4, 4, b"\x14", max_current_a=20, at="AT+MAXC+20\r\n"),
        robot_down(4, 5, b"\2", alarm_mode=2, at="AT+MODE+UNDERV\r\n"),
        alarm(6, "OVERVERR", 36000, "36"),
        alarm(7, "UNDERVERR", 21000, "21"),
        alarm(8, "OVERCERR", 12500, "12.5"),
        alarm(9, "UNDERCERR", 1, "0.001"),
        alarm(10, "OVERPERR", 1080000, "1080"),
    ),
    "robot.UP": (robot_up(-1, 36000), robot_up(0x5DD, 0xDDAA)),
}
FRAMES: Mapping[str, tuple[Written, ...]] = {**OF_000, **OF_002, **OF_003, **OF_004}


def of(frame: str, row: str) -> Iterator[Written]:
    """Those in which the row stands."""
    for one in FRAMES[frame]:
        if frame == "robot.DOWN":
            if row == f"{one.values['address']}:{one.values['command']}":
                yield one
        elif frame == "auv.ZA":
            if row == one.values["code"]:
                yield one
        elif not row or row in {**one.values, **one.derived}:
            yield one
