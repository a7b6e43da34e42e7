"""The generated parts of docs/mission-language.md: grammar and tables, made from the code.

    python -m mission.authoring.language.manual docs/mission-language.md     updates them

A part stands between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``. A test compares them with
the code.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from mission.authoring.language.syntax import grammar
from mission.authoring.language.words import (
    AIMS,
    ASSUMPTIONS,
    CLAUSES,
    LIMITS,
    REFUSED_ZA,
    SETTINGS,
    ZA,
    NamedValue,
    SettingRow,
    choices,
    kinds,
    measures,
    spots,
)
from mission.engine.variables import VARIABLES
from mission.legs import LegType
from mission.legs.words import Measure
from mission.model.extent import EXTENTS
from mission.model.units import UNITS, number_text


def refreshed(text: str) -> str:
    """Return ``text`` with every generated part up to date. Raises ValueError if a part is missing
    or stands twice."""
    for name, part in PARTS.items():
        pattern = rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)"
        text, found = re.subn(pattern, lambda m, p=part: m[1] + p() + m[2], text, flags=re.DOTALL)  # type: ignore[misc]
        if found != 1:
            raise ValueError(f"the part {name} stands {found} times, not once")
    return text


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "".join(
        f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |\n" for row in lines
    )


def _settings() -> str:
    rows = [
        (
            f"`{r.word}`",
            r.unit or "gear",
            _range(r),
            r.description,
        )
        for r in SETTINGS.values()
    ]
    return _table(("word", "bare number", "range", "what"), rows)


def _wire() -> str:
    rows = [
        (
            f"`ZA{r.code}`",
            f"{r.low} to {r.high}",
            r.description,
            f"`{'-' if r.sign < 0 and r.word == 'gear' else ''}{r.word}`",
        )
        for r in ZA.values()
    ]
    rows.append(
        ("`ZAA`", "two of -90 to 90", "pitch;roll in deg, as in ZAA5;-3", "`pitch`, `roll`")
    )
    rows += [(f"`ZA{code}`", "", f"refused: {why}", "") for code, why in REFUSED_ZA.items()]
    return _table(("word", "number", "what", "the same as"), rows)


def _kinds() -> str:
    return _table(
        ("word", "followed by", "needs", "may have", "what"),
        [_kind(row) for row in kinds().values()],
    )


def _kind(row: LegType) -> tuple[str, ...]:
    needs, may = (
        ", ".join(f"`{clause.word}`" for clause in row.clauses if clause.needed is needed)
        for needed in (True, False)
    )
    return f"`{row.name}`", row.head.shape.value, needs, may, row.description


def _measures() -> str:
    rows = [(f"`{r.word}`", r.unit, _range(r), r.description) for r in measures().values()]
    rows += [(f"`{r.word}`", "", "", f"a place: {r.description}") for r in spots().values()]
    rows += [
        (f"`{r.word}`", "", "", f"{' or '.join(r.values)}: {r.description}")
        for r in choices().values()
    ]
    return _table(("word", "bare number", "range", "what"), rows)


def _range(row: Measure | SettingRow) -> str:
    return f"{number_text(row.low)} to {number_text(row.high)}"


def _extents() -> str:
    return _table(("at most", "of"), [(f"{row.most:,}", row.what) for row in EXTENTS])


def _clauses() -> str:
    return _table(("word", "what"), [(f"`{word}`", what) for word, what in CLAUSES.items()])


def _named(rows: Mapping[str, NamedValue]) -> str:
    cells = [(f"`{r.name}`", r.unit or "share", r.description) for r in rows.values()]
    return _table(("name", "bare number", "what"), cells)


def _variables() -> str:
    rows = [
        (f"`{r.name}`", r.unit or "number", r.description, ", ".join(r.source))
        for r in VARIABLES.values()
    ]
    return _table(("variable", "bare number", "what", "known by"), rows)


def _units() -> str:
    kinds: dict[str, list[str]] = {}
    for row in UNITS.values():
        kinds.setdefault(row.si, []).append(f"`{row.name}`")
    return _table(("units of one kind",), [(", ".join(names),) for names in kinds.values()])


def _grammar() -> str:
    return f"```text\n{grammar()}```\n"


PARTS: Mapping[str, Callable[[], str]] = {
    "settings": _settings,
    "wire": _wire,
    "kinds": _kinds,
    "measures": _measures,
    "clauses": _clauses,
    "limits": lambda: _named(LIMITS),
    "assumptions": lambda: _named(ASSUMPTIONS),
    "aims": lambda: _named(AIMS),
    "variables": _variables,
    "units": _units,
    "extents": _extents,
    "grammar": _grammar,
}

if __name__ == "__main__":
    page = Path(sys.argv[1])
    page.write_text(refreshed(page.read_text(encoding="utf-8")), encoding="utf-8")
