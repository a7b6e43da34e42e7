"""Make an edit on the map in the text: change the numbers of a place, or a line, and nothing else.

    move      the two numbers of a place
    add       a place to a row of places; a leg; an area
    remove    a place from its row; the leg whose only place it is

Each result is read and verified before it is returned.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from mission.authoring.editing import numbers, writing
from mission.authoring.editing.handles import Handle, Lines, amounts_of, frame_of, handles
from mission.authoring.editing.layout import Block, EditError, Layout, LineLayout, Span, YamlLayout
from mission.authoring.language import Draft, MissionErrors, draft, is_yaml
from mission.authoring.language.clauses import Coordinates, LegText, Name, Value
from mission.model import Where
from mission.model.units import UNITS, UnitError
from mission.model.yaml_tree import YamlFault
from mission.navigation.geodesy import LocalFrame

Position = tuple[float, float]  # degrees
Change = tuple[Span, str]

_FAR = 20_000.0  # m from home
_CLOSE = 0.5  # m, greatest distance of a written place from the wanted one, in any unit
_UNUSUAL = "the text says it in a way that cannot be edited here: write it there"
_LEAST = {"corner": 3, "place": 2}  # places of a row


def move(text: str, source: str, index: int, to: Position) -> str:
    """The text with handle number ``index`` moved to ``to``. Raises EditError."""
    read = _read(text, source)
    known = handles(read, text)
    one = _chosen(known, index)
    made = _applied(text, _moved(one, Lines(text), to, frame_of(read)))
    if one.kind == "home":
        _verify(made, source, [to if h.kind == "home" else None for h in known])
    else:
        _verify(made, source, [to if i == index else h.position for i, h in enumerate(known)])
    return made


def remove(text: str, source: str, index: int) -> str:
    read = _read(text, source)
    known = handles(read, text)
    one = _chosen(known, index)
    if one.kind == "home":
        raise EditError("home cannot be removed: metres are counted from it")
    layout = _layout(text, source)
    gone = [i for i, h in enumerate(known) if h.statement is one.statement]
    if one.count > 1:
        made, gone = _applied(text, [_out_of_row(one, layout)]), [index]
    else:
        made = _applied(text, [_lines_out(layout.statement(_where(one)), text)])
    _verify(made, source, [h.position for i, h in enumerate(known) if i not in gone])
    return made


def add(text: str, source: str, what: str, to: Position, after: int | None = None) -> str:
    """The text with an added place, leg or area. ``what``: point (in the row of ``after``), or a
    key of ``writing.LEGS`` or ``AREAS``. ``after``: the handle whose leg a new leg follows; None:
    before the last leg. Raises EditError."""
    read = _read(text, source)
    if len(read.problems):
        first = read.problems.found()[0]
        raise EditError(f"mend line {first.where.line} first: {first.message}")
    known, layout = handles(read, text), _layout(text, source)
    one = None if after is None else _chosen(known, after)
    if what == "point" and (one is None or one.count == 1):
        raise EditError("choose a place in a row of places, or a corner of an area, first")
    if what == "point" and one is not None:
        ways = [_into_row(one, layout, to, frame_of(read))]
    elif what in writing.AREAS:
        ways = [writing.area(read, layout, what, to)]
    elif what in writing.LEGS:
        ways = [_leg(read, layout, what, to, one, like) for like in _likes(what, one, known)]
    else:
        raise EditError(f"{what!r} is none of point, {', '.join((*writing.LEGS, *writing.AREAS))}")
    for way in ways:
        made = _applied(text, [way])
        if _is_added(made, source, [h.position for h in known]):
            return made
    raise EditError(_UNUSUAL)


def _read(text: str, source: str) -> Draft:
    try:
        return draft(text, source)
    except MissionErrors as error:
        raise EditError(error.diagnostics[0].brief) from None


def _chosen(known: Sequence[Handle], index: int) -> Handle:
    if not 0 <= index < len(known):
        raise EditError("the text has no such place any more")
    if known[index].fixed:
        raise EditError(known[index].fixed)
    return known[index]


def _layout(text: str, source: str) -> Layout:
    try:
        return YamlLayout(text) if is_yaml(text, source) else LineLayout(text)
    except YamlFault as fault:
        raise EditError(f"mend line {fault.line} first: {fault.why}") from None


def _where(one: Handle) -> Where:
    """The position of the leg's name, or of the place itself."""
    statement = one.statement
    if isinstance(statement, LegText) and statement.name is not None:
        return statement.name.where
    return one.numbers[0].where


