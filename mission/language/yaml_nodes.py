"""YAML nodes as texts with their places: what ``yaml.compose`` gives, checked for its traps.

Plain values are never interpreted by YAML, so ``on`` stays a word, ``1:30`` an error that says
what to write, and ``1e3`` a number. Keys that stand twice are refused; merge keys (``<<``) work.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import yaml
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from mission.language.clauses import Amount, Name
from mission.language.problems import Problems, suggestion
from mission.language.syntax import Strip
from mission.model import Where

_AMOUNT = re.compile(r"(-?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z/%]*)\Z")
_WORD = re.compile(r"[A-Za-z_][\w-]*\Z")
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_MOST_NODES = 120_000  # aliases can make a small file endless

_DEEPEST = 500  # of nested brackets, and of dashes or blanks that begin a line
_NESTING = re.compile(r"[\[\]{}]")
_DASHES = re.compile(r"[-?\s]*")

Item = tuple[Name, Node]


def composed(text: str, problems: Problems) -> Node | None:
    deep = _too_deep(text)
    if deep is not None:
        problems.add("too-deep", deep, "brackets are nested too deep", "this is no mission")
        return None
    try:
        root = yaml.compose(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        _not_yaml(error, problems)
        return None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        column = error.position - (text.rfind("\n", 0, error.position) + 1) + 1
        hint = "remove it, or write it in a comment as plain text"
        problems.add("yaml", Where(line, column), "a character that YAML does not allow", hint)
        return None
    if root is None:
        problems.add(
            "empty-mission", Where(1, 1), "there is no mission here", "write mission: name"
        )
    return root


def _too_deep(text: str) -> Where | None:
    """Where nesting gets so deep that the loader, which recurses, would run out of stack."""
    depth = 0
    for number, line in enumerate(text.split("\n"), 1):
        for match in _NESTING.finditer(line):
            depth += 1 if match[0] in "[{" else -1
            if depth > _DEEPEST:
                return Where(number, match.start() + 1)
        dashes = _DASHES.match(line)
        if dashes and len(dashes[0]) > 2 * _DEEPEST:
            return Where(number, 2 * _DEEPEST)
    return None


def _not_yaml(error: yaml.MarkedYAMLError, problems: Problems) -> None:
    mark = error.problem_mark or error.context_mark
    where = Where(mark.line + 1, mark.column + 1) if mark else Where(1, 1)
    what = error.problem or error.context or "it cannot be read"
    hint = "indent with blanks, and put quotes around a text that holds a colon"
    problems.add("yaml", where, f"this is no YAML: {what}", hint)


class Nodes:
    """Reads nodes of one file; what does not fit goes to the problems."""

    def __init__(self, problems: Problems) -> None:
        self._problems = problems
        self._visited = 0

    def amount(self, node: Node) -> Amount | None:
        text = self.text(node)
        if text is None:
            return None
        if _WORD.match(text.text):
            return Amount(text.text, "", text.where, is_name=True)
        return self.number(node)

    def number(self, node: Node) -> Amount | None:
        text = self.text(node)
        match = _AMOUNT.match(text.text) if text else None
        if text is not None and match is None:
            rule, hint = "number", "write for instance 10 or 10 m"
            if re.match(r"\d+:\d", text.text):
                rule, hint = "clock-time", "write 90 s, 1.5 min or 2 h"
            elif not text.text:
                hint = "write a number behind the colon"
            self._problems.add(rule, text.where, f"{text.text!r} is no number", hint)
        return Amount(match[1], match[2], text.where) if text and match else None

    def name(self, node: Node) -> Name | None:
        text = self.text(node)
        if text is not None and not _WORD.match(text.text):
            hint = "a letter, then letters, digits, _ and -"
            self._problems.add("label", text.where, f"{text.text!r} is no name", hint)
            return None
        return text

    def text(self, node: Node) -> Name | None:
        if isinstance(node, ScalarNode):
            return Name(node.value.strip(), where_of(node))
        what = "a list" if isinstance(node, SequenceNode) else "a table"
        hint = "write one value"
        self._problems.add("yaml-type", where_of(node), f"{what} does not fit here", hint)
        return None

    def entries(self, node: Node, what: str) -> Sequence[Node]:
        if isinstance(node, SequenceNode) and self._allowed(node, len(node.value)):
            return list(node.value)
        if not isinstance(node, SequenceNode):
            hint = "begin each item with a dash"
            self._problems.add("yaml-type", where_of(node), f"{what} is a list", hint)
        return []

    def items(self, node: Node, known: Sequence[str] | None, what: str) -> list[Item]:
        """Key and value in their order, merged keys last; ``known`` None: any name."""
        if not isinstance(node, MappingNode):
            hint = "write keys and values, for instance {depth: 5 m, gear: 6}"
            self._problems.add("yaml-type", where_of(node), f"{what} has keys and values", hint)
            return []
        if not self._allowed(node, len(node.value)):
            return []
        items: dict[str, Item] = {}
        merged: list[Item] = []
        for key, value in node.value:
            if not isinstance(key, ScalarNode):
                hint = "a key is one word"
                self._problems.add("yaml-type", where_of(key), "this is no key", hint)
            elif key.tag == "tag:yaml.org,2002:merge":
                sources = value.value if isinstance(value, SequenceNode) else [value]
                merged += [item for source in sources for item in self.items(source, known, what)]
            else:
                self._key(items, Name(key.value, where_of(key)), value, known, what)
        for name, value in merged:
            items.setdefault(name.text, (name, value))
        return list(items.values())

    def _key(
        self,
        items: dict[str, Item],
        name: Name,
        value: Node,
        known: Sequence[str] | None,
        what: str,
    ) -> None:
        if name.text in items:
            first = items[name.text][0].where.line
            message = f"{name.text} appears twice; the first is in line {first}"
            self._problems.add("twice", name.where, message, "keep one of them")
        elif known is not None and name.text not in known:
            hint = suggestion(name.text, known, "keys")
            if name.text[:2] == "ZA":
                hint = "write it as an item of its own, - ZAF6, or as gear: 6"
            message = f"{what} has no key {name.text!r}"
            self._problems.add("unknown-word", name.where, message, hint)
        else:
            items[name.text] = (name, value)

    def _allowed(self, node: Node, size: int) -> bool:
        self._visited += size + 1
        if self._visited > _MOST_NODES:
            hint = "aliases repeat themselves without end, or the file is far too long"
            self._problems.add("too-long", where_of(node), "the mission is too long", hint)
        return self._visited <= _MOST_NODES


def where_of(node: Node) -> Where:
    """The node's own text, up to the end of its first line."""
    start, end = node.start_mark, node.end_mark
    same_line = start.line == end.line and isinstance(node, ScalarNode)
    length = end.column - start.column if same_line else 1
    return Where(start.line + 1, start.column + 1, max(1, length))


def strip_of(node: Node) -> Strip:
    """The text of a node that is known to be a scalar."""
    assert isinstance(node, ScalarNode)
    quote = 1 if node.style in ("'", '"') else 0
    mark = node.start_mark
    return Strip.at(node.value, mark.line + 1, mark.column + 1 + quote)
