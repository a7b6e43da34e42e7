"""The line script -> statements: comments off, continued lines joined, each line by the grammar.

# a comment        to the end of the line
+ timeout 30s      continues the line before
"""

from __future__ import annotations

import re

from mission.language.clauses import Amount, LegText, Name, Opening, Parameter, Statement
from mission.language.problems import Problems
from mission.language.syntax import Strip, Syntax
from mission.model import Where

_PARAMETER = re.compile(r"param\s+([A-Za-z_][\w-]*)\b")
_NAMED = re.compile(r"(?P<group>(?:repeat\b.*|group)\s+)?(?P<name>[A-Za-z_][\w-]*)\s*:")


def statements(text: str, problems: Problems) -> list[Statement]:
    """Every statement that could be read; the others are among the problems."""
    syntax = Syntax(problems)
    found: list[Statement] = []
    for strip in _strips(text, problems):
        statement = syntax.statement(strip)
        found += [statement] if statement is not None else _salvaged(strip)
    return found


def _salvaged(strip: Strip) -> list[Statement]:
    """The name that an unreadable line gives, so that one fault does not make others."""
    parameter = _PARAMETER.match(strip.text)
    if parameter is not None:
        where = strip.where(parameter.start(1), len(parameter[1]))
        return [Parameter(Name(parameter[1], where), Amount("1", "", where), where)]
    match = _NAMED.match(strip.text)
    if match is None:
        return []
    name = Name(match["name"], strip.where(match.start("name"), len(match["name"])))
    where = strip.where(0, 1)
    return [Opening(name, None, where) if match["group"] else LegText(name, (), where)]


def _strips(text: str, problems: Problems) -> list[Strip]:
    strips: list[Strip] = []
    for number, raw in enumerate(text.split("\n"), 1):
        code = raw.split("#", 1)[0].rstrip()
        content = code.lstrip()
        if not content:
            continue
        column = len(code) - len(content) + 1
        if not content.startswith("+"):
            strips.append(Strip.at(content, number, column))
            continue
        more = content[1:].lstrip()
        column += len(content) - len(more)
        if not strips:
            hint = "drop the +: there is no line before it"
            problems.add("continuation", Where(number, column - 1), "nothing to continue", hint)
            strips.append(Strip.at(more, number, column))
            continue
        before = strips[-1]
        parts = (*before.parts, (len(before.text) + 1, number, column))
        strips[-1] = Strip(f"{before.text} {more}", parts)
    return [s for s in strips if s.text]
