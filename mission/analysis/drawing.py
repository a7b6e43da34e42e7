"""Pictures of a finished dive: three tracks, innovations, residuals, sensors.

matplotlib is imported when a picture is drawn, with the Agg back end: no display is needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mission.analysis.ellipses import draw_ellipses, width_of
from mission.model.shown import clock

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mission.analysis.calibration import Calibrated
    from mission.analysis.doubts import Spell
    from mission.analysis.smoothing import Track

_NIS_95 = 5.991  # chi-square, 2 degrees of freedom
_ELLIPSES = 14
_STEPS_S, _TICKS = (1, 5, 15, 30, 60, 120, 300, 600, 1800, 3600, 10800), 10
_RAW, _FILTERED, _SMOOTHED, _FIX = "#999999", "#c1440e", "#2b5c8a", "#117733"
_SENSORS = {"missing": "#dddddd", "stale": "#ddcc77", "frozen": "#88ccee", "absurd": "#cc6677"}


def _figure(rows: int, heights: Sequence[float], size: tuple[float, float]) -> tuple[Any, Any]:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, 1, height_ratios=heights)


def draw_track(track: Track, spells: Sequence[Spell], path: Path, title: str) -> None:
    """Draw the track and its quality into a PNG."""
    figure, (plan, nis, residual, sensors) = _figure(4, (3.2, 1.0, 1.0, 0.9), (9.0, 13.0))
    _plan(plan, track)
    draw_quality((nis, residual, sensors), track, spells)
    figure.suptitle(title, fontsize=12)
    figure.savefig(path, dpi=110)


def draw_quality(axes: Sequence[Axes], track: Track, spells: Sequence[Spell]) -> None:
    """Draw innovations and residuals of the fixes, and when which sensor could not be believed."""
    nis, residual, sensors = axes
    _innovations(nis, track)
    _residuals(residual, track, spells)
    _spells(sensors, spells)
    for one in (nis, residual, sensors):
        begin, end = float(track.t[0]), float(track.t[-1])
        margin = max(0.01 * (end - begin), 1.0)  # fixes usually come first and last
        one.set_xlim(begin - margin, end + margin)
    timed(axes)


def timed(axes: Sequence[Axes]) -> None:
    """Format the time axes as the story does, with ticks at round steps."""
    from matplotlib.ticker import FuncFormatter, MultipleLocator

    for one in axes:
        begin, end = one.get_xlim()
        step = next((step for step in _STEPS_S if step * _TICKS >= end - begin), _STEPS_S[-1])
        one.xaxis.set_major_locator(MultipleLocator(step))
        one.xaxis.set_major_formatter(FuncFormatter(lambda t, _: clock(t).removesuffix(".0")))
    axes[-1].set_xlabel("min:s since the program began")


def _plan(axes: Axes, track: Track) -> None:
    axes.plot(track.raw[:, 1], track.raw[:, 0], color=_RAW, lw=0.9, label="raw: compass, thrusters")
    width = width_of(track.smoothed[:, ::-1].tolist())
    rows = (
        (track.filtered, track.filtered_covariance, _FILTERED, "filtered"),
        (track.smoothed, track.smoothed_covariance, _SMOOTHED, "smoothed"),
    )
    for place, covariance, colour, name in rows:
        axes.plot(place[:, 1], place[:, 0], color=colour, lw=1.2, label=name)
        shown = np.linspace(0, len(place) - 1, _ELLIPSES).astype(int)
        spread = covariance[shown][:, (0, 0, 1), (0, 1, 1)]
        placed = zip(place[shown, 1], place[shown, 0], map(tuple, spread), strict=True)
        draw_ellipses(axes, placed, width, colour, f"{name}, 95 %")
    used = [f for f in track.fixes if f.used]
    axes.plot([f.east for f in used], [f.north for f in used], ".", color=_FIX, ms=5, label="fixes")
    refused = [f for f in track.fixes if not f.used]
    if refused:
        axes.plot([f.east for f in refused], [f.north for f in refused], "x", color="k", ms=5,
                  label="fixes refused")  # fmt: skip
    for i, mark, name in ((0, "^", "start"), (-1, "s", "end")):
        north, east = track.smoothed[i]
        axes.plot(east, north, mark, color="k", ms=6, mfc="w", label=f"{name}, smoothed")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)


def _innovations(axes: Axes, track: Track) -> None:
    for used, mark in ((True, "."), (False, "x")):
        seen = [f for f in track.fixes if f.used is used]
        axes.plot([f.t for f in seen], [max(f.nis, 1e-3) for f in seen], mark, color=_FIX, ms=4)
    axes.axhline(_NIS_95, color="k", lw=0.7, ls="--")
    axes.set_yscale("log")
    axes.set_ylim(min(0.1, *axes.get_ylim()), max(10.0, *axes.get_ylim()))
    _plain_numbers(axes)
    axes.set_ylabel("NIS of fixes\n(dashed: 95 %)")
    axes.grid(alpha=0.3)


def _plain_numbers(axes: Axes) -> None:
    """Label a logarithmic axis with 0.3 and 10, not with powers of ten."""
    from matplotlib.ticker import StrMethodFormatter

    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(StrMethodFormatter(""))


def _residuals(axes: Axes, track: Track, spells: Sequence[Spell]) -> None:
    """Draw the depth's residuals only where the depth could be believed: 6553.5 m would flatten all
    others."""
    t = [f.t for f in track.fixes]
    axes.plot(t, [f.residual[0] for f in track.fixes], ".", ms=5, color=_FILTERED, label="north")
    axes.plot(t, [f.residual[1] for f in track.fixes], "x", ms=4, color=_SMOOTHED, label="east")
    depth = track.depth_residual
    for spell in spells:
        if spell.sensor == "depth":
            depth = depth[(depth[:, 0] < spell.begin - 0.5) | (depth[:, 0] > spell.end)]
    axes.plot(depth[:, 0], depth[:, 1], lw=0.6, color=_RAW, label="depth")
    axes.set_yscale("symlog", linthresh=1.0)
    _plain_numbers(axes)
    axes.set_ylabel("residuals, m\n(beyond 1: log)")
    axes.legend(fontsize=7, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes.grid(alpha=0.3)


def _spells(axes: Axes, spells: Sequence[Spell]) -> None:
    from mission.analysis.doubts import DOUBTED

    for spell in spells:
        colour = _SENSORS.get(spell.reason, "k")
        axes.barh(DOUBTED.index(spell.sensor), spell.end - spell.first, left=spell.first,
                  color=colour, height=0.8)  # fmt: skip
    axes.set_yticks(range(len(DOUBTED)), DOUBTED, fontsize=7)
    for reason, colour in _SENSORS.items():
        axes.barh(0, 0, color=colour, label=reason)
    axes.legend(fontsize=7, ncols=4, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes.set_ylim(len(DOUBTED) - 0.5, -0.5)


def draw_calibration(done: Calibrated, path: Path) -> None:
    """Draw the error at the end of each dive, before and after, and the compass error."""
    figure, (dives, compass) = _figure(2, (1.0, 1.0), (8.0, 8.0))
    known = [s for s in done.stretches if s.distance > 1.0]
    at = np.arange(len(known))
    for shift, name, colour in ((-0.2, "before", _RAW), (0.2, "after", _SMOOTHED)):
        values = [100.0 * getattr(s, name) / s.distance for s in known]
        dives.bar(at + shift, values, 0.4, color=colour, label=name)
    dives.set_xticks(at, [f"log {s.log + 1}\ndive at {s.begin:.0f} s" for s in known], fontsize=7)
    dives.set_ylabel("error at the next fix, % of distance")
    dives.margins(y=0.2)  # space for the legend
    held_out = ", after: calibrated on the other logs" if done.held_out else ""
    dives.set_title(f"dead reckoning before and after calibration{held_out}", fontsize=10)
    if known:
        dives.legend(loc="upper right", ncols=2)
    else:
        dives.set_yticks([])
        dives.text(0.5, 0.5, "no dive between two fixes", transform=dives.transAxes, ha="center")
    shown = np.linspace(0.0, 2.0 * math.pi, 181)
    vehicle = done.vehicle
    error = [vehicle.compass_bias + vehicle.calibration.deviation.at(float(h)) for h in shown]
    _, bias, sin, cos = done.sigmas
    turned = [(s, c) for s, c in zip(np.sin(shown), np.cos(shown), strict=True)]
    sigma = np.array([math.sqrt(bias**2 + (sin * s) ** 2 + (cos * c) ** 2) for s, c in turned])
    known_to = np.degrees(np.array(error) - sigma), np.degrees(np.array(error) + sigma)
    compass.fill_between(np.degrees(shown), *known_to, color=_FILTERED, alpha=0.15,
                         label="one sigma")  # fmt: skip
    compass.plot(np.degrees(shown), np.degrees(error), color=_FILTERED, label="fitted")
    compass.axhline(0.0, color="k", lw=0.6)
    compass.set_title("error of the compass over what it reads", fontsize=10)
    compass.legend(fontsize=8)
    compass.set_xlabel("compass, deg")
    compass.set_ylabel("reads too far clockwise by, deg")
    compass.set_xticks(range(0, 361, 45))
    compass.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
