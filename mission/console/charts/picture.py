"""A picture with its position: a world file beside it, or a JSON of its four corners.

    chart.png.json or chart.json  {"top_left": {"latitude": 60.1, "longitude": 24.9},
                                   "top_right": ..., "bottom_right": ..., "bottom_left": ...}
    chart.pgw, chart.pngw, chart.wld   six numbers, degrees of WGS 84

The affine map that fits the corners best places it. The residual at the corners is reported. A
picture with a large residual is refused: it is warped, and must be straightened first.
"""

from __future__ import annotations

import json
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, UnidentifiedImageError

from mission.console.charts.layer import ChartError, Layer, around, degrees, text, whole

PICTURES = (".png", ".jpg", ".jpeg", ".webp")
CORNERS = ("top_left", "top_right", "bottom_right", "bottom_left")
MOST_PIXELS = 64_000_000  # limit of a browser's canvas
MOST_OFF = 0.01  # residual, as a share of the diagonal
METRES = 111_320.0  # m per degree of latitude
Affine = tuple[float, float, float, float, float, float]
Place = tuple[float, float]  # longitude, latitude


def read_picture(path: Path) -> Layer:
    """Raises ChartError, OSError."""
    data = whole(path)
    media, wide, high = _size(path)
    beside = placed_by(path)
    if beside is None:
        asked = f"{path.name}.json with its four corners, or {world_names(path)[0]}"
        raise ChartError(f"{path.name}: nothing says where it lies: put {asked} beside it")
    corners = _corners(beside) if beside.suffix == ".json" else _world(beside, wide, high)
    for (longitude, latitude), name in zip(corners, CORNERS, strict=True):
        degrees(f"{beside.name}: {name}", latitude, longitude)
    affine, off = _fit(beside, corners, wide, high)
    more = {"width": wide, "height": high, "affine": affine}
    note = f"{wide} x {high}, {beside.name}" + (
        f", corners off by {off:.1f} m" if off >= 0.5 else ""
    )
    return Layer(path.name, "picture", around(corners), note, data, media, more)


def placed_by(path: Path) -> Path | None:
    names = (f"{path.name}.json", f"{path.stem}.json", *world_names(path))
    return next((path.with_name(n) for n in names if path.with_name(n).is_file()), None)


def world_names(path: Path) -> tuple[str, ...]:
    kind = path.suffix[1:].lower()
    return f"{path.stem}.{kind[0]}{kind[-1]}w", f"{path.name}w", f"{path.stem}.wld"


def _size(path: Path) -> tuple[str, int, int]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path, formats=("PNG", "JPEG", "WEBP")) as picture:
                wide, high = picture.size
                media = f"image/{str(picture.format).lower()}"
    except (UnidentifiedImageError, Image.DecompressionBombError, SyntaxError, ValueError) as error:
        raise ChartError(f"{path.name}: no PNG, JPEG or WebP: {error}") from None
    if wide * high > MOST_PIXELS:
        raise ChartError(f"{path.name}: {wide} x {high}: at most {MOST_PIXELS} pixels; make tiles")
    return media, wide, high


def _corners(path: Path) -> list[Place]:
    try:
        said = json.loads(text(path))
        return [(float(said[name]["longitude"]), float(said[name]["latitude"])) for name in CORNERS]
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        asked = '{"latitude": deg, "longitude": deg}'
        if isinstance(error, ChartError):
            raise
        raise ChartError(f"{path.name}: {', '.join(CORNERS)}, each {asked}: {error!r}") from None


def _world(path: Path, wide: int, high: int) -> list[Place]:
    """Return the corners; a world file counts from the middle of the first pixel."""
    try:
        a, d, b, e, c, f = (float(word) for word in text(path).split())
    except ValueError:
        raise ChartError(f"{path.name}: a world file has six numbers") from None

    def place(x: float, y: float) -> Place:
        return c + a * (x - 0.5) + b * (y - 0.5), f + d * (x - 0.5) + e * (y - 0.5)

    return [place(0, 0), place(wide, 0), place(wide, high), place(0, high)]


def _fit(path: Path, corners: list[Place], wide: int, high: int) -> tuple[list[float], float]:
    """Return longitude and latitude of a pixel, [lon, per x, per y, lat, per x, per y], and the
    residual at the corners, m: with four corners it is the same at each."""
    pixels = np.array([[1, 0, 0], [1, wide, 0], [1, wide, high], [1, 0, high]], dtype=float)
    lon, lat = (
        np.linalg.lstsq(pixels, np.array(c), rcond=None)[0] for c in zip(*corners, strict=True)
    )
    flat = math.cos(math.radians(corners[0][1]))
    x, y = np.array(corners).T
    off = METRES * math.hypot(flat * float((pixels @ lon - x)[0]), float((pixels @ lat - y)[0]))
    across = METRES * math.hypot(flat * (x[2] - x[0]), y[2] - y[0])
    if across == 0 or off > MOST_OFF * across:
        raise ChartError(
            f"{path.name}: the four corners are no parallelogram (off by {off:.0f} m of "
            f"{across:.0f} m): straighten the picture first; or two of them are swapped"
        )
    return [*map(float, lon), *map(float, lat)], off


def is_corners(said: Any) -> bool:
    return isinstance(said, dict) and CORNERS[0] in said
