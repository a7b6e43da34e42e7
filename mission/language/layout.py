"""The tidy layout of a mission file: indentation, blanks, comments in line; no word is changed.

    lines   two blanks for each open group; `+` lines two more
    YAML    two blanks for each level, one space in the places where YAML wants none or one
    both    comments stay, those behind neighbouring lines in one column; one blank line at most

Laying out twice is laying out once. What does not live here: another text of the same mission
(canonical.py, yaml_text.py).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from mission.language import is_yaml

STEP = 2


@dataclass(frozen=True, slots=True)
class Row:
    """One line: what it says and the comment behind it, ``#`` included. Either may be empty."""

    code: str
    comment: str = ""


def formatted(text: str, source: str = "") -> str:
    """``text`` must be a mission without errors."""
    text = text.removeprefix("\ufeff").replace("\r\n", "\n")
    if is_yaml(text, source):
        from mission.language.layout_yaml import rows
    else:
        rows = _line_rows
    return "".join(f"{line}\n" for line in _squeezed(_aligned(rows(text))))


def _aligned(rows: Iterable[Row]) -> list[str]:
    """Comments behind neighbouring lines begin in one column."""
    lines: list[str] = []
    block: list[Row] = []
    for row in [*rows, Row("")]:
        if row.code.strip() and row.comment:
            block.append(row)
            continue
        column = max((len(r.code) for r in block), default=0) + 2
        lines += [f"{r.code:<{column}}{r.comment}" for r in block]
        block = []
        lines.append((row.code + row.comment).rstrip())
    return lines


def _squeezed(lines: Iterable[str]) -> Iterator[str]:
    """No blank lines at the ends, one at most between."""
    waiting = started = False
    for line in lines:
        if not line:
            waiting = started
            continue
        if waiting:
            yield ""
        waiting, started = False, True
        yield line


# --- the line script ----------------------------------------------------------------------------

_SPACED = re.compile(r"\s*(->|<=|>=|<|>)\s*")
_OPENS = re.compile(r"(?:repeat|group)\b.*:$")


def _line_rows(text: str) -> Iterator[Row]:
    depth = 0
    for line in text.split("\n"):
        code, mark, comment = line.partition("#")
        code, comment = _tidy(code), (mark + comment).rstrip()
        if code == "end":
            depth = max(0, depth - 1)
        more = 1 if code.startswith("+") else 0
        indent = " " * (STEP * (depth + more)) if code or comment else ""
        yield Row(indent + code, comment)
        if _OPENS.match(code):
            depth += 1


def _tidy(code: str) -> str:
    code = _SPACED.sub(r" \1 ", " ".join(code.split()))
    code = re.sub(r"\(\s+", "(", re.sub(r"\s+([),])", r"\1", code))
    code = re.sub(r"(?<=\w)\(", " (", re.sub(r",\s*", ", ", code))
    code = re.sub(r"\)(?=\w)", ") ", code)
    code = re.sub(r"^((?:repeat \S+ |group )?[A-Za-z_][\w-]*)\s*:\s*", r"\1: ", code)
    return re.sub(r"^\+\s*", "+ ", code).strip()
