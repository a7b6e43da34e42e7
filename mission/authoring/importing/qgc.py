"""QGroundControl's .plan (docs.qgroundcontrol.com, plan file format): JSON, fileType "Plan".

A SimpleItem is a MAVLink item; a ComplexItem of a survey carries the items it was expanded to. Home
stands apart, and is no item. Fences and rally points are left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from mission.authoring.importing.mavlink import Item, Reader
from mission.authoring.importing.route import Findings, Route, Source, Step, position
from mission.authoring.importing.tree import Value, values
from mission.model import Position

_PARAMETERS = 7


def read(data: bytes, found: Findings) -> Source:
    root = values(data, found)
    if root.get("fileType").text() != "Plan":
        raise found.refusal("plan-format", "fileType", "it is not Plan")
    _leave_out(root, found)
    items = root.get("mission").get("items")
    home = _home(root.get("mission").get("plannedHomePosition"), found)
    return Source((Route("", items.path, partial(_steps, items, found)),), home)


def _steps(items: Value, found: Findings) -> tuple[Step, ...]:
    reader = Reader(found)
    read = [_item(value, found) for value in _simple(items, found)]
    return tuple(step for item in read if item is not None for step in reader.steps(item))


def _leave_out(root: Value, found: Findings) -> None:
    fence = root.get("geoFence")
    for key in ("circles", "polygons"):
        if fence.get(key).raw:
            found.leave_out(f"geoFence.{key}", "a fence")
    if root.get("rallyPoints").get("points").raw:
        found.leave_out("rallyPoints.points", "rally points")


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
    if value.raw is None:
        return None
    numbers = [item.number() for item in value.items()]
    if len(numbers) < 2 or numbers[0] is None or numbers[1] is None:
        found.refuse("position", value.path, "home is latitude, longitude and height")
        return None
    return position(numbers[0], numbers[1], value.path, found)
