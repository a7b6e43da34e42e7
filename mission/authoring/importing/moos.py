"""MOOS-IvP behavior files (.bhv): the points of each BHV_Waypoint, in its local metres.

    Behavior = BHV_Waypoint
    {
      name   = survey
      speed  = 1.2               m/s
      capture_radius = 5         m
      points = 60,-40 : 60,-160  x east, y north of LatOrigin, LongOrigin of the .moos file
    }

A behavior file is a program; its conditions, modes and other behaviors are left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

from mission.authoring.importing.route import (
    At,
    Findings,
    Point,
    Route,
    Source,
    Step,
    along,
    number,
    text_of,
)
from mission.model import Local

_POINTS = frozenset({"points", "point", "polygon"})


@dataclass(slots=True)
class _Behavior:
    kind: str
    where: At
    said: list[tuple[str, str, At]] = field(default_factory=list)  # key, value, where

    def get(self, *keys: str) -> tuple[str, At]:
        """The last value of one of the keys, and its line; "" if there is none."""
        rows = [(value, where) for key, value, where in self.said if key in keys]
        return rows[-1] if rows else ("", self.where)


def read(data: bytes, found: Findings) -> Source:
    routes = []
    for behavior in _behaviors(text_of(data, found), found):
        if behavior.kind == "BHV_Waypoint":
            name = behavior.get("name")[0]
            routes.append(Route(name, behavior.where, partial(_steps, behavior, found)))
        else:
            found.leave_out(behavior.where, f"behavior {behavior.kind[:40]}")
    return Source(tuple(routes), local=True)


def _behaviors(text: str, found: Findings) -> Iterator[_Behavior]:
    behavior: _Behavior | None = None
    for where, line in enumerate(text.split("\n"), 1):
        plain = line.partition("//")[0].strip()
        if plain.startswith("#"):
            raise found.refusal(
                "no-counterpart", where, "a macro of nsplug", "import the file that nsplug makes"
            )
        key, sign, value = (part.strip() for part in plain.partition("="))
        if key.lower() == "behavior" and sign:
            behavior = _Behavior(value.removesuffix("{").strip(), where)
        elif plain.startswith("}") and behavior is not None:
            yield behavior
            behavior = None
        elif sign and behavior is not None:
            behavior.said.append((key.lower(), value, where))
    if behavior is not None:
        found.refuse("plan-form", behavior.where, "a behavior without an end")


def _steps(behavior: _Behavior, found: Findings) -> tuple[Step, ...]:
    for key, value, where in behavior.said:
        if "$(" in value:
            found.refuse(
                "no-counterpart",
                where,
                f"a macro of nsplug in {key}",
                "import the file that nsplug makes",
            )
        elif key in ("repeat", "perpetual", "order", "condition") and value != "0":
            found.leave_out(where, f"{key} = {value[:40]}")
    speed = _amount(behavior, found, "speed")
    within = _amount(behavior, found, "capture_radius", "radius")
    text, where = behavior.get(*_POINTS)
    return along(_point(pair, where, speed, within, found) for pair in _pairs(text, where, found))


def _amount(behavior: _Behavior, found: Findings, *keys: str) -> float | None:
    text, where = behavior.get(*keys)
    value = number(text, keys[0], where, found) if text else None
    return value if value and value > 0.0 else None


def _pairs(text: str, where: At, found: Findings) -> list[str]:
    """Split ``pts={1,2:3,4}`` or ``1,2 : 3,4`` into points; refuse a pattern that MOOS expands."""
    inner = text.partition("pts={")[2].partition("}")[0] if "pts={" in text else text
    if "=" in inner or "{" in inner:
        found.refuse("no-counterpart", where, f"a pattern: {text[:40]!r}", "write its points")
        return []
    return [pair for pair in inner.split(":") if pair.strip()]


def _point(
    pair: str, where: At, speed: float | None, within: float | None, found: Findings
) -> Point | None:
    numbers = [number(part, "a coordinate", where, found) for part in pair.split(",")]
    if len(numbers) != 2:
        found.refuse("position", where, f"{pair.strip()[:40]!r} is not x,y")
        return None
    east, north = numbers
    if east is None or north is None:
        return None
    return Point(Local(north, east), where, speed=speed, within=within)
