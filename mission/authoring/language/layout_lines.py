"""The tidy layout of a line script: indentation by open groups, single blanks.

What does not live here: comments in one column, blank lines (layout.py).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from mission.authoring.language.layout_row import STEP, Row
from mission.authoring.language.lines import code_and_comment

_SPACED = re.compile(r"\s*(->|<=|>=|<|>)\s*")
_PATH = re.compile(r'(?<=\bfile)\s+("[^"]*"|[^\s":][^\s"]*)(?=\s|$)')
_OPENS = re.compile(r"(?:repeat|group)\b.*:$")


def rows(text: str) -> Iterator[Row]:
    depth = 0
    for line in text.split("\n"):
        code, comment = code_and_comment(line)
        code, comment = _tidy(code), comment.rstrip()
        if code == "end":
            depth = max(0, depth - 1)
        more = 1 if code.startswith("+") else 0
        indent = " " * (STEP * (depth + more)) if code or comment else ""
        yield Row(indent + code, comment)
        if _OPENS.match(code):
            depth += 1


def _tidy(code: str) -> str:
    """The code with single blanks; paths of files stay as they are."""
    before, *paths = _PATH.split(code)
    tidy = [_spaced(before)]
    for path, after in zip(paths[::2], paths[1::2], strict=True):
        tidy += [path, _spaced(after)]
    return " ".join(part for part in tidy if part)


def _spaced(code: str) -> str:
    code = _SPACED.sub(r" \1 ", " ".join(code.split()))
    code = re.sub(r"\(\s+", "(", re.sub(r"\s+([),])", r"\1", code))
    code = re.sub(r"(?<=\w)\(", " (", re.sub(r",\s*", ", ", code))
    code = re.sub(r"\)(?=\w)", ") ", code)
    code = re.sub(r"^((?:repeat \S+ |group )?[A-Za-z_][\w-]*)\s*:\s*", r"\1: ", code)
    return re.sub(r"^\+\s*", "+ ", code).strip()
