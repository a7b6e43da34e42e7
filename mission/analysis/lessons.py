"""What calibration says: the section of a vehicle file, and what the logs did not teach.

What does not live here: how it is found (calibration).
"""

from __future__ import annotations

import math
from collections.abc import Collection

from mission.analysis.calibration import ENOUGH, FIGURES, Calibrated, Lesson
from mission.analysis.floating import ENOUGH as RISES
from mission.model.vehicle import Calibration, Deviation, Vehicle

_HEARD = {
    "depth": "a minute of reports under water",
    "altitude": "a minute of reports with an echo",
    "heading": "a minute of reports under way",
    "fix": "half a minute at the surface with a fix every second",
}
_NAMES = (*_HEARD, *(row.name for row in FIGURES))


def untaught(done: Calibrated) -> list[str]:
    """A line for each figure that stays as it was: how little is known of it, what to fly."""
    lines = [
        f"these logs teach too little about {o.figure.name}: one sigma is {_said(o, o.logs)} "
        f"by them, {_said(o, o.before)} in the vehicle file: kept as it was; "
        f"to teach it fly, with fixes: {o.figure.fly}"
        for o in done.lessons
        if not o.taken
    ]
    lines += [
        f"these logs teach nothing about the noise of {name}: fewer than {ENOUGH} readings that "
        f"can be compared: kept as it was; to teach it log {_HEARD[name]}"
        for name in done.unheard
    ]
    if done.rise is None:
        lines.append(
            f"these logs hold no float test (fewer than {RISES} rises with nothing turning): the "
            "rise by buoyancy alone: kept as it was; to teach it fly float-test, or a copy of it "
            "that lets go deeper"
        )
    return lines


def rise(done: Calibrated) -> str:
    """The lines of a vehicle file that say how fast it rises by itself; "" if nothing taught it."""
    found = done.rise
    if found is None:
        return ""
    least, why = found.at_least, f"{found.rate:.3f} less two sigma"
    return f"""ascent_buoyancy: {least:.3f} m/s   # at least: {why}
ascent_measured: {found.day}    # by {found.rises} rises
"""


def _said(lesson: Lesson, sigma: float) -> str:
    return f"{100.0 * sigma:.1f} %" if lesson.figure.name == "speed_scale" else _deg(sigma)


def kept(done: Calibrated) -> frozenset[str]:
    """Names of the figures that stay as the vehicle file has them."""
    return frozenset(o.figure.name for o in done.lessons if not o.taken) | set(done.unheard)


def section(vehicle: Vehicle, kept: Collection[str] = ()) -> str:
    """The part of a vehicle file that calibration replaces; ``kept`` is marked as not taught."""
    s, c = vehicle.sensors, vehicle.calibration
    old = {name: "   # as it was: not taught" if name in kept else "" for name in _NAMES}
    deviation = ", ".join(f"{name}: {_deg(value)}" for name, value in _harmonics(c.deviation))
    declination = "auto" if vehicle.declination is None else f"{_deg(vehicle.declination)}"
    return f"""sensors:                     # one sigma (calibrated)
  depth: {s.depth:.3f} m{old["depth"]}
  altitude: {s.altitude:.3f} m{old["altitude"]}
  heading: {_deg(s.heading)}{old["heading"]}
  heading_bias: {_deg(s.heading_bias)}{old["heading_bias"]}
  fix: {s.fix:.2f} m{old["fix"]}
  telemetry_period: {s.telemetry_period:g} s
compass: {{declination: {declination}, bias_deg: {math.degrees(vehicle.compass_bias):.2f}}}
calibration:
  speed_scale: {c.speed_scale:.4f}        # on speed_by_gear
  speed_scale_sigma: {c.speed_scale_sigma:.4f}{old["speed_scale"]}
  deviation: {{{deviation}}}
  deviation_sigma: {_deg(c.deviation_sigma)}{old["deviation"]}
{_others(c)}"""


def _harmonics(deviation: Deviation) -> list[tuple[str, float]]:
    return [(name, getattr(deviation, name)) for name in ("sin1", "cos1", "sin2", "cos2")]


def _others(known: Calibration) -> str:
    """What calibration leaves as it was, so that the section is whole."""
    current = f"{{north: {known.current[0]:g}, east: {known.current[1]:g}}}"
    sigma = "" if known.current_sigma is None else f"  current_sigma: {known.current_sigma:g} m/s\n"
    return f"""  speed_noise: {known.speed_noise:g} m/s
  speed_time: {known.speed_time:g} s
  surge_length: {known.surge_length:g} m
  turn_loss: {known.turn_loss:g} s
  turn_slip: {known.turn_slip:g} s
  turn_slip_time: {known.turn_slip_time:g} s
  sway_noise: {known.sway_noise:g}
  compass_wander: {_deg(known.compass_wander)}
  compass_wander_time: {known.compass_wander_time:g} s
  surface_drift: {known.surface_drift:g} m/s
  current: {current}
{sigma}"""


def _deg(value: float) -> str:
    return f"{math.degrees(value):.2f} deg"