# --- changes --------------------------------------------------------------------------------------


def _applied(text: str, changes: Sequence[Change]) -> str:
    for span, new in sorted(changes, key=lambda change: change[0].begin, reverse=True):
        text = text[: span.begin] + new + text[span.end :]
    return text


def _moved(one: Handle, lines: Lines, to: Position, frame: LocalFrame | None) -> list[Change]:
    changes = []
    for amount, new in zip(one.numbers, figures(one, to, frame), strict=True):
        begin = lines.of(amount)
        assert begin is not None  # a handle has both
        changes.append((Span(begin, begin + len(amount.text)), new))
    return changes


def figures(one: Handle, to: Position, frame: LocalFrame | None) -> tuple[str, str]:
    """The two numbers of ``one`` as text, if it were at ``to``. Raises EditError."""
    first, second = amounts_of(one.place)
    if not (abs(to[0]) <= 90.0 and abs(to[1]) <= 180.0):
        raise EditError("a latitude goes from -90 to 90, a longitude from -180 to 180")
    if isinstance(one.place, Coordinates):
        return numbers.degrees(first, to[0]), numbers.degrees(second, to[1])
    if frame is None:
        raise EditError("its place is in metres from a home that the text does not name")
    north, east = frame.to_local(math.radians(to[0]), math.radians(to[1]))
    if max(abs(north), abs(east)) > _FAR:
        raise EditError(f"it is more than {_FAR / 1000:.0f} km from home")
    try:
        return numbers.metres(first, north), numbers.metres(second, east)
    except UnitError as error:
        raise EditError(str(error)) from None


def _lines_out(block: Block, text: str) -> Change:
    """Remove a block, with the end of its last line."""
    end = text.find("\n", block.lines.end)
    return Span(block.lines.begin, len(text) if end < 0 else end + 1), ""


def _out_of_row(one: Handle, layout: Layout) -> Change:
    least = _LEAST[one.kind]
    if one.count <= least:
        what = "an area has at least 3 corners" if one.kind == "corner" else "a row has 2 places"
        raise EditError(f"{what}: remove it in the text")
    spans, alone = layout.places(one)
    here = spans[one.at]
    if alone:
        return _whole_lines(layout, here), ""
    if one.at:
        return Span(spans[one.at - 1].end, here.end), ""
    return Span(here.begin, spans[1].begin), ""


def _whole_lines(layout: Layout, span: Span) -> Span:
    text = layout.text
    end = text.find("\n", span.end)
    return Span(text.rfind("\n", 0, span.begin) + 1, len(text) if end < 0 else end + 1)


def _into_row(one: Handle, layout: Layout, to: Position, frame: LocalFrame | None) -> Change:
    """Insert a copy of the place with other numbers, behind it."""
    spans, alone = layout.places(one)
    span = spans[one.at]
    copy = _copied(layout.text, span, _moved(one, layout.lines, to, frame))
    if not alone:
        return Span(span.end, span.end), f", {copy}"
    lines = _whole_lines(layout, span)
    lead = layout.text[lines.begin : span.begin]
    end = layout.lines.end(layout.text.count("\n", 0, span.end) + 1)
    return Span(end, end), f"{_break(layout.text)}{lead}{copy}"


def _copied(text: str, span: Span, changes: Sequence[Change]) -> str:
    inner = [(Span(c.begin - span.begin, c.end - span.begin), new) for c, new in changes]
    return _applied(text[span.begin : span.end], inner)


