"""95 % ellipses on plans (east to the right, north up, m) of flights, dives and tracks.

An ellipse larger than a quarter of the frame would hide the track, and so would many ellipses on
top of one another. These are left out. No ellipse makes the frame larger.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from mission.navigation.distribution import PLANE_95, Covariance, principal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LARGEST = 0.25  # of the frame's long side

Placed = tuple[float, float, Covariance]  # east, north, m; covariance of north and east, m^2


def ellipse(covariance: Covariance) -> tuple[float, float, float]:
    """Return the full axes of the 95 % ellipse (m, long and short) and the bearing of its long axis
    (rad)."""
    great, small, bearing = principal(covariance)
    return 2.0 * PLANE_95 * great, 2.0 * PLANE_95 * small, bearing


def draw_ellipses(
    axes: Axes, places: Iterable[Placed], width: float, colour: str, label: str = "95 % ellipses"
) -> None:
    """Draw the ellipses that fit into a frame of ``width`` m, each clear of the one before it. The
    legend shows the label, and says if larger ones were left out."""
    from matplotlib.patches import Ellipse

    known = [(e, n, ellipse(covariance)) for e, n, covariance in places if math.isfinite(e + n)]
    fitting = [(e, n, axis) for e, n, axis in known if axis[0] <= LARGEST * width]
    if len(fitting) < len(known):
        label += ", larger ones left out" if fitting else ", left out: larger than the track"
        if not fitting:
            axes.plot([], [], color=colour, lw=0.6, linestyle="", label=label)
    last = (math.inf, math.inf, 0.0)  # east, north, long axis
    for east, north, (along, across, bearing) in fitting:
        if math.hypot(east - last[0], north - last[1]) < (along + last[2]) / 2.0:
            continue
        last = east, north, along
        angle = 90.0 - math.degrees(bearing)
        axes.add_artist(Ellipse((east, north), along, across, angle=angle, fill=False, ec=colour,
                                lw=0.6, alpha=0.7, label=label, zorder=2.5))  # fmt: skip
        label = ""


def width_of(places: Iterable[tuple[float, float]]) -> float:
    """Return the long side, m, of the frame around all finite places (east, north)."""
    known = [place for place in places if math.isfinite(place[0] + place[1])]
    if not known:
        return 0.0
    east, north = [e for e, _ in known], [n for _, n in known]
    return max(max(east) - min(east), max(north) - min(north))
