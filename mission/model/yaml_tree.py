"""YAML text -> nodes, within bounds that hold while it is read.

    YamlFault      (the author must act; line and column count from 1)

``yaml.compose`` recurses, and accepts aliases that contain themselves or that expand to a gigabyte.
Here the size and depth of each node include its expanded aliases, and both are bounded. So a walk
over the nodes ends soon, and never runs out of stack.

What does not live here: what the nodes mean.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import yaml
from yaml.constructor import SafeConstructor
from yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    DocumentStartEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceStartEvent,
)
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from mission.model.extent import DEEPEST_YAML, NODES, STATEMENT
from mission.model.texts import Where

_DEEPEST_PLACE = 2  # levels of tables whose keys have a place
_TOO_DEEP = f"nested too deep: {DEEPEST_YAML.exceeded}"
_SCANNER_TOO_DEEP = "exceeded maximum nesting depth"  # libyaml reads ahead, and stops by itself
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class YamlFault(ValueError):
    """``code`` is yaml, too-long or too-deep; ``why`` is the message without the place."""

    def __init__(self, line: int, column: int, why: str, code: str = "yaml") -> None:
        super().__init__(f"{line}:{column}: {'not YAML: ' if code == 'yaml' else ''}{why}")
        self.line, self.column, self.why, self.code = line, column, why, code

    def said(self, what: str) -> tuple[str, Where, str, str]:
        """Return code, place, message and hint; ``what`` was read, for instance "the mission"."""
        where = Where(self.line, self.column)
        if self.code == "yaml":
            message = f"this is no YAML: {self.why or 'it cannot be read'}"
            hint = "indent with blanks, and put quotes around a text that holds a colon"
            return self.code, where, message, hint
        deep = self.code == "too-deep"
        hint = "does an alias hold itself?" if deep else "do aliases repeat themselves?"
        return self.code, where, f"{what} is {self.why}", hint


@dataclass(slots=True)
class _Branch:
    """A node with its size and height, aliases expanded; ``key`` waits for its value."""

    node: Node
    anchor: str | None = None
    size: int = 1
    height: int = 1
    key: Node | None = None


@dataclass(slots=True)
class _Tree:
    resolve: Any
    root: Node | None = None
    size: int = 0
    open: list[_Branch] = field(default_factory=list)
    anchors: dict[str, _Branch | None] = field(default_factory=dict)  # None: not complete yet

    def take(self, event: Any) -> None:
        if isinstance(event, AliasEvent):
            self._add(self._named(event), event)
        elif isinstance(event, ScalarEvent):
            if len(event.value) > STATEMENT.most:
                raise _too_long(event, STATEMENT.exceeded)
            self._add(_Branch(self._scalar(event), event.anchor), event)
        elif isinstance(event, SequenceStartEvent | MappingStartEvent):
            self._open(event)
        elif isinstance(event, CollectionEndEvent):
            branch = self.open.pop()
            branch.node.end_mark = event.end_mark
            self._add(branch, event)
        elif isinstance(event, DocumentStartEvent) and self.root is not None:
            raise _fault(event, "but found another document")

    def _scalar(self, event: Any) -> Node:
        tag = event.tag
        if tag is None or tag == "!":
            tag = self.resolve(ScalarNode, event.value, event.implicit)
        return ScalarNode(tag, event.value, event.start_mark, event.end_mark, style=event.style)

    def _open(self, event: Any) -> None:
        if len(self.open) >= DEEPEST_YAML.most:
            raise _too_deep(event)
        kind = SequenceNode if isinstance(event, SequenceStartEvent) else MappingNode
        tag = event.tag
        if tag is None or tag == "!":
            tag = self.resolve(kind, None, event.implicit)
        node = kind(tag, [], event.start_mark, None, flow_style=event.flow_style)
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        self.open.append(_Branch(node, event.anchor))

    def _named(self, event: AliasEvent) -> _Branch:
        if event.anchor not in self.anchors:
            raise _fault(event, f"found undefined alias {event.anchor!r:.60}")
        branch = self.anchors[event.anchor]
        if branch is None:
            raise _fault(event, "nested without end: an alias holds itself", "too-deep")
        return _Branch(branch.node, None, branch.size, branch.height)

    def _add(self, branch: _Branch, event: Any) -> None:
        """Add a complete node to the one that contains it."""
        if branch.anchor is not None:
            self.anchors[branch.anchor] = branch
        if len(self.open) + branch.height > DEEPEST_YAML.most + 1:
            raise _too_deep(event)
        if not self.open:
            self.root = branch.node
            return
        above = self.open[-1]
        above.size += branch.size
        above.height = max(above.height, branch.height + 1)
        if above.size > NODES.most:
            raise _too_long(event, NODES.exceeded)
        if isinstance(above.node, SequenceNode):
            above.node.value.append(branch.node)
        elif above.key is None:
            above.key = branch.node
        else:
            above.node.value.append((above.key, branch.node))
            above.key = None


def tree(text: str) -> Node | None:
    """Return the root node of the only document, None if there is none. Raises YamlFault."""
    try:
        loader = _Loader(text)
        grown = _Tree(loader.resolve)
        while loader.check_event():
            grown.take(loader.get_event())
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        if error.problem == _SCANNER_TOO_DEEP:
            raise YamlFault(line, column, _TOO_DEEP, "too-deep") from None
        raise YamlFault(line, column, error.problem or error.context or "") from None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        column = error.position - (text.rfind("\n", 0, error.position) + 1) + 1
        raise YamlFault(line, column, "a character that YAML does not allow") from None
    return grown.root


def values(root: Node | None) -> Any:
    """Return what ``yaml.safe_load`` would make of the nodes. Raises YamlFault."""
    try:
        return None if root is None else SafeConstructor().construct_document(root)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        raise YamlFault(line, column, error.problem or "") from None
    except ValueError as error:  # a number of ten thousand digits, a thirteenth month
        raise YamlFault(1, 1, f"a value cannot be read: {error!s:.80}") from None


def places(
    root: Node | None, above: tuple[str, ...] = ()
) -> dict[tuple[str, ...], tuple[Where, Where]]:
    """Return where each key of the tables stands, and where its value, by the path of keys."""
    found: dict[tuple[str, ...], tuple[Where, Where]] = {}
    for key, value in root.value if isinstance(root, MappingNode) else ():
        if isinstance(key, ScalarNode) and len(above) < _DEEPEST_PLACE:
            path = (*above, key.value)
            found[path] = where_of(key), where_of(value)
            found.update(places(value, path))
    return found


def where_of(node: Node) -> Where:
    """Return the place of a scalar on one line; of any other node that of its first character."""
    start, end = node.start_mark, node.end_mark
    same_line = isinstance(node, ScalarNode) and start.line == end.line
    length = end.column - start.column if same_line else 1
    return Where(start.line + 1, start.column + 1, max(1, length))


def _fault(event: Any, message: str, code: str = "yaml") -> YamlFault:
    mark = event.start_mark
    return YamlFault(mark.line + 1, mark.column + 1, message, code)


def _too_deep(event: Any) -> YamlFault:
    return _fault(event, _TOO_DEEP, "too-deep")


def _too_long(event: Any, message: str) -> YamlFault:
    return _fault(event, f"too long: {message}", "too-long")
