"""The unit of a decoded value: by the suffix of its name, else by its frame.

What does not live here: units of mission texts (mission.model.units). Messages are in SI.
"""

from __future__ import annotations

_BY_SUFFIX = {
    "deg": "deg",
    "m": "m",
    "c": "deg C",
    "v": "V",
    "mps": "m/s",
    "g": "g",
    "nm": "N m",
    "dps": "deg/s",
    "pct": "%",
    "khz": "kHz",
    "cdeg": "0.01 deg",
    "mv": "mV",
    "a": "A",
    "s": "mm/s",
}
_BY_FRAME = {
    "auv.SD.pwm_": "us",
    "auv.VS.pwm_": "us",
    "auv.SD.mag_": "uT",
    "auv.VS.mag_": "nT",
    "auv.SD.battery_": "counts",
    "auv.VS.battery_": "V",
    "auv.VS.ground_speed": "cm/s",
    "auv.SP.minutes": "min",
    "auv.AES.report_age": "s",
    "auv.AES.fix_age": "s",
    "auv.AES.to_time": "min",
    "auv.MD.angle": "deg",
    "auv.D.angle": "deg",
    "auv.MS.angle": "deg",
    "auv.MP.angle": "deg",
    "coreboard.MAIN_TO_PC.usbl": "deg",
    "coreboard.SENSOR_TO_MAIN.usbl": "deg",
    "coreboard.MAIN_TO_SENSOR.led": "%",
    "rov.UP.rpm_": "r/min",
    "robot.DOWN.thousandths": "0.001",
}


def unit(frame: str, name: str) -> str:
    """Return the unit; "" for a pure number, a code or a text."""
    by_frame = next((u for key, u in _BY_FRAME.items() if f"{frame}.{name}".startswith(key)), "")
    suffix = name.rpartition("_")[2]
    return _BY_SUFFIX.get(suffix, by_frame) if "_" in name else by_frame
