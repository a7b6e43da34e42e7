"""Match the legs of two charts: by path, then by name, then by similar content in order.

    same path -> same unique name in another group -> same content in the same order -> the most
    similar one between two matched legs

A generated name (``line12``) tells only the place of a leg, so such legs are matched by content.
Groups are matched by the legs inside them.

What does not live here: the differences in a pair (changes.py).
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher

from mission.authoring.language.words import GENERATED
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, Chart, Leg, State
from protocol.messages import Setpoint

ALIKE = 0.5  # least share of equal parts for which two legs are matched
Key = Callable[[State], str | None]
WINDOW = 30  # legs that are tried around the same place


@dataclass(frozen=True, slots=True)
class Match:
    """Paths before -> paths after; without the legs and groups that have no partner."""

    legs: dict[str, str]
    groups: dict[str, str]

    def renamed(self, path: str) -> str:
        """The path after; if there is none, a path that does not exist after."""
        fixed = path if path in (AUTONOMOUS, IMPLICIT_SURFACE) else f"{path} (before)"
        return self.legs.get(path) or self.groups.get(path) or fixed


def legs_of(chart: Chart) -> list[State]:
    return [s for s in chart.states if s.leg is not None and s.path != IMPLICIT_SURFACE]


def leg_of(state: State) -> Leg:
    assert state.leg is not None
    return state.leg


def set_of(state: State) -> Setpoint:
    """The complete set; a heave of 0 is the same as none."""
    setpoint = state.setpoint or Setpoint()
    return replace(setpoint, heave=None) if setpoint.heave == 0.0 else setpoint


def match(before: Chart, after: Chart) -> Match:
    old, new = legs_of(before), legs_of(after)
    pairs: dict[str, str] = {}
    for key in (_path, _name):
        rest_old, rest_new = _unmatched(old, new, pairs)
        pairs |= _by_key(key, rest_old, rest_new)
    rest_old, rest_new = _unmatched(old, new, pairs)
    pairs |= dict(_alike(rest_old, rest_new))
    return Match(pairs, _groups(before, after, pairs))


def _unmatched(
    old: list[State], new: list[State], pairs: dict[str, str]
) -> tuple[list[State], list[State]]:
    taken = set(pairs.values())
    return [s for s in old if s.path not in pairs], [s for s in new if s.path not in taken]


def _path(state: State) -> str | None:
    return None if GENERATED.match(leg_of(state).name) else state.path


def _name(state: State) -> str | None:
    name = leg_of(state).name
    return None if GENERATED.match(name) else name


def _by_key(key: Key, old: list[State], new: list[State]) -> dict[str, str]:
    there = dict(_unique(key, new))
    return {path: there[k] for k, path in _unique(key, old) if k in there}


def _unique(key: Key, states: list[State]) -> Iterator[tuple[str, str]]:
    keys = [key(s) for s in states]
    count = Counter(keys)
    return ((k, s.path) for k, s in zip(keys, states, strict=True) if k and count[k] == 1)


# --- likeness ----------------------------------------------------------------------------------


def _content(state: State) -> tuple[Hashable, ...]:
    leg, s = leg_of(state), set_of(state)
    return (
        leg.kind,
        (s.surge, s.turn),
        s.heading,
        (s.depth, s.altitude, s.heave),
        tuple(e.guard for e in leg.exits),
        (leg.duration, leg.timeout),
        state.outputs,
    )


def _alike(old: list[State], new: list[State]) -> Iterator[tuple[str, str]]:
    a, b = [_content(s) for s in old], [_content(s) for s in new]
    for tag, i1, i2, j1, j2 in _opcodes(a, b):
        if tag == "equal":
            for i, j in zip(range(i1, i2), range(j1, j2), strict=True):
                yield old[i].path, new[j].path
        elif tag == "replace":
            for i, j in _closest(a, b, range(i1, i2), range(j1, j2)):
                yield old[i].path, new[j].path


def _opcodes(
    a: Sequence[Hashable], b: Sequence[Hashable]
) -> Iterable[tuple[str, int, int, int, int]]:
    """Opcodes of SequenceMatcher. The equal beginning is found without its search, which is slow
    for many equal legs."""
    n = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
    yield "equal", 0, n, 0, n
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, a[n:], b[n:], autojunk=False).get_opcodes():
        yield tag, i1 + n, i2 + n, j1 + n, j2 + n


def _closest(
    a: list[tuple[Hashable, ...]], b: list[tuple[Hashable, ...]], old: range, new: range
) -> Iterator[tuple[int, int]]:
    free = list(new)
    for i in old:
        place = new.start + i - old.start
        near = [j for j in free if abs(j - place) <= WINDOW]
        best = max(near, key=lambda j: (_likeness(a[i], b[j]), -abs(j - place)), default=None)
        if best is not None and _likeness(a[i], b[best]) >= ALIKE:
            free.remove(best)
            yield i, best


def _likeness(one: tuple[Hashable, ...], two: tuple[Hashable, ...]) -> float:
    if type(one[0]) is not type(two[0]):
        return 0.0
    return sum(x == y for x, y in zip(one, two, strict=True)) / len(one)


# --- groups ------------------------------------------------------------------------------------


def groups_above(chart: Chart, path: str) -> tuple[str, ...]:
    """The groups around a leg or group, the innermost first."""
    above, parent = [], chart.state(path).parent
    while parent != AUTONOMOUS:
        above.append(parent)
        parent = chart.state(parent).parent
    return tuple(above)


def _groups(before: Chart, after: Chart, legs: dict[str, str]) -> dict[str, str]:
    shared: Counter[tuple[str, str]] = Counter()
    for old, new in legs.items():
        for a in groups_above(before, old):
            shared.update((a, b) for b in groups_above(after, new))
    pairs: dict[str, str] = {}

    def order(pair: tuple[str, str]) -> tuple[bool, int, int, tuple[str, str]]:
        a, b = pair
        return a != b, -shared[pair], abs(a.count("/") - b.count("/")), pair

    for a, b in sorted(shared, key=order):
        if a not in pairs and b not in pairs.values():
            pairs[a] = b
    return pairs


def rising(values: Sequence[int]) -> set[int]:
    """Indices of a longest increasing subsequence of ``values``."""
    tails: list[int] = []
    ends: list[int] = []
    before: list[int | None] = []
    for i, value in enumerate(values):
        n = bisect_left(tails, value)
        before.append(ends[n - 1] if n else None)
        tails[n : n + 1], ends[n : n + 1] = [value], [i]
    kept: set[int] = set()
    at = ends[-1] if ends else None
    while at is not None:
        kept.add(at)
        at = before[at]
    return kept
