"""Identify what results follow from by its content: never by a path, whose file may change."""

from __future__ import annotations

import json
from hashlib import sha256
from typing import Any

from mission.model.plain import to_plain


def contents(value: Any) -> str:
    """Return a digest of a dataclass, a table, an array or plain data; equal for equal values."""
    text = json.dumps(to_plain(value), sort_keys=True, default=_of_array)
    return sha256(text.encode()).hexdigest()[:16]


def _of_array(values: Any) -> list[str]:
    return [str(values.dtype), str(values.shape), sha256(values.tobytes()).hexdigest()]
