"""The map of a dive: plan, track by legs, fixes, some 95 % ellipses, scale, graticule, north.

The track and the lines of the plan fill the frame. Of a plan that was not flown to its end, only
the part near the track does. An ellipse that would hide them is left out; its size is in the page's
figures.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mission.analysis.ellipses import draw_ellipses
from mission.analysis.report.dive import Dive, Point, Stay
from mission.analysis.report.numbers import around
from mission.navigation.filter import Array
from mission.navigation.geodesy import LocalFrame
from mission.onboard.stream.plan import COVERED, HEADING, PLACES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PALETTE = (
    *("#88ccee", "#ddcc77", "#44aa99", "#cc6677", "#999933", "#aa4499"),
    *("#3355aa", "#ee8833", "#77cc55", "#885522", "#ff99bb", "#999999"),
)
_PLAN, _SMOOTHED, _FIX, _AREA = "#888888", "#222222", "#117733", "#aa4400"
_DISC = {"boxstyle": "circle,pad=0.15", "fc": "w", "lw": 0.5}
_ELLIPSES, _ELLIPSE = 10, "#555555"
_MARGIN, _NARROWEST = 0.08, 0.6  # share of the frame; share of its long side
_SMALLEST = 10.0  # m: the smallest frame
_NEAR = 0.5  # of the track's long side: the plan widens the frame by so much


@dataclass(frozen=True, slots=True)
class Mark:
    """How a leg is marked: there are more legs than distinguishable colours."""

    number: int
    colour: str
    label: str


def marks_of(stays: Sequence[Stay]) -> Mapping[str, Mark]:
    names = dict.fromkeys(stay.leg for stay in stays)
    return {
        name: Mark(i, _PALETTE[(i - 1) % len(_PALETTE)], f"{i} {plain(name)}")
        for i, name in enumerate(names, 1)
    }


def draw_map(axes: Axes, dive: Dive) -> None:
    """Draw metres from home on the axes, degrees on the lines of the graticule."""
    t, north = dive.series(dive.states, "north_m")
    _, east = dive.series(dive.states, "east_m")
    lines = _plan(axes, dive)
    _track(axes, dive, t, np.column_stack([east, north]))
    if dive.origin is not None:
        fixes = [dive.local(f["latitude_deg"], f["longitude_deg"]) for f in dive.fixes]
        if fixes:
            axes.plot(*_columns(fixes), ".", color=_FIX, ms=4, label="fixes", zorder=4)
    known = np.isfinite(east)
    flown = flown_of(dive)
    shown = [*flown, *near(flown, [point for line in lines for point in line])]
    width = _frame(axes, shown or [(0.0, 0.0)])
    _ellipses(axes, dive, t, np.column_stack([east, north]), width)
    _number(axes, dive, t, np.column_stack([east, north]), width)
    (west, east_edge), (south, north_edge) = axes.get_xlim(), axes.get_ylim()
    if west <= 0.0 <= east_edge and south <= 0.0 <= north_edge:
        axes.plot(0.0, 0.0, "*", color="k", ms=9, mfc="w", label="home", zorder=5)
    if known.any():
        at = np.flatnonzero(known)[-1]
        axes.plot(east[at], north[at], "s", color="k", ms=5, mfc="w", label="end, estimated",
                  zorder=5)  # fmt: skip
    if dive.origin is not None:
        _graticule(axes, LocalFrame(dive.origin), width)
    else:
        axes.set_xlabel("east of home, m", fontsize=8)
        axes.set_ylabel("north of home, m", fontsize=8)
        axes.grid(color="#bbbbbb", lw=0.5, zorder=0)
    _scale(axes, width, [*shown, (0.0, 0.0)])
    axes.annotate("N", (1.04, 1.0), (1.04, 0.9), xycoords="axes fraction", ha="center",
                  va="center", annotation_clip=False,
                  arrowprops={"arrowstyle": "->", "lw": 1.2})  # fmt: skip
    axes.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.01, 0.87), frameon=False)


def flown_of(dive: Dive) -> list[Point]:
    """Return the estimated and the smoothed track."""
    states = [state for state in dive.states if state["north_m"] is not None]
    flown = [(state["east_m"], state["north_m"]) for state in states]
    return flown + ([(e, n) for n, e in dive.smoothed.smoothed] if dive.smoothed else [])


def near(flown: Sequence[Point], plan: Sequence[Point], share: float = _NEAR) -> list[Point]:
    """Clip the plan to the area near the track (``share`` of its long side); without a track return
    all of it."""
    if not flown or not plan:
        return list(plan)
    low, high = np.min(flown, axis=0), np.max(flown, axis=0)
    reach = share * max(_SMALLEST, *(high - low))
    return [(float(e), float(n)) for e, n in np.clip(plan, low - reach, high + reach)]


def goes_on(dive: Dive) -> bool:
    """Whether the plan extends beyond the frame."""
    flown = flown_of(dive)
    for by, share in ((PLACES, _NEAR), (HEADING, _MARGIN)):
        plan = [point for line in planned(dive, [by]) for point in line]
        if near(flown, plan, share) != plan:
            return True
    return False


def planned(dive: Dive, by: Sequence[str] = (PLACES, HEADING)) -> list[list[Point]]:
    """Return the lines of the plan's legs; ``by``: kinds of legs (to places, by heading)."""
    if dive.origin is None:
        return []
    lines = [
        feature["geometry"]["coordinates"]
        for feature in dive.plan
        if feature["geometry"]["type"] == "LineString"
        and feature["properties"]["name"] != "radius"
        and feature["properties"].get("by", PLACES) in by
    ]
    return [[dive.local(latitude, longitude) for longitude, latitude in line] for line in lines]


