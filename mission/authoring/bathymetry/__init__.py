"""Read files of depths into one grid, north up: ESRI ASCII grids, GeoJSON, tables of soundings.

    BathymetryError   (the author must act: file, line or path, what, what instead)

    ESRI ASCII    ncols, nrows, xllcorner or xllcenter, ..., cellsize (or dx and dy), nodata_value
    GeoJSON       areas with a depth (or drval1 and drval2, as in S-57), lines and points with a
                  depth, points with a third coordinate
    table         a first line that names latitude, longitude and depth; without it, the columns
                  are longitude, latitude and depth, as in .xyz files

Depths are m below the surface; land is negative. If most values of a file are negative, they are
heights, and their sign is changed. Soundings and areas are gathered into cells. Each cell keeps the
shallowest and the deepest value in it; nan where the file has none.

What does not live here: the sea floor under a leg (authoring.check.seabed), tides, other datums.
Sources: Esri, "ASCII raster format" (ArcGIS documentation); RFC 7946; IHO S-57, appendix A.
"""

from __future__ import annotations

from pathlib import Path

from mission.authoring.bathymetry.esri import from_esri
from mission.authoring.bathymetry.geojson import from_geojson
from mission.authoring.bathymetry.grid import CONVERT, BathymetryError, Depths
from mission.authoring.bathymetry.soundings import from_table

__all__ = ["BathymetryError", "Depths", "bathymetry_of", "read_bathymetry"]

MOST_BYTES = 64 << 20
_OTHERS = {  # the first bytes of files that cannot be read here
    b"II*\0": "a GeoTIFF",
    b"MM\0*": "a GeoTIFF",
    b"II+\0": "a GeoTIFF",
    b"CDF": "netCDF",
    b"\x89HDF": "netCDF or a BAG",
    b"DSAA": "a Surfer grid",
    b"DSBB": "a Surfer grid",
    b"DSRB": "a Surfer grid",
    b"PK": "a ZIP archive",
    b"\x1f\x8b": "compressed",
}


def read_bathymetry(path: Path) -> Depths:
    """Read a file of depths; its content tells the format. Raises BathymetryError."""
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise BathymetryError(f"{path}: {error.strerror or error}") from None
    if len(data) > MOST_BYTES:
        what = f"more than {MOST_BYTES >> 20} MB"
        raise BathymetryError(f"{path}: {what}; cut out the part that is flown over")
    for begin, what in _OTHERS.items():
        if data.startswith(begin):
            archive = what in ("a ZIP archive", "compressed")
            raise BathymetryError(f"{path}: {what}; {'unpack it first' if archive else CONVERT}")
    return bathymetry_of(data.decode("utf-8-sig", "replace"), str(path))


def bathymetry_of(text: str, source: str) -> Depths:
    """Read depths from a text; messages call it ``source``. Raises BathymetryError."""
    beginning = text.lstrip()[:20].lower()
    if beginning.startswith("{"):
        return from_geojson(text, source)
    if beginning.startswith(("ncols", "nrows")):
        return from_esri(text, source)
    return from_table(text, source)
