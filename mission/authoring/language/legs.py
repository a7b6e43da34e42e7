"""A leg's clauses -> a Leg or a Set: kinds, settings, axes, what belongs to which kind.

What does not live here: names and groups (assembly.py), what this vehicle can follow
(mission.authoring.compiler.abilities), bounds in time (mission.authoring.check).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mission.authoring.language.clauses import (
    Amount,
    Clause,
    Else,
    Here,
    LegText,
    Name,
    Places,
    Side,
    Until,
    Value,
    Wire,
)
from mission.authoring.language.values import Values, whole_place
from mission.authoring.language.wire import wire_complaint
from mission.authoring.language.words import (
    ATTITUDE,
    FIELD_ORDER,
    KINDS,
    MEASURES,
    SETTINGS,
    SIDES,
    STOP,
    VERTICAL,
    WITHIN,
    ZA,
    KindRow,
    SettingRow,
    Shape,
)
from mission.model import (
    Exit,
    Follow,
    Goto,
    Hold,
    Leg,
    LegKind,
    Loiter,
    Place,
    Rows,
    Set,
    Setting,
    Surface,
    Wait,
    Where,
    Yoyo,
)
from mission.model.extent import PLACES
from mission.model.units import GEARS, compass, number_text
from mission.model.vehicle import VehicleError

_COUNT_MOST = 9999


@dataclass(slots=True)
class _Parts:
    """A leg being read."""

    kind: Name | None = None
    count: int = 0
    places: list[Place | None] = field(default_factory=list)
    settings: list[Setting] = field(default_factory=list)
    measures: dict[str, float] = field(default_factory=dict)
    start: Place | None = None
    side: int = 1
    exits: list[Exit] = field(default_factory=list)
    until_fix: Name | None = None
    times: dict[str, float] = field(default_factory=dict)
    otherwise: str | None = None
    seen: dict[str, Where] = field(default_factory=dict)


class Legs:
    """Builds legs for one file; ``values`` knows the vehicle, the parameters and the problems."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._problems = values.problems

    def build(self, text: LegText) -> Leg | Set:
        """The name is empty where the author gave none."""
        parts = _Parts()
        for clause in text.clauses:
            self._take(parts, clause)
        name = text.name.text if text.name else ""
        word = parts.kind.text if parts.kind else "hold"
        row = KINDS[word]
        self._check_settings(parts, row)
        self._check_measures(parts, row, text.where)
        self._check_times(parts, word, text.where)
        settings = tuple(sorted(parts.settings, key=lambda s: FIELD_ORDER.index(s.word)))
        bounds = (parts.exits, parts.times, parts.otherwise)
        if not name and parts.kind is None and not any(bounds):
            return Set("", settings, text.where)
        return Leg(
            name,
            self._kind(parts, word),
            settings,
            tuple(parts.exits),
            parts.times.get("for", parts.times.get("wait")),
            parts.times.get("timeout"),
            parts.otherwise,
            text.where,
        )

    # --- clauses ----------------------------------------------------------------------------

    def _take(self, parts: _Parts, clause: Clause) -> None:
        match clause:
            case Wire(word):
                parts.settings += self._wire(word)
            case Value(word, amount):
                self._value(parts, word, amount)
            case Places():
                self._places(parts, clause)
            case Side(word, side):
                if self._once(parts, word):
                    parts.side = SIDES[side.text]
            case Until():
                self._until(parts, clause)
            case Else(word, target):
                if self._once(parts, word):
                    parts.otherwise = target.text

    def _once(self, parts: _Parts, word: Name) -> bool:
        if word.text in parts.seen:
            self._problems.add(
                "twice", word.where, f"{word.text} appears twice", "keep one of them"
            )
            return False
        parts.seen[word.text] = word.where
        return True

    def _value(self, parts: _Parts, word: Name, amount: Amount | None) -> None:
        if word.text == STOP:
            parts.settings.append(Setting("surge", 0.0, word.where))
        elif word.text in SETTINGS and amount is not None:
            parts.settings += self._setting(SETTINGS[word.text], amount, word.where)
        elif not self._once(parts, word):
            return
        elif word.text in KINDS:
            self._begin(parts, word)
            if KINDS[word.text].shape is Shape.COUNT and amount is not None:
                parts.count = self._values.whole(amount, 1, _COUNT_MOST, word.text)
            elif amount is not None:
                parts.times["wait"] = self._values.seconds(amount)
        elif word.text in MEASURES and amount is not None:
            row = MEASURES[word.text]
            value = self._values.number(amount, row.unit, row.low, row.high)
            parts.measures[word.text] = value
        elif amount is not None:
            parts.times[word.text] = self._values.seconds(amount)

    def _places(self, parts: _Parts, clause: Places) -> None:
        word = clause.word
        if not self._once(parts, word):
            return
        if word.text == "from":
            parts.start = self._values.place(clause.places[0], here=True)
            return
        self._begin(parts, word)
        if len(clause.places) > PLACES.most:
            hint = "make two legs of it"
            self._problems.add("too-long", word.where, PLACES.exceeded, hint)
            return
        parts.places = [self._values.place(p, here=word.text == "loiter") for p in clause.places]
        if word.text == "follow" and len(clause.places) < 2:
            hint = "write goto, or two places and more with a comma between"
            self._problems.add("one-place", word.where, "follow needs several places", hint)
        self._same_places(clause)

    def _same_places(self, clause: Places) -> None:
        places = [self._values.place(p, here=True) for p in clause.places]
        for before, after, text in zip(places, places[1:], clause.places[1:], strict=False):
            if before == after and not isinstance(text, Here):
                where = whole_place(text)
                self._problems.add("same-place", where, "the same place twice in a row", "drop it")

    def _begin(self, parts: _Parts, word: Name) -> None:
        if parts.kind is not None:
            message = f"one leg does one thing: {parts.kind.text} or {word.text}"
            self._problems.add("two-kinds", word.where, message, "make two legs of it")
        else:
            parts.kind = word

    def _until(self, parts: _Parts, clause: Until) -> None:
        target = clause.target.text if clause.target else None
        if clause.guard is not None:
            guard = self._values.guard(clause.guard)
            parts.exits.append(Exit(guard, target, clause.word.where))
            return
        parts.until_fix = clause.word
        if clause.target is not None:
            hint = "after the fix the next leg begins; put that leg next"
            self._problems.add("fix-target", clause.target.where, "until fix has no target", hint)

    # --- settings ---------------------------------------------------------------------------

    def _setting(self, row: SettingRow, amount: Amount, where: Where) -> list[Setting]:
        if row.gear:
            gear = self._values.whole(amount, int(row.low), int(row.high), row.word)
            return [Setting(row.field, row.sign * gear / GEARS + 0.0, where)]
        if row.word == "heading" and amount.text.startswith("-") and amount.unit in ("", "deg"):
            told = number_text(float(amount.text) % 360)
            hint = f"write heading {told}; the wire's ZAH{amount.text} is heading "
            hint += number_text(-float(amount.text) % 360)
            message = "a compass says 0 to 360"
            self._problems.add("compass", amount.where, message, hint)
            return []
        value = self._values.number(amount, row.unit, row.low, row.high)
        if math.isnan(value):
            return []
        if row.word == "speed":
            return self._speed(value, amount, where)
        if row.field == "heading":
            value = value if value < math.tau else 0.0
        return [Setting(row.field, value, where)]

    def _speed(self, speed: float, amount: Amount, where: Where) -> list[Setting]:
        vehicle = self._values.vehicle
        if isinstance(vehicle, VehicleError):
            hint = "write a gear instead, or mend the vehicle file"
            self._problems.add("vehicle-file", amount.where, str(vehicle), hint)
            return []
        curve = vehicle.speed_by_gear
        if speed > max(curve.y) * (1 + 1e-9):
            message = f"{vehicle.name} cannot go {number_text(speed)} m/s"
            fastest = number_text(max(curve.y))
            gear = math.ceil(curve.inverse(max(curve.y)))
            hint = f"its fastest is {fastest} m/s with gear {gear}"
            self._problems.add("too-fast", amount.where, message, hint)
            return []
        gear = min(range(GEARS + 1), key=lambda g: (abs(curve.at(g) - speed), g))
        if gear == 0 and speed > 0:
            message = f"{number_text(speed)} m/s is nearest to standing still"
            hint = f"gear 1 makes {number_text(curve.at(1))} m/s"
            self._problems.add("too-slow", amount.where, message, hint)
        return [Setting("surge", gear / GEARS, where)]

    def _wire(self, word: Name) -> list[Setting]:
        complaint = wire_complaint(word.text)
        if complaint is not None:
            rule, message, hint = complaint
            self._problems.add(rule, word.where, message, hint)
            return []
        code, digits = word.text[2], word.text[3:]
        if code == ATTITUDE:
            pitch, roll = (Amount(text, "", word.where) for text in digits.split(";"))
            return [
                *self._setting(SETTINGS["pitch"], pitch, word.where),
                *self._setting(SETTINGS["roll"], roll, word.where),
            ]
        row, value = ZA[code], int(digits)
        if row.word == "heading":
            return [Setting("heading", compass(row.sign * value), word.where)]
        setting = SETTINGS[row.word]
        amount = row.sign * setting.sign * value
        scaled = amount / GEARS if setting.gear else float(amount)
        return [Setting(setting.field, scaled + 0.0, word.where)]

    def _check_settings(self, parts: _Parts, row: KindRow) -> None:
        seen: dict[str, Setting] = {}
        for setting in parts.settings:
            if setting.word in row.steers:
                self._steered(setting, row)
            for other in seen.values():
                if _clash(setting.word, other.word):
                    pair = (
                        other.word
                        if other.word == setting.word
                        else f"{other.word}, {setting.word}"
                    )
                    message = f"one leg sets the same axis twice ({pair})"
                    self._problems.add("axis-twice", setting.where, message, "keep one of them")
            seen.setdefault(setting.word, setting)
        surge = seen.get("surge")
        if row.word in ("goto", "follow", "rows", "loiter") and surge and surge.value <= 0:
            message = f"{row.word} never arrives without going ahead"
            self._problems.add("no-way", surge.where, message, "write gear 1 to gear 12")

    def _steered(self, setting: Setting, row: KindRow) -> None:
        if row.word == "wait":
            hint = "write the settings with `for` instead of `wait`, or on a line before it"
            message = "wait keeps what is set"
        elif row.word == "surface":
            message, hint = "surface sets everything itself", "leave it out"
        else:
            message, hint = f"{row.word} sets {setting.word} itself", "leave it out"
        self._problems.add("steered", setting.where, message, hint)

    # --- the kind ---------------------------------------------------------------------------

    def _check_measures(self, parts: _Parts, row: KindRow, where: Where) -> None:
        allowed = (*row.needs, *row.may)
        for word in (*MEASURES, "from", "side"):
            if word in parts.seen and word not in allowed:
                users = [k.word for k in KINDS.values() if word in (*k.needs, *k.may)]
                hint = f"{word} belongs to {', '.join(users)}"
                message = f"{row.word} has no {word}"
                self._problems.add("foreign-word", parts.seen[word], message, hint)
        for word in row.needs:
            if word not in parts.seen:
                place = parts.kind.where if parts.kind else where
                hint = f"add for instance {word} {_example(word)}"
                self._problems.add("missing-word", place, f"{row.word} needs {word}", hint)
        shallow, deep = parts.measures.get("shallow", 0), parts.measures.get("deep", math.inf)
        if shallow >= deep:
            where = parts.seen["shallow"]
            self._problems.add("upside-down", where, "shallow is not above deep", "swap them")

    def _check_times(self, parts: _Parts, word: str, where: Where) -> None:
        if word == "wait":
            if "for" in parts.times:
                hint = "write wait 30s, or hold for 30s"
                self._problems.add(
                    "two-times", parts.seen["for"], "wait has its time already", hint
                )
            elif not parts.times and not parts.exits:
                hint = "write for instance wait 30s"
                self._problems.add("no-time", where, "wait needs a time", hint)
        if parts.until_fix and word != "surface":
            hint = "write surface until fix, or until fix_age < 5"
            message = "until fix belongs to surface"
            self._problems.add("fix-leg", parts.until_fix.where, message, hint)

    def _kind(self, parts: _Parts, word: str) -> LegKind:
        place = parts.places[0] if parts.places else None
        measures = parts.measures
        within = measures.get("within", WITHIN)
        match word:
            case "wait":
                return Wait()
            case "goto":
                return Goto(place if place is not None else "home", within)
            case "follow":
                return Follow(tuple(p for p in parts.places if p is not None), within)
            case "rows":
                bearing = measures.get("bearing", 0.0) % math.tau
                length, spacing = measures.get("length", 0.0), measures.get("spacing", 0.0)
                count = parts.count
                return Rows(parts.start, bearing, length, spacing, count, parts.side, within)
            case "yoyo":
                return Yoyo(measures.get("shallow", 0.0), measures.get("deep", 0.0), parts.count)
            case "loiter":
                return Loiter(place, measures.get("radius", 0.0), parts.side)
            case "surface":
                return Surface(parts.until_fix is not None)
            case _:
                return Hold()


def _clash(one: str, other: str) -> bool:
    return one == other or {one, other} <= VERTICAL or {one, other} == {"heading", "turn"}


def _example(word: str) -> str:
    return {"bearing": "90", "spacing": "20", "shallow": "2", "deep": "10"}.get(word, "100")
