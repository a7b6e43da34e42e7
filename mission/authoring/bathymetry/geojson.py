"""Depths in GeoJSON: areas, lines and points with a depth, points with a third coordinate.

The property is called depth, or as in S-57 (drval1 with drval2, valdco, valsou). The sign of
elevation and height is changed.

Sources: RFC 7946; IHO S-57, appendix A, chapter 2 (attributes).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

from mission.authoring.bathymetry.cells import Found, gathered
from mission.authoring.bathymetry.grid import BathymetryError, Corner, Depths, finite

_DEPTHS = ("depth", "valdco", "valsou", "drval1")
HEIGHTS = ("elevation", "height", "elev", "ele")


def from_geojson(text: str, source: str) -> Depths:
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BathymetryError(f"{source}: no JSON ({error}); save it again as GeoJSON") from None
    found = Found(source)
    features = data.get("features", [data]) if isinstance(data, dict) else []
    for number, feature in enumerate(features if isinstance(features, list) else []):
        where = f"{source}: features[{number}]"
        try:
            _feature(feature, found, where)
        except (
            TypeError,
            ValueError,
            KeyError,
            AttributeError,
            IndexError,
            OverflowError,
        ) as error:
            if isinstance(error, BathymetryError):
                raise
            raise BathymetryError(f"{where}: no feature of GeoJSON; see RFC 7946") from None
    if len(found.heights) > 1:
        raise BathymetryError(f"{source}: some features name depths, others heights; keep one")
    return gathered(found, "GeoJSON")


def _feature(feature: dict[str, Any], found: Found, where: str) -> None:
    said = {str(k).lower(): v for k, v in (feature.get("properties") or {}).items()}
    shape = feature.get("geometry", feature)
    if shape is None:
        return
    name = next((key for key in (*_DEPTHS, *HEIGHTS) if said.get(key) is not None), "")
    depth = None if not name else finite(str(said[name]), f"{where}: {name}")
    if name:
        found.heights.add(name in HEIGHTS)
    deep = said.get("drval2")
    deepest = depth if deep is None else finite(str(deep), f"{where}: drval2")
    _geometry(shape, (depth, deepest), found, where)


def _geometry(
    shape: dict[str, Any], depths: tuple[float | None, float | None], found: Found, where: str
) -> None:
    kind = shape["type"]
    if kind == "GeometryCollection":
        for one in shape["geometries"]:
            _geometry(one, depths, found, where)
        return
    places, depth, deepest = shape["coordinates"], *depths
    if kind in ("Polygon", "MultiPolygon"):
        if depth is None or deepest is None:
            raise BathymetryError(f"{where}: an area without a depth; give it the property depth")
        for rings in [places] if kind == "Polygon" else places:
            found.areas.append(([[_corner_of(p) for p in ring] for ring in rings], depth, deepest))
        return
    for place in _flat(places):
        if depth is None and len(place) < 3:
            what = "give it the property depth, or a third coordinate"
            raise BathymetryError(f"{where}: {kind} without a depth; {what}")
        value = finite(str(place[2]), where) if depth is None else depth
        found.points.append((*_corner_of(place), value))


def _flat(places: Any) -> Iterator[list[float]]:
    if isinstance(places[0], list):
        for place in places:
            yield from _flat(place)
    else:
        yield places


def _corner_of(place: Sequence[float]) -> Corner:
    return float(place[1]), float(place[0])
