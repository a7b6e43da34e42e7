"""JSON as values with their path (``mission.items[3].params[4]``), for error messages."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from mission.authoring.importing.route import Findings, text_of


@dataclass(frozen=True, slots=True)
class Value:
    raw: Any
    path: str
    found: Findings

    def get(self, key: str) -> Value:
        """The value under ``key``; its ``raw`` is None if there is none."""
        raw = self.raw.get(key) if isinstance(self.raw, dict) else None
        return Value(raw, f"{self.path}.{key}" if self.path else key, self.found)

    def items(self) -> Iterator[Value]:
        """The items of a list; none, with an error recorded, for anything else."""
        if not isinstance(self.raw, list):
            self.found.refuse("plan-form", self.path, "not a list")
            return
        for index, raw in enumerate(self.raw):
            yield Value(raw, f"{self.path}[{index}]", self.found)

    def text(self) -> str:
        return self.raw if isinstance(self.raw, str) else ""

    def number(self) -> float | None:
        """The number; None if it is null or missing, or, with an error recorded, no number."""
        if self.raw is None:
            return None
        if isinstance(self.raw, bool) or not isinstance(self.raw, int | float):
            self.found.refuse("number", self.path, "not a number")
            return None
        value = float(self.raw) if abs(self.raw) < 1e300 else math.inf
        if not math.isfinite(value):
            self.found.refuse("number", self.path, "not a finite number")
            return None
        return value


def values(data: bytes, found: Findings) -> Value:
    """Parse JSON. Raises ImportErrors if it is not JSON, or has a key twice in one table."""
    try:
        raw = json.loads(text_of(data, found), object_pairs_hook=_once)
    except json.JSONDecodeError as error:
        raise found.refusal("plan-format", error.lineno, f"not JSON: {error.msg}") from None
    except (ValueError, RecursionError) as error:
        raise found.refusal(
            "plan-format", "", f"not JSON that a plan has: {str(error)[:80]}"
        ) from None
    return Value(raw, "", found)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    keys = [key for key, _ in pairs]
    if len(set(keys)) != len(keys):
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"the key {twice[:40]!r} stands twice in one table")
    return dict(pairs)
