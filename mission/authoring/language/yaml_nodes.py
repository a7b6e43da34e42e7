"""Read YAML nodes as texts with their positions, without the traps of YAML.

YAML never interprets plain values here: ``on`` stays a word, ``1e3`` is a number, and ``1:30`` is
an error with a hint. A key that appears twice is refused; merge keys (``<<``) work.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from mission.authoring.language import elsewhere
from mission.authoring.language.clauses import Amount, Name
from mission.authoring.language.syntax import Strip
from mission.model import Where
from mission.model.diagnostics import Diagnostics
from mission.model.likeness import suggestion
from mission.model.texts import NEVER_BELOW
from mission.model.yaml_tree import YamlFault, tree, where_of

_AMOUNT = re.compile(r"(-?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z/%]*)\Z")
_WORD = re.compile(r"[A-Za-z_][\w-]*\Z")
_NO_COLON_YET = re.compile(r"\s*(?:- +)?([A-Za-z_][\w-]*) +(\{.*)")
_NO_COLON = re.compile(r"\s*(?:- +)?([A-Za-z_][\w-]*) +([^:#]+)\Z")
_ELSEWHERE = {
    "a leg": elsewhere.LEG,
    "safety": elsewhere.SAFETY,
    "a mission": elsewhere.TOP,
    "a handler": elsewhere.HANDLER,
}
Item = tuple[Name, Node]


def composed(text: str, problems: Diagnostics) -> Node | None:
    try:
        root = tree(text)
    except YamlFault as fault:
        code, where, message, hint = fault.said("the mission")
        missing = forgotten_colon(text, fault.line) if code == "yaml" else None
        if missing is not None:
            where, hint = missing
            code, message = "colon", "a colon is missing here"
        problems.add(code, where, message, hint)
        return None
    if root is None:
        problems.add(
            "empty-mission", Where(1, 1), "there is no mission here", "write mission: name"
        )
    return root


class Nodes:
    """Reads nodes of one file; nodes of the wrong kind go to the problems."""

    def __init__(self, problems: Diagnostics) -> None:
        self._problems = problems

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
        if isinstance(node, SequenceNode):
            return list(node.value)
        hint = "begin each item with a dash"
        self._problems.add("yaml-type", where_of(node), f"{what} is a list", hint)
        return []

    def items(self, node: Node, known: Sequence[str] | None, what: str) -> list[Item]:
        """Keys with values in their order, merged keys last; ``known`` None: any key is allowed."""
        if not isinstance(node, MappingNode):
            hint = "write keys and values, for instance {depth: 5 m, gear: 6}"
            self._problems.add("yaml-type", where_of(node), f"{what} has keys and values", hint)
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
            self._problems.add(*_unknown(name, value, known, what))
        else:
            items[name.text] = (name, value)


def _unknown(
    name: Name, value: Node, known: Sequence[str], what: str
) -> tuple[str, Where, str, str]:
    """Code, place, message and hint for an unknown key."""
    word, _, rest = name.text.partition(" ")
    if rest and word in known and isinstance(value, ScalarNode) and not value.value:
        hint = f"write {word}: {rest:.40}"
        return "colon", name.where, f"a colon is missing behind {word!r}", hint
    if name.text.startswith(NEVER_BELOW):
        hint = f"a comma parts keys: write depth: 8 m {name.text:.40}"
        return "unknown-word", name.where, f"{NEVER_BELOW} is no key of its own", hint
    message = f"{what} has no key {name.text!r}"
    hint = suggestion(name.text, known, "keys")
    if name.text[:2] == "ZA":
        hint = "write it as an item of its own, - ZAF6, or as gear: 6"
    elif name.text in _ELSEWHERE.get(what, {}):
        hint = f"write {elsewhere.as_key(_ELSEWHERE[what][name.text])}"
    return "unknown-word", name.where, message, hint


def forgotten_colon(text: str, line: int) -> tuple[Where, str] | None:
    """Where a colon is missing, and a hint; None if none is.

    YAML reports a colon too many if one before it is missing: in the same line, as in
    ``- dive {depth: 5 m}``, or in the line above.
    """
    lines = text.split("\n")
    for number in (line, line - 1):
        row = lines[number - 1] if 0 < number <= len(lines) else ""
        match = _NO_COLON_YET.match(row) if number == line else _NO_COLON.match(row)
        if match is not None:
            where = Where(number, match.start(1) + 1, len(match[1]))
            return where, f"write {match[1]}: {match[2]}"
    return None


def strip_of(node: Node) -> Strip:
    """The text of a scalar node with its position."""
    assert isinstance(node, ScalarNode)
    quote = 1 if node.style in ("'", '"') else 0
    mark = node.start_mark
    return Strip.at(node.value, mark.line + 1, mark.column + 1 + quote)
