"""The picture of a flight: plan view with its 95 % ellipses, depth over time, the legs coloured.

Legs have a colour and a number, since there are more legs than colours that can be told apart. The
number is at the leg's middle in the plan, over its part of the profile, and in the key.

matplotlib is imported when a picture is drawn, with the Agg back end: no display is needed.

What does not live here: the state graph (graph), figures (flightlog).
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mission.analysis.ellipses import Placed, draw_ellipses, width_of
from mission.model import Estimate
from mission.verification.simulation.flightlog import Flight, LegFlown, Sample, TruePlace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ELLIPSES = 12
_DIGIT = 0.011  # width of a number's digit over the profile, as a share of the mission
_NEAR = 0.05  # share of the plan's width; a number nearer than this to another would hide it
_TITLE_WIDTH = 100  # characters
_KEY_WIDTH = 120  # characters of the key in one row
_TRUE, _ESTIMATE = "#2b2b2b", "#c1440e"
_PALETTE = ("#88ccee", "#ddcc77", "#44aa99", "#cc6677", "#999933", "#aa4499", "#6699cc", "#117733")


def draw_flight(flight: Flight, path: Path, title: str, caption: str = "") -> None:
    """Write a PNG. ``caption``: sea and seed."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 10.0), layout="constrained")
    FigureCanvasAgg(figure)
    drawn(figure, flight, title, caption)
    figure.savefig(path, dpi=110)


def drawn(figure: Figure, flight: Flight, title: str, caption: str = "") -> None:
    plan, profile = figure.subplots(2, 1, height_ratios=(2.2, 1.0))
    marks = marks_of(flight.legs)
    _draw_plan(plan, flight, marks)
    _draw_profile(profile, flight, marks)
    figure.suptitle(title_of(flight, title, caption), fontsize=11)


def title_of(flight: Flight, title: str, caption: str = "") -> str:
    rows = [f"{title}: {flight.outcome}"]
    if flight.outcome != "completed":
        rows += textwrap.wrap(flight.reason, _TITLE_WIDTH)
    if flight.error_end is not None:
        deep = "" if flight.on_land else f"to {flight.max_depth:.1f} m deep and "
        rows.append(
            f"{flight.mission_time / 60:.1f} min, {deep}"
            f"{flight.max_range:.0f} m from home; the estimate is {flight.error_end:.1f} m off "
            "at the end"
        )
    rows += textwrap.wrap(caption, _TITLE_WIDTH)
    return "\n".join(rows)


@dataclass(frozen=True, slots=True)
class _Mark:
    number: int
    colour: str


def marks_of(legs: Sequence[LegFlown]) -> dict[str, _Mark]:
    names = dict.fromkeys(_plain(leg.name) for leg in legs)
    return {name: _Mark(i + 1, _PALETTE[i % len(_PALETTE)]) for i, name in enumerate(names)}


def _plain(name: str) -> str:
    return name.partition("#")[0]


def _draw_plan(axes: Axes, flight: Flight, marks: dict[str, _Mark]) -> None:
    samples = flight.samples
    knows = len({(s.estimate.north, s.estimate.east) for s in samples}) > 1
    flown = [(leg, [s for s in samples if leg.entered <= s.t <= leg.left]) for leg in flight.legs]
    for leg, seen in flown:  # by the estimate, as the guards saw it
        places = [_where(s, knows) for s in seen]
        axes.plot(
            [place.east for place in places],
            [place.north for place in places],
            color=marks[_plain(leg.name)].colour,
            linewidth=5.0,
            solid_capstyle="round",
            alpha=0.8,
        )
    axes.plot(
        [s.true.east for s in samples],
        [s.true.north for s in samples],
        color=_TRUE,
        linewidth=1.2,
        label="true track, to its end",
        marker="s",
        markersize=5.0,
        markevery=[len(samples) - 1] if samples else [],
    )
    axes.plot(
        [s.estimate.east for s in samples],
        [s.estimate.north for s in samples],
        color=_ESTIMATE,
        linewidth=1.0,
        linestyle="--",
        label="estimate",
        marker="s",
        markersize=5.0,
        markevery=[len(samples) - 1] if samples else [],
    )
    flown_at = [(s.true.east, s.true.north) for s in samples]
    width = width_of([*flown_at, *((s.estimate.east, s.estimate.north) for s in samples)])
    draw_ellipses(axes, _placed(_spread(samples, _ELLIPSES)), width, _ESTIMATE)
    spots = [(leg, [_where(s, knows) for s in seen]) for leg, seen in flown]
    _number_legs(axes, spots, marks)
    as_map(axes)


