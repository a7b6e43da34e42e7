"""KML 2.2 (OGC 07-147r2), and KMZ (a ZIP file with a KML file): each LineString is a route.

A Polygon and a LinearRing are areas and no routes; a leg that covers an area can use their corners.
``coordinates`` are "longitude,latitude,height" separated by white space. The height is used with
altitudeMode absolute (above sea level) and relativeToSeaFloor (an altitude).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from mission.authoring.importing.archive import is_archive, member
from mission.authoring.importing.route import (
    At,
    Findings,
    Point,
    Route,
    Source,
    Step,
    along,
    below,
    number,
    position,
)
from mission.authoring.importing.xml import Element, elements

_LEFT_OUT = {
    "Point": "a Point: points have no order, draw a path",
    "Polygon": "a Polygon: an area is no path",
    "LinearRing": "a LinearRing: an area is no path",
    "Track": "a Track, which is no plan",
    "NetworkLink": "a NetworkLink: nothing outside the file is read",
    "GroundOverlay": "a GroundOverlay, which is a picture",
}
_NO_HEIGHT = frozenset({"", "clampToGround", "clampToSeaFloor"})


def read(data: bytes, found: Findings) -> Source:
    routes = []
    for element in _outside(_root(data, found)):
        if element.name in _LEFT_OUT:
            found.leave_out(element.where, _LEFT_OUT[element.name])
        elif element.name == "Placemark":
            routes += [
                Route(element.said("name"), line.where, partial(_steps, line, found))
                for line in element.within()
                if line.name == "LineString"
            ]
    return Source(tuple(routes))


def areas(data: bytes, found: Findings) -> Source:
    """Each Polygon, and each LinearRing outside one, as its corners, for a leg that covers it."""
    return Source(tuple(_areas(_root(data, found), "", found)))


def _root(data: bytes, found: Findings) -> Element:
    if is_archive(data):
        data = member(data, ".kml", "doc.kml", found)
    return elements(data, "kml", found)


def _outside(element: Element) -> Iterator[Element]:
    """The element and all its descendants, except those inside a Polygon."""
    yield element
    for child in element.children if element.name != "Polygon" else ():
        yield from _outside(child)


def _areas(element: Element, name: str, found: Findings) -> Iterator[Route]:
    name = element.said("name") or name
    if element.name == "Polygon":
        if element.one("innerBoundaryIs") is not None:
            what = "an area with holes: draw it by one ring"
            found.refuse("plan-form", element.where, what)
        element = element.one("outerBoundaryIs", "LinearRing") or element
    if element.name == "LinearRing":
        yield Route(name, element.where, partial(_corners, element, found))
        return
    for child in element.children:
        yield from _areas(child, name, found)


def _corners(ring: Element, found: Findings) -> tuple[Step, ...]:
    """The corners of a ring; its last corner repeats the first and is dropped."""
    return _steps(ring, found)[:-1]


def _steps(line: Element, found: Findings) -> tuple[Step, ...]:
    mode = line.said("altitudeMode")
    places = line.one("coordinates")
    if places is None:
        return ()
    return along(
        _point(one, mode, places.line + row, found)
        for row, text in enumerate(places.text.split("\n"))
        for one in text.split()
    )


def _point(text: str, mode: str, where: At, found: Findings) -> Point | None:
    parts = text.split(",")
    if not 2 <= len(parts) <= 3:
        found.refuse("position", where, f"{text[:60]!r} is not longitude,latitude,height")
        return None
    numbers = [number(part, "a coordinate", where, found) for part in parts]
    if None in numbers:
        return None
    longitude, latitude, height = [*(n or 0.0 for n in numbers), 0.0][:3]
    place = position(latitude, longitude, where, found)
    if place is None:
        return None
    depth = altitude = None
    if mode == "relativeToSeaFloor" and height > 0.0:
        altitude = height
    elif mode == "absolute":
        depth = below(height, where, found)
    elif mode not in _NO_HEIGHT:
        found.leave_out(where, f"heights {mode}")
    return Point(place, where, depth=depth, altitude=altitude)
