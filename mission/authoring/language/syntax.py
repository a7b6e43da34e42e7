"""Parse one statement (or leg, guard, place, until) into clauses, with lark.

Lark's LALR tables are made once, on first use. A text that does not fit the grammar gives one
Diagnostic, worded by ``complaints``. A ``Strip`` maps offsets in the text to lines and columns.

What does not live here: what the clauses mean (legs.py), how statements make a mission
(assembly.py).
"""

from __future__ import annotations

import operator
import re
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lark import Lark, Token, Tree, UnexpectedInput

from mission.authoring.language import complaints
from mission.authoring.language.clauses import (
    Amount,
    AreaText,
    AtHome,
    BackText,
    Chosen,
    Clause,
    ComparisonText,
    Coordinates,
    Else,
    End,
    ExpressionText,
    Guarded,
    GuardText,
    Here,
    HomeAt,
    LegText,
    MissionHead,
    Name,
    Named,
    Negation,
    OfArea,
    OfFile,
    Offset,
    On,
    Opening,
    OutputText,
    Parameter,
    Places,
    PlaceText,
    Several,
    Statement,
    TrendText,
    Until,
    Value,
    Wire,
    WithoutFix,
)
from mission.authoring.language.words import (
    AIMS,
    ASSUMPTIONS,
    LIMITS,
    SETTINGS,
    choices,
    kinds,
    measures,
    spots,
)
from mission.legs import LEGS
from mission.legs.words import Shape
from mission.model import Where
from mission.model.diagnostics import Diagnostics
from mission.model.extent import DEEPEST_GUARD
from mission.model.tables import derived
from mission.model.units import UNITS

WITHIN = "within"
_NESTING = re.compile(r"[()]|\b(?:not|and|or|until|on)\b")


# The terminals for the words of kinds, by what follows them.
_SHAPED = {
    Shape.NOTHING: "BARE",
    Shape.TIME: "TIMED",
    Shape.COUNT: "COUNTED",
    Shape.PLACE: "PLACED",
    Shape.ABOUT: "ABOUT",
    Shape.PLACES: "ALONG",
}


@dataclass(frozen=True, slots=True)
class Strip:
    """A text and its place in the file: each part begins at an offset, and stands at line and
    column."""

    text: str
    parts: tuple[tuple[int, int, int], ...]  # offset, line, column; ascending

    def where(self, offset: int, length: int) -> Where:
        part = bisect_right(self.parts, offset, key=operator.itemgetter(0)) - 1
        start, line, column = self.parts[max(0, part)]
        return Where(line, column + offset - start, length)

    @classmethod
    def at(cls, text: str, line: int, column: int) -> Strip:
        return cls(text, ((0, line, column),))


def grammar() -> str:
    """The grammar of the parser: grammar.lark with the terminals from the word tables."""
    text = (Path(__file__).parent / "grammar.lark").read_text(encoding="utf-8")
    terminals = {
        "SETTING": SETTINGS,
        **{_SHAPED[shape]: _of_shape(shape) for shape in Shape},
        "MEASURE": [word for word in measures() if word != WITHIN],  # guards use it, too
        "SPOT": spots(),
        "CHOICE": choices(),
        "CHOSEN": dict.fromkeys(value for row in choices().values() for value in row.values),
        "LIMIT": LIMITS,
        "ASSUMED": ASSUMPTIONS,
        "AIM": AIMS,
    }
    rows = [f"{name}.3: {_any_of(words)}" for name, words in terminals.items()]
    return "\n".join([text, *rows, f"UNIT.3: {_any_of(UNITS)}", ""])


def _of_shape(shape: Shape) -> tuple[str, ...]:
    return tuple(word for word, row in kinds().items() if row.head.shape is shape)


def _any_of(words: Iterable[str]) -> str:
    longest_first = sorted(words, key=lambda word: (-len(word), word))
    alternatives = "|".join(re.escape(word).replace("/", r"\/") for word in longest_first)
    return rf"/(?:{alternatives})(?![A-Za-z0-9_\/%])/"


@derived(LEGS)
def _parser() -> Lark:
    return Lark(
        grammar(),
        parser="lalr",
        lexer="contextual",
        start=["statement", "leg", "guard", "until", "place"],
        maybe_placeholders=True,
    )


