"""Archives of tiles: MBTiles (SQLite) and PMTiles, raster, Web Mercator.

The page places each tile by its corners. Within a tile latitude is not quite linear: the middle of
a tile of zoom 12 is up to 0.9 m off, of zoom 14 0.06 m. From zoom 10 on that is less than a fifth
of a pixel.
"""

from __future__ import annotations

import contextlib
import gzip
import math
import sqlite3
import time
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mission.console.charts.layer import Bounds, ChartError, Layer, Tile

DEEPEST = 24
MOST_TILE = 4 << 20  # bytes
MOST_DIRECTORY = 1 << 20  # bytes, unpacked
DEEPEST_DIRECTORY = 4
LONGEST_S = 5.0  # for one query of an archive
STEPS = 10_000  # steps of SQLite between checks of the clock
KINDS = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp"}
RASTER = ("png", "jpg", "jpeg", "webp")


def media_of(tile: bytes) -> str:
    """Return the type by the first bytes; "" for one that is not shown."""
    return next((kind for mark, kind in KINDS.items() if tile.startswith(mark)), "")


def _layer(path: Path, bounds: Bounds, zooms: tuple[int, int], read: Tile) -> Layer:
    if not all(isinstance(z, int) for z in zooms) or not 0 <= zooms[0] <= zooms[1] <= DEEPEST:
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
            bounds = _told(found) or _covered(path, archive, zooms[1])
    except sqlite3.Error as error:
        raise ChartError(f"{path.name}: no MBTiles: {error}") from None
    return _layer(path, bounds, zooms, lambda z, x, y: _mbtile(path, z, x, y))


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    path.stat()  # its error message is better than sqlite's
    archive = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
    end = time.monotonic() + LONGEST_S  # the tiles may be a view that never ends
    archive.set_progress_handler(lambda: time.monotonic() > end, STEPS)
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


def _covered(path: Path, archive: sqlite3.Connection, zoom: int) -> Bounds:
    asked = (
        "SELECT min(tile_column), min(tile_row), max(tile_column), max(tile_row) "
        "FROM tiles WHERE zoom_level = ?"
    )
    left, low, right, up = found = archive.execute(asked, (zoom,)).fetchone()
    if not all(isinstance(v, int) for v in (zoom, *found)) or not 0 <= zoom <= DEEPEST:
        raise ChartError(f"{path.name}: tiles at zoom {zoom!r}, {found}: whole numbers are needed")
    n = 1 << zoom
    return (
        left / n * 360 - 180,
        _latitude(n - low, n),
        (right + 1) / n * 360 - 180,
        _latitude(n - up - 1, n),
    )


def _latitude(row: float, n: int) -> float:
    """Return the latitude of the upper edge of a row, counted from the north."""
    return math.degrees(math.atan(math.sinh(math.pi * (1 - 2 * row / n))))


def _mbtile(path: Path, zoom: int, column: int, row: int) -> bytes | None:
    """Read a tile; the archive counts rows from the south."""
    asked = (
        "SELECT tile_data FROM tiles WHERE zoom_level = ? AND tile_column = ? AND tile_row = ? "
        "AND length(tile_data) <= ?"
    )
    try:
        with _opened(path) as archive:
            which = zoom, column, (1 << zoom) - 1 - row, MOST_TILE
            found = archive.execute(asked, which).fetchone()
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
    """Like the package's own reader, which unpacks without a limit."""
    from pmtiles.tile import deserialize_directory, deserialize_header, find_tile, zxy_to_tileid

    damaged = (OSError, EOFError, ValueError, IndexError, KeyError, OverflowError, zlib.error)
    with contextlib.suppress(*damaged), path.open("rb") as file:

        def get(offset: int, length: int) -> bytes:
            file.seek(offset)
            return file.read(length) if length <= MOST_TILE else b""

        head = deserialize_header(get(0, 127))
        tile = zxy_to_tileid(zoom, column, row)
        where = head["root_offset"], head["root_length"]
        for _ in range(DEEPEST_DIRECTORY):
            found = find_tile(deserialize_directory(_bounded(get(*where))), tile)
            if found is None:
                return None
            if found.run_length:
                return get(head["tile_data_offset"] + found.offset, found.length)
            where = head["leaf_directory_offset"] + found.offset, found.length
    return None


def _bounded(packed: bytes) -> bytes:
    """Limit a directory: 4 MiB may unpack to 4 GiB. Raises ValueError."""
    plain = zlib.decompressobj(zlib.MAX_WBITS | 16).decompress(packed, MOST_DIRECTORY + 1)
    if len(plain) > MOST_DIRECTORY:
        raise ValueError("a directory larger than any")
    return gzip.compress(plain, 0)
