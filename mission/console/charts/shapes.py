"""GeoJSON of the user as points, lines and areas, each with its name and depth.

    {"form": "point", "line" or "area", "at": [[[longitude, latitude], ...], ...],
     "name": "", "depth": m or null, "deeper": m or null}    deeper: of an area from depth to deeper

Depths are taken from the usual attributes of charts (``DEPTHS``); heights change their sign. A
third coordinate is a height by RFC 7946, but files do not follow that: it is not read.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mission.console.charts.layer import ChartError, Layer, around, degrees, text

MOST_POINTS = 300_000
NAMES = ("name", "objnam", "label", "title")
DEPTHS = ("depth", "depth_m", "valsou", "valdco", "drval1")
DEEPER = ("drval2", "depth_max")
HEIGHTS = ("elevation", "elev", "height")
_FORMS = {"Point": "point", "LineString": "line", "Polygon": "area"}  # and Multi... of each
Shape = dict[str, Any]


def read_shapes(path: Path) -> Layer:
    """Raises ChartError, OSError."""
    try:
        said = json.loads(text(path))
    except (ValueError, RecursionError) as error:
        raise error if isinstance(error, ChartError) else _no_geojson(path, str(error)) from None
    _in_degrees(path, said)
    shapes: list[Shape] = []
    points = 0
    for where, feature in _features(path, said):
        for shape in _shapes(where, feature):
            shapes.append(shape)
            points += sum(len(ring) for ring in shape["at"])
        if points > MOST_POINTS:
            raise ChartError(f"{where}: more than {MOST_POINTS} points; simplify the file")
    if not shapes:
        raise ChartError(f"{path.name}: no point, line or area in it")
    bounds = around((p[0], p[1]) for shape in shapes for ring in shape["at"] for p in ring)
    data = json.dumps(shapes, separators=(",", ":")).encode()
    return Layer(path.name, "shapes", bounds, f"{len(shapes)} shapes", data)


def _no_geojson(path: Path, why: str) -> ChartError:
    return ChartError(f"{path.name}: no GeoJSON: {why}")


def _in_degrees(path: Path, said: Any) -> None:
    """Raises ChartError for another coordinate system, which files from before RFC 7946 may
    name."""
    named = said.get("crs") if isinstance(said, dict) else None
    name = str((named or {}).get("properties", {}).get("name", "")) if named else ""
    if name and not name.endswith(("CRS84", ":4326", "::4326", "CRS84h")):
        raise ChartError(f"{path.name}: crs {name}: bring the file to EPSG:4326 first")


def _features(path: Path, said: Any) -> Iterator[tuple[str, Any]]:
    kind = said.get("type") if isinstance(said, dict) else None
    if kind == "FeatureCollection" and isinstance(said.get("features"), list):
        for number, feature in enumerate(said["features"], 1):
            yield f"{path.name}: feature {number}", feature
    elif kind == "Feature":
        yield path.name, said
    elif _form(kind) or kind == "GeometryCollection":
        yield path.name, {"geometry": said, "properties": {}}
    else:
        raise _no_geojson(path, f"type is {kind!r}: a FeatureCollection, Feature or geometry")


def _shapes(where: str, feature: Any) -> Iterator[Shape]:
    if not isinstance(feature, dict):
        raise ChartError(f"{where}: no feature, but {type(feature).__name__}")
    has = feature.get("properties")
    named = {str(k).lower(): v for k, v in has.items()} if isinstance(has, dict) else {}
    about = {"name": _name(named), "depth": _depth(named), "deeper": _number(named, DEEPER)}
    for form, at in _geometry(where, feature.get("geometry")):
        yield {"form": form, "at": at, **about}


def _geometry(where: str, geometry: Any) -> Iterator[tuple[str, list[Any]]]:
    if geometry is None:
        return
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if kind == "GeometryCollection" and isinstance(geometry.get("geometries"), list):
        for one in geometry["geometries"]:
            if isinstance(one, dict) and one.get("type") == kind:
                raise ChartError(f"{where}: a collection in a collection: take it apart")
            yield from _geometry(where, one)
        return
    form, coordinates = _form(kind), geometry.get("coordinates") if kind else None
    if not form:
        raise ChartError(f"{where}: geometry {kind!r}: one of {', '.join(_FORMS)}, or Multi of it")
    for one in _list(where, coordinates) if str(kind).startswith("Multi") else [coordinates]:
        yield form, _lines(where, form, one)


def _form(kind: Any) -> str:
    return _FORMS.get(str(kind).removeprefix("Multi"), "")


def _lines(where: str, form: str, one: Any) -> list[list[list[float]]]:
    lines = {"point": [[one]], "line": [one], "area": one}[form]
    return [[_place(where, p) for p in _list(where, line)] for line in _list(where, lines)]


def _list(where: str, value: Any) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise ChartError(f"{where}: coordinates are missing or not nested as its type needs")
    return value


def _place(where: str, value: Any) -> list[float]:
    """Return longitude and latitude to 1 cm."""
    pair = value[:2] if isinstance(value, list) else []
    if len(pair) != 2 or not all(_is_number(v) for v in pair):
        raise ChartError(f"{where}: {str(value)[:60]} is no [longitude, latitude]")
    degrees(where, pair[1], pair[0])
    return [round(pair[0], 7), round(pair[1], 7)]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _name(named: dict[str, Any]) -> str:
    found = next((named[key] for key in NAMES if isinstance(named.get(key), str)), "")
    return str(found)[:80]


def _depth(named: dict[str, Any]) -> float | None:
    depth, height = _number(named, DEPTHS), _number(named, HEIGHTS)
    return depth if depth is not None or height is None else -height


def _number(named: dict[str, Any], keys: tuple[str, ...]) -> float | None:
    """Return the first of the values; files also have numbers as texts."""
    for key in keys:
        try:
            value = float(named.get(key))  # type: ignore[arg-type]
        except (TypeError, ValueError):
            continue
        if math.isfinite(value):
            return value
    return None
