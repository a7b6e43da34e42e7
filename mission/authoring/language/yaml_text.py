"""Write a Mission as YAML: one line for each leg, with units. It reads back as the same Mission."""

from __future__ import annotations

from collections.abc import Iterator

from mission.authoring.language import render
from mission.authoring.language.words import ASSUMPTIONS, kinds
from mission.legs.words import Shape
from mission.model import Aims, Area, Group, Handler, Leg, Mission, Node, Set
from mission.model.units import number_text

# Names that other YAML readers would not read as text; they are quoted.
_NOT_TEXT = frozenset({"on", "off", "yes", "no", "true", "false", "null", "y", "n"})


def to_yaml(mission: Mission) -> str:
    return "".join(f"{line}\n" for line in _lines(mission))


def _lines(mission: Mission) -> Iterator[str]:
    yield f"mission: {_name(mission.name)}"
    yield f"vehicle: {_name(mission.vehicle)}"
    if mission.home is not None:
        latitude = number_text(mission.home.latitude_deg)
        longitude = number_text(mission.home.longitude_deg)
        yield f"home: {{latitude: {latitude}, longitude: {longitude}}}"
    limits = [f"{word}: {value}" for word, value in render.safety_pairs(mission.safety, True)]
    limits += _areas(mission)
    if limits:
        yield f"safety: {_table(limits)}"
    if mission.assume:
        units = {name: row.unit for name, row in ASSUMPTIONS.items()}
        yield "assume: " + _table([f"{n}: {number_text(v)} {units[n]}" for n, v in mission.assume])
    if mission.start_without_fix:
        yield "start: without fix"
    yield from _achieve(mission, "")
    yield "legs:"
    yield from _body(mission.body, "  ")
    general = [f"when: {word}, do: {_name(to)}" for word, to in render.handlers_of(mission)]
    yield from _handlers(general, mission.handlers, "")


def _achieve(scope: Group | Mission, indent: str) -> Iterator[str]:
    if scope.achieve:
        yield f"{indent}achieve: {_aims(scope.achieve)}"


def _areas(mission: Mission) -> Iterator[str]:
    for word, out in (("keep_in", False), ("keep_out", True)):
        areas = [_area(area) for area in mission.areas if area.out is out]
        if areas:
            yield f"{word}: {_table(areas)}"


def _area(area: Area) -> str:
    keys = [f"corners: [{', '.join(map(render.place_text, area.corners))}]"]
    if area.limited:
        keys.append(f"between: [{', '.join(render.depths_of(area, True))}]")
    return f"{_name(area.name)}: {_table(keys)}"


def _aims(aims: Aims) -> str:
    return _table([f"{name}: {value}" for name, value in render.aim_pairs(aims, True)])


def _body(body: tuple[Node, ...], indent: str) -> Iterator[str]:
    for node in body:
        if isinstance(node, Group):
            yield f"{indent}- {_name(node.name)}:"
            inner = f"{indent}    "
            if node.repeat > 1:
                yield f"{inner}repeat: {node.repeat}"
            yield from _achieve(node, inner)
            yield f"{inner}legs:"
            yield from _body(node.body, f"{inner}  ")
            yield from _handlers([], node.handlers, inner)
        elif render.label(node):
            yield f"{indent}- {_name(node.name)}: {_table(list(_keys(node)))}"
        else:
            pairs = render.node_pairs(node, True)
            text = " ".join(f"{word} {value}".rstrip() for word, value in pairs)
            yield f"{indent}- {text}"


def _keys(node: Leg | Set) -> Iterator[str]:
    exits: list[str] = []
    if outputs := [value.replace(" ", ": ") for value in _outputs(node)]:
        yield f"output: {_table(outputs)}"
    for word, value in render.node_pairs(node, True):
        if word == "output":
            continue
        if word == "achieve" and isinstance(node, Leg):
            value = _aims(node.achieve)
        if word == "until":
            exits.append(value)
            continue
        if exits:
            yield _until(exits)
            exits = []
        yield f"{word}: {_value(word, value)}"
    if exits:
        yield _until(exits)


def _outputs(node: Leg | Set) -> Iterator[str]:
    return (value for word, value in render.node_pairs(node, True) if word == "output")


def _until(exits: list[str]) -> str:
    return f"until: {exits[0]}" if len(exits) == 1 else f"until: [{', '.join(exits)}]"


def _value(word: str, value: str) -> str:
    row = kinds().get(word)
    if row is not None and row.head.shape is Shape.PLACES:
        return f"[{value}]"
    if word == "else":
        return _name(value)
    return value or "true"


def _handlers(general: list[str], handlers: tuple[Handler, ...], indent: str) -> Iterator[str]:
    if not general and not handlers:
        return
    yield f"{indent}on:"
    for text in general:
        yield f"{indent}  - {{{text}}}"
    for handler in handlers:
        when = render.expression_text(handler.guard.expression, True)
        held = handler.guard.held
        keys = [f"when: {when}"]
        if held:
            keys.append(f"held: {render.quantity_text(held, 's', True)}")
        yield f"{indent}  - {_table([*keys, f'do: {_name(handler.target)}'])}"


def _table(items: list[str]) -> str:
    return f"{{{', '.join(items)}}}"


def _name(name: str) -> str:
    return f'"{name}"' if name.lower() in _NOT_TEXT else name