def _where(sample: Sample, knows: bool) -> Estimate | TruePlace:
    """Return where to draw a sample: the estimate, or the true place if the vehicle does not know
    its position."""
    return sample.estimate if knows else sample.true


def _placed(samples: Sequence[Sample]) -> Iterator[Placed]:
    return ((s.estimate.east, s.estimate.north, s.estimate.covariance) for s in samples)


def as_map(axes: Axes) -> None:
    """Make the axes a map: m from home, which is marked, at one scale, with a legend."""
    axes.plot(0.0, 0.0, marker="*", markersize=14, color=_TRUE, linestyle="", label="home")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east of home, m")
    axes.set_ylabel("north of home, m")
    axes.grid(alpha=0.3)
    axes.legend(loc="best", fontsize=9)


def _number_legs(
    axes: Axes,
    flown: Sequence[tuple[LegFlown, Sequence[Estimate | TruePlace]]],
    marks: dict[str, _Mark],
) -> None:
    """Draw one number for each leg near its middle, if there is room. Further rounds have none,
    since they are near by."""
    low, high = axes.get_xlim()
    bottom, top = axes.get_ylim()
    near = _NEAR * max(high - low, top - bottom)
    placed: list[tuple[float, float]] = []
    for leg, seen in flown:
        if not seen or leg.name != _plain(leg.name):
            continue
        spots = (seen[int(share * (len(seen) - 1))] for share in (0.5, 0.25, 0.75))
        at = next(
            (
                spot
                for spot in spots
                if all(math.hypot(spot.east - e, spot.north - n) >= near for e, n in placed)
            ),
            None,
        )
        if at is None:
            continue
        placed.append((at.east, at.north))
        mark = marks[leg.name]
        axes.annotate(
            str(mark.number),
            (at.east, at.north),
            xytext=(7, 7),
            textcoords="offset points",
            fontsize=9,
            fontweight="bold",
            color=_TRUE,
            bbox={"boxstyle": "circle,pad=0.2", "fc": "white", "ec": mark.colour, "alpha": 0.85},
        )


def _draw_profile(axes: Axes, flight: Flight, marks: dict[str, _Mark]) -> None:
    named: set[str] = set()
    free = 0.0  # s, where the number before ends
    for leg in flight.legs:
        name = _plain(leg.name)
        mark = marks[name]
        label = None if name in named else f"{mark.number}  {name}"
        named.add(name)
        axes.axvspan(leg.entered, leg.left, color=mark.colour, alpha=0.6, lw=0, label=label)
        middle = (leg.entered + leg.left) / 2.0
        half = _DIGIT * flight.mission_time * (len(str(mark.number)) + 0.5) / 2.0
        if middle - half >= free:
            free = middle + half
            axes.text(
                middle,
                1.01,
                str(mark.number),
                transform=axes.get_xaxis_transform(),
                ha="center",
                va="bottom",
                fontsize=8,
            )
    axes.plot(
        [s.t for s in flight.samples],
        [math.nan if flight.on_land else s.true.depth for s in flight.samples],
        color=_TRUE,
        linewidth=1.2,
    )
    known = [(s.t, s.estimate.depth) for s in flight.samples if s.estimate.depth is not None]
    axes.plot(
        [t for t, _ in known],
        [depth for _, depth in known],
        color=_ESTIMATE,
        linewidth=1.0,
        linestyle="--",
    )
    axes.invert_yaxis()
    axes.set_xlabel("s from the start of the mission")
    if flight.on_land:
        axes.set_yticks([])
    else:
        axes.set_ylabel("depth, m")
    axes.grid(alpha=0.3)
    if named:
        below = (0.5, -0.2)  # among the curves it would hide one of them
        longest = max(len(name) for name in named)
        columns = max(1, min(len(named), 6, _KEY_WIDTH // (longest + 8)))
        axes.legend(loc="upper center", bbox_to_anchor=below, fontsize=8, ncols=columns)


def _spread(samples: Sequence[Sample], count: int) -> Sequence[Sample]:
    step = max(1, len(samples) // count)
    return samples[step - 1 :: step]
