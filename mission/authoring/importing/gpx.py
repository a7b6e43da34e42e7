"""GPX 1.0 and 1.1 (topografix.com/GPX/1/1): each ``rte`` is a route, its ``rtept`` in order.

``ele`` is metres upward. OpenCPN adds ``arrival_radius`` in nautical miles to a point. ``wpt`` are
left out since they have no order, and ``trk`` since a track is no plan.
"""

from __future__ import annotations

from functools import partial

from mission.authoring.importing.route import (
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

_NAUTICAL_MILE = 1852.0  # m
_OTHER = {"wpt": "a waypoint outside any route", "trk": "a track, which is no plan"}


def read(data: bytes, found: Findings) -> Source:
    root = elements(data, "gpx", found)
    for child in root.children:
        if child.name in _OTHER:
            found.leave_out(child.where, _OTHER[child.name])
    routes = root.all("rte")
    return Source(tuple(Route(r.said("name"), r.where, partial(_steps, r, found)) for r in routes))


def tracks(data: bytes, found: Findings) -> Source:
    """Each ``trkseg`` of each ``trk`` as a route, to follow a recorded track again."""
    root = elements(data, "gpx", found)
    return Source(
        tuple(
            Route(trk.said("name"), seg.where, partial(_passed, seg, found))
            for trk in root.all("trk")
            for seg in trk.all("trkseg")
        )
    )


def _passed(seg: Element, found: Findings) -> tuple[Step, ...]:
    return along(_point(element, found) for element in seg.all("trkpt"))


def _steps(rte: Element, found: Findings) -> tuple[Step, ...]:
    return along(_point(element, found) for element in rte.all("rtept"))


def _point(element: Element, found: Findings) -> Point | None:
    where = element.where
    latitude = number(element.attributes.get("lat", ""), "lat", where, found)
    longitude = number(element.attributes.get("lon", ""), "lon", where, found)
    height = number(element.said("ele"), "ele", where, found) if element.said("ele") else None
    if latitude is None or longitude is None:
        return None
    place = position(latitude, longitude, where, found)
    if place is None:
        return None
    depth = below(height, where, found)
    within = _arrival(element, found)
    return Point(place, where, element.said("name"), depth=depth, within=within)


def _arrival(element: Element, found: Findings) -> float | None:
    for extension in element.all("extensions"):
        for inner in extension.within():
            if inner.name == "arrival_radius":
                radius = number(inner.text, inner.name, inner.where, found)
                return round(radius * _NAUTICAL_MILE, 2) if radius else None
    return None