class Syntax:
    """Parses pieces of one file; text that does not fit goes to ``problems``."""

    def __init__(self, problems: Diagnostics) -> None:
        self._problems = problems

    def statement(self, strip: Strip) -> Statement | None:
        found: Statement | None = self._read(strip, "statement")
        return found

    def leg(self, strip: Strip) -> LegText | None:
        found: LegText | None = self._read(strip, "leg")
        return found

    def guard(self, strip: Strip) -> GuardText | None:
        found: GuardText | None = self._read(strip, "guard")
        return found

    def until(self, strip: Strip) -> tuple[GuardText | None, Name | None] | None:
        found: tuple[GuardText | None, Name | None] | None = self._read(strip, "until")
        return found

    def place(self, strip: Strip) -> PlaceText | None:
        found: PlaceText | None = self._read(strip, "place")
        return found

    def _read(self, strip: Strip, start: str) -> Any:
        deep = _too_deep(strip.text)
        if deep is not None:
            message = f"the guard is nested too deep: {DEEPEST_GUARD.exceeded}"
            hint = "drop the ones that change nothing"
            self._problems.add("too-deep", strip.where(deep, 1), message, hint)
            return None
        try:
            tree = _parser().parse(strip.text, start=start)
        except UnexpectedInput as error:
            complaint = complaints.explain(strip.text, error)
            where = strip.where(complaint.offset, complaint.length)
            self._problems.add(complaint.code, where, complaint.message, complaint.hint)
            return None
        return _Clauses(strip).made(tree)


def _too_deep(text: str) -> int | None:
    """The offset where a guard exceeds the allowed nesting (readers recurse); None if nowhere."""
    depth, outer = 0, []
    for match in _NESTING.finditer(text):
        if match[0] == "not":
            depth += 1
        elif match[0] == "(":
            outer.append(depth)
            depth += 1
        elif match[0] == ")":
            depth = outer.pop() if outer else 0
        else:
            depth = outer[-1] + 1 if outer else 0
        if depth > DEEPEST_GUARD.most:
            return match.start()
    return None


