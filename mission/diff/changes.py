"""What changed for the vehicle between two charts: one row per change, in the order of the legs.

Two missions are the same for the vehicle if legs and groups can be matched so that every leg has
the same complete set, kind, clocks and ways, in the same order of looking at them; names, order in
the text and groups that neither repeat nor handle do not matter. Whatever follows from a leg that
came, went or moved alone (where the one before it now leads) is not told again.

What does not live here: who is matched with whom (matching.py), how it is shown (show.py).
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import TypeVar

from mission.diff import wording
from mission.diff.matching import groups_above, leg_of, legs_of, match, rising, set_of
from mission.envelope import in_force
from mission.graph import words
from mission.language.words import GENERATED
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    By,
    Chart,
    Edge,
    Exit,
    Group,
    Guard,
    Handler,
    Loop,
    Mission,
    State,
)
from mission.units import number_text
from mission.vehicle import Vehicle
from protocol.messages import SetSafety

MISSION = "mission"
T = TypeVar("T", Exit, Handler)
Way = tuple[By, Guard | None, str, tuple[Loop, ...]]


class Kind(enum.Enum):
    ADDED = "added"
    REMOVED = "removed"
    MOVED = "moved"
    CHANGED = "changed"


@dataclass(frozen=True, slots=True)
class Change:
    """``places`` are legs, groups or the mission; more than one where all changed alike.
    ``lines``: before and after of each place, 0 where there is none."""

    kind: Kind
    places: tuple[str, ...]
    what: str
    before: str
    after: str
    lines: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Changes:
    rows: tuple[Change, ...]
    renamed: tuple[tuple[str, str], ...]  # legs: another name or group, whatever else changed


def changes(before: Chart, after: Chart, vehicles: tuple[Vehicle, Vehicle]) -> Changes:
    compared = _Comparison(before, after, vehicles)
    pairs = ((a, b) for a, b in compared.match.legs.items() if a != b and _named(a, b))
    renamed = tuple((wording.name(a), wording.name(b)) for a, b in pairs)
    return Changes(tuple(_together(compared.rows())), renamed)


def _named(*paths: str) -> bool:
    """Whether some author gave one of them its name: numbers of lines are nobody's names."""
    return not all(GENERATED.match(path.rpartition("/")[2]) for path in paths)


def _together(rows: Iterator[Change]) -> Iterator[Change]:
    """Legs that changed alike share a row, at the place of the first."""
    merged: dict[tuple[object, ...], Change] = {}
    for i, row in enumerate(rows):
        alone = row.kind is not Kind.CHANGED or row.places == (MISSION,)
        key = (i,) if alone else (row.what, row.before, row.after)
        first = merged.get(key)
        if first is not None:
            row = replace(first, places=first.places + row.places, lines=first.lines + row.lines)
        merged[key] = row
    yield from merged.values()


