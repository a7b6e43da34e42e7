"""Places as GPX 1.1 (topografix.com/GPX/1/1): legs as routes, estimated track and fixes as tracks.

``ele`` is metres above the surface, negative under water. GPX has no areas: they are closed tracks
without times, so that no plotter steers along them. The radius is no route and is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from mission import __version__
from mission.analysis.export.places import Places, Plan, Point, pieces

_SCHEMA = "http://www.topografix.com/GPX/1/1"


def gpx(found: Places) -> bytes:
    root = Element("gpx", version="1.1", creator=f"auvmission {__version__}", xmlns=_SCHEMA)
    about = SubElement(root, "metadata")
    SubElement(about, "name").text = found.vehicle
    SubElement(about, "time").text = found.began
    for plan in found.plans.values():
        _points(root, plan)
    for plan in found.plans.values():
        _routes(root, plan)
    _track(root, "track, as estimated", found.track)
    _track(root, "fixes", found.fixes)
    for plan in found.plans.values():
        _areas(root, plan)
    indent(root)
    text: bytes = tostring(root, "utf-8", xml_declaration=True)
    return text + b"\n"


def _points(root: Element, plan: Plan) -> None:
    for name, what, corners in plan.lines("Point"):
        point = _place(root, "wpt", corners[0])
        SubElement(point, "name").text = name
        SubElement(point, "desc").text = f"{plan.mission}: {what}"


def _routes(root: Element, plan: Plan) -> None:
    for name, what, corners in plan.lines("LineString"):
        if name == "radius":
            continue
        route = SubElement(root, "rte")
        SubElement(route, "name").text = name
        SubElement(route, "desc").text = f"{plan.mission}: {what}"
        for corner in corners:
            _place(route, "rtept", corner)


def _areas(root: Element, plan: Plan) -> None:
    for name, what, corners in plan.lines("Polygon"):
        track = SubElement(root, "trk")
        SubElement(track, "name").text = name
        SubElement(track, "desc").text = f"{plan.mission}: {what}"
        segment = SubElement(track, "trkseg")
        for corner in corners:
            _place(segment, "trkpt", corner)


def _track(root: Element, name: str, points: Sequence[Point]) -> None:
    if not points:
        return
    track = SubElement(root, "trk")
    SubElement(track, "name").text = name
    for piece in pieces(points):
        segment = SubElement(track, "trkseg")
        for point in piece:
            made = _place(segment, "trkpt", (point.longitude, point.latitude))
            if point.up is not None:
                SubElement(made, "ele").text = repr(point.up)
            SubElement(made, "time").text = point.time


def _place(parent: Element, tag: str, corner: Sequence[float]) -> Element:
    longitude, latitude = corner
    return SubElement(parent, tag, lat=f"{latitude:.8f}", lon=f"{longitude:.8f}")