def _plan(axes: Axes, dive: Dive) -> list[list[Point]]:
    """Draw the plan. Return what must fit into the frame: lines to places, and covered areas; not
    areas to stay in or out of, nor lines by heading, which assume that there is no current."""
    covered: list[list[Point]] = []
    for feature in dive.plan:
        form, said = feature["geometry"], feature["properties"]
        if dive.origin is not None and form["type"] == "Polygon":
            ring = [
                dive.local(latitude, longitude) for longitude, latitude in form["coordinates"][0]
            ]
            axes.plot(
                *_columns(ring), "-.", color=_AREA, lw=0.9, label=plain(said["what"]), zorder=1
            )
            covered += [ring] if said["what"] == COVERED else []
    for i, line in enumerate(planned(dive)):
        axes.plot(*_columns(line), "--", color=_PLAN, lw=0.9, label="" if i else "plan", zorder=1)
    return planned(dive, [PLACES]) + covered


def _track(axes: Axes, dive: Dive, t: Array, places: Array) -> None:
    stays = dive.stays()
    marks, named = marks_of(stays), set[str]()
    axes.plot(places[:, 0], places[:, 1], color=_PLAN, lw=1.0, label="estimated", zorder=1.5)
    for stay in stays:
        within = (t >= stay.begin) & (t <= stay.end) & np.isfinite(places[:, 0])
        mark, line = marks[stay.leg], places[within]
        axes.plot(line[:, 0], line[:, 1], color=mark.colour, lw=3.0, solid_capstyle="round",
                  label="" if stay.leg in named else mark.label, zorder=2)  # fmt: skip
        named.add(stay.leg)
    if dive.smoothed is not None:
        north, east = dive.smoothed.smoothed.T
        axes.plot(east, north, color=_SMOOTHED, lw=0.8, label="smoothed", zorder=3)


