"""Turn amounts, places and guards as written into SI values: parameters, units, ranges.

Errors go to the problems; a default value replaces the wrong one, so that reading continues.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Collection, Iterator, Mapping

from mission.authoring.language.clauses import (
    Amount,
    AreaText,
    AtHome,
    BackText,
    ComparisonText,
    Coordinates,
    ExpressionText,
    GuardText,
    Here,
    Name,
    Named,
    Negation,
    Offset,
    PlaceText,
    Several,
    TrendText,
)
from mission.authoring.language.words import WINDOWS, NamedValue
from mission.engine.variables import VARIABLES, Variable
from mission.model import (
    HOME,
    And,
    Area,
    Back,
    Comparison,
    Expression,
    Guard,
    Local,
    Not,
    Or,
    Place,
    Position,
    Trend,
    Where,
)
from mission.model.diagnostics import Diagnostics
from mission.model.extent import CORNERS
from mission.model.likeness import suggestion
from mission.model.shipped import load_vehicle
from mission.model.units import UNITS, UnitError, quantity, range_text
from mission.model.vehicle import Vehicle, VehicleError

NamedPair = tuple[str, float]

_SHORTEST = 0.1  # s, the shortest time of a leg; no clock of the vehicle is finer
_FAR = 20_000.0  # m from home; no mission goes farther


class Values:
    """Reads values for one file.

    ``named``: the name of the mission's vehicle. ``flown``: the vehicle that is to fly it, which
    defines the readings that guards may use and the speed of each gear; None: the shipped vehicle
    ``named``.
    """

    def __init__(
        self,
        problems: Diagnostics,
        parameters: Mapping[str, Amount],
        named: str,
        flown: Vehicle | None = None,
    ) -> None:
        self.problems = problems
        self._parameters = parameters
        self._named, self._flown = named, flown

    @functools.cached_property
    def vehicle(self) -> Vehicle | VehicleError:
        if self._flown is not None:
            return self._flown
        try:
            return load_vehicle(self._named)
        except VehicleError as error:
            return error

    @property
    def _readings(self) -> Collection[str]:
        """The readings that the vehicle file names, beside the variables."""
        vehicle = self.vehicle
        return () if isinstance(vehicle, VehicleError) else vehicle.readings

    def number(
        self, amount: Amount, unit: str, low: float, high: float, above: bool = False
    ) -> float:
        """The amount in SI, NaN if it is wrong. ``low``..``high`` are in ``unit``; ``above``: the
        value must be above ``low``."""
        value, written = self._si(amount, unit)
        if math.isnan(value):
            return value
        factor = UNITS[unit].factor if unit else 1.0
        bare = value / factor
        slack = 1e-9 * abs(bare)  # for the rounding when another unit is converted
        if bare < low - slack or bare > high + slack or (above and bare <= low):
            message = f"{written} is out of range"
            hint = range_text(low, high, unit, above)
            self.problems.add("range", amount.where, message, hint)
            return math.nan
        return value

    def named(self, statement: Named, rows: Mapping[str, NamedValue]) -> Iterator[NamedPair]:
        """Yield names with values; a name must be in ``rows`` and appear once."""
        seen: set[str] = set()
        for name, amount in statement.items:
            row = rows.get(name.text)
            if row is None:
                hint = suggestion(name.text, list(rows), statement.word)
                message = f"{statement.word} has no {name.text!r}"
                self.problems.add("unknown-word", name.where, message, hint)
            elif name.text in seen:
                message = f"{name.text} appears twice"
                self.problems.add("twice", name.where, message, "keep one of them")
            else:
                seen.add(name.text)
                yield row.name, self.number(amount, row.unit, row.low, row.high, row.above)

    def whole(self, amount: Amount, low: int, high: int, what: str) -> int:
        """A whole number without a unit; ``low`` if the amount is wrong."""
        value, written = self._si(amount, "")
        if math.isnan(value):
            return low
        if value != int(value):
            message = f"{written}: {what} is a whole number"
            self.problems.add("whole", amount.where, message, f"write {max(low, round(value))}")
        elif not low <= value <= high:
            hint = f"{what} goes from {low} to {high}"
            self.problems.add("range", amount.where, f"{written} is out of range", hint)
        else:
            return int(value)
        return low

    def bare(self, amount: Amount, what: str, positive: bool = False) -> float:
        """A number whose unit the vehicle file defines; NaN if the amount is wrong."""
        given = self._parameters.get(amount.text, amount) if amount.is_name else amount
        if given.unit:
            message = f"{what} takes a bare number, not one in {given.unit}"
            hint = f"write {given.text}; the vehicle file says the unit"
            self.problems.add("unit", amount.where, message, hint)
            return math.nan
        return self.number(amount, "", 0.0 if positive else -1e6, 1e6, above=positive)

    def seconds(self, amount: Amount, zero: bool = False) -> float:
        return self.number(amount, "s", 0.0 if zero else _SHORTEST, 1e6)

    def _si(self, amount: Amount, unit: str) -> tuple[float, str]:
        """The value in SI (NaN if it cannot be read), and the text as written."""
        given = amount
        if amount.is_name:
            found = self._parameters.get(amount.text)
            if found is None:
                hint = suggestion(amount.text, list(self._parameters), "parameters")
                message = f"{amount.text!r} is neither a number nor a parameter"
                hint = hint or f"write a number{f' of {unit}' if unit else ''}"
                self.problems.add("unknown-parameter", amount.where, message, hint)
                return math.nan, amount.text
            given = found
        written = f"{given.text} {given.unit}".strip()
        shown = f"{amount.text} ({written})" if amount.is_name else written
        try:
            value = quantity(written, unit)
        except UnitError as error:
            rule = "unit" if given.unit else "number"
            message = f"{shown}: the unit does not fit" if given.unit else f"{shown} is no number"
            self.problems.add(rule, amount.where, message, str(error))
            return math.nan, shown
        if given.unit == "rad":  # texts are in degrees: round to a value that they can express
            value = math.radians(math.degrees(value))
        return value + 0.0, shown

    # --- places -----------------------------------------------------------------------------

    def position(self, place: Coordinates) -> Position:
        latitude = self._degrees(place.latitude, 90, "latitude")
        return Position(latitude, self._degrees(place.longitude, 180, "longitude"))

    def _degrees(self, amount: Amount, limit: int, what: str) -> float:
        value = math.nan if amount.is_name else float(amount.text)
        if amount.unit not in ("", "deg") or math.isnan(value):
            hint = f"write the {what} in degrees, a bare number"
            self.problems.add("position", amount.where, f"{amount.text!r} is no {what}", hint)
            return 0.0
        if not -limit <= value <= limit:
            hint = f"a {what} goes from -{limit} to {limit}; latitude stands first"
            self.problems.add("position", amount.where, f"{amount.text} is no {what}", hint)
            return 0.0
        return value + 0.0

    def place(self, place: PlaceText, here: bool = False) -> Place | None:
        """A place of the model. None means the place where the leg is entered, which is allowed
        only with ``here``."""
        match place:
            case AtHome():
                return HOME
            case Here(where):
                if not here:
                    hint = "home, north .. east .., or latitude longitude"
                    self.problems.add("here", where, "the leg is here already", hint)
                return None
            case Coordinates():
                return self.position(place)
            case Offset(north, east):
                metres = [self.number(a, "m", -_FAR, _FAR) for a in (north, east)]
                return Local(metres[0], metres[1])

    def area(self, text: AreaText) -> Area:
        """An area; its depths must be in order. The check later judges whether its corners make a
        polygon, since that needs home."""
        corners = tuple(self.place(corner) or HOME for corner in text.corners)
        if len(corners) > CORNERS.most:
            hint = "make two areas of it"
            self.problems.add("too-long", text.name.where, CORNERS.exceeded, hint)
        top, bottom = 0.0, math.inf
        if text.between is not None:
            top, bottom = (self.number(a, "m", 0.0, 11000.0) for a in text.between)
            if top >= bottom:
                hint = "write between 4 and 12: the shallower depth first"
                message = f"{text.name.text} lies between no depths"
                self.problems.add("upside-down", text.name.where, message, hint)
        return Area(text.name.text, text.out, corners, top, bottom, text.where)

    # --- guards -----------------------------------------------------------------------------

    def guard(self, text: GuardText) -> Guard:
        held = 0.0 if text.held is None else self.seconds(text.held, zero=True)
        return Guard(self.expression(text.expression), held)

    def expression(self, text: ExpressionText) -> Expression:
        match text:
            case ComparisonText():
                return self._comparison(text)
            case TrendText():
                return self._trend(text)
            case BackText():
                return self._back(text)
            case Negation(operand):
                return Not(self.expression(operand))
            case Several(every, operands):
                kind: type[And] | type[Or] = And if every else Or
                flat: list[Expression] = []
                for read in map(self.expression, operands):
                    flat.extend(read.operands if isinstance(read, kind) else [read])
                return kind(tuple(flat))

    def _comparison(self, text: ComparisonText) -> Comparison:
        row = VARIABLES.get(text.variable.text)
        bound, sure = 0.0, None
        if row is not None:
            bound = self._bound(row, text.bound)
        elif text.variable.text in self._readings:
            bound = self.bare(text.bound, text.variable.text)
        else:
            self._unknown_variable(text.variable)
        if text.sure is not None:
            sure = self._share(text.sure)
        return Comparison(text.variable.text, text.operator, bound, sure, text.where)

    def _trend(self, text: TrendText) -> Trend:
        name = text.variable
        self._has_extremes(name)
        amount, window, of_depth = self._difference(name, text.amount), math.inf, False
        if text.window is not None:
            window, of_depth = self._reach(text.window)
        if of_depth and name.text == "depth":
            message = f"the depth {text.moves} by all of the way within which it is asked for"
            hint = f"write within 20 s, or {name.text} {text.moves} .. alone: since the leg began"
            self.problems.add("no-trend", text.window.where, message, hint)  # type: ignore[union-attr]
        return Trend(name.text, text.moves == "rises", amount, window, of_depth, name.where)

    def _back(self, text: BackText) -> Back:
        row = VARIABLES.get(text.variable.text)
        if row is not None and row.timed:
            hint = "write depth, heading, or the reading itself"
            self.problems.add("no-trend", text.variable.where, f"{row.name} never comes back", hint)
        self._has_extremes(text.peak)
        if text.peak.text not in VARIABLES and text.peak.text not in self._readings:
            self._unknown_variable(text.peak)
        within = self._difference(text.variable, text.within)
        where = text.variable.where
        return Back(text.variable.text, text.extreme == "highest", text.peak.text, within, where)

    def _has_extremes(self, name: Name) -> None:
        """Refuse a variable without a peak: an angle that goes round, or a time that only grows."""
        row = VARIABLES.get(name.text)
        if row is not None and (row.circular or row.timed):
            message = f"{row.name} {'goes round' if row.circular else 'only grows'}: it has no peak"
            hint = f"compare it, as in {row.name} > 60"
            self.problems.add("no-trend", name.where, message, hint)

    def _difference(self, name: Name, amount: Amount) -> float:
        """A difference between two values of a variable; it must be above 0."""
        row = VARIABLES.get(name.text)
        if row is not None:
            most = 180.0 if row.unit == "deg" else 1e6
            return self.number(amount, row.unit, 0.0, most, above=True)
        if name.text in self._readings:
            return self.bare(amount, name.text, positive=True)
        self._unknown_variable(name)
        return math.nan

    def _reach(self, amount: Amount) -> tuple[float, bool]:
        """The window of a trend, and whether it is in m of depth instead of s."""
        given = self._parameters.get(amount.text, amount) if amount.is_name else amount
        unit = UNITS.get(given.unit)
        row = WINDOWS.get(unit.si) if unit is not None else None
        if row is None and not given.is_name:
            message = f"within {amount.text}: of what?"
            hint = "write within 20 s, or within 5 m: of depth"
            self.problems.add("unit", amount.where, message, hint)
            return math.nan, False
        row = row or WINDOWS["s"]
        return self.number(amount, row.unit, row.low, row.high), row.unit == "m"

    def _bound(self, row: Variable, amount: Amount) -> float:
        if row.unit == "V" and amount.unit == "%":
            hint = f"write the volts of your battery at that charge, for instance {row.name} < 11"
            message = f"{row.name} is told in V, not as a share"
            self.problems.add("unit", amount.where, message, hint)
            return math.nan
        low, high = (0.0, 360.0) if row.circular else (-1e6, 1e7)
        return self.number(amount, row.unit, low, high)

    def _unknown_variable(self, name: Name) -> None:
        hint = suggestion(name.text, [*VARIABLES, *self._readings], "variables")
        self.problems.add("unknown-variable", name.where, f"unknown variable {name.text!r}", hint)

    def _share(self, amount: Amount) -> float:
        share, written = self._si(amount, "")
        if share > 1 and not amount.unit:
            self.problems.add("sure", amount.where, f"sure {written}: a share", f"write {written}%")
        elif not 0 < share < 1 and not math.isnan(share):
            hint = "a share above 0 % and below 100 %, for instance 95%"
            self.problems.add("sure", amount.where, f"sure {written} can never be known", hint)
        return share


def whole_place(place: PlaceText) -> Where:
    """Where a place stands in the text, for messages."""
    match place:
        case AtHome(where) | Here(where):
            return where
        case Coordinates(first, _) | Offset(first, _):
            return first.where
