"""Build a Leg or a Set from the clauses of a leg: kinds, settings, axes, clauses of each kind.

What does not live here: names and groups (assembly.py), what this vehicle can follow
(mission.authoring.compiler.abilities), bounds in time (mission.authoring.check).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mission.authoring.language.clauses import (
    Amount,
    AreaText,
    Chosen,
    Clause,
    Else,
    Guarded,
    Here,
    LegText,
    Name,
    Named,
    OfArea,
    OfFile,
    OutputText,
    Places,
    Until,
    Value,
    Wire,
)
from mission.authoring.language.files import Files, PlacesError
from mission.authoring.language.settings import Settings
from mission.authoring.language.values import Values, whole_place
from mission.authoring.language.words import (
    AIMS,
    FIELD_ORDER,
    GUARDED,
    HOLD,
    SETTINGS,
    STOP,
    VERTICAL,
    choices,
    kinds,
    measures,
    spots,
    steered,
)
from mission.legs import LegType
from mission.legs.purposes import OF_ANY
from mission.legs.words import LegClause, Measure, Shape
from mission.model import (
    HOME,
    Aims,
    Exit,
    Leg,
    LegKind,
    OutputSetting,
    Place,
    Set,
    Setting,
    Where,
)
from mission.model.extent import PLACES
from mission.model.likeness import suggestion

_COUNT_MOST = 9999


@dataclass(slots=True)
class _Parts:
    """The parts of the leg that is being read."""

    kind: Name | None = None
    count: int = 0
    places: list[Place | None] = field(default_factory=list)
    settings: list[Setting] = field(default_factory=list)
    outputs: dict[str, OutputSetting] = field(default_factory=dict)
    guarded: bool = False  # the leg has a depth that is never below an altitude
    given: dict[str, Any] = field(default_factory=dict)  # the clauses of its kind, by word
    exits: list[Exit] = field(default_factory=list)
    until_fix: Name | None = None
    times: dict[str, float] = field(default_factory=dict)
    otherwise: str | None = None
    seen: dict[str, Where] = field(default_factory=dict)
    achieve: Aims = ()


class Legs:
    """Builds legs for one file; ``values`` has the vehicle, the parameters and the problems."""

    def __init__(self, values: Values, areas: Mapping[str, AreaText], files: Files) -> None:
        """``areas``: the mission's areas, by name."""
        self._values, self._areas, self._files = values, areas, files
        self._problems = values.problems
        self._settings = Settings(values)

    def build(self, text: LegText) -> Leg | Set:
        """Build one leg. Its name is empty if the author gave none; a leg with settings only
        becomes a Set."""
        parts = _Parts()
        for clause in text.clauses:
            self._take(parts, clause)
        name = text.name.text if text.name else ""
        row = kinds()[parts.kind.text if parts.kind else HOLD]
        self._check_settings(parts, row)
        self._check_clauses(parts, row, text.where)
        self._check_times(parts, row, text.where)
        settings = tuple(sorted(parts.settings, key=lambda s: FIELD_ORDER.index(s.word)))
        outputs = tuple(parts.outputs[name] for name in sorted(parts.outputs))
        bounds = (parts.exits, parts.times, parts.otherwise)
        if not name and parts.kind is None and not any(bounds):
            return Set("", settings, text.where, outputs)
        return Leg(
            name,
            _kind(parts, row),
            settings,
            tuple(parts.exits),
            parts.times.get("for", parts.times.get(row.name)),
            parts.times.get("timeout"),
            parts.otherwise,
            text.where,
            outputs,
            parts.achieve,
        )

    # --- clauses ----------------------------------------------------------------------------

    def _take(self, parts: _Parts, clause: Clause) -> None:
        match clause:
            case Wire(word):
                parts.settings += self._settings.wire(word)
            case Value(word, amount):
                self._value(parts, word, amount)
            case Guarded():
                self._guarded(parts, clause)
            case Places():
                self._places(parts, clause)
            case OfArea():
                self._of_area(parts, clause)
            case OfFile():
                self._of_file(parts, clause)
            case Chosen(word, choice):
                self._chosen(parts, word, choice)
            case Until():
                self._until(parts, clause)
            case Else(word, target):
                if self._once(parts, word):
                    parts.otherwise = target.text
            case OutputText():
                self._output(parts, clause)
            case Named(word, _, where):
                if self._once(parts, Name(word, where)):
                    parts.achieve = tuple(sorted(self._values.named(clause, AIMS)))

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
            parts.settings += self._settings.said(SETTINGS[word.text], amount, word.where)
        elif not self._once(parts, word):
            return
        elif word.text in kinds():
            self._begin(parts, word)
            if kinds()[word.text].head.shape is Shape.COUNT and amount is not None:
                parts.count = self._values.whole(amount, 1, _COUNT_MOST, word.text)
            elif amount is not None:
                parts.times[word.text] = self._values.seconds(amount)
        elif word.text in measures() and amount is not None:
            row = measures()[word.text]
            value = self._values.number(amount, row.unit, row.low, row.high)
            parts.given[word.text] = value % math.tau if row.circular else value
        elif amount is not None:
            parts.times[word.text] = self._values.seconds(amount)

    def _guarded(self, parts: _Parts, clause: Guarded) -> None:
        words = (clause.held.word, clause.least.word)
        if {word.text for word in words} != GUARDED:
            message = f"{words[0].text} is never below {words[1].text}: that says nothing"
            hint = "write depth 8 never below altitude 3, or the reverse, which is the same"
            self._problems.add("never-below", words[1].where, message, hint)
            return
        parts.guarded = True
        for value in (clause.held, clause.least):
            self._value(parts, value.word, value.amount)

    def _output(self, parts: _Parts, clause: OutputText) -> None:
        name, amount = clause.name, clause.amount
        if name.text in parts.outputs:
            message = f"output {name.text} appears twice"
            self._problems.add("twice", name.where, message, "keep one of them")
            return
        value = self._values.bare(amount, f"output {name.text}")
        parts.outputs[name.text] = OutputSetting(name.text, value, name.where)

    def _chosen(self, parts: _Parts, word: Name, choice: Name) -> None:
        values = choices()[word.text].values
        if choice.text not in values:
            message, hint = f"unknown {word.text} {choice.text!r}", f"write {' or '.join(values)}"
            self._problems.add("unknown-word", choice.where, message, hint)
        elif self._once(parts, word):
            parts.given[word.text] = values[choice.text]

    def _places(self, parts: _Parts, clause: Places) -> None:
        word = clause.word
        if not self._once(parts, word):
            return
        if word.text in spots():
            parts.given[word.text] = self._values.place(clause.places[0], here=True)
            return
        self._begin(parts, word)
        if len(clause.places) > PLACES.most:
            hint = "make two legs of it"
            self._problems.add("too-long", word.where, PLACES.exceeded, hint)
            return
        shape = kinds()[word.text].head.shape
        parts.places = [self._values.place(p, here=shape is Shape.ABOUT) for p in clause.places]
        if shape is Shape.PLACES:
            self._several(word, len(clause.places))
        self._same_places(clause)

    def _several(self, word: Name, count: int) -> None:
        if count < 2:
            hint = "write goto, or two places and more with a comma between"
            message = f"{word.text} needs several places"
            self._problems.add("one-place", word.where, message, hint)

    def _of_area(self, parts: _Parts, clause: OfArea) -> None:
        if not kinds()[clause.word.text].encloses:
            hint = f"name its places, or write cover area {clause.area.text}"
            message = f"{clause.word.text} goes along places, not over an area"
            self._problems.add("foreign-word", clause.area.where, message, hint)
        elif (area := self._areas.get(clause.area.text)) is None:
            hint = suggestion(clause.area.text, list(self._areas), "areas")
            hint = hint or "keep in and keep out name areas; else write its corners here"
            self._begin(parts, clause.word)
            message = f"there is no area {clause.area.text!r}"
            self._problems.add("unknown-area", clause.area.where, message, hint)
        else:
            self._places(parts, Places(clause.word, area.corners))

    def _of_file(self, parts: _Parts, clause: OfFile) -> None:
        if not self._once(parts, clause.word):
            return
        self._begin(parts, clause.word)
        try:
            places = self._files(clause.path.text)
        except PlacesError as error:
            self._problems.add("places-file", clause.path.where, error.message, error.hint)
            return
        if len(places) > PLACES.most:
            message = f"{clause.path.text} has {len(places):,} places: {PLACES.exceeded}"
            hint = "thin it out, or make two files and two legs of it"
            self._problems.add("too-long", clause.path.where, message, hint)
        else:
            parts.places = [*places]
            self._several(clause.word, len(places))

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

    def _check_settings(self, parts: _Parts, row: LegType) -> None:
        seen: dict[str, Setting] = {}
        fixed = steered(row)
        for setting in parts.settings:
            if setting.word in fixed:
                self._steered(setting, row)
            for other in seen.values():
                pair_of_one = parts.guarded and {setting.word, other.word} == GUARDED
                if _clash(setting.word, other.word) and not pair_of_one:
                    pair = (
                        other.word
                        if other.word == setting.word
                        else f"{other.word}, {setting.word}"
                    )
                    message = f"one leg sets the same axis twice ({pair})"
                    self._problems.add("axis-twice", setting.where, message, "keep one of them")
            seen.setdefault(setting.word, setting)
        surge = seen.get("surge")
        if row.makes_way and surge and surge.value <= 0:
            message = f"{row.name} never arrives without going ahead"
            self._problems.add("no-way", surge.where, message, "write gear 1 to gear 12")

    def _steered(self, setting: Setting, row: LegType) -> None:
        if row.keeps:
            hint = f"write the settings with `for` instead of `{row.name}`, or on a line before it"
            message = f"{row.name} keeps what is set"
        elif row.ascends:
            message, hint = f"{row.name} sets everything itself", "leave it out"
        else:
            message, hint = f"{row.name} sets {setting.word} itself", "leave it out"
        self._problems.add("steered", setting.where, message, hint)

    # --- the kind ---------------------------------------------------------------------------

    def _check_clauses(self, parts: _Parts, row: LegType, where: Where) -> None:
        own = {clause.word for clause in row.clauses}
        for word in (*measures(), *spots(), *choices()):
            if word in parts.seen and word not in own:
                self._foreign(parts, row, word)
        self._check_aims(parts, row)
        for clause in row.clauses:
            if clause.needed and clause.word not in parts.seen:
                place = parts.kind.where if parts.kind else where
                hint = f"add for instance {clause.word} {_example(clause)}"
                message = f"{row.name} needs {clause.word}"
                self._problems.add("missing-word", place, message, hint)
        misfit = row.contradiction(parts.given)
        if misfit is not None:
            place = parts.seen[misfit.word]
            self._problems.add(misfit.code, place, misfit.message, misfit.hint)

    def _check_aims(self, parts: _Parts, row: LegType) -> None:
        """A leg without rows may achieve only ``position``, and only if it does not ascend."""
        idle = [name for name, _ in parts.achieve if name != OF_ANY or row.ascends]
        if idle and not row.surveys:
            users = ", ".join(k.name for k in kinds().values() if k.surveys)
            hint = f"it belongs to {users}, to a group of them or to the mission"
            message = f"{row.name} has no {idle[0]} to achieve"
            self._problems.add("foreign-word", parts.seen["achieve"], message, hint)

    def _foreign(self, parts: _Parts, row: LegType, word: str) -> None:
        users = [k.name for k in kinds().values() if word in {c.word for c in k.clauses}]
        hint = f"{word} belongs to {', '.join(users)}"
        self._problems.add("foreign-word", parts.seen[word], f"{row.name} has no {word}", hint)

    def _check_times(self, parts: _Parts, row: LegType, where: Where) -> None:
        word = row.name
        if row.head.shape is Shape.TIME:
            if "for" in parts.times:
                hint = f"write {word} 30s, or hold for 30s"
                message = f"{word} has its time already"
                self._problems.add("two-times", parts.seen["for"], message, hint)
            elif not parts.times and not parts.exits:
                hint = f"write for instance {word} 30s"
                self._problems.add("no-time", where, f"{word} needs a time", hint)
        if parts.until_fix and not row.until_fix:
            hint = "write surface until fix, or until fix_age < 5"
            message = "until fix belongs to surface"
            self._problems.add("fix-leg", parts.until_fix.where, message, hint)


def _kind(parts: _Parts, row: LegType) -> LegKind:
    """The kind of the leg with its parameters; defaults replace the unreadable ones."""
    figures = {c.field: parts.given.get(c.word, c.unsaid) for c in row.clauses}
    if row.until_fix:
        figures[row.until_fix] = parts.until_fix is not None
    place = parts.places[0] if parts.places else None
    match row.head.shape:
        case Shape.COUNT:
            figures[row.head.field] = parts.count
        case Shape.PLACE:
            figures[row.head.field] = place if place is not None else HOME
        case Shape.ABOUT:
            figures[row.head.field] = place
        case Shape.PLACES:
            figures[row.head.field] = tuple(p for p in parts.places if p is not None)
    return row.kind(**figures)


def _clash(one: str, other: str) -> bool:
    return one == other or {one, other} <= VERTICAL or {one, other} == {"heading", "turn"}


def _example(clause: LegClause) -> str:
    return clause.example if isinstance(clause, Measure) else ""
