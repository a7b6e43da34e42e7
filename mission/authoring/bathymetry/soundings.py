"""Tables of soundings: a first line names latitude, longitude and depth.

Without such a line, three columns without commas are longitude, latitude and depth, as in .xyz
files. A depth of NaN means no data (GMT). If no value of a column named depth is positive, the sign
decides whether they are heights.
"""

from __future__ import annotations

import contextlib
import csv
import re
from collections.abc import Iterable

from mission.authoring.bathymetry.cells import Found, gathered
from mission.authoring.bathymetry.geojson import HEIGHTS
from mission.authoring.bathymetry.grid import READABLE, BathymetryError, Depths, finite, nothing

_UNIT = re.compile(r"\s*[(\[](m|meters?|metres?|deg|degrees?|°)[)\]]\Z")  # behind a name
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
    head = [_UNIT.sub("", word.strip().strip('"').lower()) for word in _split(lines[0][1], mark)]
    found, order, named = Found(source), [1, 0, 2], "z"
    if not _numeric(head):
        order = [_column(head, names, source) for names in _NAMES.values()]
        named = head[order[2]]
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
        if not nothing(words[order[2]].strip()):
            a, b, c = (finite(words[k].strip(), f"{source}:{number}") for k in order)
            found.points.append((a, b, c))
    if named in HEIGHTS or (named == "depth" and any(depth > 0.0 for _, _, depth in found.points)):
        found.heights.add(named in HEIGHTS)
    return gathered(found, "soundings")


def _split(line: str, mark: str | None) -> list[str]:
    if mark is None:
        return line.split()
    with contextlib.suppress(csv.Error):  # a field that is too long
        return next(csv.reader([line], delimiter=mark))
    return line.split(mark)


def _numeric(words: Iterable[str]) -> bool:
    try:
        return len([float(word) for word in words]) > 0
    except ValueError:
        return False


def _column(head: list[str], names: tuple[str, ...], source: str) -> int:
    for name in names:
        if name in head:
            return head.index(name)
    raise BathymetryError(f"{source}:1: no column {' or '.join(names[:2])}; {READABLE}")
