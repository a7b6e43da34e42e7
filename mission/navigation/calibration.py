"""Calibration from dives with fixes: speed scale, compass bias, its deviation, noise figures.

Each log is filtered with wide priors; what its fixes taught about scale, bias and deviation is
the information that its posterior has beyond the prior (Maybeck, Stochastic Models, Estimation,
and Control 1, 1979, ch. 5.7: information adds over independent data), so logs of any length add
up. White noise of a sensor is what is left of its third differences (a ramp and a bend of it
cancel; Brockwell and Davis, Time Series, 1991, ch. 1.4).

The proof is the error with which each dive ends: the estimate against the first fix that comes
again, with the vehicle file before and after; with several logs, "after" is calibrated on the
others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from mission.navigation.filter import Array
from mission.navigation.model import COMPASS, COS, SCALE, SIN, STATES
from mission.navigation.navigator import Navigation
from mission.vehicle import Calibration, Deviation, Sensors, Vehicle
from protocol.messages import Fix, Telemetry

Inputs = Sequence[Telemetry | Fix]

_WIDE_SCALE, _WIDE_BIAS, _WIDE_DEVIATION = 0.3, math.radians(15.0), math.radians(4.0)
_LEAST_SCALE, _LEAST_BIAS, _LEAST_DEVIATION = 0.02, math.radians(1.0), math.radians(0.5)
_FITTED = (SCALE, COMPASS, SIN, COS)
_DIVE = 60.0  # s without a fix
_ENOUGH = 20  # differences without which a noise figure stays as it was


class CalibrationError(ValueError):
    """The operator must act: these logs cannot calibrate; says what is missing."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """A dive from one fix to another: what was missed at its end, of what was swum (m)."""

    log: int
    begin: float
    end: float
    distance: float
    before: float
    after: float


@dataclass(frozen=True, slots=True)
class Calibrated:
    vehicle: Vehicle
    sigmas: tuple[float, float, float, float]  # of scale, bias, and the deviation's sin and cos
    stretches: tuple[Stretch, ...]
    held_out: bool  # "after" was calibrated on other logs

    def percent(self) -> tuple[float, float]:
        """Median error before and after, in % of distance."""
        known = [s for s in self.stretches if s.distance > 1.0]
        if not known:
            return math.nan, math.nan
        before = median(100.0 * s.before / s.distance for s in known)
        return before, median(100.0 * s.after / s.distance for s in known)


def calibrate(logs: Sequence[Inputs], vehicle: Vehicle) -> Calibrated:
    """Raises CalibrationError."""
    logs = [sorted(log, key=lambda item: item.t) for log in logs]
    if not any(len([i for i in log if isinstance(i, Fix)]) >= 2 for log in logs):
        raise CalibrationError("no log has two fixes: there is nothing to compare with")
    taught = [_information(log, vehicle) for log in logs]
    fitted, sigmas = _fit(vehicle, taught)
    done = _noise(fitted, logs)
    held_out = len(logs) > 1
    stretches: list[Stretch] = []
    for i, log in enumerate(logs):
        others = [t for j, t in enumerate(taught) if j != i]
        tried = _fit(vehicle, others)[0] if held_out else fitted
        stretches += _compare(i, log, vehicle, tried)
    return Calibrated(done, sigmas, tuple(stretches), held_out)


# --- fit -----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Information:
    matrix: Array  # 4 x 4
    vector: Array
    declination: float


def _prior() -> Array:
    wide = (_WIDE_SCALE, _WIDE_BIAS, _WIDE_DEVIATION, _WIDE_DEVIATION)
    return np.diag([1.0 / s**2 for s in wide])


def _information(log: Inputs, vehicle: Vehicle) -> _Information:
    """Of the four, about (scale - 1, bias, sin, cos), beyond the prior."""
    wide = replace(
        vehicle,
        sensors=replace(vehicle.sensors, heading_bias=_WIDE_BIAS),
        calibration=replace(
            vehicle.calibration, speed_scale_sigma=_WIDE_SCALE, deviation_sigma=_WIDE_DEVIATION
        ),
    )
    nav = Navigation(wide)
    for item in log:
        if isinstance(item, Fix):
            nav.fix(item)
        else:
            nav.telemetry(item)
    x = nav.core.filter.x - np.eye(STATES)[SCALE]
    p = nav.core.filter.covariance[np.ix_(_FITTED, _FITTED)]
    matrix = np.linalg.inv(p)
    return _Information(matrix - _prior(), matrix @ x[list(_FITTED)], nav.declination)


def _fit(
    vehicle: Vehicle, taught: Sequence[_Information]
) -> tuple[Vehicle, tuple[float, float, float, float]]:
    matrix = _prior() + sum((t.matrix for t in taught), np.zeros((4, 4)))
    covariance = np.linalg.inv(matrix)
    x = covariance @ sum((t.vector for t in taught), np.zeros(4))
    scale, bias, a, b = x.tolist()
    sigmas = np.sqrt(np.diag(covariance)).tolist()
    known, old = vehicle.calibration, vehicle.calibration.deviation
    turn = taught[0].declination - vehicle.compass_bias if taught else 0.0
    c, s = math.cos(turn), math.sin(turn)  # the filter's phase is the corrected heading's
    deviation = replace(old, sin1=old.sin1 + a * c - b * s, cos1=old.cos1 + a * s + b * c)
    return replace(
        vehicle,
        compass_bias=vehicle.compass_bias + bias,
        sensors=replace(vehicle.sensors, heading_bias=max(sigmas[1], _LEAST_BIAS)),
        calibration=replace(
            known,
            speed_scale=known.speed_scale * (1.0 + scale),
            speed_scale_sigma=max(sigmas[0], _LEAST_SCALE),
            deviation=deviation,
            deviation_sigma=max(*sigmas[2:], _LEAST_DEVIATION),
        ),
    ), (sigmas[0], sigmas[1], sigmas[2], sigmas[3])


# --- noise ---------------------------------------------------------------------------------------


def _noise(vehicle: Vehicle, logs: Sequence[Inputs]) -> Vehicle:
    reports = [[i for i in log if isinstance(i, Telemetry)] for log in logs]
    old = vehicle.sensors
    depth = _white(reports, lambda t: t.depth)
    sensors: Sensors = replace(
        old,
        depth=old.depth if depth is None else max(depth * math.sqrt(2.0), 0.01),
        altitude=_or(_white(reports, lambda t: t.altitude), old.altitude, 0.01),
        heading=_or(_white(reports, lambda t: t.heading, circular=True), old.heading, 2e-3),
        fix=_or(_fix_noise(logs, vehicle), old.fix, 0.01),
    )
    return replace(vehicle, sensors=sensors)


def _or(found: float | None, kept: float, least: float) -> float:
    return kept if found is None else max(found, least)


def _white(
    logs: Sequence[Sequence[Telemetry]],
    read: Callable[[Telemetry], float | None],
    *,
    circular: bool = False,
) -> float | None:
    """Sigma of white noise by the median of third differences: bends and repeats do not count."""
    found: list[float] = []
    for log in logs:
        for window in zip(*(log[i:] for i in range(4)), strict=False):
            values = [read(t) for t in window]
            if any(v is None for v in values) or len(set(values)) < 4:
                continue
            a, b, c, d = (float(v) for v in values if v is not None)
            third = d - 3.0 * c + 3.0 * b - a
            found.append(abs(math.remainder(third, 2.0 * math.pi) if circular else third))
    if len(found) < _ENOUGH:
        return None
    return median(found) / 0.6745 / math.sqrt(20.0)  # of |normal|; 1 + 9 + 9 + 1


def _fix_noise(logs: Sequence[Inputs], vehicle: Vehicle) -> float | None:
    """By the innovations of fixes one second after another (the filter adds little to them)."""
    squares: list[float] = []
    for log in logs:
        nav = Navigation(vehicle)
        for item in log:
            if isinstance(item, Telemetry):
                nav.telemetry(item)
                continue
            last = nav.core.last_fix
            nav.fix(item)
            if last is not None and item.t - last < 1.5 and nav.core.fix_nis is not None:
                squares.append(item.accuracy**2 * nav.core.fix_nis / 2.0)
    return math.sqrt(sum(squares) / len(squares)) if len(squares) >= _ENOUGH else None


# --- proof ---------------------------------------------------------------------------------------


def _compare(log_number: int, log: Inputs, before: Vehicle, after: Vehicle) -> list[Stretch]:
    one, two = (_missed(log, vehicle) for vehicle in (before, after))
    return [
        Stretch(log_number, a.begin, a.end, a.distance, a.error, b.error)
        for a, b in zip(one, two, strict=True)
    ]


@dataclass(frozen=True, slots=True)
class _Dive:
    begin: float
    end: float
    distance: float
    error: float


def _missed(log: Inputs, vehicle: Vehicle) -> list[_Dive]:
    """How far the estimate is from the first fix after each dive, before it is used."""
    nav, found = Navigation(vehicle), []
    last, swum, seen = -math.inf, 0.0, 0.0
    for item in log:
        if isinstance(item, Telemetry):
            nav.telemetry(item)
            estimate = nav.estimate(item.t)
            swum += abs(estimate.speed) * (item.t - seen) if estimate and seen else 0.0
            seen = item.t
            continue
        estimate = nav.estimate(item.t)
        if estimate is not None and nav.frame is not None and item.t - last >= _DIVE:
            north, east = nav.frame.to_local(item.latitude, item.longitude)
            if last > -math.inf:
                error = math.hypot(north - estimate.north, east - estimate.east)
                found.append(_Dive(last, item.t, swum, error))
        nav.fix(item)
        last, swum = item.t, 0.0
    return found


# --- text ----------------------------------------------------------------------------------------


def section(vehicle: Vehicle) -> str:
    """The part of a vehicle file that calibration replaces."""
    s, c = vehicle.sensors, vehicle.calibration
    deviation = ", ".join(f"{name}: {_deg(value)}" for name, value in _harmonics(c.deviation))
    declination = "auto" if vehicle.declination is None else f"{_deg(vehicle.declination)}"
    return f"""sensors:                     # one sigma (calibrated)
  depth: {s.depth:.3f} m
  altitude: {s.altitude:.3f} m
  heading: {_deg(s.heading)}
  heading_bias: {_deg(s.heading_bias)}
  fix: {s.fix:.2f} m
  telemetry_period: {s.telemetry_period:g} s
compass: {{declination: {declination}, bias_deg: {math.degrees(vehicle.compass_bias):.2f}}}
calibration:
  speed_scale: {c.speed_scale:.4f}        # on speed_by_gear
  speed_scale_sigma: {c.speed_scale_sigma:.4f}
  deviation: {{{deviation}}}
  deviation_sigma: {_deg(c.deviation_sigma)}
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
