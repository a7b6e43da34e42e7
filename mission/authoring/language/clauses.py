"""The statements and clauses that both readers deliver to the assembly, with their text positions.

Values are as written (``Amount``). ``mission.authoring.language.values`` resolves parameters, units
and ranges, since it knows the unit that each place needs.
"""

from __future__ import annotations

from dataclasses import dataclass

from mission.model import Where


@dataclass(frozen=True, slots=True)
class Amount:
    """A number with or without a unit, or the name of a parameter."""

    text: str
    unit: str
    where: Where
    is_name: bool = False


@dataclass(frozen=True, slots=True)
class Name:
    text: str
    where: Where


# --- places -------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class AtHome:
    where: Where


@dataclass(frozen=True, slots=True)
class Here:
    where: Where


@dataclass(frozen=True, slots=True)
class Coordinates:
    latitude: Amount
    longitude: Amount


@dataclass(frozen=True, slots=True)
class Offset:
    north: Amount
    east: Amount


PlaceText = AtHome | Here | Coordinates | Offset

# --- guards -------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ComparisonText:
    variable: Name
    operator: str
    bound: Amount
    sure: Amount | None
    where: Where


@dataclass(frozen=True, slots=True)
class TrendText:
    """A trend. ``moves``: falls or rises; ``window`` None: since the leg began."""

    variable: Name
    moves: str
    amount: Amount
    window: Amount | None


@dataclass(frozen=True, slots=True)
class BackText:
    """A return to a peak. ``extreme``: highest or lowest value of the variable ``peak``."""

    variable: Name
    extreme: str
    peak: Name
    within: Amount


@dataclass(frozen=True, slots=True)
class Negation:
    operand: ExpressionText


@dataclass(frozen=True, slots=True)
class Several:
    """Guards joined by ``and`` (``every``) or by ``or``."""

    every: bool
    operands: tuple[ExpressionText, ...]


ExpressionText = ComparisonText | TrendText | BackText | Negation | Several


@dataclass(frozen=True, slots=True)
class GuardText:
    expression: ExpressionText
    held: Amount | None


# --- clauses of a leg -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Wire:
    """A ZA word, as written."""

    word: Name


@dataclass(frozen=True, slots=True)
class Value:
    """A word with one amount or none: a setting, a measure, a count, for, timeout, wait, hold,
    surface, stop."""

    word: Name
    amount: Amount | None = None


@dataclass(frozen=True, slots=True)
class Guarded:
    """A depth with a least altitude, or the reverse: depth 8 never below altitude 3."""

    held: Value
    least: Value


@dataclass(frozen=True, slots=True)
class Places:
    """A word with places: one for goto, none or one for loiter, any number for follow."""

    word: Name
    places: tuple[PlaceText, ...]


@dataclass(frozen=True, slots=True)
class OfArea:
    """A word with the name of an area of the mission, whose corners are its places."""

    word: Name
    area: Name


@dataclass(frozen=True, slots=True)
class OfFile:
    """A word with a file of places; the path is relative to the mission's folder."""

    word: Name
    path: Name


@dataclass(frozen=True, slots=True)
class Chosen:
    """A word with one of its allowed values: side port."""

    word: Name
    choice: Name


@dataclass(frozen=True, slots=True)
class Until:
    """``guard`` None: a position fix."""

    word: Name
    guard: GuardText | None
    target: Name | None


@dataclass(frozen=True, slots=True)
class Else:
    word: Name
    target: Name


@dataclass(frozen=True, slots=True)
class OutputText:
    """An output of the vehicle file and its value."""

    word: Name
    name: Name
    amount: Amount


@dataclass(frozen=True, slots=True)
class Named:
    """safety, assume, achieve: names with amounts."""

    word: str
    items: tuple[tuple[Name, Amount], ...]
    where: Where


Clause = (
    Wire | Value | Guarded | Places | OfArea | OfFile | Chosen | Until | Else | OutputText | Named
)

# --- the other statements -------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class MissionHead:
    name: Name
    vehicle: Name | None
    total: Name | None  # sum, 8 hex digits
    where: Where


@dataclass(frozen=True, slots=True)
class HomeAt:
    place: Coordinates
    where: Where


@dataclass(frozen=True, slots=True)
class AreaText:
    """keep in or keep out; ``between``: two depths, None for all depths."""

    name: Name
    out: bool
    corners: tuple[PlaceText, ...]
    between: tuple[Amount, Amount] | None
    where: Where


@dataclass(frozen=True, slots=True)
class Parameter:
    name: Name
    amount: Amount
    where: Where


@dataclass(frozen=True, slots=True)
class WithoutFix:
    where: Where


@dataclass(frozen=True, slots=True)
class Opening:
    """The begin of a group; ``repeat`` None: once."""

    name: Name
    repeat: Amount | None
    where: Where


@dataclass(frozen=True, slots=True)
class End:
    where: Where


@dataclass(frozen=True, slots=True)
class On:
    """A handler; ``when``: a guard, or the word uncertain or timeout."""

    when: GuardText | str
    target: Name
    where: Where


@dataclass(frozen=True, slots=True)
class LegText:
    name: Name | None
    clauses: tuple[Clause, ...]
    where: Where


Header = AreaText | MissionHead | HomeAt | Named | Parameter | WithoutFix
Statement = Header | Opening | End | On | LegText
