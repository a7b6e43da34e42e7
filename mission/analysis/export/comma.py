"""Sheets as CSV (RFC 4180, UTF-8): a file for each topic, and columns.csv with every column's unit.

A spreadsheet runs a cell as a formula by its first character, and texts come from anybody who sent
a frame. So an apostrophe is put before a text that begins like a formula or with an apostrophe.
Backslashes and control characters are escaped (\\x1b). Both can be undone. Numbers have all their
digits; a cell without a value is empty.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterable, Iterator, Sequence
from datetime import UTC, datetime
from typing import Any

from mission.analysis.export.columns import JSON, TEXT, TIME, Column, sheets
from mission.model import Record
from mission.onboard.blackbox import Gap

_FORMULA = re.compile(r"\s*['=+\-@\uff1d\uff0b\uff0d\uff20]")
_ODD = re.compile(
    r"[\\\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufeff]"
    r"|;(?=\s*[=+\-@])"  # if ; separates cells, a formula begins after it
)
_HEAD = ("topic", "column", "kind", "unit", "says")


def csv_files(items: Iterable[Record | Gap]) -> Iterator[tuple[str, bytes]]:
    """Yield names and contents of the files of one recording. Raises ExportError."""
    said: list[Sequence[str]] = [_HEAD]
    for sheet in sheets(items):
        head = tuple(map(_text, (column.name for column in sheet.columns)))
        rows = (_row(sheet.columns, row) for row in sheet.rows)
        yield f"{sheet.topic.name}.csv", _written([head, *rows])
        for column in sheet.columns:
            row = (sheet.topic.name, column.name, column.kind, column.unit, column.says)
            said.append(tuple(map(_text, row)))
    yield "columns.csv", _written(said)


def _written(rows: Iterable[Sequence[str]]) -> bytes:
    text = io.StringIO(newline="")
    csv.writer(text).writerows(rows)
    return text.getvalue().encode()


def _row(columns: Sequence[Column], row: Sequence[Any]) -> list[str]:
    return [_cell(column.kind, value) for column, value in zip(columns, row, strict=True)]


def _cell(kind: str, value: Any) -> str:
    if value is None:
        return ""
    if kind == TIME:
        return datetime.fromtimestamp(value, UTC).isoformat(timespec="microseconds")
    if kind == TEXT:
        return _text(value)
    return str(value) if kind == JSON else json.dumps(value)


def _text(text: str) -> str:
    plain = _ODD.sub(_written_out, text)
    return f"'{plain}" if _FORMULA.match(plain) else plain


def _written_out(found: re.Match[str]) -> str:
    code = ord(found[0])
    if found[0] == "\\":
        return "\\\\"
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
