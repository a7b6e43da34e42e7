"""The planned track as a picture: plan view over a grid, and depth over time.

The ellipses along the track are the 95 % ellipses of the estimate; they grow until the next fix.
Legs have a colour and a number. Turning points have a mark, and their time if there is room. The
depth profile shows the sea floor of a file, where the file has it.

matplotlib is imported when a picture is drawn, with the Agg back end: no display is needed.
"""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING

from mission.authoring.graph import words
from mission.engine.areas import Fence
from mission.verification.planned.track import Plan, Spot, Stretch

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PALETTE = ("#3b7ea1", "#c19a2e", "#2f8f7f", "#b8505f", "#7d7d2a", "#8d3f8d", "#4f6fa8", "#256f2f")
_GROUND = "#8a7452"
_INK, _BAND = "#2b2b2b", "#c1440e"
_RGB = (0.72, 0.31, 0.37)  # colour of areas to keep out of
_ELLIPSES = 14
_IN_SIGHT = 4.0  # times the greatest depth; a deeper floor would make the dive too small to see
_ROOM = 0.03  # share of the picture's width; nearer than this, two times would overlap


def picture(plan: Plan, format_: str) -> bytes:
    """Return the picture as ``png`` or ``svg``; the same plan gives the same bytes."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    made = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "auvmission"}):
        figure = Figure(figsize=(9.0, 10.5), layout="constrained")
        FigureCanvasAgg(figure)
        above, below = figure.subplots(2, 1, height_ratios=(2.6, 1.0))
        _plan_view(above, plan)
        _profile(below, plan)
        widest = max((s.axes[0] for leg in plan.stretches for s in leg.spots), default=0.0)
        under = "" if plan.clearance is None else f",\nleast water under it {_water(plan)}"
        figure.suptitle(
            f"{plan.mission}: planned, {minutes(plan.seconds)} min in still water, "
            f"95 % within {widest:.0f} m at worst by its own estimate{under}",
            fontsize=11,
        )
        metadata = {"Date": None} if format_ == "svg" else None
        figure.savefig(made, format=format_, dpi=110, metadata=metadata)
    return made.getvalue()


def minutes(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"


def _water(plan: Plan) -> str:
    near = plan.clearance
    return "" if near is None else f"{near.least:.1f} m" + (": aground" if near.aground else "")


def _colour(index: int) -> str:
    return _PALETTE[index % len(_PALETTE)]


def _plan_view(axes: Axes, plan: Plan) -> None:
    spots = [spot for leg in plan.stretches for spot in leg.spots]
    for spot in spots[:: max(1, len(spots) // _ELLIPSES)]:
        _draw_ellipse(axes, spot)
    for index, leg in enumerate(plan.stretches):
        if leg.area and leg.area not in [before.area for before in plan.stretches[:index]]:
            outline = [*leg.area, leg.area[0]]
            axes.fill([e for _, e in outline], [n for n, _ in outline], color=_colour(index),
                      alpha=0.10, lw=0)  # fmt: skip
            axes.plot([e for _, e in outline], [n for n, _ in outline], color=_colour(index),
                      lw=0.8, ls=":")  # fmt: skip
        axes.plot([s.east for s in leg.spots], [s.north for s in leg.spots], color=_colour(index),
                  lw=2.2, solid_capstyle="round", label=f"{index + 1}  {leg.name}")  # fmt: skip
    axes.plot(0.0, 0.0, marker="*", markersize=14, color=_INK, ls="", label="home")
    axes.plot([], [], color=_BAND, lw=0.8, label="where it may be, 95 %, by its own estimate")
    axes.set_aspect("equal", adjustable="datalim")
    _draw_radius(axes, plan.radius)
    for fence in plan.fences:
        _draw_fence(axes, fence)
    _tell_times(axes, plan)
    axes.set_xlabel("east of home, m")
    axes.set_ylabel("north of home, m")
    axes.grid(alpha=0.35)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), fontsize=8, ncols=4)


def _draw_ellipse(axes: Axes, spot: Spot) -> None:
    from matplotlib.patches import Ellipse

    axes.add_patch(
        Ellipse((spot.east, spot.north), 2.0 * spot.axes[0], 2.0 * spot.axes[1],
                angle=90.0 - math.degrees(spot.bearing), fill=False, ec=_BAND, lw=0.8, alpha=0.6)
    )  # fmt: skip


def _draw_radius(axes: Axes, radius: float) -> None:
    """Draw the radius limit without enlarging the view, which would make the track small."""
    from matplotlib.patches import Circle

    axes.add_artist(Circle((0.0, 0.0), radius, fill=False, ec=_INK, lw=1.0, ls="--"))


def _draw_fence(axes: Axes, fence: Fence) -> None:
    """Draw an area with its name at the first corner: red to keep out of, grey to keep in."""
    from matplotlib.patches import Polygon

    corners = [(east, north) for north, east in fence.polygon]
    out, colour = fence.area.out, "#b8505f" if fence.area.out else _INK
    axes.add_patch(Polygon(corners, fill=out, fc=(*_RGB, 0.15), ec=colour, lw=1.0, ls="--"))
    axes.annotate(words.area(fence.area), corners[0], xytext=(4, 4), textcoords="offset points",
                  fontsize=7.5, color=colour)  # fmt: skip


def _tell_times(axes: Axes, plan: Plan) -> None:
    low, high = axes.get_xlim()
    room, told = _ROOM * (high - low), list[tuple[float, float]]()
    for spot in _marked(plan):
        axes.plot(spot.east, spot.north, "o", ms=3.5, color=_INK)
        here = (spot.north, spot.east)
        if all(math.dist(here, other) >= room for other in told):
            told.append(here)
            axes.annotate(minutes(spot.t), (spot.east, spot.north), xytext=(4, 4),
                          textcoords="offset points", fontsize=7.5, color=_INK)  # fmt: skip


def _marked(plan: Plan) -> list[Spot]:
    """Return the beginnings of legs, and their turning points."""
    return [spot for leg in plan.stretches for spot in (*leg.spots[:1], *leg.turns)]


def _profile(axes: Axes, plan: Plan) -> None:
    for index, leg in enumerate(plan.stretches):
        axes.plot([s.t / 60.0 for s in leg.spots], [s.depth for s in leg.spots],
                  color=_colour(index), lw=2.0)  # fmt: skip
    _draw_floor(axes, plan)
    axes.invert_yaxis()
    axes.set_xlabel("minutes from the start")
    axes.set_ylabel("depth, m")
    axes.grid(alpha=0.35)
    spread = axes.twinx()
    spots = [spot for leg in plan.stretches for spot in leg.spots]
    spread.plot(
        [s.t / 60.0 for s in spots], [s.axes[0] for s in spots], color=_BAND, lw=1.0, ls="--"
    )
    spread.set_ylabel("95 % radius of the position, m", color=_BAND)
    spread.set_ylim(bottom=0.0)


def _draw_floor(axes: Axes, plan: Plan) -> None:
    """Draw the floor of the file under the track, with gaps where the file has no depth."""
    spots = [spot for leg in plan.stretches for spot in leg.spots]
    known = [spot.floor for spot in spots if spot.floor is not None]
    if not known:
        return
    deepest = max(max(spot.depth for spot in spots), 1.0)
    below = min(1.05 * max(deepest, *known), _IN_SIGHT * deepest)
    floor = [math.nan if s.floor is None else min(s.floor, below) for s in spots]
    top = axes.get_ylim()[0]
    axes.fill_between([s.t / 60.0 for s in spots], floor, below, color=_GROUND, lw=0, alpha=0.55)
    axes.set_ylim(top, below)


def rows(plan: Plan) -> list[tuple[Stretch, float]]:
    """Return each leg with the 95 % radius (m) at its end."""
    return [(leg, leg.spots[-1].axes[0] if leg.spots else 0.0) for leg in plan.stretches]
