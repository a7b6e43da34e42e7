"""Places as GeoJSON (RFC 7946): plan, track and fixes in one FeatureCollection, marked by ``of``.

A position is longitude, latitude and, if known, metres above the surface (negative under water). A
line of the track has ``times`` and ``radius_95_m``, an entry for each position.
"""

from __future__ import annotations

import json
from typing import Any

from mission.analysis.export.places import Places, Point, pieces


def geojson(found: Places) -> bytes:
    features = [
        feature | {"properties": {"of": "plan", "mission": plan.mission, **feature["properties"]}}
        for plan in found.plans.values()
        for feature in plan.features
    ]
    features += [_line(piece) for piece in pieces(found.track)]
    features += [_fix(fix) for fix in found.fixes]
    about = {"vehicle": found.vehicle, "began": found.began}
    whole = {"type": "FeatureCollection", **about, "features": features}
    return json.dumps(whole, allow_nan=False).encode() + b"\n"


def _line(piece: list[Point]) -> dict[str, Any]:
    """Return a line, or a point if the piece has only one."""
    places = [_position(point) for point in piece]
    form, coordinates = ("LineString", places) if len(places) > 1 else ("Point", places[0])
    times, radii = [point.time for point in piece], [point.within for point in piece]
    properties = {"of": "track", "times": times, "radius_95_m": radii}
    return _feature(form, coordinates, properties)


def _fix(fix: Point) -> dict[str, Any]:
    properties = {"of": "fix", "time": fix.time, "accuracy_m": fix.within}
    return _feature("Point", _position(fix), properties)


def _feature(form: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    geometry = {"type": form, "coordinates": coordinates}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def _position(point: Point) -> list[float]:
    up = [] if point.up is None else [point.up]
    return [point.longitude, point.latitude, *up]
