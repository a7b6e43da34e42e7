"""The file formats of a plan: one row per suffix."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from html import escape
from types import MappingProxyType
from typing import Any

from mission.legs.base import Point
from mission.navigation.geodesy import LocalFrame
from mission.verification.planned.picture import minutes, picture, rows
from mission.verification.planned.track import Plan, Spot, Stretch, Unplanned

_STYLE = (
    "body{font-family:sans-serif;margin:2em;max-width:60em}svg{max-width:100%;height:auto}"
    "table{border-collapse:collapse}td,th{padding:.2em .8em;text-align:right;"
    "border-bottom:1px solid #ccc}td:first-child,th:first-child{text-align:left}"
)


@dataclass(frozen=True, slots=True)
class Format:
    suffix: str
    what: str
    write: Callable[[Plan], bytes]


def page(plan: Plan) -> bytes:
    """Return an HTML page with picture and table, which loads nothing from the network."""
    drawn = picture(plan, "svg").decode()
    drawn = drawn[drawn.index("<svg") :]
    lines = "".join(
        f"<tr><td>{escape(leg.name)}</td><td>{minutes(leg.begin)}</td><td>{minutes(leg.end)}</td>"
        f"<td>{_metres(leg.expected)}</td><td>{radius:.0f} m</td>{_water(plan, leg)}</tr>"
        for leg, radius in rows(plan)
    )
    water = "" if plan.clearance is None else "<th>least water under it</th>"
    head = (
        "<th>leg</th><th>begins</th><th>ends</th><th>95 % of dives within, on it (check)</th>"
        f"<th>95 % by its own estimate, at its end</th>{water}"
    )
    table = f"<table><tr>{head}</tr>{lines}</table>"
    title = escape(plan.mission)
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title>'
        f"<style>{_STYLE}</style><h1>{title}, as planned</h1>{drawn}{table}"
        "</html>\n"
    ).encode()


def _water(plan: Plan, leg: Stretch) -> str:
    if plan.clearance is None:
        return ""
    return "<td>not known</td>" if leg.water is None else f"<td>{leg.water:.1f} m</td>"


def _metres(value: float | None) -> str:
    return "" if value is None else f"{value:.0f} m"


def geojson(plan: Plan) -> bytes:
    """Return GeoJSON (RFC 7946): lines of legs, turning points, areas, ellipses. Raises Unplanned
    without a home."""
    if plan.home is None:
        raise Unplanned("the mission names no home, so that nothing has a latitude; write home")
    frame = LocalFrame(plan.home)
    return json.dumps(
        {"type": "FeatureCollection", "features": list(_features(plan, frame))}, indent=1
    ).encode()


def _features(plan: Plan, frame: LocalFrame) -> Iterator[dict[str, Any]]:
    for fence in plan.fences:
        known: dict[str, Any] = {"is": "keep out" if fence.area.out else "keep in"}
        known["name"] = fence.area.name
        if fence.area.limited:
            known |= {"top_m": fence.area.top, "bottom_m": fence.area.bottom}
        yield _feature("Polygon", [_ring(fence.polygon, frame)], known)
    for leg in plan.stretches:
        told = {"leg": leg.name, "begin_s": round(leg.begin, 1), "end_s": round(leg.end, 1)}
        line = [_degrees((s.north, s.east), frame, s.depth) for s in leg.spots]
        water = {} if leg.water is None else {"water_m": round(leg.water, 2)}
        if leg.expected is not None:
            told["expected_m"] = round(leg.expected, 1)
        if len(line) > 1:
            yield _feature("LineString", line, {"is": "track", **told, **water})
        if leg.area:
            yield _feature("Polygon", [_ring(leg.area, frame)], {"is": "area", "leg": leg.name})
        for spot in leg.turns:
            at = _degrees((spot.north, spot.east), frame, spot.depth)
            yield _feature("Point", at, {"is": "turn", "leg": leg.name, "t_s": round(spot.t, 1)})
        for spot in leg.spots[-1:]:
            known = {"is": "95 %", "leg": leg.name, "radius_m": round(spot.axes[0], 1)}
            yield _feature("Polygon", [_ring(_ellipse(spot), frame)], known)


def _feature(kind: str, coordinates: object, properties: dict[str, Any]) -> dict[str, Any]:
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def _degrees(point: Point, frame: LocalFrame, depth: float | None = None) -> list[float]:
    latitude, longitude = frame.to_geodetic(*point)
    place = [round(math.degrees(longitude), 7), round(math.degrees(latitude), 7)]
    return place if depth is None else [*place, round(-depth, 2)]


def _ring(points: tuple[Point, ...], frame: LocalFrame) -> list[list[float]]:
    """Return a closed, counterclockwise ring, as the standard requires of an outer ring."""
    area = sum(
        a[1] * b[0] - b[1] * a[0] for a, b in zip(points, (*points[1:], points[0]), strict=True)
    )
    turned = points if area > 0.0 else points[::-1]
    return [_degrees(point, frame) for point in (*turned, turned[0])]


def _ellipse(spot: Spot) -> tuple[Point, ...]:
    c, s = math.cos(spot.bearing), math.sin(spot.bearing)
    points = []
    for step in range(36):
        along = spot.axes[0] * math.cos(math.tau * step / 36)
        across = spot.axes[1] * math.sin(math.tau * step / 36)
        points.append((spot.north + along * c - across * s, spot.east + along * s + across * c))
    return tuple(points)


_ROWS = (
    Format(".png", "picture", lambda plan: picture(plan, "png")),
    Format(".svg", "the same, to any size", lambda plan: picture(plan, "svg")),
    Format(".html", "picture and table, one file", page),
    Format(".geojson", "for charts and GIS", geojson),
)
FORMATS: Mapping[str, Format] = MappingProxyType({row.suffix: row for row in _ROWS})
