"""What is wrong with a mission text: where, what, and what to write instead.

    MissionErrors     (the author must act; holds every Problem of the file, by position)

Readers do not raise: they add to a ``Problems`` and read on, so that one run tells everything.
What is too large, and the hundredth error, end the reading there.
"""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from mission.model import Where
from mission.model.extent import NAME, PROBLEMS

_SHOWN = 100  # characters of a line shown to either side of what is wrong in it
_TOLD = 300  # characters of a message
_COMPARED = 500  # names that a misspelt one is compared with


@dataclass(frozen=True, slots=True)
class Problem:
    """``text`` is the whole source line, of which ``length`` characters from ``column`` are meant.

    Lines and columns count from 1; line 0 is no place in the text (a parameter from outside).
    ``rule`` names the rule that was broken, for programs and tests.
    """

    line: int
    column: int
    length: int
    text: str
    message: str
    hint: str
    rule: str

    @property
    def offending(self) -> str:
        return self.text[self.column - 1 : self.column - 1 + self.length] if self.line else ""

    def rendered(self, source: str) -> str:
        """Message, source line, underline, hint; tabs are kept so that the marks line up. Of a
        long line, what stands around."""
        place = f"{source}:{self.line}:{self.column}: " if self.line else f"{source}: "
        rows = [f"{place}{self.message} [{self.rule}]"]
        if self.line and self.text:
            at = self.column - 1
            first = 0 if len(self.text) <= 2 * _SHOWN else max(0, at - _SHOWN)
            text = self.text[first : at + 2 * _SHOWN]
            lead = "".join("\t" if c == "\t" else " " for c in self.text[first:at])
            marks = "^" * max(1, min(self.length, len(text) - len(lead)))
            rows += [f"    {text}", f"    {lead}{marks}"]
        if self.hint:
            rows.append(f"    {self.hint}")
        return "\n".join(rows)


class MissionErrors(ValueError):
    """Every problem of one mission text; ``str`` shows them all, underlined."""

    def __init__(self, problems: Sequence[Problem], source: str = "") -> None:
        self.problems = tuple(sorted(problems, key=lambda p: (p.line, p.column)))
        self.source = source or "mission"
        super().__init__(self.problems)

    def __str__(self) -> str:
        count = len(self.problems)
        total = f"{self.source}: {count} error{'s' if count != 1 else ''}"
        if count >= PROBLEMS.most:
            total += "; reading ended there, there may be more"
        return "\n".join([*(p.rendered(self.source) for p in self.problems), total])


class Problems:
    """Collects while a text is read; one complaint per rule and place."""

    def __init__(self, text: str, source: str = "") -> None:
        self._source = source
        self._lines = [line.removesuffix("\r") for line in text.split("\n")]
        self._found: dict[tuple[str, int, int], Problem] = {}

    def add(self, rule: str, where: Where, message: str, hint: str = "") -> None:
        text = self._lines[where.line - 1] if 0 < where.line <= len(self._lines) else ""
        length = max(1, min(where.length, len(text) - where.column + 1))
        said, hint = _clipped(message), _clipped(hint)
        problem = Problem(where.line, where.column, length, text, said, hint, rule)
        self._found.setdefault((rule, where.line, where.column), problem)
        if len(self._found) >= PROBLEMS.most:
            self.complain()

    def refusal(self, rule: str, where: Where, message: str, hint: str = "") -> MissionErrors:
        """With this one, after which there is no reading on."""
        self.add(rule, where, message, hint)
        return self._errors()

    def __len__(self) -> int:
        return len(self._found)

    def within(self, first: int, last: int) -> bool:
        """Whether something is wrong in these lines already."""
        return any(first <= line <= last for _, line, _ in self._found)

    def complain(self) -> None:
        """Raises MissionErrors if there is anything to complain about."""
        if self._found:
            raise self._errors()

    def _errors(self) -> MissionErrors:
        return MissionErrors(list(self._found.values()), self._source)


def _clipped(text: str) -> str:
    return text if len(text) <= _TOLD else f"{text[:_TOLD]}..."


def nearest(word: str, known: Iterable[str], likeness: float = 0.6) -> str:
    """The known name that ``word`` most likely means, or "" where none is that like it."""
    if len(word) > 2 * NAME.most:
        return ""
    names = {name.lower(): name for name in itertools.islice(known, _COMPARED)}
    found = difflib.get_close_matches(word.lower(), names, n=1, cutoff=likeness)
    return names[found[0]] if found else ""


def suggestion(word: str, known: Sequence[str], what: str) -> str:
    """A hint: the nearest known name, and all of them where they are few."""
    close = nearest(word, known)
    if close:
        return f"did you mean {close}?"
    shown = ", ".join(known[:30])
    return f"{what}: {shown}" if known else ""
