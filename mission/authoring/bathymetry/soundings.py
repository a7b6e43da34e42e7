"""Tables of soundings: a first line names latitude, longitude and depth; without one three columns
without commas are longitude, latitude and depth, as .xyz has them.
"""

from __future__ import annotations

import contextlib
import csv
import math
from collections.abc import Iterable

from mission.authoring.bathymetry.cells import Found, gathered
from mission.authoring.bathymetry.geojson import HEIGHTS
from mission.authoring.bathymetry.grid import READABLE, BathymetryError, Depths, finite

_NAMES = {
    0: ("latitude", "lat", "y"),
    1: ("longitude", "lon", "long", "lng", "x"),
    2: ("depth", "z", *HEIGHTS),
}


def from_table(text: str, source: str) -> Depths:
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1)
             if line.strip() and not line.lstrip().startswith("#")]  # fmt: skip
    if not lines:
        raise BathymetryError(f"{source}: empty; {READABLE}")
    mark = next((m for m in (";", ",", "\t") if m in lines[0][1]), None)
    head = [word.strip().strip('"').lower() for word in _split(lines[0][1], mark)]
    found, order = Found(source), [1, 0, 2]
    if not _numeric(head):
        order = [_column(head, names, source) for names in _NAMES.values()]
        found.heights.add(head[order[2]] in HEIGHTS)
        if head[order[2]] == "z":
            found.heights.clear()
        lines = lines[1:]
    elif mark == "," or len(head) != 3:
        raise BathymetryError(
            f"{source}:{lines[0][0]}: nothing says which column is which; {READABLE}"
        )
    for number, line in lines:
        words = _split(line, mark)
        if len(words) <= max(order):
            what = f"{len(words)} columns are too few; write {', '.join(head)}"
            raise BathymetryError(f"{source}:{number}: {what}")
        a, b, c = (finite(words[k].strip(), f"{source}:{number}") for k in order)
        found.points.append((a, b, c))
    return gathered(found, "soundings")


def _split(line: str, mark: str | None) -> list[str]:
    if mark is None:
        return line.split()
    with contextlib.suppress(csv.Error):  # a field that is too long
        return next(csv.reader([line], delimiter=mark))
    return line.split(mark)


def _numeric(words: Iterable[str]) -> bool:
    try:
        return all(math.isfinite(float(word)) for word in words)
    except ValueError:
        return False


def _column(head: list[str], names: tuple[str, ...], source: str) -> int:
    for name in names:
        if name in head:
            return head.index(name)
    raise BathymetryError(f"{source}:1: no column {' or '.join(names[:2])}; {READABLE}")
