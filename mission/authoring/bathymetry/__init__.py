"""Files of depths -> one grid of them, north up: ESRI ASCII grids, GeoJSON, tables of soundings.

    BathymetryError   (the author must act: file, line or path, what, what instead)

    ESRI ASCII    ncols, nrows, xllcorner or xllcenter, ..., cellsize (or dx and dy), nodata_value
    GeoJSON       areas with a depth (or drval1 and drval2, as S-57 has them), lines and points with
                  one, points with a third coordinate
    table         a first line that names latitude, longitude and depth; without one longitude,
                  latitude and depth, as .xyz has them

Depths are m below the surface; land is negative. A file whose values are negative for the greater
part has heights, which are turned round. Soundings and areas are gathered into cells; of what lies
in a cell both the shallowest and the deepest are kept. What no cell knows is nan.

What does not live here: what lies under a leg (authoring.check.seabed), tides, other datums.
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
_OTHERS = {  # how files begin that are not read
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
    """By what is in it. Raises BathymetryError."""
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
    """The same of a text that is at hand; ``source`` is what messages call it."""
    beginning = text.lstrip()[:20].lower()
    if beginning.startswith("{"):
        return from_geojson(text, source)
    if beginning.startswith(("ncols", "nrows")):
        return from_esri(text, source)
    return from_table(text, source)
