"""Pictures of a dive as SVG in a page, and as separate files.

matplotlib is imported when a picture is drawn, with the Agg back end: no display is needed.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mission.analysis.drawing import draw_quality, timed
from mission.analysis.report.dive import Dive
from mission.analysis.report.map import draw_map, goes_on, marks_of, plain, planned
from mission.analysis.report.numbers import along
from mission.analysis.report.words import simulated
from mission.analysis.resting import SILENT_S
from mission.engine.limits import LIMITS
from mission.engine.thrust import THRUSTERS
from mission.navigation.filter import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Rows = Sequence[tuple[str, str]]  # a topic's field, and its name or unit

_ATTITUDE: Rows = (("heading_deg", "heading"), ("pitch_deg", "pitch"), ("roll_deg", "roll"))
_BATTERIES: Rows = (("control_v", "control"), ("power_v", "power"))
_SENSORS: Rows = (("altitude_m", "altitude, m"), ("temperature_c", "temperature, \u00b0C"))
_MARGINS = (("to_depth_m", "m"), ("to_radius_m", "m"), ("to_time_s", "s"), ("to_voltage_v", "V"))
_NOTICED_S = 0.5  # after a report: when its sensor's health is checked
_APART = 0.025  # of the time axis: least distance of two leg numbers


@dataclass(frozen=True, slots=True)
class Picture:
    """``size`` in inches; ``draw`` gets ``rows`` axes."""

    name: str
    caption: str
    rows: int
    size: tuple[float, float]
    draw: Callable[[Any], None]
    box: str | None = None  # "tight" if its frame leaves space beside it


def pictures_of(dive: Dive) -> Iterator[Picture]:
    """Yield the pictures for which the dive has data."""
    if dive.is_tracked:
        yield map_of(dive)
    if any(state["depth_m"] is not None for state in dive.states):
        caption = "Depth: as reported, and smoothed on board, with the legs."
        if any(spell.sensor == "depth" for spell in dive.spells):
            caption += " Hatched: it was not to be believed."
        yield Picture("depth", caption, 1, (9, 3), lambda axes: _depth(axes[0], dive))
    known = [(n, u) for n, u in _MARGINS if _acts(dive, n)]
    if known:
        caption, size = "What was left to each limit.", (9.0, 1.3 * len(known))
        yield Picture("margins", caption, len(known), size, lambda a: _margins(a, dive, known))
    for name, rows, unit in (
        ("attitude", _ATTITUDE, "deg"), ("batteries", _BATTERIES, "V"), ("sensors", _SENSORS, "")
    ):  # fmt: skip
        yield from _values_of(dive, name, rows, unit)
    if thrusters_of(dive):
        caption = "Thrusters: the share of full thrust that each reported."
        yield Picture("thrusters", caption, 1, (9, 2.4), lambda axes: _thrusters(axes[0], dive))
    track = dive.smoothed
    if track is not None:
        caption = "Fixes: innovations, residuals, and when which sensor could not be believed."
        yield Picture("fixes", caption, 3, (9, 6), lambda a: draw_quality(a, track, dive.spells))


def map_of(dive: Dive) -> Picture:
    of = f" ({words})" if (words := simulated(dive)) else ""
    shown = ["plan"] if planned(dive) else []
    shown += ["estimated track by legs"]
    shown += ["smoothed track", "fixes"] if dive.smoothed is not None else []
    caption = f"Map: {', '.join(shown)}{of}."
    if goes_on(dive):
        caption += " The plan goes on beyond the map."
    return Picture("map", caption, 1, (8.5, 6.5), lambda axes: draw_map(axes[0], dive), "tight")


def _acts(dive: Dive, margin: str) -> bool:
    """Whether the margin is known and its limit can act."""
    limit = LIMITS[margin.removeprefix("to_").rpartition("_")[0]]
    return not limit.disarmed(dive.vehicle) and any(s[margin] is not None for s in dive.states)


def _values_of(dive: Dive, name: str, rows: Rows, unit: str) -> Iterator[Picture]:
    """Yield a picture of those rows that the vehicle reported."""
    said = [row for row in rows if any(one[row[0]] is not None for one in dive.telemetry)]
    if said:
        caption, size = f"{name.capitalize()}.", (9.0, 1.4 * len(said))
        yield Picture(name, caption, len(said), size, lambda axes: _values(axes, dive, said, unit))


def save(picture: Picture, path: Path, title: str) -> None:
    """Save as PNG, PDF or SVG, by the suffix."""
    figure, axes = _figure(picture.rows, picture.size)
    picture.draw(axes)
    axes[0].set_title(plain(title), fontsize=9, pad=14)  # above the leg numbers
    figure.savefig(path, dpi=200, bbox_inches="tight")


def _figure(rows: int, size: tuple[float, float]) -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, 1, squeeze=False)[:, 0]


def as_svg(picture: Picture) -> str:
    """Return SVG without prolog, metadata and name spaces, which an HTML page does not need."""
    import matplotlib as mpl

    figure, axes = _figure(picture.rows, picture.size)
    picture.draw(axes)
    text = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "auvmission"}):
        figure.savefig(text, format="svg", metadata={"Date": None}, bbox_inches=picture.box)
    inner = text.getvalue()[text.getvalue().index("<svg") :]
    inner = re.sub(r"<metadata>.*?</metadata>", "", inner, count=1, flags=re.DOTALL)
    return re.sub(r' xmlns(:\w+)?="[^"]*"', "", inner)


def _depth(axes: Axes, dive: Dive) -> None:
    stays = dive.stays()
    marks = marks_of(stays)
    for stay in stays:
        axes.axvspan(stay.begin, stay.end, color=marks[stay.leg].colour, alpha=0.35, lw=0)
    middles = [((stay.begin + stay.end) / 2.0, marks[stay.leg].number) for stay in stays]
    lasts = max(dive.states[-1]["t"] - dive.states[0]["t"], 1.0)
    for at, numbers in along(middles, _APART * lasts):
        axes.text(at, 1.02, numbers, fontsize=7, ha="center",
                  transform=axes.get_xaxis_transform())  # fmt: skip
    t, depth = parted(*dive.series(dive.states, "depth_m"))
    axes.plot(t, depth, color="#222222", lw=1.0, label="smoothed on board")
    axes.plot(*dive.series(reports_of_depth(dive), "depth_m"), ".", color="#cc3311", ms=2.5,
              label="as reported")  # fmt: skip
    for spell in dive.spells:
        if spell.sensor == "depth":
            axes.axvspan(spell.first, spell.end, fill=False, hatch="///", ec="#cc3311", lw=0)
    for mark in marks.values():
        axes.plot([], [], color=mark.colour, lw=5, label=mark.label)
    axes.invert_yaxis()
    axes.set_ylabel("depth, m")
    timed([axes])
    if axes.get_legend_handles_labels()[1]:
        axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    axes.grid(alpha=0.3)


def reports_of_depth(dive: Dive) -> list[Mapping[str, Any]]:
    """Return the reports whose depth could be believed."""
    last = dive.telemetry[-1]["t"] if dive.telemetry else 0.0
    doubted = [
        (one.begin - _NOTICED_S, one.end - _NOTICED_S if one.end < last else np.inf)
        for one in dive.spells
        if one.sensor == "depth"
    ]
    return [s for s in dive.telemetry if not any(a <= s["t"] < b for a, b in doubted)]


def parted(t: Array, values: Array) -> tuple[Array, Array]:
    """Put a gap into the line where no report came for long."""
    silent = np.flatnonzero(np.diff(t) > SILENT_S) + 1
    return np.insert(t, silent, t[silent]), np.insert(values, silent, np.nan)


def _margins(axes: Sequence[Axes], dive: Dive, known: Rows) -> None:
    for one, (name, unit) in zip(axes, known, strict=True):
        one.plot(*dive.series(dive.states, name), color="#2b5c8a", lw=1.0)
        one.set_xlim(dive.states[0]["t"], max(dive.states[-1]["t"], dive.states[0]["t"] + 1.0))
        one.axhline(0.0, color="#cc3311", lw=0.8)
        one.set_ylim(*_bounds(dive, name))
        _dress(one, f"to {name.removeprefix('to_').rpartition('_')[0]}, {unit}")
    timed(axes)


def _bounds(dive: Dive, margin: str) -> tuple[float, float]:
    """Return the bounds of the axis, by the last limit in force: an earlier one must not flatten
    it."""
    _, left = dive.series(dive.states, margin)
    known = left[np.isfinite(left)]
    limit = margin.removeprefix("to_").rpartition("_")[0]
    bound = getattr(dive.standing[-1], limit) if dive.standing else np.inf
    top = max(known.max() if limit == "voltage" else min(bound, known.max()), 0.0)
    low = min(known.min(), 0.0)
    room = 0.05 * max(top - low, 1e-3)
    return low - room, top + room


def _values(axes: Sequence[Axes], dive: Dive, rows: Rows, unit: str) -> None:
    for one, (name, says) in zip(axes, rows, strict=True):
        t, values = dive.series(dive.telemetry, name)
        if name in ("heading_deg", "roll_deg"):
            values = unbroken(values)
        one.plot(t, values, ".", ms=2, color="#2b5c8a")
        _dress(one, f"{says}, {unit}".removesuffix(", "))
    timed(axes)


def thrusters_of(dive: Dive) -> list[str]:
    """Return the names of the reported thrusters; rudders and servos follow them in the reports."""
    said: Mapping[str, float] = next(
        (one["actuators"] for one in dive.telemetry if one["actuators"]), {}
    )
    return list(said)[:THRUSTERS]


def _thrusters(axes: Axes, dive: Dive) -> None:
    """Draw each line a little above the one before: equal ones would hide each other."""
    for number, name in enumerate(thrusters_of(dive)):
        told = [{"t": one["t"], name: one["actuators"].get(name)} for one in dive.telemetry]
        t, share = parted(*dive.series(told, name))
        axes.plot(t, 100.0 * share + number, lw=1.0, label=plain(name))
    _dress(axes, "thrust, %")
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    timed([axes])


def unbroken(heading: Array) -> Array:
    """Return degrees from -180 to 180 or from 0 to 360, whichever keeps them closer together."""
    about, whole = (heading + 180.0) % 360.0 - 180.0, heading % 360.0
    known = np.isfinite(heading)
    closer = known.any() and np.ptp(about[known]) <= np.ptp(whole[known])
    return about if closer else whole


def _dress(axes: Axes, label: str) -> None:
    axes.set_ylabel(label, fontsize=8)
    axes.tick_params(labelsize=7)
    axes.ticklabel_format(useOffset=False)
    axes.grid(alpha=0.3)
