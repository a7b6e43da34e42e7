"""The tidy layout of a line script: indentation by open groups, single blanks.

What does not live here: comments in one column, blank lines (layout.py).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from mission.authoring.language.layout_row import STEP, Row

_SPACED = re.compile(r"\s*(->|<=|>=|<|>)\s*")
_OPENS = re.compile(r"(?:repeat|group)\b.*:$")


def rows(text: str) -> Iterator[Row]:
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
