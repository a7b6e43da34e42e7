"""The rooms of the code, drawn from the layer contracts and from the imports themselves.

    .importlinter --layers--> bands of boxes, the higher over the lower
    import statements ------> what each room uses (the title of its box, and the table)

A room is a name that stands in a contract of type ``layers``; a module belongs to the longest name
that begins its own.
"""

from __future__ import annotations

import ast
import configparser
import importlib
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from xml.sax.saxutils import escape

from from_code.commands import escaped
from mission.authoring.graph.canvas import Style, width

ROOT = Path(__file__).resolve().parents[2]
_LABEL = Style(13.0, "currentColor")
_HIGH, _PAD, _GAP, _ACROSS = 30.0, 12.0, 10.0, 760.0
Band = tuple[str, ...]


@cache
def layers() -> tuple[tuple[str, tuple[Band, ...]], ...]:
    """Each contract's name with its bands from the top down."""
    contracts = configparser.ConfigParser()
    contracts.read(ROOT / ".importlinter", encoding="utf-8")
    found = []
    for section in contracts.sections():
        if contracts.get(section, "type", fallback="") == "layers":
            wing = contracts.get(section, "containers", fallback="").strip()
            rows = contracts[section]["layers"].split("\n")
            bands = (re.split(r"\s*[|:]\s*", row.strip("() ")) for row in rows if row)
            named = tuple(tuple(f"{wing}.{n}" if wing else n for n in band) for band in bands)
            found.append((contracts[section]["name"], named))
    return tuple(found)


@cache
def rooms() -> tuple[str, ...]:
    """Every room once, as the contracts name them."""
    names = (name for _, bands in layers() for band in bands for name in band)
    return tuple(dict.fromkeys(names))


def room_of(module: str) -> str:
    """ "" for what belongs to no room."""
    inside = (r for r in rooms() if module == r or module.startswith(f"{r}."))
    return max(inside, key=len, default="")


@cache
def uses() -> Mapping[str, frozenset[str]]:
    """The rooms that each room imports."""
    found: defaultdict[str, set[str]] = defaultdict(set)
    for top in sorted({name.partition(".")[0] for name in rooms()}):
        for path in sorted((ROOT / top).rglob("*.py")):
            dotted = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            here = room_of(dotted.removesuffix(".__init__"))
            found[here] |= {room_of(name) for name in _imported(path)} - {here, ""}
    return {room: frozenset(used) for room, used in found.items()}


def _imported(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@cache
def purpose(room: str) -> str:
    """The first sentence of its docstring."""
    text = (importlib.import_module(room).__doc__ or "").strip()
    return re.split(r"(?<=\.)\s|\n\n", text, maxsplit=1)[0].replace("\n", " ").replace("`", "")


def rooms_table() -> str:
    rows = [f"| `{room}` | {escaped(purpose(room))} | {_used(room)} |" for room in rooms()]
    return "\n".join(["| room | what it is | it uses |", "|---|---|---|", *rows])


def _used(room: str) -> str:
    inside = sorted(uses().get(room, ()), key=rooms().index)
    return ", ".join(f"`{_short(name)}`" for name in inside)


def _short(name: str) -> str:
    return name.rpartition(".")[2]


# --- the picture --------------------------------------------------------------------------------


def layers_picture() -> str:
    """One SVG: each contract a frame, each layer a band of boxes."""
    parts: list[str] = []
    y = 0.0
    for name, bands in layers():
        parts.append(f'<text x="0" y="{y + 14:g}" class="head">{escape(name)}</text>')
        y += 24.0
        for band in bands:
            for row in _rows(band):
                parts += _boxes(row, y)
                y += _HIGH + _GAP
        y += 18.0
    return svg(_ACROSS, y, "".join(parts), "The layers of the code, the higher over the lower")


def _rows(band: Band) -> Iterator[list[str]]:
    """A band's rooms in as many rows as they need."""
    row: list[str] = []
    for name in band:
        if row and _wide([*row, name]) > _ACROSS:
            yield row
            row = []
        row.append(name)
    yield row


def _wide(row: list[str]) -> float:
    return sum(width(_short(name), _LABEL) + 2 * _PAD + _GAP for name in row) - _GAP


def _boxes(row: list[str], y: float) -> Iterator[str]:
    spare = (_ACROSS - _wide(row)) / len(row)
    x = 0.0
    for name in row:
        across = width(_short(name), _LABEL) + 2 * _PAD + spare
        used = ", ".join(sorted(map(_short, uses().get(name, ())))) or "no other room"
        yield (
            f"<g><title>{escape(f'{name}: {purpose(name)} It uses {used}.')}</title>"
            f'<rect x="{x + 0.5:g}" y="{y:g}" width="{across - 1:g}" height="{_HIGH:g}" rx="5"/>'
            f'<text x="{x + across / 2:g}" y="{y + _HIGH / 2 + 4.5:g}" text-anchor="middle">'
            f"{escape(_short(name))}</text></g>"
        )
        x += across + _GAP


def svg(across: float, high: float, inside: str, title: str) -> str:
    """A picture that takes its colours from the page, light or dark."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {across:g} {high:g}" '
        f'role="img" aria-label="{escape(title)}">{inside}</svg>'
    )
