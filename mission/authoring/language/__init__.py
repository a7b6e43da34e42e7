"""Mission texts: two ways to write one Mission, and one canonical text of it.

    lines --lines.py--+                                       +--canonical.py--> lines, digest,
                      +--> statements --assembly.py--> Mission +                  @AW script
    YAML --yaml_form--+                                       +--yaml_text.py--> YAML

All errors of a text are reported at once (``MissionErrors``), each with line, column, and what to
write instead. What does not live here: whether the mission is safe
(mission.authoring.check).
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from mission.authoring.language.canonical import digest, script, to_lines
from mission.authoring.language.files import Files, no_files
from mission.model import NOWHERE, Mission, Where
from mission.model.diagnostics import Diagnostics, MissionErrors, Stage
from mission.model.extent import BYTES, STATEMENTS

if TYPE_CHECKING:
    from mission.authoring.language.clauses import Statement
    from mission.model.vehicle import Vehicle

__all__ = [
    "MissionErrors",
    "digest",
    "draft",
    "draft_script",
    "load",
    "parse",
    "parse_script",
    "read_file",
    "script",
    "to_lines",
    "to_yaml",
]

_NONE: Mapping[str, str] = MappingProxyType({})
_YAML_KEY = re.compile(r"""(?m)^(?:["']?(?:mission|legs)["']?\s*:(?:\s|$)|---|%YAML|\{)""")
_HEAD = re.compile(r"(?:\s|#.*\n)*mission\s+[\w-]+\s+vehicle\s")  # a leg may be named like a key
_HOME = re.compile(r"(?m)^\W*home\b")


def is_yaml(text: str, source: str = "") -> bool:
    """Whether the text is YAML, by its content; if that is not clear, by the suffix of the file."""
    if _HEAD.match(text):
        return False
    if _YAML_KEY.search(text):
        return True
    if re.search(r"(?m)^\s*(?:mission\s+\w|end\b|\w[\w-]*:.*\bZA)", text):
        return False
    return source.endswith((".yaml", ".yml")) or bool(re.search(r"(?m)^\s*- ", text))


@dataclass(frozen=True, slots=True)
class Draft:
    """The readable part of a text. The mission is complete only if there are no problems."""

    mission: Mission
    problems: Diagnostics
    lines: tuple[int, ...]  # the lines in which statements begin, ascending
    says_home: bool = False  # the text has a home statement, readable or not; only with problems
    statements: tuple[Statement, ...] = ()  # the readable ones, as written

    def sound(self, where: Where) -> bool:
        """Whether the statement that begins at ``where`` has no problem."""
        after = bisect_right(self.lines, where.line)
        last = self.lines[after] - 1 if after < len(self.lines) else BYTES.most
        return not self.problems.within(where.line, last)


def parse(
    text: str,
    source: str = "",
    parameters: Mapping[str, str] = _NONE,
    vehicle: Vehicle | None = None,
    files: Files = no_files,
) -> Mission:
    """Read a mission in either form. Raises MissionErrors with all errors."""
    return _whole(draft(text, source, parameters, vehicle, files))


def _whole(read: Draft) -> Mission:
    read.problems.complain()
    return read.mission


def draft(
    text: str,
    source: str = "",
    parameters: Mapping[str, str] = _NONE,
    vehicle: Vehicle | None = None,
    files: Files = no_files,
) -> Draft:
    """Read either form as far as possible.

    ``vehicle``: the vehicle that is to fly the mission; it defines the readings that guards may
    use, and the speed of each gear. None: the shipped vehicle that the text names. ``files`` reads
    the files of places that the text names. Raises MissionErrors if reading ended early (the text
    is too large).
    """
    text = text.removeprefix("\ufeff").replace("\r\n", "\n")
    return _drafted(text, source, parameters, vehicle, files, yaml=is_yaml(text, source))


def draft_script(lines: Sequence[str], vehicle: Vehicle | None = None) -> Draft:
    """Read the lines that came by ``@AW``; ``sum`` in line 1 must fit. Raises like ``draft``."""
    return _drafted("\n".join(lines), "script", _NONE, vehicle, no_files, yaml=False)


def _drafted(
    text: str,
    source: str,
    parameters: Mapping[str, str],
    vehicle: Vehicle | None,
    files: Files,
    yaml: bool,
) -> Draft:
    from mission.authoring.language import assembly, canonical

    found = Diagnostics(Stage.TEXT, text, source)
    if yaml:
        from mission.authoring.language.yaml_form import statements as read
    else:
        from mission.authoring.language.lines import statements as read
    statements = list(_bounded(read(text, found), found))
    mission, claimed = assembly.Assembly(found, parameters, vehicle, files).read(statements)
    begins = tuple(sorted({statement.where.line for statement in statements}))
    if len(found):
        return Draft(mission, found, begins, bool(_HOME.search(text)), tuple(statements))
    mission = canonical.numbered(mission)
    canonical.check_length(mission, found)
    if claimed is not None and claimed.text != canonical.total(mission):
        hint = f"the lines make {canonical.total(mission)}: send them again, or drop the sum"
        found.add("sum", claimed.where, "the sum does not fit the lines", hint)
    return Draft(mission, found, begins, statements=tuple(statements))


def _bounded(statements: Iterable[Statement], found: Diagnostics) -> Iterator[Statement]:
    for number, statement in enumerate(statements, 1):
        if number > STATEMENTS.most:
            message = f"the mission is too long: {STATEMENTS.exceeded}"
            raise found.refusal(
                "too-long", statement.where, message, "make it shorter, or two of it"
            )
        yield statement


def load(
    path: str | Path, parameters: Mapping[str, str] = _NONE, files: Files = no_files
) -> Mission:
    """Read a mission file. Raises MissionErrors, also if the file cannot be read."""
    return parse(read_file(path), str(path), parameters, files=files)


def read_file(path: str | Path) -> str:
    """The text of a mission file. Raises MissionErrors if the file does not exist, is not UTF-8, or
    is larger than a mission may be (a device file may never end)."""
    why, hint = "", "give a mission file"
    try:
        with Path(path).open("rb") as file:
            data = file.read(BYTES.most + 1)
        if len(data) <= BYTES.most:
            return data.decode("utf-8")
        why = f"it has {BYTES.exceeded}, which no mission has"
    except OSError as error:
        why = error.strerror or str(error)
    except UnicodeDecodeError:
        why, hint = "it is not UTF-8", "save it as UTF-8; a mission needs ASCII alone"
    found = Diagnostics(Stage.TEXT, "", str(path))
    raise found.refusal("unreadable", NOWHERE, f"cannot be read: {why}", hint)


def parse_script(lines: Sequence[str], vehicle: Vehicle | None = None) -> Mission:
    """As ``draft_script``, but the whole mission. Raises MissionErrors with all errors."""
    return _whole(draft_script(lines, vehicle))


def to_yaml(mission: Mission) -> str:
    """The YAML form, with units; parameters are resolved, comments are dropped."""
    from mission.authoring.language import yaml_text

    return yaml_text.to_yaml(mission)