class _Comparison:
    def __init__(self, before: Chart, after: Chart, vehicles: tuple[Vehicle, Vehicle]) -> None:
        self.before, self.after, self.vehicles = before, after, vehicles
        self.match = match(before, after)
        self.old_of = {b: a for a, b in self.match.legs.items()}
        self.matters = {
            side: {s.path for s in chart.states if s.group and _matters(s.group)}
            for side, chart in (("before", before), ("after", after))
        }
        self.moved = set() if self._same_ways() else self._moved()

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
        yield from self._assumptions(one, two)
        uncertain = self._mapped(self.before, ":uncertain", AUTONOMOUS)
        if uncertain != self._plain(self.after, ":uncertain", AUTONOMOUS):
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
            told = words.duration if unit == "s" else lambda v, u=unit: f"{number_text(v)} {u}"
            if old != new:
                pair = wording.apart(old, new, told, number_text)
                yield from self._mission(f"limit of {limit}", *pair)

    def _assumptions(self, one: Mission, two: Mission) -> Iterator[Change]:
        """A current that is not assumed is the vehicle file's."""
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
            if state.group and _matters(state.group) and state.path not in self.match.groups:
                place, lines = wording.name(state.path), ((state.group.where.line, 0),)
                told = wording.group(state.group)
                yield Change(Kind.REMOVED, (place,), "group", told, "", lines)
        for state in self.after.states:
            if state.group is None:
                continue
            if state.path in partner:
                yield from self._group(self.before.state(partner[state.path]), state)
            elif _matters(state.group):
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
        yield from self._handlers(old.path, new.path, old.group, new.group, place)

    def _handlers(
        self, old: str, new: str, one: Group | Mission, two: Group | Mission, place: str
    ) -> Iterator[Change]:
        def same_way(i: int, j: int) -> bool:
            one_way = self._mapped(self.before, f":on{i}", old)
            return one_way == self._plain(self.after, f":on{j}", new)

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
        for what, one_time, two_time in (
            ("for", a.duration, b.duration), ("timeout", a.timeout, b.timeout)
        ):  # fmt: skip
            if one_time != two_time:
                told = wording.apart(one_time, two_time, wording.time, wording.exact_time)
                yield row(what, *told)
        yield from self._otherwise(old, new, row)

        def same_way(i: int, j: int) -> bool:
            implicit = a.exits[i - 1].target is None and b.exits[j - 1].target is None
            return self._same_way(old, f":until{i}", new, f":until{j}", implicit=implicit)

        yield from self._aligned("until", place, a.exits, b.exits, same_way)
        for suffix in (":end", ":for"):
            if not self._same_way(old, suffix, new, suffix, implicit=True):
                yield row("then", *self._targets(old, new, suffix))

    def _otherwise(self, old: State, new: State, row: Callable[..., Change]) -> Iterator[Change]:
        a, b = leg_of(old).otherwise, leg_of(new).otherwise
        if self._same_way(old, ":else", new, ":else", implicit=a is None and b is None):
            return
        told = a or self.before.mission.on_timeout, b or self.after.mission.on_timeout
        yield row("else", *(told if told[0] != told[1] else self._targets(old, new, ":else")))

    def _aligned(
        self,
        what: str,
        place: str,
        old: Sequence[T],
        new: Sequence[T],
        same_way: Callable[[int, int], bool],
    ) -> Iterator[Change]:
        """In the order in which they are looked at, which is part of what they mean; ``same_way``
        is asked by their numbers, from 1."""
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

    # --- ways ---------------------------------------------------------------------------------

    def _plain(self, chart: Chart, suffix: str, source: str) -> tuple[Way, ...]:
        return tuple((e.by, e.guard, e.target, e.loops) for e in _edges(chart, source, suffix))

    def _mapped(self, chart: Chart, suffix: str, source: str) -> tuple[Way, ...]:
        rename = self.match.renamed
        return tuple(
            (by, guard, rename(target), tuple(Loop(rename(x.group), x.again) for x in loops))
            for by, guard, target, loops in self._plain(chart, suffix, source)
        )

    def _same_way(self, old: State, suffix: str, new: State, there: str, *, implicit: bool) -> bool:
        """``implicit``: to whatever comes next, so that a leg that came, went or moved, or rounds
        that changed, say already why it leads elsewhere."""
        one = self._mapped(self.before, suffix, old.path)
        two = self._plain(self.after, there, new.path)
        if [way[2:] for way in one] == [way[2:] for way in two]:
            return True
        told = not one or not two or new.path in self.moved
        return implicit and (told or any(self._told(way) for way in (*one, *two)))

    def _told(self, way: Way) -> bool:
        _, _, target, loops = way
        came_or_went = target != IMPLICIT_SURFACE and target not in self.old_of
        return (
            came_or_went
            or target in self.moved
            or any(self._changed_group(loop.group) for loop in loops)
        )

    def _changed_group(self, path: str) -> bool:
        partner = {b: a for a, b in self.match.groups.items()}.get(path)
        if partner is None:
            return True
        one, two = self.before.state(partner).group, self.after.state(path).group
        return one is None or two is None or one.repeat != two.repeat

    def _targets(self, old: State, new: State, suffix: str) -> tuple[str, str]:
        def told(chart: Chart, source: str) -> str:
            ends = (wording.name(e.target) for e in _edges(chart, source, suffix))
            return " or ".join(dict.fromkeys(ends))

        return told(self.before, old.path), told(self.after, new.path)

    def _same_ways(self) -> bool:
        """Whether all ways lead alike, whatever opens them: then order in the text is no matter."""
        if len(self.match.legs) != len(legs_of(self.before)) or len(self.old_of) != len(
            legs_of(self.after)
        ):
            return False
        if self.match.renamed(self.before.initial) != self.after.initial:
            return False
        sources = [*self.match.legs.items(), *self.match.groups.items(), (AUTONOMOUS, AUTONOMOUS)]
        return all(
            _ends(self._mapped(self.before, "", a)) == _ends(self._plain(self.after, "", b))
            and self._around(self.before, a, "before") == self._around(self.after, b, "after")
            for a, b in sources
        )

    def _around(self, chart: Chart, path: str, side: str) -> tuple[str, ...]:
        """The groups around it that repeat or handle, by their paths after."""
        if path == AUTONOMOUS:
            return ()
        rename = self.match.renamed if side == "before" else str
        return tuple(rename(g) for g in groups_above(chart, path) if g in self.matters[side])

    def _moved(self) -> set[str]:
        """Paths after: out of the order that the others keep, or into another group."""
        old = {s.path: i for i, s in enumerate(legs_of(self.before))}
        pairs = [
            (old[self.old_of[s.path]], s.path) for s in legs_of(self.after) if s.path in self.old_of
        ]
        kept = rising([i for i, _ in pairs])
        moved = {path for n, (_, path) in enumerate(pairs) if n not in kept}
        for _, path in pairs:
            before = self._around(self.before, self.old_of[path], "before")
            after = self._around(self.after, path, "after")
            if [g for g in before if not g.endswith(" (before)")] != [
                g for g in after if g in self.match.groups.values()
            ]:
                moved.add(path)
        return moved


def _ends(ways: tuple[Way, ...]) -> set[tuple[object, ...]]:
    return {(by, target, loops) for by, _, target, loops in ways}


def _edges(chart: Chart, source: str, suffix: str) -> list[Edge]:
    """A state's edges whose trigger is that of ``suffix``; of one way there are several, one for
    each outcome of the rounds."""
    trigger = source + suffix
    return [
        e
        for e in chart.leaving(source)
        if not suffix or e.trigger == trigger or e.trigger.startswith(f"{trigger}.")
    ]


def _matters(group: Group) -> bool:
    return group.repeat > 1 or bool(group.handlers)
