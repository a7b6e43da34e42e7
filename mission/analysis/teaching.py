"""Calibration from recordings (CSV), as if this vehicle had logged them.

A run counts as driven at gear 8 all the way, with a fix in every row. Its depth would contradict
these fixes, so it counts as not reported. A glider has its fixes at the surface.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from mission.analysis.calibration import Calibrated, calibrate
from mission.analysis.recordings import (
    CRUISE_PWM,
    NEUTRAL_PWM,
    Array,
    Recording,
    RecordingError,
    surfaced,
    wire,
)
from mission.model.vehicle import Vehicle


def calibrate_by(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    compass: Callable[[Array], Array] = lambda heading: heading,
) -> Calibrated:
    """Calibrate ``vehicle``. Raises CalibrationError, and RecordingError if the recordings are of
    both kinds, or of the other kind than ``vehicle``. ``compass``: turns a true heading into a
    reading."""
    if any(r.glider != vehicle.glides for r in recordings):
        kind = "glides" if vehicle.glides else "does not glide"
        wanted = "rows of a glider" if vehicle.glides else "runs with a place in each row"
        raise RecordingError(f"{vehicle.name} {kind}: give recordings that hold {wanted}")
    reports = vehicle.reports if vehicle.glides else vehicle.reports - {"depth"}
    logs = [
        wire(r, surfaced(r) if r.glider else range(len(r.t)), compass(r.heading), _pwm(r))
        for r in recordings
    ]
    done = calibrate(logs, replace(vehicle, reports=reports))
    return replace(done, vehicle=replace(done.vehicle, reports=vehicle.reports))


def _pwm(recording: Recording) -> int:
    return NEUTRAL_PWM if recording.glider else CRUISE_PWM