def _number(axes: Axes, dive: Dive, t: Array, places: Array, width: float) -> None:
    """Write each leg's number at its first stretch."""
    found: list[tuple[Point, int]] = []
    stays = {stay.leg: stay for stay in reversed(dive.stays())}
    for leg, mark in marks_of(dive.stays()).items():
        within = (t >= stays[leg].begin) & (t <= stays[leg].end) & np.isfinite(places[:, 0])
        if within.any():
            east, north = places[within][int(within.sum()) // 2]
            found.append(((float(east), float(north)), mark.number))
    for place, numbers in around(found, width):
        box = _DISC if len(numbers) < 3 else _DISC | {"boxstyle": "round,pad=0.15"}
        axes.annotate(numbers, place, fontsize=8, zorder=7, ha="center", va="center", bbox=box)


def _ellipses(axes: Axes, dive: Dive, t: Array, places: Array, width: float) -> None:
    if not dive.covariances:
        return
    times = np.array([time for time, _ in dive.covariances])
    flown = [stay for stay in dive.stays() if stay.end > times[0]]
    if not flown:
        return
    placed = []
    for at in np.linspace(flown[0].begin, flown[-1].end, _ELLIPSES):
        i = int(np.argmin(np.abs(times - at)))
        (east, north), spread = places[int(np.argmin(np.abs(t - times[i])))], dive.covariances[i][1]
        placed.append((east, north, (spread[0, 0], spread[0, 1], spread[1, 1])))
    draw_ellipses(axes, placed, width, _ELLIPSE)


def _frame(axes: Axes, shown: Sequence[Point]) -> float:
    """Fit the frame around ``shown``; return its long side, m. The short side has space for
    labels."""
    low, high = np.min(shown, axis=0), np.max(shown, axis=0)
    spans = np.maximum(high - low, _SMALLEST) * (1 + 2 * _MARGIN)
    east, north = np.maximum(spans, _NARROWEST * np.max(spans)) / 2.0
    middle = (low + high) / 2.0
    axes.set_xlim(middle[0] - east, middle[0] + east)
    axes.set_ylim(middle[1] - north, middle[1] + north)
    axes.set_aspect("equal")
    return 2.0 * float(max(east, north))


def _graticule(axes: Axes, frame: LocalFrame, width: float) -> None:
    """Draw latitude and longitude at round steps, two to five lines of each."""
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    corners = np.degrees([frame.to_geodetic(south, west), frame.to_geodetic(north, east)])
    for axis, (low, high) in enumerate(corners.T):
        step = _step(float(high - low) / 2.0)
        digits = max(0, -math.floor(math.log10(step)))
        ticks, labels = [], []
        for value in np.arange(math.ceil(low / step) * step, high, step):
            place = np.radians([value, corners[0, 1]] if axis == 0 else [corners[0, 0], value])
            ticks.append(frame.to_local(float(place[0]), float(place[1]))[axis])
            side = ("NS", "EW")[axis][int(value < 0.0)]
            labels.append(f"{abs(value):.{digits}f}\u00b0 {side}")
        drawn = axes.yaxis if axis == 0 else axes.xaxis
        drawn.set_ticks(ticks, labels, fontsize=6.5)
    axes.grid(color="#bbbbbb", lw=0.5, zorder=0)


def _scale(axes: Axes, width: float, shown: Sequence[Point]) -> None:
    """Draw the scale in the least crowded corner."""
    length, room = _step(width / 5.0), 0.04 * width
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    far, high = right - room - length, top - 2.0 * room

    def crowd(corner: Point) -> int:
        x, y = corner
        return sum(
            x - room <= e <= x + length + room and y - room <= n <= y + 2.0 * room for e, n in shown
        )

    x, y = min(((left + room, bottom + room), (far, bottom + room), (left + room, high)), key=crowd)
    axes.plot([x, x + length], [y, y], color="k", lw=3, solid_capstyle="butt", zorder=6)
    axes.text(x + length / 2.0, y + 0.015 * width, f"{length:g} m", ha="center", fontsize=8)


def _step(about: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at most ``about``."""
    power = 10.0 ** math.floor(math.log10(about))
    return float(next(m for m in (5.0, 2.0, 1.0) if m * power <= about * (1 + 1e-9)) * power)


def plain(text: str) -> str:
    """Escape what matplotlib takes for mathematics."""
    return text.replace("$", r"\$")


def _columns(points: Sequence[Point]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]
