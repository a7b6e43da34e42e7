"""Read a line script into statements: drop comments, join continued lines, parse each line.

# a comment        to the end of the line
+ timeout 30s      continues the line before
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from mission.authoring.language.clauses import Amount, LegText, Name, Opening, Parameter, Statement
from mission.authoring.language.syntax import Strip, Syntax
from mission.model import Where
from mission.model.diagnostics import Diagnostics
from mission.model.extent import CODE, STATEMENT

_PARAMETER = re.compile(r"param\s+([A-Za-z_][\w-]*)\b")
_NAMED = re.compile(r"([A-Za-z_][\w-]*)\s*:")
_CODE = re.compile(r'(?:"[^"]*"|[^"#]|"(?=[^"]*$))*')


def statements(text: str, problems: Diagnostics) -> Iterator[Statement]:
    """Yield every readable statement; add the others to ``problems``. Raises MissionErrors if the
    text is too long."""
    syntax = Syntax(problems)
    code = 0
    for strip in _strips(text, problems):
        code += len(strip.text)
        if code > CODE.most:
            message = f"the mission is too long: {CODE.exceeded}"
            raise problems.refusal(
                "too-long", strip.where(0, 1), message, "make two missions of it"
            )
        statement = syntax.statement(strip)
        yield from [statement] if statement is not None else _salvaged(strip)


def _salvaged(strip: Strip) -> list[Statement]:
    """A stand-in for an unreadable line, with its name, so that one error does not cause others."""
    parameter = _PARAMETER.match(strip.text)
    if parameter is not None:
        where = strip.where(parameter.start(1), len(parameter[1]))
        return [Parameter(Name(parameter[1], where), Amount("1", "", where), where)]
    head = strip.text.partition(":")[0]
    words = head.split()
    group = len(words) > 1 and words[0] in ("repeat", "group", "loop")
    if group and words[-1].isdigit():  # repeat 3: and no name
        return [Opening(Name("unnamed", strip.where(0, 1)), None, strip.where(0, 1))]
    match = _NAMED.match(strip.text, head.rindex(words[-1]) if group else 0)
    if match is None:
        return []
    name = Name(match[1], strip.where(match.start(), len(match[1])))
    where = strip.where(0, 1)
    return [Opening(name, None, where) if group else LegText(name, (), where)]


class _Growing:
    """A statement that may continue in the next line."""

    def __init__(self, text: str, line: int, column: int) -> None:
        self._texts, self._parts = [text], [(0, line, column)]
        self.length = len(text)

    def add(self, text: str, line: int, column: int) -> None:
        self._parts.append((self.length + 1, line, column))
        self._texts.append(text)
        self.length += 1 + len(text)

    def strip(self) -> Strip:
        return Strip(" ".join(self._texts), tuple(self._parts))


def _strips(text: str, problems: Diagnostics) -> Iterator[Strip]:
    growing: _Growing | None = None
    for number, column, content in _code(text):
        more = content[1:].lstrip() if content.startswith("+") else content
        at = column + len(content) - len(more)
        if growing is not None and more is not content:
            growing.add(more, number, at)
        else:
            if growing is not None:
                yield growing.strip()
            elif more is not content:
                hint = "drop the +: there is no line before it"
                where = Where(number, at - 1)
                problems.add("continuation", where, "nothing to continue", hint)
            growing = _Growing(more, number, at) if more else None
        if growing is not None and growing.length > STATEMENT.most:
            hint = "a mission's longest statement is a fraction of that"
            raise problems.refusal("too-long", Where(number, column), STATEMENT.exceeded, hint)
    if growing is not None:
        yield growing.strip()


def _code(text: str) -> Iterator[tuple[int, int, str]]:
    """Line number, column and code of each line that has code."""
    for number, raw in enumerate(text.split("\n"), 1):
        code = code_and_comment(raw)[0].rstrip()
        content = code.lstrip()
        if content:
            yield number, len(code) - len(content) + 1, content


def code_and_comment(line: str) -> tuple[str, str]:
    """Split a line where its comment begins: at the first `#` that is not in a quoted path."""
    end = _CODE.match(line).end()  # type: ignore[union-attr]  # the empty text matches
    return line[:end], line[end:]
