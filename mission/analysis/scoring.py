"""The accuracy and consistency of the estimate on recordings of real vehicles.

    runs      start   a fix in the first row, none after
              150s    fixes during the first 150 s, none after
              each with the heading as recorded, and +noise: 3 deg bias, 2 deg noise, seed 0
    gliders   dives   the estimate when the first fix after a dive comes, before it is used

Errors are in % of the true path since the last fix. The path of a glider under water is not known:
its own estimate of the path is used. Coverage is the share of samples whose 95 % ellipse contains
the truth. Ellipse is the mean radius of that ellipse in % of the path at the end.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from mission.analysis import references
from mission.analysis.calibration import CalibrationError
from mission.analysis.missed import trust
from mission.analysis.recordings import (
    ADRIFT,
    CRUISE_PWM,
    NEAREST,
    NEUTRAL_PWM,
    UNUSABLE,
    Recording,
    RecordingError,
    read,
    surfaced,
    wire,
)
from mission.analysis.scores import Score
from mission.analysis.teaching import calibrate_by
from mission.model import Estimate
from mission.model.vehicle import Calibration, Curve, Vehicle
from mission.navigation.declination import declination
from mission.navigation.navigator import Navigation
from protocol.messages import Fix, Telemetry

Array = NDArray[np.float64]

CHI2_95 = 5.991  # 2 degrees of freedom
_LEARNING = 150.0  # s of fixes
_DEEP, _LONG = 5.0, 1000.0  # m and s: the least of a dive
_HALVED = 8  # dives: with fewer, one half teaches too little
_CRUISE = 8.0  # gear of the runs
_RUN_HEADING = 0.0  # declination of runs: their heading is true
# for a run without any other recording
_UNKNOWN_SPEED = Curve((0.0, 8.0, 12.0), (0.0, 1.5, 1.5))
_UNKNOWN = Calibration(
    speed_scale_sigma=0.4, speed_noise=0.3, speed_time=200.0, sway_noise=0.05, current_sigma=0.2
)


@dataclass(frozen=True, slots=True)
class _Sample:
    error: float
    nees: float
    radius: float  # of the 95 % ellipse, geometric mean
    path: float


def _still(**known: float | tuple[float, float]) -> Callable[[Vehicle], Vehicle]:
    """Return a function that sets these figures of a vehicle's calibration."""
    return lambda v: replace(v, calibration=replace(v.calibration, **known))  # type: ignore[arg-type]


WITHOUT: Mapping[str, Callable[[Vehicle], Vehicle]] = MappingProxyType(
    {
        "waters": _still(current=(0.0, 0.0), current_sigma=0.2),
        "current": _still(current=(0.0, 0.0), current_sigma=0.0, surface_drift=1e-4),
        "surface drift": _still(surface_drift=1e-4),
        "scale": _still(speed_scale_sigma=1e-4),
        "speed noise": _still(speed_noise=1e-4),
        "sway": _still(sway_noise=0.0),
        "deviation": _still(deviation_sigma=1e-5),
        "compass": lambda v: replace(
            v,
            sensors=replace(v.sensors, heading_bias=0.0),
            calibration=replace(v.calibration, deviation_sigma=1e-5),
        ),
        "declination": lambda v: replace(v, declination=0.0),
    }
)
"""What a state earns is what is lost without it: the figure that takes it away."""


def score_folder(
    folder: Path, vehicle: Vehicle, without: Sequence[str] = ()
) -> tuple[list[Score], list[str]]:
    """Score every CSV of the two formats below ``folder``; also return what was left out, and
    why."""
    recordings: list[Recording] = []
    refused: list[str] = []
    files = (f for f in sorted(folder.rglob("*")) if f.suffix.lower() == ".csv" and f.is_file())
    for file in files:
        try:
            found = replace(read(file), name=file.relative_to(folder).as_posix())
        except (RecordingError, OSError) as error:
            refused.append(str(error))
            continue
        recordings.append(found)
        if found.skipped:
            refused.append(f"{file}: {found.skipped} rows {UNUSABLE}")
        if found.adrift:
            refused.append(f"{file}: {found.adrift} rows {ADRIFT}")
    if not recordings:
        refused.append(f"{folder}: no recording (.csv) in it or below it")
    scores = score(recordings, vehicle, without)
    scored = {s.file for s in scores}
    idle = [r.name for r in recordings if r.name not in scored]
    refused += [f"{name}: no dive between two fixes: nothing to score" for name in idle]
    return scores, refused


