"""The JSON Schema (draft 7) of the YAML form, made from the word tables, for completion and hover.

It tells an editor what may stand where. The reader of the language reports what a schema cannot
express: axes that are set twice, targets that do not exist, ranges of parameters.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from mission.authoring.language.words import (
    AIMS,
    ASSUMPTIONS,
    CLAUSES,
    GUARDED,
    LIMITS,
    SETTINGS,
    STOP,
    NamedValue,
    SettingRow,
    choices,
    kinds,
    measures,
    spots,
)
from mission.engine.variables import VARIABLES
from mission.legs import LegType
from mission.legs.words import Shape
from mission.model.extent import NAME
from mission.model.shipped import missions_folder
from mission.model.texts import NEVER_BELOW
from mission.model.units import UNITS

Schema = dict[str, Any]

_NAME = r"^[A-Za-z_][A-Za-z0-9_]*(-[A-Za-z0-9_]+)*$"
_NUMBER = r"-?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"


def schema() -> Schema:
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "AUV mission",
        "description": "A mission of auvmission in its YAML form",
        "type": "object",
        "additionalProperties": False,
        "required": ["mission", "legs"],
        "properties": _top(),
        "definitions": {
            "name": _name("the name of a leg or a group"),
            "target": _name("a leg or a group of this group or an outer one, or surface"),
            "place": _place(),
            "coordinates": _coordinates(),
            "guard": _text(
                "variable, < <= > >=, value; falls, rises, back at; and, or, not; held, sure"
            ),
            "body": {"type": "array", "minItems": 1, "items": {"$ref": "#/definitions/node"}},
            "node": _node(),
            "leg": _leg(),
            "group": _group(),
            "handlers": _handlers(),
        },
    }


def schema_text() -> str:
    return json.dumps(schema(), indent=2) + "\n"


def _ref(name: str, description: str) -> Schema:
    return {"description": description, "allOf": [{"$ref": f"#/definitions/{name}"}]}


def _name(description: str) -> Schema:
    longest = NAME.most
    return {"type": "string", "pattern": _NAME, "maxLength": longest, "description": description}


def _text(description: str) -> Schema:
    return {"type": "string", "minLength": 1, "description": description}


def _quantity(unit: str, description: str) -> Schema:
    """A number, a number with a unit of the right kind, or a parameter."""
    si = UNITS[unit].si if unit else ""
    fits = [row.name for row in UNITS.values() if row.si == si] if unit else ["%"]
    units = "|".join(name.replace("/", r"\/") for name in fits)
    shown = f"{description} ({unit})" if unit else description
    pattern = rf"^({_NUMBER}\s*({units})?|[A-Za-z_][A-Za-z0-9_-]*)$"
    return {"type": ["number", "string"], "pattern": pattern, "description": shown}


def _guarded(row: SettingRow) -> Schema:
    """A depth never below an altitude, or the reverse."""
    (other,) = GUARDED - {row.word}
    amount = rf"({_NUMBER}\s*[a-z]*|[A-Za-z_][A-Za-z0-9_-]*)"
    pair = {"pattern": rf"^{amount}\s*,?\s+{NEVER_BELOW}\s+{other}\s+{amount}$", "type": "string"}
    return {"anyOf": [_quantity(row.unit, row.description), pair], "description": row.description}


def _table(rows: Mapping[str, NamedValue], description: str) -> Schema:
    properties = {row.name: _quantity(row.unit, row.description) for row in rows.values()}
    return _object(properties, description)


def _object(
    properties: Mapping[str, Schema], description: str, required: Iterable[str] = ()
) -> Schema:
    made: Schema = {
        "type": "object",
        "description": description,
        "additionalProperties": False,
        "properties": dict(properties),
    }
    return {**made, "required": list(required)} if required else made


def _top() -> dict[str, Schema]:
    vehicles = sorted(path.stem for path in (missions_folder() / "vehicles").glob("*.yaml"))
    number = {"type": ["number", "string"], "pattern": rf"^{_NUMBER}\s*[A-Za-z/%]*$"}
    return {
        "mission": _name("the mission's name"),
        "vehicle": {**_name("the vehicle file it is for; auv unless said"), "examples": vehicles},
        "home": _ref("coordinates", "where range and north/east are counted from"),
        "safety": _safety(),
        "assume": _table(ASSUMPTIONS, "what the check may rely on"),
        "param": {
            "type": "object",
            "description": "numbers with names; `--param name=value` sets them",
            "patternProperties": {_NAME: number},
            "additionalProperties": False,
        },
        "start": {"const": "without fix", "description": "home is where it starts (a pool)"},
        "achieve": _table(AIMS, "what the mission's rows, or else its other legs, are flown for"),
        "legs": _ref("body", "what the vehicle does, in this order"),
        "on": _ref("handlers", "what ends any leg of the mission"),
    }


def _safety() -> Schema:
    table = _table(LIMITS, "what this mission allows, within the vehicle's hard limits")
    depth = _quantity("m", "a depth")
    area = _object(
        {
            "corners": {"type": "array", "minItems": 3, "items": {"$ref": "#/definitions/place"}},
            "between": {"type": "array", "minItems": 2, "maxItems": 2, "items": depth},
        },
        "a polygon, and the depths between which it counts",
        ("corners",),
    )
    areas = {"type": "object", "patternProperties": {_NAME: area}, "additionalProperties": False}
    keeps = {
        "keep_in": {**areas, "description": "areas, by name, one of which it must be in"},
        "keep_out": {**areas, "description": "areas, by name, which it must not be in"},
    }
    return {**table, "properties": {**table["properties"], **keeps}}


def _coordinates() -> Schema:
    # YAML 1.1 reads 1e-05 as a string; the mission language reads it as a number
    degrees = {
        "type": ["number", "string"],
        "pattern": rf"^{_NUMBER}$",
        "description": "deg, WGS 84",
    }
    latitude = {**degrees, "minimum": -90, "maximum": 90}
    longitude = {**degrees, "minimum": -180, "maximum": 180}
    table = _object(
        {"latitude": latitude, "longitude": longitude}, "a position", ("latitude", "longitude")
    )
    text = {"type": "string", "pattern": rf"^{_NUMBER}\s*[,\s]\s*{_NUMBER}$"}
    return {"anyOf": [table, text]}


def _place() -> Schema:
    offset = _object(
        {"north": _quantity("m", "north of home"), "east": _quantity("m", "east of home")},
        "metres from home",
        ("north", "east"),
    )
    words = {"type": "string", "pattern": r"^(home|here|north\s.+east\s.+)$"}
    return {"anyOf": [words, offset, {"$ref": "#/definitions/coordinates"}]}


def _node() -> Schema:
    group = {"anyOf": [{"required": ["legs"]}, {"required": ["repeat"]}]}
    body = {
        "if": group,
        "then": {"$ref": "#/definitions/group"},
        "else": {"$ref": "#/definitions/leg"},
    }
    named = {
        "type": "object",
        "minProperties": 1,
        "maxProperties": 1,
        "patternProperties": {_NAME: body},
        "additionalProperties": False,
        "description": "a leg or a group: its name, and its keys",
    }
    line = _text("a line of the line script: ZAF6, or wait 30 s")
    return {"if": {"type": "object"}, "then": named, "else": line}


def _flag(description: str) -> Schema:
    return {"enum": [True, None, "true", "yes", "on"], "description": description}


def _kind(row: LegType) -> Schema:
    match row.head.shape:
        case Shape.NOTHING:
            return _flag(row.description)
        case Shape.TIME:
            time = _quantity("s", row.description)
            return {**time, "type": ["number", "string", "boolean", "null"]}
        case Shape.COUNT:
            return _quantity("", row.description)
        case Shape.PLACE | Shape.ABOUT:
            return _ref("place", row.description)
        case Shape.PLACES:
            places = {"type": "array", "minItems": 2, "items": {"$ref": "#/definitions/place"}}
            area = {"type": "string", "pattern": r"^area\s+[A-Za-z_][A-Za-z0-9_-]*$"}
            file = {"type": "string", "pattern": r"^file\s+\S.*$"}
            forms = [places, file, area] if row.encloses else [places, file]
            return {"anyOf": forms, "description": row.description}


def _leg() -> Schema:
    properties: dict[str, Schema] = {row.name: _kind(row) for row in kinds().values()}
    properties |= {r.word: _quantity(r.unit, r.description) for r in SETTINGS.values()}
    properties |= {word: _guarded(SETTINGS[word]) for word in sorted(GUARDED)}
    properties[STOP] = _flag("thrusters ahead off, the same as gear 0")
    properties |= {r.word: _quantity(r.unit, r.description) for r in measures().values()}
    properties |= {r.word: _ref("place", r.description) for r in spots().values()}
    properties |= {
        r.word: {"enum": list(r.values), "description": r.description} for r in choices().values()
    }
    guards = ", ".join(VARIABLES)
    until = {"$ref": "#/definitions/guard"}
    properties["until"] = {
        "description": f"{CLAUSES['until']}. Variables: {guards}",
        "anyOf": [until, {"type": "array", "minItems": 1, "items": until}],
    }
    for word in ("for", "timeout"):
        properties[word] = _quantity("s", CLAUSES[word])
    properties["else"] = _ref("target", CLAUSES["else"])
    properties["output"] = {
        "type": "object",
        "description": CLAUSES["output"],
        "minProperties": 1,
        "patternProperties": {_NAME: _quantity("", "a bare number, in the vehicle file's unit")},
        "additionalProperties": False,
    }
    properties["achieve"] = _table(AIMS, CLAUSES["achieve"])
    leg = _object(properties, "a leg: what it holds, and what ends it")
    needs = {name: [c.word for c in row.clauses if c.needed] for name, row in kinds().items()}
    needs = {name: words for name, words in needs.items() if words}
    return {**leg, "minProperties": 1, "dependencies": needs}


def _group() -> Schema:
    properties = {
        "repeat": _quantity("", "rounds of the group; once unless said"),
        "achieve": _table(AIMS, "what the group's rows, or else its other legs, are flown for"),
        "legs": _ref("body", "the group's legs, in this order"),
        "on": _ref("handlers", "what ends any leg of the group; stronger than outer ones"),
    }
    return _object(properties, "legs that belong together", ("legs",))


def _handlers() -> Schema:
    when = _ref("guard", "a guard; or uncertain, timeout for the whole mission")
    held = _quantity("s", "how long it must hold; a second in which it does not takes back two")
    do = _ref("target", "where to go")
    handler = _object({"when": when, "held": held, "do": do}, "a handler", ("when", "do"))
    return {"type": "array", "minItems": 1, "items": handler}
