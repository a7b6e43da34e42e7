"""List the changes for the vehicle between two charts: a row per change, in the order of the legs.

Two missions are the same for the vehicle if their legs and groups can be matched so that each leg
has the same complete set, kind, clocks and ways, tested in the same order. Names, the order in the
text, and groups without rounds and handlers do not matter. If a leg was added, removed or moved,
its direct consequences (the leg before it now leads elsewhere) are not reported again.

What does not live here: matching legs (matching.py), comparing ways (ways.py), output (show.py).
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import TypeVar

from mission.authoring.diff import wording
from mission.authoring.diff.matching import leg_of, legs_of, match, set_of
from mission.authoring.diff.ways import Ways, matters
from mission.authoring.graph import words
from mission.authoring.language.render import area_text
from mission.authoring.language.words import GENERATED
from mission.engine.bounds import in_force
from mission.model import (
    AUTONOMOUS,
    Chart,
    Exit,
    Group,
    Handler,
    Mission,
    State,
    shown,
)
from mission.model.units import number_text
from mission.model.vehicle import Vehicle
from protocol.messages import SetSafety

MISSION = "mission"
T = TypeVar("T", Exit, Handler)


class Kind(enum.Enum):
    ADDED = "added"
    REMOVED = "removed"
    MOVED = "moved"
    CHANGED = "changed"


@dataclass(frozen=True, slots=True)
class Change:
    """One change. ``places``: legs, groups or the mission; several if all changed in the same way.
    ``lines``: the line of each place before and after; 0 where it does not exist."""

    kind: Kind
    places: tuple[str, ...]
    what: str
    before: str
    after: str
    lines: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Changes:
    rows: tuple[Change, ...]
    renamed: tuple[tuple[str, str], ...]  # legs with another name or group, also if changed


def changes(before: Chart, after: Chart, vehicles: tuple[Vehicle, Vehicle]) -> Changes:
    compared = _Comparison(before, after, vehicles)
    pairs = ((a, b) for a, b in compared.match.legs.items() if a != b and _named(a, b))
    renamed = tuple((wording.name(a), wording.name(b)) for a, b in pairs)
    return Changes(tuple(_together(compared.rows())), renamed)


def _named(*paths: str) -> bool:
    """Whether an author named one of them; a generated name (``line12``) does not count."""
    return not all(GENERATED.match(path.rpartition("/")[2]) for path in paths)


def _together(rows: Iterator[Change]) -> Iterator[Change]:
    """Join rows of legs that changed in the same way, at the place of the first."""
    merged: dict[tuple[object, ...], Change] = {}
    for i, row in enumerate(rows):
        alone = row.kind is not Kind.CHANGED or row.places == (MISSION,)
        key = (i,) if alone else (row.what, row.before, row.after)
        first = merged.get(key)
        if first is not None:
            row = replace(first, places=first.places + row.places, lines=first.lines + row.lines)
        merged[key] = row
    yield from merged.values()


def _told(group: Group) -> bool:
    return matters(group) or bool(group.achieve)


class _Comparison:
    def __init__(self, before: Chart, after: Chart, vehicles: tuple[Vehicle, Vehicle]) -> None:
        self.before, self.after, self.vehicles = before, after, vehicles
        self.match = match(before, after)
        self.ways = Ways(before, after, self.match)
        self.old_of, self.moved = self.ways.old_of, self.ways.moved

    def rows(self) -> Iterator[Change]:
        yield from self._header()
        yield from self._groups()
        for state in legs_of(self.before):
            if state.path not in self.match.legs:
                leg = leg_of(state)
                yield Change(
                    Kind.REMOVED, (wording.name(state.path),), "leg", wording.whole(state), "",
                    ((leg.where.line, 0),),
                )  # fmt: skip
        for state in legs_of(self.after):
            old = self.old_of.get(state.path)
            if old is None:
                leg = leg_of(state)
                yield Change(
                    Kind.ADDED, (wording.name(state.path),), "leg", "", wording.whole(state),
                    ((0, leg.where.line),),
                )  # fmt: skip
            else:
                yield from self._leg(self.before.state(old), state)

    # --- the whole ----------------------------------------------------------------------------

    def _mission(self, what: str, before: str, after: str) -> Iterator[Change]:
        if before != after:
            lines = (self.before.mission.where.line, self.after.mission.where.line)
            yield Change(Kind.CHANGED, (MISSION,), what, before, after, (lines,))

    def _header(self) -> Iterator[Change]:
        one, two = self.before.mission, self.after.mission
        yield from self._mission("vehicle", self.vehicles[0].name, self.vehicles[1].name)
        yield from self._mission("home", wording.home(one), wording.home(two))
        yield from self._mission(
            "start", wording.start(one.start_without_fix), wording.start(two.start_without_fix)
        )
        yield from self._limits(one, two)
        yield from self._areas(one, two)
        yield from self._assumptions(one, two)
        yield from self._mission("to achieve", *map(wording.achieve, (one, two)))
        uncertain = self.ways.mapped(self.before, ":uncertain", AUTONOMOUS)
        if uncertain != self.ways.plain(self.after, ":uncertain", AUTONOMOUS):
            yield from self._mission("on uncertain", one.on_uncertain, two.on_uncertain)
        yield from self._mission("first leg", *self._initial())
        yield from self._handlers(AUTONOMOUS, AUTONOMOUS, one, two, MISSION)

    def _initial(self) -> tuple[str, str]:
        one, two = self.before.initial, self.after.initial
        mapped = self.match.renamed(one)
        told = {one, two} & self.moved or two not in self.old_of or one not in self.match.legs
        return ("", "") if mapped == two or told else (wording.name(one), wording.name(two))

    def _limits(self, one: Mission, two: Mission) -> Iterator[Change]:
        bounds = [
            in_force(vehicle, mission.safety, SetSafety())
            for vehicle, mission in zip(self.vehicles, (one, two), strict=True)
        ]
        for limit, unit in (("radius", "m"), ("time", "s"), ("depth", "m"), ("voltage", "V")):
            old, new = (getattr(b, limit) for b in bounds)
            told = shown.duration if unit == "s" else lambda v, u=unit: f"{number_text(v)} {u}"
            if old != new:
                pair = wording.apart(old, new, told, number_text)
                yield from self._mission(f"limit of {limit}", *pair)

    def _areas(self, one: Mission, two: Mission) -> Iterator[Change]:
        told = [{area.name: area_text(area) for area in mission.areas} for mission in (one, two)]
        for name in sorted(told[0].keys() | told[1].keys()):
            old, new = (side.get(name, "not there") for side in told)
            yield from self._mission(f"area {name}", old, new)

    def _assumptions(self, one: Mission, two: Mission) -> Iterator[Change]:
        """Compare the assumptions; without an assumed current, that of the vehicle file counts."""
        given = [
            {"current": vehicle.current} | dict(mission.assume)
            for vehicle, mission in zip(self.vehicles, (one, two), strict=True)
        ]
        for what in sorted(given[0].keys() | given[1].keys()):
            old, new = (number_text(side[what]) if what in side else "not stated" for side in given)
            yield from self._mission(f"assumed {what}", old, new)

    # --- groups -------------------------------------------------------------------------------

    def _groups(self) -> Iterator[Change]:
        partner = {b: a for a, b in self.match.groups.items()}
        for state in self.before.states:
            if state.group and _told(state.group) and state.path not in self.match.groups:
                place, lines = wording.name(state.path), ((state.group.where.line, 0),)
                told = wording.group(state.group)
                yield Change(Kind.REMOVED, (place,), "group", told, "", lines)
        for state in self.after.states:
            if state.group is None:
                continue
            if state.path in partner:
                yield from self._group(self.before.state(partner[state.path]), state)
            elif _told(state.group):
                place, lines = wording.name(state.path), ((0, state.group.where.line),)
                told = wording.group(state.group)
                yield Change(Kind.ADDED, (place,), "group", "", told, lines)

    def _group(self, old: State, new: State) -> Iterator[Change]:
        assert old.group is not None
        assert new.group is not None
        place = wording.name(new.path)
        lines = ((old.group.where.line, new.group.where.line),)
        if old.group.repeat != new.group.repeat:
            a, b = str(old.group.repeat), str(new.group.repeat)
            yield Change(Kind.CHANGED, (place,), "rounds", a, b, lines)
        one, two = wording.achieve(old.group), wording.achieve(new.group)
        if one != two:
            yield Change(Kind.CHANGED, (place,), "to achieve", one, two, lines)
        yield from self._handlers(old.path, new.path, old.group, new.group, place)

    def _handlers(
        self, old: str, new: str, one: Group | Mission, two: Group | Mission, place: str
    ) -> Iterator[Change]:
        def same_way(i: int, j: int) -> bool:
            one_way = self.ways.mapped(self.before, f":on{i}", old)
            return one_way == self.ways.plain(self.after, f":on{j}", new)

        yield from self._aligned("on", place, one.handlers, two.handlers, same_way)

    # --- one leg ------------------------------------------------------------------------------

    def _leg(self, old: State, new: State) -> Iterator[Change]:
        a, b = leg_of(old), leg_of(new)
        place, lines = wording.name(new.path), ((a.where.line, b.where.line),)

        def row(what: str, before: str, after: str, kind: Kind = Kind.CHANGED) -> Change:
            return Change(kind, (place,), what, before, after, lines)

        if new.path in self.moved:
            stood = wording.stands_after(self.before, old.path)
            stands = wording.stands_after(self.after, new.path)
            yield row("place", stood, stands, Kind.MOVED)
        if a.kind != b.kind:
            told = wording.apart(a, b, words.kind, wording.exact_kind)
            yield row("does", told[0] or "hold", told[1] or "hold")
        for what, axis in wording.AXES.items():
            one, two = axis(set_of(old)), axis(set_of(new))
            if one != two:
                yield row(what, *wording.apart(one, two, wording.axis(what), wording.exact_set))
        names = dict.fromkeys(name for name, _ in (*old.outputs, *new.outputs))
        for name in names:
            sides = zip((old, new), self.vehicles, strict=True)
            one_level, two_level = (wording.level(state, name, of) for state, of in sides)
            if one_level != two_level:
                yield row(f"output {name}", one_level, two_level)
        for what, one_time, two_time in (
            ("for", a.duration, b.duration), ("timeout", a.timeout, b.timeout)
        ):  # fmt: skip
            if one_time != two_time:
                told = wording.apart(one_time, two_time, wording.time, wording.exact_time)
                yield row(what, *told)
        if a.achieve != b.achieve:
            yield row("to achieve", wording.achieve(a), wording.achieve(b))
        yield from self._otherwise(old, new, row)

        def same_way(i: int, j: int) -> bool:
            implicit = a.exits[i - 1].target is None and b.exits[j - 1].target is None
            return self.ways.same_way(old, f":until{i}", new, f":until{j}", implicit=implicit)

        yield from self._aligned("until", place, a.exits, b.exits, same_way)
        for suffix in (":end", ":for"):
            if not self.ways.same_way(old, suffix, new, suffix, implicit=True):
                yield row("then", *self.ways.targets(old, new, suffix))

    def _otherwise(self, old: State, new: State, row: Callable[..., Change]) -> Iterator[Change]:
        a, b = leg_of(old).otherwise, leg_of(new).otherwise
        if self.ways.same_way(old, ":else", new, ":else", implicit=a is None and b is None):
            return
        told = a or self.before.mission.on_timeout, b or self.after.mission.on_timeout
        yield row("else", *(told if told[0] != told[1] else self.ways.targets(old, new, ":else")))

    def _aligned(
        self,
        what: str,
        place: str,
        old: Sequence[T],
        new: Sequence[T],
        same_way: Callable[[int, int], bool],
    ) -> Iterator[Change]:
        """Compare two lists of guards in order; the order in which guards are tested has a meaning.
        ``same_way`` takes the numbers of two guards, from 1."""
        a, b = [one.guard for one in old], [one.guard for one in new]
        for tag, i1, i2, j1, j2 in SequenceMatcher(None, a, b, autojunk=False).get_opcodes():
            for n in range(max(i2 - i1, j2 - j1)):
                i, j = i1 + n, j1 + n
                one = old[i] if i < i2 else None
                two = new[j] if j < j2 else None
                if tag == "equal" and same_way(i + 1, j + 1):
                    continue
                lines = (one.where.line if one else 0, two.where.line if two else 0)
                kind = Kind.ADDED if one is None else Kind.REMOVED if two is None else Kind.CHANGED
                told = wording.apart(one, two, wording.way, wording.exact_way)
                yield Change(kind, (place,), what, *told, (lines,))
