"""The tidy layout of a mission file: indentation, blanks, aligned comments; no word is changed.

    lines   two blanks for each open group; `+` lines two more
    YAML    two blanks for each level, one space in the places where YAML wants none or one
    both    comments stay, those behind neighbouring lines in one column; one blank line at most

A second pass changes nothing. What does not live here: another text of the same mission
(canonical.py, yaml_text.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mission.authoring.language import is_yaml
from mission.authoring.language.layout_row import Row

_WIDEST = 120  # columns: a longer line does not move the comments of its neighbours farther


def formatted(text: str, source: str = "") -> str:
    """Return ``text`` in the tidy layout. ``text`` must be a mission without errors."""
    text = text.removeprefix("\ufeff").replace("\r\n", "\n")
    if is_yaml(text, source):
        from mission.authoring.language.layout_yaml import rows
    else:
        from mission.authoring.language.layout_lines import rows
    return "".join(f"{line}\n" for line in _squeezed(_aligned(rows(text))))


def _aligned(rows: Iterable[Row]) -> list[str]:
    """Join rows to lines; comments behind neighbouring lines begin in one column."""
    lines: list[str] = []
    block: list[Row] = []
    for row in [*rows, Row("")]:
        if row.code.strip() and row.comment:
            block.append(row)
            continue
        column = max((min(len(r.code), _WIDEST) for r in block), default=0) + 2
        lines += [f"{r.code:<{column}}{r.comment}" for r in block]
        block = []
        lines.append((row.code + row.comment).rstrip())
    return lines


def _squeezed(lines: Iterable[str]) -> Iterator[str]:
    """Drop blank lines at both ends; keep at most one between other lines."""
    waiting = started = False
    for line in lines:
        if not line:
            waiting = started
            continue
        if waiting:
            yield ""
        waiting, started = False, True
        yield line
