"""The canonical text of a Mission, its digest, and the script that ``@AW`` sends.

Rules: ASCII, one LF per line, single blanks, no indentation, blocks closed by ``end``, no comments,
no parameters. A statement longer than 200 bytes continues in lines that begin with ``+``. A leg
without a name is named after its line in this text.

    digest   SHA-256 of the canonical text
    sum      first 8 hex digits of the SHA-256 over the canonical lines 2..n, each with its LF
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace

from mission.authoring.language import render
from mission.model import Group, Mission, Node
from mission.model.diagnostics import Diagnostics
from mission.model.extent import LINES
from mission.model.units import number_text

LONGEST_LINE = 200  # bytes of an @AW payload (E-F7)


def to_lines(mission: Mission) -> str:
    """The canonical text, with a final LF."""
    return "".join(f"{line}\n" for line in _lines(mission))


def check_length(mission: Mission, problems: Diagnostics) -> None:
    """Raise MissionErrors if the mission has too many lines to send (each line is one ``@AW``)."""
    if sum(1 for _ in _lines(mission)) > LINES.most:
        message = f"the mission is too long: {LINES.exceeded}"
        raise problems.refusal("too-long", mission.where, message, "make it shorter, or two of it")


def digest(mission: Mission) -> str:
    return hashlib.sha256(to_lines(mission).encode("ascii")).hexdigest()


def total(mission: Mission) -> str:
    """The ``sum`` that line 1 of the script must have."""
    rest = "".join(f"{line}\n" for line in list(_lines(mission))[1:])
    return hashlib.sha256(rest.encode("ascii")).hexdigest()[:8]


def script(mission: Mission) -> list[str]:
    """The payloads for ``@AW``; line 1 includes ``sum``."""
    first, *rest = _lines(mission)
    return [f"{first} sum {total(mission)}", *rest]


def numbered(mission: Mission) -> Mission:
    """The mission with a name for each unnamed leg: that of its canonical line, as ``line12``."""
    line = sum(1 for _ in _header(mission))
    body, _ = _numbered(mission.body, line)
    return replace(mission, body=body)


def _numbered(body: tuple[Node, ...], line: int) -> tuple[tuple[Node, ...], int]:
    """Name the legs of ``body``. ``line`` is the last line before the body; the returned number is
    the last line of the body."""
    nodes: list[Node] = []
    for node in body:
        if isinstance(node, Group):
            line += sum(1 for _ in _begin(node))
            inner, line = _numbered(node.body, line)
            line += sum(1 for _ in _group_end(node))
            nodes.append(replace(node, body=inner) if inner != node.body else node)
        elif render.label(node):
            line += len(_broken(_statement(node)))
            nodes.append(node)
        else:
            named = replace(node, name=f"line{line + 1}")
            line += len(_broken(_statement(named)))
            nodes.append(named)
    return tuple(nodes), line


def _lines(mission: Mission) -> Iterator[str]:
    yield from _header(mission)
    yield from _body(mission.body)
    for word, target in render.handlers_of(mission):
        yield f"on {word} -> {target}"
    for handler in mission.handlers:
        yield from _broken(f"on {render.handler_text(handler, False)} -> {handler.target}")


def _header(mission: Mission) -> Iterator[str]:
    yield f"mission {mission.name} vehicle {mission.vehicle}"
    if mission.home is not None:
        yield f"home {render.place_text(mission.home)}"
    limits = _joined(render.safety_pairs(mission.safety, False))
    if limits:
        yield f"safety {limits}"
    if mission.assume:
        yield f"assume {_joined((n, number_text(v)) for n, v in mission.assume)}"
    for area in mission.areas:
        yield from _broken(render.area_text(area))
    if mission.start_without_fix:
        yield "start without fix"
    yield from _achieve(mission)


def _achieve(scope: Group | Mission) -> Iterator[str]:
    if scope.achieve:
        yield f"achieve {_joined(render.aim_pairs(scope.achieve, False))}"


def _joined(pairs: Iterator[render.Pair]) -> str:
    return " ".join(f"{word} {value}".rstrip() for word, value in pairs)


def _body(body: tuple[Node, ...]) -> Iterator[str]:
    for node in body:
        if isinstance(node, Group):
            yield from _begin(node)
            yield from _body(node.body)
            yield from _group_end(node)
        else:
            yield from _broken(_statement(node))


def _opening(group: Group) -> str:
    return f"repeat {group.repeat} {group.name}:" if group.repeat > 1 else f"group {group.name}:"


def _begin(group: Group) -> Iterator[str]:
    yield from _broken(_opening(group))
    yield from _achieve(group)


def _group_end(group: Group) -> Iterator[str]:
    for handler in group.handlers:
        yield from _broken(f"on {render.handler_text(handler, False)} -> {handler.target}")
    yield "end"


def _statement(node: Node) -> str:
    assert not isinstance(node, Group)
    name = render.label(node)
    return (f"{name}: " if name else "") + _joined(render.node_pairs(node, False))


def _broken(statement: str) -> list[str]:
    """Break a statement at the last blank that fits; continuation lines begin with ``+``."""
    lines: list[str] = []
    rest = statement
    while len(rest) > LONGEST_LINE:
        cut = rest.rindex(" ", 3, LONGEST_LINE + 1)
        lines.append(rest[:cut])
        rest = f"+ {rest[cut + 1 :]}"
    return [*lines, rest]
