"""Read the YAML form into statements: the keys of a mission, a group, a leg, a handler.

What does not live here: YAML itself and its traps (yaml_nodes.py), what words mean (words.py,
legs.py), values inside a text such as ``until`` (syntax.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from mission.authoring.language import elsewhere
from mission.authoring.language.clauses import (
    Amount,
    AreaText,
    Chosen,
    Clause,
    Coordinates,
    Else,
    End,
    HomeAt,
    LegText,
    MissionHead,
    Name,
    Named,
    Offset,
    On,
    Opening,
    OutputText,
    Parameter,
    Places,
    PlaceText,
    Statement,
    Until,
    Value,
    WithoutFix,
)
from mission.authoring.language.syntax import Strip, Syntax
from mission.authoring.language.words import (
    AIMS,
    ASSUMPTIONS,
    GUARDED,
    LIMITS,
    STOP,
    NamedValue,
    choices,
    kinds,
    leg_words,
    spots,
)
from mission.authoring.language.yaml_nodes import Item, Nodes, composed, strip_of
from mission.legs.words import Shape
from mission.model import Where
from mission.model.diagnostics import Diagnostics
from mission.model.texts import NEVER_BELOW
from mission.model.yaml_tree import where_of

TOP_KEYS = (
    "mission", "vehicle", "home", "safety", "assume", "param", "start", "achieve", "legs", "on",
)  # fmt: skip
GROUP_KEYS = ("repeat", "achieve", "legs", "on")
KEEPS = {"keep_in": False, "keep_out": True}
AREA_KEYS = ("corners", "between")
HANDLER_KEYS = ("when", "held", "do")
WITHOUT_FIX = "without fix"

_NO_METRES = Amount("0", "", Where(0, 0, 0))  # replaces an unreadable amount

_YES = ("true", "yes", "on", "")


def statements(text: str, problems: Diagnostics) -> Iterator[Statement]:
    """Yield every readable statement; add the others to ``problems``."""
    root = composed(text, problems)
    return iter(()) if root is None else _Form(problems).top(root)


class _Form:
    def __init__(self, problems: Diagnostics) -> None:
        self._problems = problems
        self._syntax = Syntax(problems)
        self._nodes = Nodes(problems)
        self._guessed = False

    def top(self, root: Node) -> Iterator[Statement]:
        before = len(self._problems)
        items = dict(self._nodes.items(root, TOP_KEYS, "a mission"))
        self._guessed = len(self._problems) > before  # a missing key may be a misspelt one
        keys = {name.text: (name, node) for name, node in items.items()}
        yield from self._head(keys, root)
        if "home" in keys:
            name, node = keys["home"]
            place = self._place(node)
            if isinstance(place, Coordinates):
                yield HomeAt(place, name.where)
            elif place is not None:
                hint = "write {latitude: 30.28, longitude: 120.15}"
                self._problems.add("position", where_of(node), "home is a position", hint)
        if "safety" in keys:
            yield from self._safety(*keys["safety"])
        if "assume" in keys:
            yield self._named(*keys["assume"], ASSUMPTIONS)
        if "param" in keys:
            for key, value in self._nodes.items(keys["param"][1], None, "param"):
                amount = self._nodes.number(value) or Amount("1", "", key.where)
                yield Parameter(key, amount, key.where)
        if "start" in keys:
            yield from self._start(*keys["start"])
        yield from self._body(keys)

    def _safety(self, name: Name, node: Node) -> Iterator[Statement]:
        pairs = self._nodes.items(node, (*LIMITS, *KEEPS), name.text)
        limits = [(key, value) for key, value in pairs if key.text in LIMITS]
        amounts = [(key, self._nodes.amount(value)) for key, value in limits]
        given = tuple((key, amount) for key, amount in amounts if amount)
        yield Named(name.text, given, name.where)
        for key, value in pairs:
            if key.text in KEEPS:
                for area, inner in self._nodes.items(value, None, key.text):
                    yield from self._area(area, KEEPS[key.text], inner)

    def _area(self, name: Name, out: bool, node: Node) -> Iterator[AreaText]:
        keys = {k.text: v for k, v in self._nodes.items(node, AREA_KEYS, "an area")}
        if "corners" not in keys:
            hint = "write corners: [north 0 east 0, north 50 east 0, north 50 east 50]"
            self._problems.add("missing-word", name.where, f"{name.text} has no corners", hint)
            return
        nodes = self._nodes.entries(keys["corners"], "corners")
        corners = [place for item in nodes if (place := self._place(item)) is not None]
        depths = self._nodes.entries(keys["between"], "between") if "between" in keys else []
        amounts = [amount for item in depths if (amount := self._nodes.amount(item)) is not None]
        if "between" in keys and len(amounts) != 2:
            message, hint = "between takes two depths", "write between: [4 m, 12 m]"
            self._problems.add("missing-word", where_of(keys["between"]), message, hint)
            return
        between = (amounts[0], amounts[1]) if amounts else None
        yield AreaText(name, out, tuple(corners), between, name.where)

    def _named(self, name: Name, node: Node, rows: Mapping[str, NamedValue]) -> Named:
        pairs = self._nodes.items(node, tuple(rows), name.text)
        amounts = [(key, self._nodes.amount(value)) for key, value in pairs]
        given = tuple((key, amount) for key, amount in amounts if amount)
        return Named(name.text, given, name.where)

    def _head(self, keys: dict[str, Item], root: Node) -> Iterator[Statement]:
        name = self._nodes.name(keys["mission"][1]) if "mission" in keys else None
        if "mission" not in keys and not self._guessed:
            hint = "write mission: and its name in the first line"
            where = Where(root.start_mark.line + 1, root.start_mark.column + 1)
            self._problems.add("missing-word", where, "the mission has no name", hint)
        vehicle = self._nodes.name(keys["vehicle"][1]) if "vehicle" in keys else None
        if name is not None:
            yield MissionHead(name, vehicle, None, keys["mission"][0].where)
        if "legs" not in keys and not self._guessed:
            hint = "write legs: and a list of legs"
            where = Where(root.start_mark.line + 1, root.start_mark.column + 1)
            self._problems.add("missing-word", where, "the mission has no legs", hint)

    def _start(self, name: Name, node: Node) -> Iterator[Statement]:
        text = self._nodes.text(node)
        if text is None:
            return
        if text.text == WITHOUT_FIX:
            yield WithoutFix(name.where)
        else:
            hint = f"write start: {WITHOUT_FIX}, or leave it out"
            self._problems.add("unknown-word", text.where, f"start has no {text.text!r}", hint)

    def _body(self, keys: dict[str, Item]) -> Iterator[Statement]:
        if "achieve" in keys:
            aims = self._named(*keys["achieve"], AIMS)
            yield LegText(None, (aims,), aims.where)
        if "legs" in keys:
            for node in self._nodes.entries(keys["legs"][1], "legs"):
                yield from self._node(node)
        if "on" in keys:
            for node in self._nodes.entries(keys["on"][1], "on"):
                yield from self._handler(node)

    # --- legs and groups --------------------------------------------------------------------------

    def _node(self, node: Node) -> Iterator[Statement]:
        if isinstance(node, ScalarNode):
            strip = strip_of(node)
            leg = self._syntax.leg(strip)
            if leg is not None and leg.name is not None:
                hint = f"write {leg.name.text}: and the leg's keys, without quotes"
                self._problems.add("label", leg.name.where, "a text item has no name", hint)
            elif leg is not None:
                yield leg
            return
        items = self._nodes.items(node, None, "a leg")
        word = items[0][0].text.split()[0] if items and items[0][0].text.split() else ""
        if word in elsewhere.CONTROL:
            way = elsewhere.as_key(elsewhere.LEG.get(word, "repeat"))
            message = elsewhere.no_name(word)
            self._problems.add("control-word", items[0][0].where, message, f"write {way}")
            return
        if len(items) != 1:
            hint = "write - name: {...}, one name to each item of legs"
            if items:
                message = "a leg is one name with its keys below"
                odd = items[isinstance(items[0][1], MappingNode)][0]  # the first key that is no leg
                self._problems.add("leg-form", odd.where, message, hint)
            return
        name, inner = items[0]
        keys = [key.value for key, _ in inner.value] if isinstance(inner, MappingNode) else []
        if "legs" in keys or "repeat" in keys:
            yield from self._group(name, inner)
        else:
            clauses = self._clauses(inner)
            if clauses:
                yield LegText(name, tuple(clauses), name.where)

    def _group(self, name: Name, node: Node) -> Iterator[Statement]:
        keys = {
            key.text: (key, value) for key, value in self._nodes.items(node, GROUP_KEYS, "a group")
        }
        repeat = self._nodes.amount(keys["repeat"][1]) if "repeat" in keys else None
        if "legs" not in keys:
            hint = "write legs: and a list of legs"
            self._problems.add("missing-word", name.where, f"group {name.text} has no legs", hint)
            yield LegText(name, (), name.where)
            return
        yield Opening(name, repeat, name.where)
        yield from self._body(keys)
        yield End(replace(name.where, line=node.end_mark.line + 1))

    def _clauses(self, node: Node) -> list[Clause]:
        clauses: list[Clause] = []
        for word, value in self._nodes.items(node, leg_words(), "a leg"):
            clauses += self._clause(word, value)
        if isinstance(node, MappingNode) and not node.value:
            message = "a name with nothing behind it"
            hint = "write for instance {depth: 5 m, until: depth >= 4.5 m}"
            self._problems.add("empty-leg", where_of(node), message, hint)
        return clauses

    def _clause(self, word: Name, node: Node) -> Iterator[Clause]:
        row = kinds().get(word.text)
        shape = row.head.shape if row is not None else None
        if word.text == STOP or shape is Shape.NOTHING:
            if self._flag(word, node):
                yield Value(word)
        elif word.text in spots() or shape in (Shape.PLACE, Shape.ABOUT):
            place = self._place(node)
            if place is not None:
                yield Places(word, (place,))
        elif shape is Shape.PLACES and isinstance(node, ScalarNode):
            yield from self._as_in_a_line(word, node)
        elif shape is Shape.PLACES:
            places = [
                self._place(item) or Offset(Amount(str(i), "", word.where), _NO_METRES)
                for i, item in enumerate(self._nodes.entries(node, word.text))
            ]
            if places:
                yield Places(word, tuple(places))
        elif word.text in choices():
            choice = self._nodes.text(node)
            if choice is not None:
                yield Chosen(word, choice)
        elif word.text == "until":
            yield from self._until(word, node)
        elif word.text == "else":
            target = self._nodes.name(node)
            if target is not None:
                yield Else(word, target)
        elif word.text in ("achieve", "output"):
            yield from self._tabled(word, node)
        elif shape is Shape.TIME and isinstance(node, ScalarNode) and node.value in _YES:
            yield Value(word)
        else:
            yield from self._sized(word, node)

    def _sized(self, word: Name, node: Node) -> Iterator[Clause]:
        if word.text in GUARDED and isinstance(node, ScalarNode) and NEVER_BELOW in node.value:
            yield from self._as_in_a_line(word, node)
        elif (amount := self._nodes.amount(node)) is not None:
            yield Value(word, amount)

    def _as_in_a_line(self, word: Name, node: ScalarNode) -> Iterator[Clause]:
        """Parse ``8 m never below altitude 3 m`` or ``area bay`` as a line, behind its word."""
        strip = strip_of(node)
        (_, line, column), ahead = strip.parts[0], f"{word.text} "
        read = self._syntax.leg(Strip.at(ahead + strip.text, line, column - len(ahead)))
        if read is None:
            return
        if len(read.clauses) > 1:
            hint = f"each word of a leg is a key of its own beside {word.text}"
            message = f"{word.text} has more behind it than belongs to it"
            self._problems.add("yaml-type", where_of(node), message, hint)
        yield read.clauses[0]

    def _tabled(self, word: Name, node: Node) -> Iterator[Clause]:
        if word.text == "achieve":
            yield self._named(word, node, AIMS)
            return
        for name, value in self._nodes.items(node, None, "output"):
            amount = self._nodes.amount(value)
            if amount is not None:
                yield OutputText(word, name, amount)

    def _flag(self, word: Name, node: Node) -> bool:
        text = node.value.lower() if isinstance(node, ScalarNode) else None
        if text in (*_YES, "null", "~"):
            return True
        hint = f"write {word.text}: true, or leave it out"
        self._problems.add("flag", where_of(node), f"{word.text} has no value", hint)
        return False

    def _until(self, word: Name, node: Node) -> Iterator[Clause]:
        for item in (
            self._nodes.entries(node, "until") if isinstance(node, SequenceNode) else [node]
        ):
            text = self._nodes.text(item)
            if text is None:
                continue
            read = self._syntax.until(strip_of(item))
            if read is not None:
                yield Until(Name("until", text.where), *read)

    def _handler(self, node: Node) -> Iterator[Statement]:
        items = self._nodes.items(node, HANDLER_KEYS, "a handler")
        keys = {key.text: value for key, value in items}
        brought = {elsewhere.HANDLER.get(key.value) for key, _ in node.value} if items else ()
        for missing in (k for k in ("when", "do") if items and k not in {*keys, *brought}):
            hint = "write {when: battery < 11 V, do: up}"
            self._problems.add("missing-word", where_of(node), f"a handler needs {missing}", hint)
        if "when" not in keys or "do" not in keys:
            return
        target, text = self._nodes.name(keys["do"]), self._nodes.text(keys["when"])
        held = self._nodes.amount(keys["held"]) if "held" in keys else None
        if target is None or text is None:
            return
        if text.text in ("uncertain", "timeout"):
            if held is not None:
                message = f"{text.text} has no held: what follows it does so at once"
                self._problems.add("unknown-word", held.where, message, "leave held out")
            yield On(text.text, target, where_of(node))
            return
        guard = self._syntax.guard(strip_of(keys["when"]))
        if guard is None:
            return
        if held is not None and guard.held is not None:
            message = "held appears twice"
            self._problems.add("twice", held.where, message, "keep one of them")
        elif held is not None:
            guard = type(guard)(guard.expression, held)
        yield On(guard, target, where_of(node))

    # --- values -------------------------------------------------------------------------------

    def _place(self, node: Node) -> PlaceText | None:
        if isinstance(node, ScalarNode):
            return self._syntax.place(strip_of(node))
        if isinstance(node, SequenceNode):
            self._list_of_coordinates(node)
            return None
        keys = {k.text: v for k, v in self._nodes.items(node, None, "a place")}
        for one, other in (("latitude", "longitude"), ("north", "east")):
            if set(keys) == {one, other}:
                first, second = self._nodes.amount(keys[one]), self._nodes.amount(keys[other])
                if first is None or second is None:
                    return None
                return (Offset if one == "north" else Coordinates)(first, second)
        if isinstance(node, MappingNode):
            given = {elsewhere.PLACE.get(key, key): value for key, value in keys.items()}
            self._problems.add("place", where_of(node), "this is no place", _place_hint(given))
        return None

    def _list_of_coordinates(self, node: SequenceNode) -> None:
        """Refuse coordinates as a list: it does not show which number is the latitude."""
        named = dict(zip(("latitude", "longitude"), node.value, strict=False))
        hint = _place_hint(named if len(node.value) == 2 else {})
        self._problems.add("place", where_of(node), "a list is no place: name its numbers", hint)


def _place_hint(given: Mapping[str, Node]) -> str:
    """A hint how to write a place, with the given numbers if they make one."""
    for pair in (("latitude", "longitude"), ("north", "east")):
        values = [given[key].value for key in pair if isinstance(given.get(key), ScalarNode)]
        if len(values) == len(given) == 2:
            return f"write {{{pair[0]}: {values[0]:.20}, {pair[1]}: {values[1]:.20}}}"
    return "write home, {north: 10 m, east: 20 m} or {latitude: 30.28, longitude: 120.15}"
