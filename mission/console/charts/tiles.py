"""Archives of tiles: MBTiles (SQLite) and PMTiles, raster, Web Mercator.

The page places each tile by its corners. Within a tile latitude is not quite straight: the middle
of one of zoom 12 lies up to 0.9 m off, of zoom 14 0.06 m; from zoom 10 on that is less than a fifth
of its pixel.
"""

from __future__ import annotations

import contextlib
import math
import sqlite3
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mission.console.charts.layer import Bounds, ChartError, Layer, Tile

DEEPEST = 24
MOST_TILE = 4 << 20  # bytes
KINDS = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp"}
RASTER = ("png", "jpg", "jpeg", "webp")


def media_of(tile: bytes) -> str:
    """By what it begins with; "" for none that is shown."""
    return next((kind for mark, kind in KINDS.items() if tile.startswith(mark)), "")


def _layer(path: Path, bounds: Bounds, zooms: tuple[int, int], read: Tile) -> Layer:
    if not 0 <= zooms[0] <= zooms[1] <= DEEPEST:
        raise ChartError(f"{path.name}: zoom {zooms[0]} to {zooms[1]}: from 0 to {DEEPEST}")
    west, south, east, north = bounds
    if not (-180 <= west < east <= 180 and -90 <= south < north <= 90):
        raise ChartError(f"{path.name}: bounds {bounds}: west, south, east, north in degrees")
    more = {"least": zooms[0], "greatest": zooms[1]}
    return Layer(path.name, "tiles", bounds, f"zoom {zooms[0]} to {zooms[1]}", more=more, tile=read)


# --- MBTiles -------------------------------------------------------------------------------------


def read_mbtiles(path: Path) -> Layer:
    """Raises ChartError, OSError."""
    try:
        with _opened(path) as archive:
            found = dict(archive.execute("SELECT name, value FROM metadata").fetchmany(1000))
            zooms = archive.execute("SELECT min(zoom_level), max(zoom_level) FROM tiles").fetchone()
            if zooms[0] is None:
                raise ChartError(f"{path.name}: no tile in it")
            kind = str(found.get("format") or "png").lower()
            if kind not in RASTER:
                raise ChartError(
                    f"{path.name}: tiles of {kind}: only pictures ({', '.join(RASTER)})"
                )
            bounds = _told(found) or _covered(archive, zooms[1])
    except sqlite3.Error as error:
        raise ChartError(f"{path.name}: no MBTiles: {error}") from None
    return _layer(path, bounds, zooms, lambda z, x, y: _mbtile(path, z, x, y))


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    path.stat()  # says it better than sqlite
    archive = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
    try:
        yield archive
    finally:
        archive.close()


def _told(found: Mapping[str, Any]) -> Bounds | None:
    try:
        west, south, east, north = (float(v) for v in str(found["bounds"]).split(","))
    except (KeyError, ValueError):
        return None
    return west, south, east, north


def _covered(archive: sqlite3.Connection, zoom: int) -> Bounds:
    asked = (
        "SELECT min(tile_column), min(tile_row), max(tile_column), max(tile_row) "
        "FROM tiles WHERE zoom_level = ?"
    )
    left, low, right, up = archive.execute(asked, (zoom,)).fetchone()
    n = 1 << zoom
    return (
        left / n * 360 - 180,
        _latitude(n - low, n),
        (right + 1) / n * 360 - 180,
        _latitude(n - up - 1, n),
    )


def _latitude(row: float, n: int) -> float:
    """Of the upper edge of a row from the north."""
    return math.degrees(math.atan(math.sinh(math.pi * (1 - 2 * row / n))))


def _mbtile(path: Path, zoom: int, column: int, row: int) -> bytes | None:
    """Its rows are counted from the south."""
    asked = "SELECT tile_data FROM tiles WHERE zoom_level = ? AND tile_column = ? AND tile_row = ?"
    try:
        with _opened(path) as archive:
            found = archive.execute(asked, (zoom, column, (1 << zoom) - 1 - row)).fetchone()
    except (sqlite3.Error, OSError):
        return None
    return found[0] if found and isinstance(found[0], bytes) else None


# --- PMTiles -------------------------------------------------------------------------------------


def read_pmtiles(path: Path) -> Layer:
    """Raises ChartError, OSError."""
    from pmtiles.tile import Compression, MagicNumberNotFound, TileType, deserialize_header

    try:
        with path.open("rb") as file:
            head = deserialize_header(file.read(127))
    except (MagicNumberNotFound, ValueError, IndexError, KeyError) as error:
        raise ChartError(f"{path.name}: no PMTiles of version 3 ({type(error).__name__})") from None
    pictures = (TileType.PNG, TileType.JPEG, TileType.WEBP)
    if head["tile_type"] not in pictures:
        raise ChartError(f"{path.name}: tiles of {head['tile_type'].name}: only PNG, JPEG, WebP")
    if head["internal_compression"] != Compression.GZIP:
        packed = head["internal_compression"].name
        raise ChartError(f"{path.name}: its directories are packed with {packed}: gzip is read")
    west, south, east, north = (
        head[name] / 1e7 for name in ("min_lon_e7", "min_lat_e7", "max_lon_e7", "max_lat_e7")
    )
    zooms = head["min_zoom"], head["max_zoom"]
    return _layer(path, (west, south, east, north), zooms, lambda z, x, y: _pmtile(path, z, x, y))


def _pmtile(path: Path, zoom: int, column: int, row: int) -> bytes | None:
    from pmtiles.reader import Reader

    damaged = (OSError, EOFError, ValueError, IndexError, OverflowError, zlib.error)
    with contextlib.suppress(*damaged), path.open("rb") as file:

        def get(offset: int, length: int) -> bytes:
            file.seek(offset)
            return file.read(min(length, MOST_TILE))

        found: bytes | None = Reader(get).get(zoom, column, row)  # type: ignore[no-untyped-call]
        return found
    return None
