"""A grid of depths: ESRI ASCII (.asc), in degrees.

Depths or heights: many grids of the sea floor (GEBCO, EMODnet) hold heights, which are below zero
under water. Where the middle value is below zero all are turned round, and the note says so.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from mission.console.charts.layer import ChartError, Layer, degrees, text

MOST_CELLS = 4_000_000
_NEEDED = ("ncols", "nrows")
_KNOWN = (*_NEEDED, "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy",
          "nodata_value")  # fmt: skip
Header = dict[str, float]
Values = npt.NDArray[np.float32]


def read_grid(path: Path) -> Layer:
    """Raises ChartError, OSError."""
    lines = text(path).splitlines()
    head = _header(path, lines)
    columns, rows = int(head["ncols"]), int(head["nrows"])
    if columns * rows > MOST_CELLS:
        raise ChartError(f"{path.name}: {columns} x {rows} cells: at most {MOST_CELLS}")
    values = _values(path, lines, len(head), columns * rows)
    values[values == np.float32(head.get("nodata_value", -9999.0))] = np.nan
    known = values[np.isfinite(values)]
    if not known.size:
        raise ChartError(f"{path.name}: no cell of it has a value")
    turned = float(np.median(known)) < 0
    depths, known = (-values, -known) if turned else (values, known)
    least, greatest = float(known.min()), float(known.max())
    note = f"{least:.1f} to {greatest:.1f} m" + (", heights turned to depths" if turned else "")
    more = {"columns": columns, "rows": rows, "least": least, "greatest": greatest}
    data, media = depths.astype("<f4").tobytes(), "application/octet-stream"
    return Layer(path.name, "depths", _bounds(path, head), note, data, media, more)


def _header(path: Path, lines: list[str]) -> Header:
    found: Header = {}
    for number, line in enumerate(lines[: len(_KNOWN)], 1):
        name, _, value = line.strip().partition(" ")
        if name.lower() not in _KNOWN:
            break
        try:
            found[name.lower()] = float(value)
        except ValueError:
            raise ChartError(f"{path.name}: line {number}: {value!r} is no number") from None
    missing = [name for name in _NEEDED if not 1 <= found.get(name, 0) < 1e6]
    if missing:
        raise ChartError(f"{path.name}: no ESRI ASCII grid: {missing[0]} is missing at its head")
    return found


def _values(path: Path, lines: list[str], head: int, count: int) -> Values:
    words = [word for line in lines[head:] for word in line.split()]
    if len(words) != count:
        raise ChartError(f"{path.name}: {len(words)} values, its head says {count}")
    try:
        return np.array(words, dtype=np.float32)
    except ValueError as error:
        raise ChartError(f"{path.name}: {error}") from None


def _bounds(path: Path, head: Header) -> tuple[float, float, float, float]:
    wide = head.get("dx", head.get("cellsize", 0.0))
    high = head.get("dy", head.get("cellsize", 0.0))
    corners = {"x": wide, "y": high}
    for axis, cell in corners.items():
        low, middle = head.get(f"{axis}llcorner"), head.get(f"{axis}llcenter")
        if cell <= 0 or (low is None and middle is None):
            raise ChartError(f"{path.name}: its head has no cellsize or no {axis}llcorner")
        corners[axis] = low if low is not None else float(middle or 0.0) - cell / 2
    west, south = corners["x"], corners["y"]
    east, north = west + head["ncols"] * wide, south + head["nrows"] * high
    for latitude, longitude in ((south, west), (north, east)):
        degrees(path.name, round(latitude, 9), round(longitude, 9))
    return west, south, east, north
