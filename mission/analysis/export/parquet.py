"""Sheets as Parquet, a file for each topic; the metadata of each field has unit and meaning.

pyarrow is imported when a file is made, because it is an optional extra.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from typing import Any

from mission.analysis.export.columns import (
    FLAG,
    INTEGER,
    JSON,
    NUMBER,
    NUMBERS,
    TEXT,
    TEXTS,
    TIME,
    ExportError,
    Sheet,
    sheets,
)
from mission.model import Record
from mission.onboard.blackbox import Gap


def parquet_files(items: Iterable[Record | Gap]) -> Iterator[tuple[str, bytes]]:
    """Yield names and contents of the files of one recording. Raises ExportError, also without
    pyarrow."""
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        why = f"Parquet needs pyarrow: pip install 'auvmission[parquet]' ({error})"
        raise ExportError(why) from None
    for sheet in sheets(items):
        yield f"{sheet.topic.name}.parquet", _file(sheet)


def _file(sheet: Sheet) -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    types = {
        TIME: pa.timestamp("us", "UTC"), NUMBER: pa.float64(), INTEGER: pa.int64(),
        FLAG: pa.bool_(), TEXT: pa.string(), JSON: pa.string(),
        NUMBERS: pa.list_(pa.float64()), TEXTS: pa.list_(pa.string()),
    }  # fmt: skip
    fields = [
        pa.field(_plain(c.name), types[c.kind], metadata={"unit": c.unit, "says": c.says})
        for c in sheet.columns
    ]
    arrays = [
        pa.array([_value(column.kind, row[i]) for row in sheet.rows], types[column.kind])
        for i, column in enumerate(sheet.columns)
    ]
    about = {"topic": sheet.topic.name, "says": sheet.topic.says}
    file = io.BytesIO()
    table = pa.Table.from_arrays(arrays, schema=pa.schema(fields, metadata=about))
    parquet.write_table(table, file, compression="zstd")
    return file.getvalue()


def _value(kind: str, value: Any) -> Any:
    if value is None:
        return None
    if kind == TIME:
        return round(value * 1e6)
    if kind == TEXT:
        return _plain(value)
    return [None if one is None else _plain(one) for one in value] if kind == TEXTS else value


def _plain(text: str) -> str:
    """Escape lone surrogates, which UTF-8 cannot encode."""
    return text.encode("utf-8", "backslashreplace").decode()
