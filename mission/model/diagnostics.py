"""Errors in a text that a user wrote: at which stage, where, which rule, and what to do.

    Diagnosed      (the author of the text must act; holds every Diagnostic, str shows them all)
      MissionErrors         a mission in either form, or a script that was uploaded
      VehicleError          a vehicle file
      ConfigurationError    serve.yaml
      ImportErrors          a plan of another program

Readers do not raise: they add to a ``Diagnostics`` and continue, so that one run reports all
errors. A text that is too large, and the hundredth error, end the reading.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from mission.model.extent import PROBLEMS
from mission.model.texts import NOWHERE, Where

_SHOWN = 100  # characters of a line that are shown on either side of an error
_TOLD = 300  # characters of a message


class Stage(enum.Enum):
    """The step in which an error was found, in the order of the steps."""

    CONFIGURATION = "configuration"  # serve.yaml was read
    VEHICLE = "vehicle"  # a vehicle file was read
    IMPORT = "import"  # a plan of another program was read
    TEXT = "text"  # a mission's text was read
    COMPILE = "compile"  # its legs were put together, on a vehicle
    CHECK = "check"  # the bounds were proved


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One error. ``code`` names the rule that was broken, for programs and tests; ``hint`` says
    what to write instead.

    ``text`` is the whole source line ("" if not known); ``where.length`` characters of it from
    ``where.column`` are meant. Line 0 is no place in the text (a parameter from outside). ``path``
    is the counterexample of a bound: leg, how it was left, after how long.
    """

    stage: Stage
    code: str
    where: Where
    message: str
    hint: str = ""
    path: tuple[str, ...] = ()
    file: str = ""
    text: str = ""

    @property
    def offending(self) -> str:
        column = self.where.column
        return self.text[column - 1 : column - 1 + self.where.length] if self.where.line else ""

    @property
    def place(self) -> str:
        """``file:line:column``, without the parts that are not known."""
        at = f"{self.where.line}:{self.where.column}" if self.where.line else ""
        return ":".join(filter(None, (self.file, at)))

    @property
    def brief(self) -> str:
        """One line, for a journal."""
        said = f"{self.place}: {self.message}" if self.place else self.message
        return f"{said}; {self.hint}" if self.hint else said

    @property
    def rendered(self) -> str:
        """Message, source line, underline, hint. Tabs are kept, so that the marks line up; of a
        long line only the part around the error is shown."""
        said = f"{self.message} [{self.code}]"
        rows = [f"{self.place}: {said}" if self.place else said]
        if self.where.line and self.text:
            at = self.where.column - 1
            first = 0 if len(self.text) <= 2 * _SHOWN else max(0, at - _SHOWN)
            text = self.text[first : at + 2 * _SHOWN]
            lead = "".join("\t" if c == "\t" else " " for c in self.text[first:at])
            marks = "^" * max(1, min(self.where.length, len(text) - len(lead)))
            rows += [f"    {text}", f"    {lead}{marks}"]
        rows += [f"    {self.hint}"] if self.hint else []
        return "\n".join([*rows, *(f"    {step}" for step in self.path)])

    def as_object(self) -> dict[str, Any]:
        """The error as programs read it (``--json``)."""
        return {
            "stage": self.stage.value,
            "code": self.code,
            "file": self.file,
            "line": self.where.line,
            "column": self.where.column,
            "length": self.where.length,
            "message": self.message,
            "hint": self.hint,
            "path": list(self.path),
        }


class Diagnosed(ValueError):
    """Everything that is wrong with a text, by stage and place."""

    def __init__(self, found: Iterable[Diagnostic], source: str = "") -> None:
        self.diagnostics = ordered(found)
        self.source = source
        super().__init__(self.diagnostics)

    @property
    def brief(self) -> str:
        """One line for each, for a journal."""
        return "\n".join(d.brief for d in self.diagnostics)

    def __str__(self) -> str:
        return shown(self.diagnostics, self.source)


