"""A mission as the page shows it: its text, its graph, its map, and what is proved of it.

    lines of a vehicle, or a text --authoring--> one object (docs/design/console.md)

What does not live here: errors in a text (authoring), where lines come from (vehicle).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from functools import lru_cache
from typing import Any

from mission.authoring.check.show import as_object, unreadable_object
from mission.authoring.editing.handles import handles
from mission.authoring.graph.outline import TooLarge, outline
from mission.authoring.graph.svg import svg
from mission.authoring.language import Draft, to_lines
from mission.authoring.language.clauses import LegText, Opening
from mission.authoring.prepare import (
    Prepared,
    Unreadable,
    check_prepared,
    drafted,
    prepare_draft,
    prepare_text,
)
from mission.model.shipped import load_vehicle, shipped_missions, vehicle_file
from mission.model.vehicle import Vehicle
from mission.model.vehicle_file import read_vehicle
from mission.onboard.doctor.vehicle_file import of_file
from mission.onboard.stream.plan import plan_geojson
from mission.onboard.uncollected import uncollected

EMPTY: dict[str, Any] = {
    "digest": "", "name": "", "vehicle": "", "text": "", "lines": 0, "svg": "", "map": None,
    "home": None, "radius": None, "problem": "",
}  # fmt: skip


def on_board(lines: Sequence[str], vehicle: str | None) -> dict[str, Any]:
    """``vehicle``: a file or the name of a shipped one; None: the one that the mission names."""
    if not lines:
        return {**EMPTY, "problem": "no mission is on board"}
    text = "\n".join(lines)
    try:
        return shown(prepare_text(text, "script", vehicle))
    except Unreadable as error:
        why = f"what is on board cannot be shown here: {error.diagnostics[0].message}"
        return {**EMPTY, "text": text, "lines": len(lines), "problem": why}


def of_vehicle(name: str) -> list[dict[str, str]]:
    """Return the doctor's findings in the vehicle file; none if the file cannot be read."""
    try:
        found = list(of_file(load_vehicle(name)))
    except (OSError, ValueError):
        return []
    return [{**asdict(one), "condition": one.condition.value} for one in found]


def checked(text: str, source: str, vehicle: str | None) -> dict[str, Any]:
    """Check a text: with ``ok``, ``refusals``, what is ``proved``, and the ``places`` that can
    move."""
    with uncollected():
        return _checked(text, source, vehicle)


def _checked(text: str, source: str, vehicle: str | None) -> dict[str, Any]:
    named = dict[str, Any](places=[], names=[])
    try:
        read = drafted(text, source, vehicle)
        named = {"places": [h.as_object() for h in handles(read, text)], "names": _names(read)}
        chosen = _known(vehicle or read.mission.vehicle) or vehicle
        prepared = prepare_draft(read, text, source, chosen)
    except Unreadable as error:
        home = next((p["at"] for p in named["places"] if p["kind"] == "home"), None)
        wrong = unreadable_object(error.diagnostics)
        return {**EMPTY, "text": text, "home": home, **wrong, **named}
    told = shown(prepared, drawn=False)  # nobody looks at the graph of a text in work
    return {**told, **as_object(check_prepared(prepared)), **named}


def _known(name: str) -> Vehicle | None:
    """Return the vehicle, read once for each text of its file, which saves a quarter of the work at
    each keystroke. None if it cannot be read."""
    try:
        path = vehicle_file(name)
        return _vehicle(path.read_text(encoding="utf-8"), str(path))
    except (OSError, ValueError):
        return None


@lru_cache(maxsize=8)
def _vehicle(text: str, where: str) -> Vehicle:
    return read_vehicle(text, where)


def get_ready() -> None:
    """Do all imports and reads in advance, so that the first text is answered as fast as the
    next."""
    checked(next(iter(shipped_missions().values())).read_text(encoding="utf-8"), "ready.yaml", None)


def _names(read: Draft) -> list[str]:
    """Return the names of legs and groups, the possible targets of an exit."""
    named = (s.name for s in read.statements if isinstance(s, LegText | Opening))
    return sorted({name.text for name in named if name is not None})


def shown(prepared: Prepared, drawn: bool = True) -> dict[str, Any]:
    """``drawn``: with its graph."""
    mission, chart = prepared.mission, prepared.chart
    home, picture, problem = mission.home, "", ""
    try:
        picture = svg(outline(chart, None), False) if drawn else ""
    except TooLarge as error:
        problem = str(error)
    if home is None:
        problem = problem or "the mission names no home: no map before it is under way"
    return {
        "digest": chart.digest[:16],
        "name": mission.name,
        "vehicle": mission.vehicle,
        "text": prepared.text,
        "lines": to_lines(mission).count("\n"),
        "svg": picture,
        "map": None if home is None else plan_geojson(chart, prepared.vehicle, home),
        "home": None if home is None else [home.latitude_deg, home.longitude_deg],
        "radius": min(prepared.vehicle.limits.radius, mission.safety.radius or math.inf),
        "problem": problem,
    }
