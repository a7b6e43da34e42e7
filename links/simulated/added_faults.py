"""Faults of added sensors: rows as in faults, for vehicles that have these sensors.

    speed_log_wild, doppler_frozen, ...   each sensor with each lie
    gps2_stuck, gps2_wanders, ...         the second receiver

What does not live here: what a lie does to a value (added).
"""

from __future__ import annotations

from links.simulated.added import LIES, SENSORS, Lie, usual
from links.simulated.fault import Fault, Parts

_SAYS = {
    "frozen": "says the last for ever",
    "silent": "says nothing",
    "wild": "says anything",
    "offset": "is off",
    "drift": "drifts",
    "delay": "comes late",
}
_UNITS = {"speed_log": "m/s", "doppler": "m/s", "acoustic": "m", "ranges": "m"}
SECOND = "second_gps"  # the setting


def _lies(sensor: str, how: str) -> Fault:
    def begin(vehicle: Parts, value: float) -> None:
        if vehicle.added is not None:
            vehicle.added.lies[sensor] = Lie(how, vehicle.now, value)

    def end(vehicle: Parts, _: float) -> None:
        if vehicle.added is not None:
            vehicle.added.lies.pop(sensor, None)

    valued = how not in ("frozen", "silent")
    unit = {"delay": "s", "drift": f"{_UNITS[sensor]}/s"}.get(how, _UNITS[sensor])
    says = f"the added {sensor.replace('_', ' ')} {_SAYS[how]}"
    value = usual(sensor, how) if valued else 0.0
    return Fault(says, begin, end, value, unit if valued else "", needs=sensor, slot=sensor)


def _second(part: str, says: str) -> Fault:
    def begin(vehicle: Parts, _: float) -> None:
        if vehicle.second_gps is not None:
            setattr(vehicle.second_gps, part, True)

    def end(vehicle: Parts, _: float) -> None:
        if vehicle.second_gps is not None:
            setattr(vehicle.second_gps, part, False)

    return Fault(f"the second receiver {says}", begin, end, needs=SECOND)


def _beside(vehicle: Parts, metres: float) -> None:
    if vehicle.second_gps is not None:
        vehicle.second_gps.offset = (metres, 0.0)


def _true(vehicle: Parts, _: float) -> None:
    _beside(vehicle, 0.0)


ADDED_FAULTS: dict[str, Fault] = {
    **{f"{sensor}_{how}": _lies(sensor, how) for sensor in SENSORS for how in LIES},
    "gps2_lost": _second("blind", "has no fix"),
    "gps2_silent": _second("silent", "sends nothing"),
    "gps2_stuck": _second("stuck", "repeats its last fix, under water too"),
    "gps2_wanders": _second("wanders", "says plausible places under water, too"),
    "gps2_jump": Fault(
        "fixes of the second receiver are beside the truth, northward",
        _beside,
        _true,
        200.0,
        "m",
        needs=SECOND,
    ),
}