class MissionErrors(Diagnosed):
    """A mission that cannot be flown."""


def ordered(found: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    stages = list(Stage)
    return tuple(sorted(found, key=lambda d: (stages.index(d.stage), d.where.line, d.where.column)))


def shown(found: Sequence[Diagnostic], source: str) -> str:
    """All errors, underlined, with their number and files. ``source`` is the text that was read,
    "" if there was none. An error that is not in the text belongs to no file."""
    count, files = len(found), sorted({d.file for d in found} - {""}) if source else []
    total = f"{', '.join(files)}: " if files else ""
    total += f"{count} error{'s' if count != 1 else ''}"
    if count >= PROBLEMS.most:
        total += "; reading ended there, there may be more"
    return "\n".join([*(d.rendered for d in found), *([total] if files or count > 1 else [])])


def placed(found: Iterable[Diagnostic], text: str, file: str) -> tuple[Diagnostic, ...]:
    """Return the same diagnostics with their lines of ``text``."""
    lines = _lines(text)
    return tuple(_placed(d, lines, file) for d in found)


def _placed(diagnostic: Diagnostic, lines: Sequence[str], file: str) -> Diagnostic:
    where = diagnostic.where
    text = lines[where.line - 1] if 0 < where.line <= len(lines) else ""
    length = max(1, min(where.length, len(text) - where.column + 1)) if where.line else 0
    return replace(diagnostic, where=replace(where, length=length), text=text, file=file)


def _lines(text: str) -> list[str]:
    return [line.removesuffix("\r") for line in text.split("\n")]


class Diagnostics:
    """Collects errors while the text of a ``file`` is read, each once per place. ``error`` is the
    exception to raise."""

    def __init__(
        self,
        stage: Stage,
        text: str,
        file: str = "",
        error: type[Diagnosed] = MissionErrors,
    ) -> None:
        self._stage, self._file, self._error = stage, file, error
        self._lines = _lines(text)
        self._found: dict[tuple[str, int, int, str], Diagnostic] = {}

    def add(self, code: str, where: Where, message: str, hint: str = "") -> None:
        found = Diagnostic(self._stage, code, where, _clipped(message), _clipped(hint))
        found = _placed(found, self._lines, self._file)
        self._take(message, found)

    def add_outside(self, code: str, message: str, hint: str = "") -> None:
        """Add an error in something that was given besides the text."""
        self._take(message, whole(code, _clipped(message), _clipped(hint), self._stage))

    def _take(self, message: str, found: Diagnostic) -> None:
        where = found.where
        self._found.setdefault((found.code, where.line, where.column, message), found)
        if len(self._found) >= PROBLEMS.most:
            self.complain()

    def refusal(self, code: str, where: Where, message: str, hint: str = "") -> Diagnosed:
        """Add an error after which reading cannot continue; return the exception to raise."""
        self.add(code, where, message, hint)
        return self.error()

    def __len__(self) -> int:
        return len(self._found)

    def found(self) -> tuple[Diagnostic, ...]:
        return ordered(self._found.values())

    def within(self, first: int, last: int) -> bool:
        """Whether an error in these lines is known already."""
        return any(first <= line <= last for _, line, *_ in self._found)

    def placed(self, found: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
        """Return what others found in the same text, with its lines."""
        return tuple(_placed(d, self._lines, self._file) for d in found)

    def complain(self) -> None:
        """Raise the errors, if there are any."""
        if self._found:
            raise self.error()

    def error(self) -> Diagnosed:
        return self._error(self._found.values(), self._file)


def whole(code: str, message: str, hint: str = "", stage: Stage = Stage.TEXT) -> Diagnostic:
    """Return an error without a place in a text: in the file as a whole, or in an argument."""
    return Diagnostic(stage, code, NOWHERE, message, hint)


def _clipped(text: str) -> str:
    return text if len(text) <= _TOLD else f"{text[:_TOLD]}..."
