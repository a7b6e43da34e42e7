"""Places as KML 2.2 (OGC 07-147r2), with Google's gx:Track for lines with times.

Heights are metres above the surface, "absolute", negative under water.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from mission.analysis.export.places import Places, Plan, Point, pieces

_SCHEMAS = {
    "xmlns": "http://www.opengis.net/kml/2.2",
    "xmlns:gx": "http://www.google.com/kml/ext/2.2",
}


def kml(found: Places) -> bytes:
    root = Element("kml", _SCHEMAS)
    document = SubElement(root, "Document")
    SubElement(document, "name").text = f"{found.vehicle}, {found.began}"
    for plan in found.plans.values():
        _plan(document, plan)
    _track(document, found.track)
    _fixes(document, found.fixes)
    indent(root)
    text: bytes = tostring(root, "utf-8", xml_declaration=True)
    return text + b"\n"


def _plan(document: Element, plan: Plan) -> None:
    folder = _folder(document, f"plan: {plan.mission}")
    for form in ("Point", "LineString", "Polygon"):
        for name, what, corners in plan.lines(form):
            mark = SubElement(folder, "Placemark")
            SubElement(mark, "name").text = name
            SubElement(mark, "description").text = what
            if form == "Polygon":  # no fill
                SubElement(SubElement(SubElement(mark, "Style"), "PolyStyle"), "fill").text = "0"
            drawn = SubElement(mark, form)
            if form != "Point":
                SubElement(drawn, "tessellate").text = "1"
            if form == "Polygon":
                drawn = SubElement(SubElement(drawn, "outerBoundaryIs"), "LinearRing")
            places = (f"{longitude:.8f},{latitude:.8f}" for longitude, latitude in corners)
            SubElement(drawn, "coordinates").text = " ".join(places)


def _track(document: Element, track: Sequence[Point]) -> None:
    if not track:
        return
    mark = SubElement(_folder(document, "track"), "Placemark")
    SubElement(mark, "name").text = "track, as estimated"
    several = SubElement(mark, "gx:MultiTrack")
    for piece in pieces(track):
        drawn = SubElement(several, "gx:Track")
        SubElement(drawn, "altitudeMode").text = "absolute"
        for point in piece:
            SubElement(drawn, "when").text = point.time
        for point in piece:
            SubElement(drawn, "gx:coord").text = _coordinates(point, " ")


def _fixes(document: Element, fixes: Sequence[Point]) -> None:
    if not fixes:
        return
    folder = _folder(document, "fixes")
    for fix in fixes:
        mark = SubElement(folder, "Placemark")
        SubElement(SubElement(mark, "TimeStamp"), "when").text = fix.time
        SubElement(SubElement(mark, "Point"), "coordinates").text = _coordinates(fix, ",")


def _coordinates(point: Point, between: str) -> str:
    up = [] if point.up is None else [repr(point.up)]
    return between.join([f"{point.longitude:.8f}", f"{point.latitude:.8f}", *up])


def _folder(document: Element, name: str) -> Element:
    folder = SubElement(document, "Folder")
    SubElement(folder, "name").text = name
    return folder