def _break(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"


# --- legs -----------------------------------------------------------------------------------------


def _leg(
    read: Draft, layout: Layout, what: str, to: Position, one: Handle | None, like: Handle | None
) -> Change:
    """Insert a leg behind that of ``one``, or before the last: a copy of ``like`` with its depth,
    gear and layout, or a new leg if ``like`` is None."""
    fresh = writing.fresh_name(read, what)
    seconds = writing.timeout(read, what, to, one or like)
    code = (
        writing.leg(read, layout, what, fresh, to, seconds)
        if like is None
        else _likeness(like, layout, fresh, to, frame_of(read), seconds)
    )
    behind = one is not None and isinstance(one.statement, LegText)
    block = layout.statement(_where(one) if one and behind else writing.last_leg(read))
    lead = layout.text[block.lines.begin : block.code.begin]
    if behind:
        return Span(block.lines.end, block.lines.end), f"{_break(layout.text)}{lead}{code}"
    begin = block.lines.begin
    return Span(begin, begin), f"{lead}{code}{_break(layout.text)}"


def _likes(what: str, one: Handle | None, known: Sequence[Handle]) -> tuple[Handle | None, ...]:
    """Legs to try as the pattern of a new one: the nearest one before of that kind, with a name and
    one place, or else the first; then None, if a copy does not work (its exits may name targets of
    another group)."""
    legs = [h for h in known if h.word == writing.LEGS[what] and h.count == 1 and not h.fixed]
    legs = [h for h in legs if isinstance(h.statement, LegText) and h.statement.name is not None]
    before = [h for h in legs if one is not None and _line(h) <= _line(one)]
    return (*before[-1:], None) if before else (*legs[:1], None)


def _line(one: Handle) -> int:
    return one.numbers[0].where.line


def _likeness(
    like: Handle, layout: Layout, fresh: str, to: Position, frame: LocalFrame | None,
    seconds: float,
) -> str:  # fmt: skip
    leg = like.statement
    assert isinstance(leg, LegText)
    assert isinstance(leg.name, Name)
    block = layout.statement(leg.name.where)
    begin = layout.lines.offset(leg.name.where.line, leg.name.where.column)
    assert begin is not None
    changes = [(Span(begin, begin + len(leg.name.text)), fresh)]
    changes += _moved(like, layout.lines, to, frame)
    for clause in leg.clauses:
        if isinstance(clause, Value) and clause.word.text == "timeout":
            changes += _longer(clause, layout.lines, seconds)
    return _copied(layout.text, block.code, changes)


def _longer(clause: Value, lines: Lines, seconds: float) -> list[Change]:
    """Make a timeout longer; one that is long enough already stays as written."""
    amount = clause.amount
    begin = None if amount is None or amount.is_name else lines.of(amount)
    if amount is None or begin is None:
        return []
    unit = UNITS[amount.unit or "s"].factor
    if float(amount.text) * unit >= seconds:
        return []
    return [(Span(begin, begin + len(amount.text)), numbers.plain(math.ceil(seconds / unit), 0))]


# --- verify the new text -------------------------------------------------------------------------


def _verify(made: str, source: str, wanted: Sequence[Position | None]) -> None:
    found = [handle.position for handle in handles(_read(made, source), made)]
    if len(found) != len(wanted) or not all(map(_near, found, wanted)):
        raise EditError(_UNUSUAL)


def _is_added(made: str, source: str, before: Sequence[Position | None]) -> bool:
    """Whether the new text has no errors, all places from before, and at least one more."""
    read = _read(made, source)
    left = [handle.position for handle in handles(read, made)]
    for place in before:
        same = next((i for i, there in enumerate(left) if _near(there, place)), None)
        if same is not None:
            del left[same]
    return not len(read.problems) and bool(left)


def _near(one: Position | None, other: Position | None) -> bool:
    """Whether two positions are within ``_CLOSE``; ``other`` None: any position."""
    if one is None or other is None:
        return other is None
    north = math.radians(one[0] - other[0]) * 6.4e6
    turn = math.remainder(one[1] - other[1], 360.0)
    return math.hypot(north, math.radians(turn) * 6.4e6 * math.cos(math.radians(one[0]))) < _CLOSE
