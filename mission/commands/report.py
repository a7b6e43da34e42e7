"""``auvmission report``: dives that are over on one page, smoothed, with what the sensors said."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import AS_JSON, LOGGED_VEHICLE
from mission.commands.output import writing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mission.analysis.report.dive import Dive
    from mission.analysis.smoothing import Track
    from mission.model import Record
    from mission.onboard.blackbox import Gap


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...",
                type=click.Path(path_type=Path, dir_okay=False))  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="Page to write; default: the first FILE with the suffix .html. With the suffix "
              ".png the smoothed track of one FILE alone, as a picture.")  # fmt: skip
@click.option("--map", "map_", type=click.Path(path_type=Path, dir_okay=False),
              help="The map of one FILE as well, as a PNG, PDF or SVG, by its suffix.")  # fmt: skip
@LOGGED_VEHICLE
@AS_JSON
def report(
    files: tuple[Path, ...],
    output: Path | None,
    map_: Path | None,
    vehicle: str | None,
    as_json: bool,
) -> None:
    """Make a page of dives: map, depth, sensors, limits, fixes, story, and the smoothed track.

    One HTML file of the black boxes FILE..., in the order of their starts, that needs nothing else.
    The smoothed track uses the fixes of after the dive, too; with it come innovations, residuals,
    and when which sensor could not be believed. Exit 2 where a FILE cannot be used.
    """
    from mission.analysis.journal import recordings
    from mission.analysis.report.dive import Dive
    from mission.model.shipped import load_vehicle
    from mission.model.vehicle import VehicleError
    from mission.onboard.blackbox import BlackBoxError

    page = output or files[0].with_suffix(".html")
    _check_one(files, page, map_)
    try:
        known = load_vehicle(vehicle) if vehicle else None
        read = recordings(files)
        dives = [Dive.of(items, known) for items in read]
        if page.suffix == ".png" and dives[0].smoothed is None:
            raise ValueError("there is no fix: a track has no place")
    except (BlackBoxError, VehicleError) as error:
        raise _failed(str(error)) from None
    except (ValueError, KeyError, TypeError) as error:
        raise _failed(f"{', '.join(map(str, files))}: {error}") from None
    _write(read, dives, page, map_, ", ".join(path.name for path in files))
    told = [figures(dive.smoothed) if dive.smoothed else None for dive in dives]
    if as_json:
        click.echo(json.dumps(told[0] if len(told) == 1 else told))
        return
    for dive in dives:
        click.echo(text(dive.smoothed))
    click.echo(f"{'picture' if page.suffix == '.png' else 'page':10} {page}")


def _check_one(files: tuple[Path, ...], page: Path, map_: Path | None) -> None:
    if len(files) > 1 and (map_ is not None or page.suffix == ".png"):
        raise click.UsageError("a picture or a map is of one FILE")
    if map_ is not None and map_.suffix not in (".png", ".pdf", ".svg"):
        raise click.UsageError(f"--map {map_}: a map is a .png, .pdf or .svg")


def _write(
    read: Sequence[Sequence[Record | Gap]],
    dives: Sequence[Dive],
    page: Path,
    map_: Path | None,
    title: str,
) -> None:
    from mission.analysis.drawing import draw_track
    from mission.analysis.report.figures import save_map
    from mission.analysis.report.page import report_page

    with writing(page):
        if page.suffix == ".png" and (track := dives[0].smoothed) is not None:
            draw_track(track, page, title)
        else:
            words = [(dive, text(dive.smoothed)) for dive in dives]
            page.write_text(report_page(title, read, words), encoding="utf-8")
    if map_ is not None:
        with writing(map_):
            save_map(dives[0], map_, title)


def _failed(why: str) -> SystemExit:
    click.echo(why, err=True)
    return SystemExit(2)


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


def text(track: Track | None) -> str:
    if track is None:
        return "track      there is no fix: it has no place"
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
    ]
    return "\n".join(rows)
