"""``auvmission report``: a dive that is over, smoothed, with what its sensors were like."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import AS_JSON, LOGGED_VEHICLE

if TYPE_CHECKING:
    from mission.analysis.smoothing import Track


@click.command()
@click.argument("log", type=click.Path(path_type=Path, dir_okay=False))
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="PNG to write; default: LOG with the suffix .png.")  # fmt: skip
@LOGGED_VEHICLE
@AS_JSON
def report(log: Path, output: Path | None, vehicle: str | None, as_json: bool) -> None:
    """Smooth the track of the black box LOG between its fixes, and draw it.

    Raw, filtered and smoothed track with 95 % ellipses, innovations of the fixes, residuals, and
    when which sensor could not be believed. Exit 2 where LOG cannot be used.
    """
    import json

    from mission.analysis.drawing import draw_track
    from mission.analysis.smoothing import smooth
    from mission.model.shipped import load_vehicle
    from mission.model.vehicle import VehicleError
    from mission.onboard.blackbox import BlackBoxError
    from mission.onboard.serve.heard import LogError, read_log

    try:
        heard = read_log(log)
        known = load_vehicle(vehicle) if vehicle else heard.vehicle
        track = smooth(heard.inputs, known)
    except (BlackBoxError, LogError, VehicleError, ValueError) as error:
        named = isinstance(error, (BlackBoxError, LogError, VehicleError))
        click.echo(str(error) if named else f"{log}: {error}", err=True)
        raise SystemExit(2) from None
    picture = output or log.with_suffix(".png")
    try:
        draw_track(track, picture, log.name)
    except OSError as error:
        click.echo(f"{picture}: cannot be written: {error.strerror or error}", err=True)
        raise SystemExit(2) from None
    click.echo(json.dumps(figures(track)) if as_json else text(track, picture))


def figures(track: Track) -> dict[str, object]:
    import numpy as np

    used = [f for f in track.fixes if f.used]
    radius = np.sqrt(5.991 * np.sqrt(np.maximum(np.linalg.det(track.smoothed_covariance), 0.0)))
    apart = np.hypot(*(track.filtered - track.smoothed).T)
    return {
        "seconds": float(track.t[-1] - track.t[0]),
        "fixes": len(track.fixes),
        "fixes_refused": len(track.fixes) - len(used),
        "mean_nis": float(np.mean([f.nis for f in used])) if used else None,
        "filtered_from_smoothed_m": {"max": float(apart.max()), "mean": float(apart.mean())},
        "smoothed_radius_95_m": {"max": float(radius.max()), "mean": float(radius.mean())},
        "speed_scale": [float(track.states[-1, 6]), float(track.sigmas[-1, 6])],
        "compass_error_deg": [
            float(np.degrees(track.states[-1, 8])),
            float(np.degrees(track.sigmas[-1, 8])),
        ],
        "current_m_s": [float(v) for v in track.states[-1, 2:4]],
        "sensors": [
            {"sensor": s.sensor, "begin_s": s.begin, "end_s": s.end, "reason": s.reason}
            for s in track.spells
        ],
    }


def text(track: Track, picture: Path) -> str:
    f = figures(track)
    apart, radius = f["filtered_from_smoothed_m"], f["smoothed_radius_95_m"]
    assert isinstance(apart, dict)
    assert isinstance(radius, dict)
    nis = "" if f["mean_nis"] is None else f", mean NIS {f['mean_nis']:.2f} (2 is honest)"
    rows = [
        f"track      {f['seconds']:.0f} s, {f['fixes']} fixes, {f['fixes_refused']} refused{nis}",
        f"smoothed   95 % radius {radius['mean']:.1f} m in the mean, {radius['max']:.1f} m at most",
        f"filtered   off the smoothed by {apart['mean']:.1f} m, {apart['max']:.1f} m at most",
        *(f"{s.sensor:10} {s.reason} from {s.begin:.0f} to {s.end:.0f} s" for s in track.spells),
        f"picture    {picture}",
    ]
    return "\n".join(rows)