class _Clauses:
    """Parse tree to clauses; each method is one rule of the grammar.

    Lark's own Transformer does the same, but takes 1.5 times as long for a whole mission.
    """

    def __init__(self, strip: Strip) -> None:
        self._strip = strip
        self._all = strip.where(0, len(strip.text)) if len(strip.parts) == 1 else strip.where(0, 1)

    def made(self, node: Any) -> Any:
        if not isinstance(node, Tree):
            return node
        return getattr(self, node.data)(*[self.made(child) for child in node.children])

    def _where(self, token: Token) -> Where:
        return self._strip.where(token.start_pos or 0, len(token))

    def _name(self, token: Token) -> Name:
        return Name(str(token), self._where(token))

    # statements

    def statement(self, item: Statement) -> Statement:
        return item

    def mission(self, name: Token, vehicle: Token | None, total: Token | None) -> MissionHead:
        given = [self._name(t) if t is not None else None for t in (vehicle, total)]
        return MissionHead(self._name(name), given[0], given[1], self._all)

    def home(self, place: Coordinates) -> HomeAt:
        return HomeAt(place, self._all)

    def safety(self, *items: Any) -> Named:
        return self._named("safety", items)

    def limit(self, name: Token) -> Token:
        return name

    def assume(self, *items: Any) -> Named:
        return self._named("assume", items)

    def achieve(self, *items: Any) -> Named:
        return self._named("achieve", items)

    def _named(self, word: str, items: tuple[Any, ...]) -> Named:
        names = [self._name(token) for token in items[::2]]
        return Named(word, tuple(zip(names, items[1::2], strict=True)), self._all)

    def area(self, keep: Token, label: Token, *rest: Any) -> AreaText:
        *corners, top, bottom = rest
        between = None if top is None else (top, bottom)
        out = keep.type == "KEEP_OUT"
        return AreaText(self._name(label), out, tuple(corners), between, self._all)

    def param(self, name: Token, number: Token, unit: Token | None) -> Parameter:
        return Parameter(self._name(name), self.number(number, unit), self._all)

    def start(self) -> WithoutFix:
        return WithoutFix(self._all)

    def repeat(self, times: Amount, label: Token) -> Opening:
        return Opening(self._name(label), times, self._all)

    def group(self, label: Token) -> Opening:
        return Opening(self._name(label), None, self._all)

    def end(self) -> End:
        return End(self._all)

    def on(self, when: GuardText | Token, target: Token) -> On:
        condition = when if isinstance(when, GuardText) else str(when)
        return On(condition, self._name(target), self._all)

    def leg(self, label: Token | None, *clauses: Clause) -> LegText:
        return LegText(self._name(label) if label else None, clauses, self._all)

    # clauses

    def wire(self, word: Token) -> Wire:
        return Wire(self._name(word))

    def setting(self, word: Token, amount: Amount) -> Value:
        return Value(self._name(word), amount)

    measure = counted = time = setting

    def guarded(self, word: Token, amount: Amount, other: Token, least: Amount) -> Guarded:
        return Guarded(self.setting(word, amount), self.setting(other, least))

    def stop(self, word: Token) -> Value:
        return Value(self._name(word))

    bare = stop

    def timed(self, word: Token, amount: Amount | None) -> Value:
        return Value(self._name(word), amount)

    def placed(self, word: Token, *places: PlaceText | None) -> Places:
        return Places(self._name(word), tuple(p for p in places if p is not None))

    def borrowed(self, word: Token, area: Token) -> OfArea:
        return OfArea(self._name(word), self._name(area))

    def filed(self, word: Token, path: Token) -> OfFile:
        return OfFile(self._name(word), Name(str(path).strip('"'), self._where(path)))

    def chosen(self, word: Token, choice: Token) -> Chosen:
        return Chosen(self._name(word), self._name(choice))

    def until_clause(self, word: Token, until: tuple[GuardText | None, Name | None]) -> Until:
        return Until(self._name(word), *until)

    def otherwise(self, word: Token, target: Token) -> Else:
        return Else(self._name(word), self._name(target))

    def output(self, word: Token, name: Token, amount: Amount) -> OutputText:
        return OutputText(self._name(word), self._name(name), amount)

    # guards

    def until(self, what: GuardText | Token, target: Token | None) -> tuple[Any, Any]:
        guard = what if isinstance(what, GuardText) else None
        return guard, self._name(target) if target is not None else None

    def guard(self, expression: ExpressionText, held: Amount | None) -> GuardText:
        return GuardText(expression, held)

    def either(self, *operands: ExpressionText) -> Several:
        return Several(False, operands)

    def both(self, *operands: ExpressionText) -> Several:
        return Several(True, operands)

    def negation(self, operand: ExpressionText) -> Negation:
        return Negation(operand)

    def comparison(
        self, variable: Token, operator: Token, bound: Amount, sure: Amount | None
    ) -> ComparisonText:
        end = (sure or bound).where
        name = self._name(variable)
        length = end.column + end.length - name.where.column
        whole = Where(name.where.line, name.where.column, length)
        where = whole if end.line == name.where.line else name.where
        return ComparisonText(name, str(operator), bound, sure, where)

    def trend(
        self,
        variable: Token,
        moves: Token,
        amount: Amount,
        within: Token | None,
        window: Amount | None,
    ) -> TrendText:
        return TrendText(self._name(variable), str(moves), amount, window)

    def back(
        self, variable: Token, extreme: Token, peak: Token, within: Token, near: Amount
    ) -> BackText:
        return BackText(self._name(variable), str(extreme), self._name(peak), near)

    # places and amounts

    def at_home(self, word: Token) -> AtHome:
        return AtHome(self._where(word))

    def here(self, word: Token) -> Here:
        return Here(self._where(word))

    def offset(self, north: Amount, east: Amount) -> Offset:
        return Offset(north, east)

    def place(self, inner: PlaceText) -> PlaceText:
        return inner

    def coordinates(self, latitude: Token, longitude: Token) -> Coordinates:
        return Coordinates(self.number(latitude, None), self.number(longitude, None))

    def number(self, number: Token, unit: Token | None) -> Amount:
        start = number.start_pos or 0
        end = (unit if unit is not None else number).end_pos or start
        return Amount(str(number), str(unit or ""), self._strip.where(start, end - start))

    def parameter(self, name: Token) -> Amount:
        return Amount(str(name), "", self._where(name), is_name=True)
