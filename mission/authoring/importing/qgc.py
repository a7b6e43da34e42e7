"""QGroundControl's .plan (docs.qgroundcontrol.com, plan file format): JSON, fileType "Plan".

- A SimpleItem is a MAVLink item. A ComplexItem of a survey contains the items of its expansion.
- Home is stored apart and is no item.
- Polygons and circles of the GeoFence become areas to keep in or out. A circle becomes a polygon of
  ``_ROUND`` corners: inside the circle (keep in) or around it (keep out), so that it never allows
  more than the circle.
- Several fences to keep in are refused, since autopilots differ: in all of them, or in one.
- Rally points are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from mission.authoring.importing.mavlink import Item, steps_of
from mission.authoring.importing.route import Fence, Findings, Route, Source, Step, position
from mission.authoring.importing.tree import Value, values
from mission.model import Position
from mission.navigation.geodesy import LocalFrame

_PARAMETERS = 7
_ROUND = 24


def read(data: bytes, found: Findings) -> Source:
    root = values(data, found)
    if root.get("fileType").text() != "Plan":
        raise found.refusal("plan-format", "fileType", "it is not Plan")
    if root.get("rallyPoints").get("points").raw:
        found.leave_out("rallyPoints.points", "rally points")
    items = root.get("mission").get("items")
    home = _home(root.get("mission").get("plannedHomePosition"), found)
    fences = tuple(_fences(root.get("geoFence"), found))
    inner = [fence.where for fence in fences if not fence.out]
    if len(inner) > 1:
        message = f"a second fence to keep in, beside {inner[0]}: in both of them, or in one?"
        found.refuse("no-counterpart", inner[1], message, "make one fence of them")
    return Source((Route("", items.path, partial(_steps, items, found)),), home, fences=fences)


def _steps(items: Value, found: Findings) -> tuple[Step, ...]:
    read = [_item(value, found) for value in _simple(items, found)]
    return steps_of((item for item in read if item is not None), found)


def _fences(fence: Value, found: Findings) -> Iterator[Fence]:
    for value in _those_of(fence.get("polygons")):
        places = [_place(corner, found) for corner in _those_of(value.get("polygon"))]
        corners = tuple(place for place in places if place is not None)
        if len(places) < 3:
            found.refuse("plan-form", value.path, "a polygon has three corners or more")
        yield Fence(_is_out(value, found), corners, value.path)
    for value in _those_of(fence.get("circles")):
        center = _place(value.get("circle").get("center"), found)
        radius = value.get("circle").get("radius").number()
        if radius is None or not 0.0 < radius < math.inf:
            found.refuse("plan-form", value.path, "a circle has a radius greater than 0")
        elif center is not None:
            out = _is_out(value, found)
            wide = radius / math.cos(math.pi / _ROUND) if out else radius
            yield Fence(out, _ring(center, wide), value.path)


def _those_of(value: Value) -> Iterator[Value]:
    """The items of a list that may be missing."""
    return iter(()) if value.raw is None else value.items()


def _is_out(value: Value, found: Findings) -> bool:
    inclusion = value.get("inclusion").raw
    if not isinstance(inclusion, bool):
        found.refuse("plan-form", f"{value.path}.inclusion", "it is neither true nor false")
    return not inclusion


def _ring(center: Position, radius: float) -> tuple[Position, ...]:
    """The corners of a regular polygon, ``radius`` m from the center."""
    frame = LocalFrame(center)
    turns = [math.tau * i / _ROUND for i in range(_ROUND)]
    places = [frame.to_geodetic(radius * math.cos(t), radius * math.sin(t)) for t in turns]
    return tuple(Position(math.degrees(lat), math.degrees(lon)) for lat, lon in places)


def _simple(items: Value, found: Findings) -> Iterator[Value]:
    for item in items.items():
        kind = item.get("type").text()
        if kind == "SimpleItem":
            yield item
        elif kind == "ComplexItem":
            inner = item.get("TransectStyleComplexItem").get("Items")
            name = item.get("complexItemType").text()[:40]
            if inner.raw is None:
                found.refuse(
                    "plan-form", item.path, f"a {name} without the items it was expanded to"
                )
                continue
            found.leave_out(item.path, f"the area of a {name}: its points are taken")
            yield from _simple(inner, found)
        else:
            found.refuse(
                "plan-form",
                f"{item.path}.type",
                f"{kind[:40]!r} is neither SimpleItem nor ComplexItem",
            )


def _item(item: Value, found: Findings) -> Item | None:
    numbers = [value.number() for value in item.get("params").items()]
    command, frame = item.get("command").number(), item.get("frame").number()
    if len(numbers) != _PARAMETERS or command is None or frame is None:
        found.refuse("plan-form", item.path, "an item has a command, a frame and seven params")
        return None
    return Item(int(command), int(frame), numbers, item.path)


def _home(value: Value, found: Findings) -> Position | None:
    return None if value.raw is None else _place(value, found)


def _place(value: Value, found: Findings) -> Position | None:
    numbers = [item.number() for item in value.items()]
    if len(numbers) < 2 or numbers[0] is None or numbers[1] is None:
        found.refuse("position", value.path, "a place is latitude and longitude")
        return None
    return position(numbers[0], numbers[1], value.path, found)
