"""GeoJSON (RFC 7946): each LineString is a route, and each line of a MultiLineString.

A position is longitude, latitude, and perhaps metres upward. WGS 84 is the only datum; a ``crs``
(older than RFC 7946) may state it. Points are left out since they have no order, and areas since
they are no path.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from mission.authoring.importing.route import (
    Findings,
    Point,
    Route,
    Source,
    Step,
    along,
    below,
    position,
)
from mission.authoring.importing.tree import Value, values

_WGS_84 = (":CRS84", "EPSG:4326", "EPSG::4326")
_GEOMETRIES = {
    "Point": "a Point: points have no order, draw a line",
    "MultiPoint": "a MultiPoint: points have no order, draw a line",
    "Polygon": "a Polygon: an area is no path",
    "MultiPolygon": "a MultiPolygon: an area is no path",
}


def read(data: bytes, found: Findings) -> Source:
    return Source(tuple(_routes(_root(data, found), "", found)))


def areas(data: bytes, found: Findings) -> Source:
    """Each Polygon as a route of its corners, for a leg that covers the area."""
    return Source(tuple(_areas(_root(data, found), "", found)))


def _root(data: bytes, found: Findings) -> Value:
    """The root value. Raises ImportErrors if its places are not in WGS 84."""
    root = values(data, found)
    crs = root.get("crs")
    name = crs.get("properties").get("name").text()
    if crs.raw is not None and not name.upper().endswith(_WGS_84):
        what = f"its places are in {name[:60] or 'another datum'}, not in WGS 84"
        raise found.refusal("position", "crs", what, "ogr2ogr -t_srs EPSG:4326 makes them so")
    return root


def _areas(value: Value, name: str, found: Findings) -> Iterator[Route]:
    kind = value.get("type").text()
    if kind == "FeatureCollection":
        for feature in value.get("features").items():
            yield from _areas(feature, name, found)
    elif kind == "Feature" and value.get("geometry").raw is not None:
        said = value.get("properties").get("name").text()
        yield from _areas(value.get("geometry"), said, found)
    elif kind == "GeometryCollection":
        for geometry in value.get("geometries").items():
            yield from _areas(geometry, name, found)
    elif kind == "MultiPolygon":
        for part in value.get("coordinates").items():
            yield Route(name, part.path, partial(_corners, part, found))
    elif kind == "Polygon":
        yield Route(name, value.path, partial(_corners, value.get("coordinates"), found))


def _corners(rings: Value, found: Findings) -> tuple[Step, ...]:
    """The corners of the only ring; its last corner repeats the first and is dropped."""
    outer = list(rings.items())
    if len(outer) != 1:
        what = "an area with holes" if outer else "an area without corners"
        found.refuse("plan-form", rings.path, f"{what}: draw it by one ring")
        return ()
    return _steps(outer[0], found)[:-1]


def _routes(value: Value, name: str, found: Findings) -> Iterator[Route]:
    kind = value.get("type").text()
    if kind == "FeatureCollection":
        for feature in value.get("features").items():
            yield from _routes(feature, name, found)
    elif kind == "Feature":
        said = value.get("properties").get("name").text()
        if value.get("geometry").raw is not None:
            yield from _routes(value.get("geometry"), said, found)
    elif kind == "GeometryCollection":
        for geometry in value.get("geometries").items():
            yield from _routes(geometry, name, found)
    elif kind == "LineString":
        yield _route(value.get("coordinates"), name, found)
    elif kind == "MultiLineString":
        for number, line in enumerate(value.get("coordinates").items(), 1):
            yield _route(line, f"{name} {number}".strip(), found)
    elif kind in _GEOMETRIES:
        found.leave_out(value.path, _GEOMETRIES[kind])
    else:
        found.refuse("plan-form", value.path, f"{kind[:40]!r} is no type of GeoJSON")


def _route(line: Value, name: str, found: Findings) -> Route:
    return Route(name, line.path, partial(_steps, line, found))


def _steps(line: Value, found: Findings) -> tuple[Step, ...]:
    return along(_point(value, found) for value in line.items())


def _point(value: Value, found: Findings) -> Point | None:
    numbers = [item.number() for item in value.items()]
    if not 2 <= len(numbers) <= 3 or None in numbers[:2]:
        found.refuse(
            "position", value.path, "a position is longitude, latitude and perhaps a height"
        )
        return None
    longitude, latitude = numbers[0], numbers[1]
    assert longitude is not None
    assert latitude is not None
    place = position(latitude, longitude, value.path, found)
    if place is None:
        return None
    height = numbers[2] if len(numbers) == 3 else None
    return Point(place, value.path, depth=below(height, value.path, found))
