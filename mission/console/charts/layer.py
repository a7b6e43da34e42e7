"""A layer of the chart: its description for the page, its data, and its tiles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

Kind = Literal["shapes", "picture", "tiles", "depths"]
Bounds = tuple[float, float, float, float]  # west, south, east, north, degrees
Tile = Callable[[int, int, int], bytes | None]  # arguments: zoom, column, row from the north
MOST = 64 << 20  # bytes of a file that is read as a whole, at most


class ChartError(ValueError):
    """The message names the file, the place in it, what is wrong, and a remedy."""


@dataclass(frozen=True, slots=True)
class Layer:
    """``data``, of type ``media``: what the page loads at once. ``more``: fields of its kind
    (docs/design/console.md)."""

    name: str
    kind: Kind
    bounds: Bounds
    note: str = ""
    data: bytes = b""
    media: str = "application/json"
    more: Mapping[str, Any] = field(default_factory=dict)
    tile: Tile | None = None

    def as_object(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "kind": self.kind,
            "bounds": list(self.bounds),
            "note": self.note,
            **self.more,
        }


def whole(path: Path) -> bytes:
    """Raises ChartError, and OSError."""
    size = path.stat().st_size
    if size > MOST:
        raise ChartError(
            f"{path.name}: {size >> 20} MiB: at most {MOST >> 20} MiB are read at once; cut out "
            "the survey's part, or make tiles of it (MBTiles, PMTiles)"
        )
    return path.read_bytes()


def text(path: Path) -> str:
    try:
        return whole(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ChartError(f"{path.name}: byte {error.start}: no UTF-8 text") from None


def degrees(where: str, latitude: float, longitude: float) -> None:
    """Raises ChartError unless both are degrees, e.g. for metres of a projection."""
    if not (abs(latitude) <= 90 and abs(longitude) <= 180):  # also true for NaN
        raise ChartError(
            f"{where}: latitude {latitude:g}, longitude {longitude:g}: degrees of WGS 84 are "
            "needed; bring the file to EPSG:4326 first"
        )


def around(places: Iterable[tuple[float, float]]) -> Bounds:
    """Return the bounds of longitudes and latitudes; at least one pair."""
    west = south = math.inf
    east = north = -math.inf
    for longitude, latitude in places:
        west, east = min(west, longitude), max(east, longitude)
        south, north = min(south, latitude), max(north, latitude)
    return west, south, east, north