def score(
    recordings: Sequence[Recording], vehicle: Vehicle, without: Sequence[str] = ()
) -> list[Score]:
    """Score recordings. ``without`` names rows of ``WITHOUT``."""
    runs = [r for r in recordings if not r.glider]
    scores: list[Score] = []
    for recording in recordings:
        if recording.glider:
            scores += _glider(
                recording, _deprived(glider_vehicle(vehicle, recording.period), without)
            )
        else:
            others = [r for r in runs if r is not recording and not r.overlaps(recording)]
            scores += _run(recording, others, vehicle, without)
    return scores


# --- runs ----------------------------------------------------------------------------------------


def _deprived(vehicle: Vehicle, without: Sequence[str]) -> Vehicle:
    for name in without:
        vehicle = WITHOUT[name](vehicle)
    return vehicle


def _run(
    run: Recording, others: Sequence[Recording], vehicle: Vehicle, without: Sequence[str]
) -> list[Score]:
    scores = []
    for suffix, compass in (("", lambda h: h), ("+noise", noisy)):
        heading = compass(run.heading)
        known = _deprived(run_vehicle(vehicle, others, compass, run.period), without)
        for name, until in (("start", 0.0), ("150s", _LEARNING)):
            samples = _reckon_run(run, heading, until, known)
            if not samples:
                continue
            reckoned = [
                references.constant_speed(run, heading, given)
                if until == 0.0
                else references.least_squares(run, heading, given, until)
                for given in _given(others, known)
            ]
            reference, equal = reckoned or (None, None)
            scores.append(_sum_up(run.name, name + suffix, samples, reference, {}, equal))
    return scores


def _given(others: Sequence[Recording], known: Vehicle) -> list[references.Known]:
    """Return what the references know: the speed over ground only, then all that `calibrate`
    found."""
    if not others:
        return []
    ground = references.Known(float(np.mean([references.ground_speed(o) for o in others])))
    speed = known.calibration.speed_scale * known.speed_by_gear.at(_CRUISE)
    equal = references.Known(speed, known.calibration.current, known.compass_bias)
    return [ground, equal]


def noisy(heading: Array) -> Array:
    """Add the errors of a small compass: 3 deg bias, 2 deg noise, seed 0."""
    rng = random.Random(0)
    errors = np.radians([3.0 + rng.gauss(0.0, 2.0) for _ in heading])
    noised: Array = heading + errors
    return noised


def run_vehicle(
    vehicle: Vehicle,
    others: Sequence[Recording],
    compass: Callable[[Array], Array],
    period: float,
) -> Vehicle:
    """Return the vehicle file as `calibrate` changes it from the other runs; with wide figures if
    that is not possible. ``period``: time between two reports, s."""
    known = replace(
        vehicle,
        declination=_RUN_HEADING,
        glides=False,
        sensors=replace(vehicle.sensors, telemetry_period=period),
    )
    try:
        return calibrate_by(others, known, compass).vehicle
    except CalibrationError:
        return replace(known, speed_by_gear=_UNKNOWN_SPEED, calibration=_UNKNOWN)


def _reckon_run(run: Recording, heading: Array, until: float, known: Vehicle) -> list[_Sample]:
    fixes = [i for i, t in enumerate(run.t.tolist()) if t <= until]
    nav, path, last = Navigation(known, run.origin), run.path, fixes[-1]
    samples: list[_Sample] = []
    if path[-1] - path[last] < NEAREST:
        return samples
    for item in wire(run, fixes, heading, CRUISE_PWM):
        _feed(nav, item)
        if isinstance(item, Telemetry) and item.t > run.t[last] + 10.0:
            i = int(np.searchsorted(run.t, item.t - 1e-6))
            estimate = nav.estimate(item.t)
            assert estimate is not None
            truth = float(run.north[i]), float(run.east[i])
            samples.append(_sample(estimate, *truth, float(path[i] - path[last]), 0.0))
    return samples


# --- gliders -------------------------------------------------------------------------------------


def glider_vehicle(vehicle: Vehicle, period: float) -> Vehicle:
    """Return a vehicle without thrusters: a light, slow hull that the wind moves at the surface."""
    return replace(
        vehicle,
        glides=True,
        declination=None,
        current=0.06,
        sensors=replace(vehicle.sensors, telemetry_period=period),
        calibration=Calibration(speed_scale_sigma=0.15, speed_noise=0.03, surface_drift=0.25),
    )


