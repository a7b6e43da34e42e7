"""One picture of a rehearsal: where flights came up, and the spreads of time, error, coverage.

matplotlib is imported when a picture is drawn, with the Agg back end: no display is needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING

from mission.verification.rehearsing.flights import Flown
from mission.verification.rehearsing.report import Rehearsal
from mission.verification.simulation.plot import as_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_GOOD, _BAD, _REGION = "#3b7ea1", "#c1440e", "#256f2f"


def draw_rehearsal(
    made: Rehearsal, flown: Sequence[Flown], to: Path | IO[bytes], title: str, format_: str = ""
) -> None:
    """Write a PNG or SVG. ``format_`` "": by the suffix. Raises OSError."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 9.5), layout="constrained")
    FigureCanvasAgg(figure)
    shown = ["time, min", "position error, m", *(["coverage, %"] if made.coverage else [])]
    places, *spreads = figure.subplot_mosaic(
        [["map"] * len(shown), [str(i) for i in range(len(shown))]], height_ratios=(2.4, 1.0)
    ).values()
    _map(places, made, flown)
    values = ([f.time / 60.0 for f in flown], [f.error for f in flown],
              [100.0 * f.covered for f in flown])  # fmt: skip
    for axes, name, row in zip(spreads, shown, values, strict=False):
        axes.hist(row, bins=min(30, max(5, len(flown) // 5)), color=_GOOD, ec="white", lw=0.5)
        axes.set_xlabel(name)
        axes.set_ylabel("flights")
    done = made.outcomes.get("completed", 0)
    figure.suptitle(f"{title}: {done} of {made.asked} flights completed", fontsize=12)
    figure.savefig(to, dpi=110, format=format_ or None)


def _map(axes: Axes, made: Rehearsal, flown: Sequence[Flown]) -> None:
    from matplotlib.patches import Ellipse

    for good, colour, name in ((True, _GOOD, "completed"), (False, _BAD, "not completed")):
        up = [f.surfaced for f in flown if f.surfaced and (f.outcome == "completed") is good]
        if up:
            axes.plot([e for _, e in up], [n for n, _ in up], ".", color=colour, ms=5,
                      label=f"{name}, at the surface at the end")  # fmt: skip
    for r in made.regions:
        axes.add_patch(Ellipse((r.east, r.north), 2.0 * r.axes[0], 2.0 * r.axes[1],
                               angle=90.0 - math.degrees(r.bearing), fill=False, ec=_REGION,
                               lw=1.2))  # fmt: skip
        top = (r.east + r.axes[0] * math.sin(r.bearing), r.north + r.axes[0] * math.cos(r.bearing))
        axes.annotate(f"{r.share:.0%}", top, fontsize=9, color=_REGION)
    as_map(axes)
