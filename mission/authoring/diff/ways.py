"""The ways out of legs and groups, and whether those of two charts lead to the same places.

The ways of the chart before are compared in the paths of the chart after (``mapped``), so renaming
a leg changes no way. A way that leads elsewhere only because a leg was added, removed or moved is
no change of its own.

What does not live here: matching legs (matching.py), the changes (changes.py).
"""

from __future__ import annotations

from mission.authoring.diff import wording
from mission.authoring.diff.matching import Match, groups_above, legs_of, rising
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    By,
    Chart,
    Edge,
    Group,
    Guard,
    Loop,
    State,
)

Way = tuple[By, Guard | None, str, tuple[Loop, ...]]


class Ways:
    """The ways of two matched charts. ``old_of``: leg after -> leg before. ``moved``: legs after
    that have left the order of the others, or are in another group."""

    def __init__(self, before: Chart, after: Chart, match: Match) -> None:
        self.before, self.after, self.match = before, after, match
        self.old_of = {b: a for a, b in match.legs.items()}
        self._matter = {
            side: {s.path for s in chart.states if s.group and matters(s.group)}
            for side, chart in (("before", before), ("after", after))
        }
        self.moved = set() if self._same_ways() else self._moved()

    def plain(self, chart: Chart, suffix: str, source: str) -> tuple[Way, ...]:
        return tuple((e.by, e.guard, e.target, e.loops) for e in _edges(chart, source, suffix))

    def mapped(self, chart: Chart, suffix: str, source: str) -> tuple[Way, ...]:
        rename = self.match.renamed
        return tuple(
            (by, guard, rename(target), tuple(Loop(rename(x.group), x.again) for x in loops))
            for by, guard, target, loops in self.plain(chart, suffix, source)
        )

    def same_way(self, old: State, suffix: str, new: State, there: str, *, implicit: bool) -> bool:
        """Whether a way leads to the same place. ``implicit``: it leads to the next leg. Then legs
        that were added, removed or moved, and changed rounds, may explain another target."""
        one = self.mapped(self.before, suffix, old.path)
        two = self.plain(self.after, there, new.path)
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

    def targets(self, old: State, new: State, suffix: str) -> tuple[str, str]:
        def told(chart: Chart, source: str) -> str:
            ends = (wording.name(e.target) for e in _edges(chart, source, suffix))
            return " or ".join(dict.fromkeys(ends))

        return told(self.before, old.path), told(self.after, new.path)

    def _same_ways(self) -> bool:
        """Whether all ways lead to the same places, without regard to their guards. The order in
        the text does not matter then."""
        if len(self.match.legs) != len(legs_of(self.before)) or len(self.old_of) != len(
            legs_of(self.after)
        ):
            return False
        if self.match.renamed(self.before.initial) != self.after.initial:
            return False
        sources = [*self.match.legs.items(), *self.match.groups.items(), (AUTONOMOUS, AUTONOMOUS)]
        return all(
            _ends(self.mapped(self.before, "", a)) == _ends(self.plain(self.after, "", b))
            and self._around(self.before, a, "before") == self._around(self.after, b, "after")
            for a, b in sources
        )

    def _around(self, chart: Chart, path: str, side: str) -> tuple[str, ...]:
        """The groups around it that repeat or have handlers, by their paths after."""
        if path == AUTONOMOUS:
            return ()
        rename = self.match.renamed if side == "before" else str
        return tuple(rename(g) for g in groups_above(chart, path) if g in self._matter[side])

    def _moved(self) -> set[str]:
        """Paths of legs that have left the order of the others, or are in another group."""
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


def matters(group: Group) -> bool:
    """Whether a group repeats or has handlers."""
    return group.repeat > 1 or bool(group.handlers)


def _ends(ways: tuple[Way, ...]) -> set[tuple[object, ...]]:
    return {(by, target, loops) for by, _, target, loops in ways}


def _edges(chart: Chart, source: str, suffix: str) -> list[Edge]:
    """The edges of a state with the trigger ``suffix``; one way may have several, one for each
    outcome of the rounds."""
    trigger = source + suffix
    return [
        e
        for e in chart.leaving(source)
        if not suffix or e.trigger == trigger or e.trigger.startswith(f"{trigger}.")
    ]
