"""Read XML, with limits, as elements that have their line.

Entities that a file defines are refused (a few lines of them expand to gigabytes), and nothing
outside the file is read. Names are without their namespace.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from mission.authoring.importing.route import Findings
from mission.model.extent import DEEPEST_YAML, NODES


@dataclass(slots=True)
class Element:
    name: str
    line: int
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    text: str = ""

    @property
    def where(self) -> int:
        return self.line

    def all(self, name: str) -> Iterator[Element]:
        """The children with that name."""
        return (child for child in self.children if child.name == name)

    def one(self, *path: str) -> Element | None:
        """The first descendant along the path of names."""
        here: Element | None = self
        for name in path:
            here = next(here.all(name), None) if here is not None else None
        return here

    def said(self, *path: str) -> str:
        """The text at the path; "" if there is none."""
        found = self.one(*path)
        return found.text.strip() if found is not None else ""

    def within(self) -> Iterator[Element]:
        """The element and all its descendants, in the order of the file."""
        yield self
        for child in self.children:
            yield from child.within()


class _Builder:
    def __init__(self, found: Findings) -> None:
        self._found = found
        self._parser = expat.ParserCreate(namespace_separator=" ")
        self._parser.buffer_text = True
        self._open: list[Element] = []
        self._count = 0
        self.root: Element | None = None
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text
        self._parser.EntityDeclHandler = self._entity

    def read(self, data: bytes) -> Element:
        try:
            self._parser.Parse(data, True)
        except expat.ExpatError as error:
            why = expat.ErrorString(error.code)
            raise self._found.refusal("plan-format", error.lineno, f"not XML: {why}") from None
        assert self.root is not None
        return self.root

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        where = self._parser.CurrentLineNumber
        self._count += 1
        for extent, size in ((NODES, self._count), (DEEPEST_YAML, len(self._open))):
            if size > extent.most:
                raise self._found.refusal("too-long", where, f"more than {extent.most:,} elements")
        plain = {_local(key): value for key, value in attributes.items()}
        made = Element(_local(name), self._parser.CurrentLineNumber, plain)
        if self._open:
            self._open[-1].children.append(made)
        else:
            self.root = made
        self._open.append(made)

    def _end(self, name: str) -> None:
        self._open.pop()

    def _text(self, text: str) -> None:
        self._open[-1].text += text

    def _entity(self, name: str, *rest: object) -> None:
        where = self._parser.CurrentLineNumber
        raise self._found.refusal(
            "plan-format", where, f"it defines an entity ({name[:40]})", "write it out"
        )


def _local(name: str) -> str:
    return name.rpartition(" ")[2]


def elements(data: bytes, root: str, found: Findings) -> Element:
    """The root element, which must have that name. Raises ImportErrors."""
    read = _Builder(found).read(data)
    if read.name != root:
        raise found.refusal(
            "plan-format", read.where, f"the outermost element is {read.name}, not {root}"
        )
    return read
