"""Texts of a calibration: the section of a vehicle file, and what the logs did not teach.

What does not live here: how the figures are found (calibration).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from mission.analysis.adrift import ENOUGH as DIVES
from mission.analysis.calibration import Calibrated, Lesson
from mission.analysis.floating import ENOUGH as RISES
from mission.analysis.information import FIGURES
from mission.analysis.noise import ENOUGH
from mission.model import Position
from mission.model.units import quantity
from mission.model.vehicle import Calibration, Deviation, Vehicle
from mission.model.vehicle_ranges import RANGES

_HEARD = {
    "depth": "a minute of reports under water",
    "altitude": "a minute of reports with an echo",
    "heading": "a minute of reports under way",
    "fix": "half a minute at the surface with a fix every second",
    "fix_velocity": "half a minute at the surface with speed and course from the receiver",
    "motion": "legs of a minute or more at the surface with a fix every second, by a receiver that "
    "tells speed and course, or is good to some decimetres (speed_noise and sway_noise)",
}
_DRIFT = "surface_drift"
_NAMES = (*_HEARD, _DRIFT, *(row.name for row in FIGURES))


def untaught(done: Calibrated) -> list[str]:
    """Return a line for each figure that is kept as it was: how little is known, and what to
    fly."""
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
    if not _drift_taught(done):
        lines.append(
            f"these logs hold {done.drift.dives if done.drift else 0} dives that end with a fix, "
            f"and fewer than {DIVES} never narrow {_DRIFT}: kept as it was; to teach it fly, with "
            "half a minute of fixes before, dives of ten minutes or more that end with a fix"
        )
    if done.rise is None:
        lines.append(
            f"these logs hold no float test (fewer than {RISES} rises with nothing turning): the "
            "rise by buoyancy alone: kept as it was; to teach it fly float-test, or a copy of it "
            "that lets go deeper"
        )
    return lines


def _drift_taught(done: Calibrated) -> bool:
    return done.drift is not None and done.drift.share != 1.0


def rise(done: Calibrated) -> str:
    """Return the vehicle file's lines on the rise by buoyancy; "" if no log taught it."""
    found = done.rise
    if found is None:
        return ""
    least, why = found.at_least, f"{found.rate:.3f} less two sigma"
    return f"""ascent_buoyancy: {least:.3f} m/s   # at least: {why}
ascent_measured: {found.day}    # by {found.rises} rises
"""


def _said(lesson: Lesson, sigma: float) -> str:
    name = lesson.figure.name
    if name == "speed_scale":
        return f"{100.0 * sigma:.1f} %"
    return f"{sigma:.2f} m/s" if name == "current" else _deg(sigma)


def taught(done: Calibrated) -> list[str]:
    """Return a line for each figure that is taken over, with its sigma; then the drift, and the
    factor by which the dives' errors differ from what the figures say."""
    lines = [
        f"{o.figure.name}: one sigma {_said(o, o.logs)} by these logs, "
        f"{_said(o, o.before)} in the vehicle file"
        for o in done.lessons
        if o.taken
    ]
    if done.drift is not None and _drift_taught(done):
        lines.append(
            f"{_DRIFT}: {done.drift.share:.2f} times the vehicle file's, by the ends of "
            f"{done.drift.dives} dives of {done.drift.length / 60.0:.0f} min"
        )
    if done.trusted != 1.0:
        lines.append(
            f"the dives ended {done.trusted:.2f} times as far off as these figures say: each sigma "
            "of what moves a position is written so many times as wide, taught or not"
        )
    return lines


def left_out(done: Calibrated, names: Sequence[str]) -> list[str]:
    """Return a line for each log of ``names`` that is not counted, and why."""
    lines = [
        f"{names[i]}: a copy of {names[j]}, or a piece of it: counted once" for i, j in done.copies
    ]
    return lines + [
        f"{names[i]}: stands apart from the other logs in {name}: not counted"
        for i, name in done.apart
    ]


def kept(done: Calibrated) -> frozenset[str]:
    """Return the names of the figures that stay as in the vehicle file."""
    still = frozenset() if _drift_taught(done) else frozenset({_DRIFT})
    return still.union(done.unheard, (o.figure.name for o in done.lessons if not o.taken))


def section(vehicle: Vehicle, kept: Collection[str] = (), waters: Position | None = None) -> str:
    """Return the part of a vehicle file that calibration replaces. ``kept``: marked as not taught.
    ``waters``: where the current was found, as a comment for the reader."""
    s, c = vehicle.sensors, vehicle.calibration
    old = {name: "   # as it was: not taught" if name in kept else "" for name in _NAMES}
    if waters is not None and "current" not in kept:
        old["current"] = f"   # near {waters.latitude_deg:.2f}, {waters.longitude_deg:.2f} alone"
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
{_others(c, old)}{_added(vehicle)}"""


def _added(vehicle: Vehicle) -> str:
    """Write the sigmas of added sensors, if there are any, each in the unit of its range."""
    said = []
    for kind, sigma in vehicle.added.items():
        unit = RANGES[f"added.{kind}"].unit
        said.append(f"{kind}: {sigma / quantity(1.0, unit):.3f} {unit}")
    return f"added: {{{', '.join(said)}}}\n" if said else ""


def _harmonics(deviation: Deviation) -> list[tuple[str, float]]:
    return [(name, getattr(deviation, name)) for name in ("sin1", "cos1", "sin2", "cos2")]


def _others(known: Calibration, old: Mapping[str, str]) -> str:
    """Write motion and water, including what calibration left as it was: the section is
    complete."""
    north, east = known.current
    sigma = (
        "" if known.current_sigma is None else f"  current_sigma: {known.current_sigma:.3f} m/s\n"
    )
    return f"""  speed_noise: {known.speed_noise:.3f} m/s{old["motion"]}
  speed_time: {known.speed_time:g} s
  surge_length: {known.surge_length:g} m
  turn_loss: {known.turn_loss:g} s
  turn_slip: {known.turn_slip:g} s
  turn_slip_time: {known.turn_slip_time:g} s
  sway_noise: {known.sway_noise:.4f}{old["motion"]}
  compass_wander: {_deg(known.compass_wander)}
  compass_wander_time: {known.compass_wander_time:g} s
  surface_drift: {known.surface_drift:.4f} m/s{old["surface_drift"]}
  fix_velocity: {known.fix_velocity:.3f} m/s{old["fix_velocity"]}
  current: {{north: {north:.3f}, east: {east:.3f}}}{old["current"]}
{sigma}{_steady(known)}"""


def _steady(known: Calibration) -> str:
    """Write how slowly the current changes, and for how long, if dives taught it."""
    if not known.current_time_for:
        return ""
    return f"""  current_time: {known.current_time:.0f} s   # it changes so slowly
  current_time_for: {known.current_time_for:.0f} s   # after a fix; later as a tide
"""


def _deg(value: float) -> str:
    return f"{math.degrees(value):.2f} deg"