def _glider(glider: Recording, vehicle: Vehicle) -> list[Score]:
    at = surfaced(glider)
    found = references.dives(glider, at, _DEEP, _LONG)
    if not found:
        return []
    ends = {float(glider.t[d.end]): d for d in found}
    samples = _reckon_glider(glider, at, ends, vehicle)
    lat, lon = math.radians(glider.origin.latitude_deg), math.radians(glider.origin.longitude_deg)
    true = declination(lat, lon, glider.start.isoformat())
    naive = references.glider_errors(glider, found, 0.0, causal=False)
    turned = references.glider_errors(glider, found, true, causal=False)
    causal = references.glider_errors(glider, found, true, causal=True)
    glide = references.glider_errors(
        glider, found, true, causal=True, speed=references.glide_speed(glider)
    )
    errors = {"naive": naive, "declination": turned, "causal_current": causal, "glide": glide}
    medians = {name: float(np.median(v)) for name, v in errors.items() if v}
    reference, equal = medians.get("causal_current"), medians.get("glide")
    scored = {"dives": samples}
    if len(found) >= _HALVED:
        scored["dives by the other half"] = _halves(glider, found, vehicle)
    return [
        replace(
            _sum_up(glider.name, name, dives, reference, medians, equal),
            end_pct=float(np.median([100.0 * s.error / s.path for s in dives])),
            nees=0.5 * float(np.mean([s.nees for s in dives])),
            ends=len(dives),
        )
        for name, dives in scored.items()
    ]


def _reckon_glider(
    glider: Recording,
    at: Sequence[int],
    ends: Mapping[float, references.Dive],
    vehicle: Vehicle,
    *,
    learning: bool = True,
) -> list[_Sample]:
    """Return one sample per dive. ``learning``: each dive's error adjusts the trust in the
    figures."""
    nav = Navigation(vehicle, glider.origin, date=glider.start.isoformat())
    believed, share = nav.core.figures, 1.0
    samples: list[_Sample] = []
    misses: list[float] = []
    for item in wire(glider, at, glider.heading, NEUTRAL_PWM):
        if not isinstance(item, Fix) or item.t not in ends:
            _feed(nav, item)
            continue
        dive, estimate = ends[item.t], nav.estimate(item.t)
        assert estimate is not None
        truth = float(glider.north[dive.end]), float(glider.east[dive.end])
        samples.append(_sample(estimate, *truth, dive.path, item.accuracy**2))
        _feed(nav, item)
        if learning:
            misses.append(0.5 * samples[-1].nees * share * share)
            nav.core.filter.trust(believed.times(trust(misses)), trust(misses) / share)
            share = trust(misses)
    return samples


def _halves(glider: Recording, found: Sequence[references.Dive], vehicle: Vehicle) -> list[_Sample]:
    """Score the dives of each half with what `calibrate` makes of the other half."""
    middle = found[len(found) // 2].begin
    halves = glider.rows(0, middle + 1), glider.rows(middle, len(glider.t))
    samples: list[_Sample] = []
    for half, other in (halves, halves[::-1]):
        at = surfaced(half)
        ends = {float(half.t[d.end]): d for d in references.dives(half, at, _DEEP, _LONG)}
        known = calibrate_by([other], vehicle).vehicle
        samples += _reckon_glider(half, at, ends, known, learning=False)
    return samples


# --- both ----------------------------------------------------------------------------------------


def _feed(nav: Navigation, item: Telemetry | Fix) -> None:
    if isinstance(item, Fix):
        nav.fix(item)
    else:
        nav.telemetry(item)


def _sample(e: Estimate, north: float, east: float, path: float, variance: float) -> _Sample:
    """``variance``: of the true position, if that is a fix; m^2."""
    dn, de = north - e.north, east - e.east
    a, b, d = e.covariance[0] + variance, e.covariance[1], e.covariance[2] + variance
    det = a * d - b * b
    nees = (d * dn * dn - 2.0 * b * dn * de + a * de * de) / det
    radius = math.sqrt(CHI2_95 * math.sqrt(det))
    return _Sample(math.hypot(dn, de), nees, radius, max(path, 1.0))


def _sum_up(
    file: str,
    scoring: str,
    samples: Sequence[_Sample],
    reference: float | None,
    others: dict[str, float],
    equal: float | None = None,
) -> Score:
    relative = [100.0 * s.error / s.path for s in samples]
    return Score(
        file=file,
        scoring=scoring,
        end_pct=relative[-1],
        median_pct=float(np.median(relative)),
        coverage=float(np.mean([s.nees < CHI2_95 for s in samples])),
        samples=len(samples),
        ellipse_pct=float(np.mean([100.0 * s.radius / s.path for s in samples[-20:]])),
        nees=0.5 * samples[-1].nees,
        reference_pct=reference,
        references=others,
        equal_pct=equal,
    )
