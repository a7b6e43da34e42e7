"""KML 2.2 (OGC 07-147r2), and KMZ, a ZIP file that holds one: each LineString is a route.

``coordinates`` are "longitude,latitude,height" separated by white space. The height counts with
altitudeMode absolute (from the sea's level), and relativeToSeaFloor (an altitude).
"""

from __future__ import annotations

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
    "Track": "a Track, which is no plan",
    "NetworkLink": "a NetworkLink: nothing outside the file is read",
    "GroundOverlay": "a GroundOverlay, which is a picture",
}
_NO_HEIGHT = frozenset({"", "clampToGround", "clampToSeaFloor"})


def read(data: bytes, found: Findings) -> Source:
    if is_archive(data):
        data = member(data, ".kml", "doc.kml", found)
    routes = []
    for element in elements(data, "kml", found).within():
        if element.name in _LEFT_OUT:
            found.leave_out(element.where, _LEFT_OUT[element.name])
        elif element.name == "Placemark":
            routes += [
                Route(element.said("name"), line.where, partial(_steps, line, found))
                for line in element.within()
                if line.name == "LineString"
            ]
    return Source(tuple(routes))


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
