"""The page of bench_growth: its tables put where their marks stand, read again, and drawn."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path

from bench_growth import SWEEPS, Cost, Point

COLUMNS = 5
MARKED = re.compile(r"<!-- begin (\w+) -->\n(.*?)<!-- end \1 -->", re.DOTALL)


def filled(page: str, tables: Mapping[str, str]) -> str:
    """The tables between the marks of their names; the others stay."""

    def put(mark: re.Match[str]) -> str:
        return f"<!-- begin {mark[1]} -->\n{tables.get(mark[1], mark[2])}<!-- end {mark[1]} -->"

    return MARKED.sub(put, page)


def points_of(page: str) -> dict[str, list[Point]]:
    """By sweep, what the page's tables tell of sizes, times and memories."""
    return {mark[1]: list(map(_point, _rows(mark[2]))) for mark in MARKED.finditer(page)}


def _rows(text: str) -> list[list[str]]:
    return [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("|")][2:]


def _point(row: list[str]) -> Point:
    size, time, memory = (float(cell.replace(",", "")) for cell in row[:3])
    return Point(int(size), Cost(time, memory))


def draw(page: str, path: Path) -> None:
    """Writes an SVG: time and memory by size, both axes logarithmic."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "growth"
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    found = points_of(page)
    rows = math.ceil(len(found) / COLUMNS)
    figure = Figure(figsize=(3.0 * COLUMNS, 3.0 * rows), layout="constrained")
    grid = figure.subplots(rows, COLUMNS).flat
    for axes, (name, points) in zip(grid, found.items(), strict=False):
        sweep, sizes = SWEEPS[name], [point.size for point in points]
        time = "% of a core" if sweep.served else "s"
        axes.loglog(sizes, [point.cost.time for point in points], "o-", color="#2b5c8a", label=time)
        axes.loglog(sizes, [p.cost.memory for p in points], "s--", color="#c1440e", label="MB")
        axes.set_title(sweep.says.split(", ")[0].replace("`", ""), fontsize=9)
        axes.set_xlabel(sweep.counted, fontsize=8)
        axes.grid(True, which="major", color="#dddddd")
        axes.legend(fontsize=7)
        axes.tick_params(labelsize=7)
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.yaxis.set_minor_formatter(NullFormatter())
    figure.savefig(path, metadata={"Date": None})
