"""How many flights it takes until one notices a broken rule: drawn by chance, or searched.

A flight notices when the whole program flies it without a violation and the broken program does
not. The whole program's flights serve all rules. A flight is not flown again with a rule broken
that could not have changed it (reached).

What does not live here: how a rule is broken (broken), which flights a search asks for (search).
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from mission.verification.campaign.broken import BROKEN, broken
from mission.verification.campaign.draw import Plan, Subject, draw
from mission.verification.campaign.faults import fly_near
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.reached import reached
from mission.verification.campaign.search import Search
from mission.verification.campaign.steered import plan_of
from mission.verification.campaign.unseen import unseen


@dataclass(frozen=True, slots=True)
class Noticed:
    """``flights``: how many it took, None if none noticed; ``by``: the law that was broken.
    ``reason``: why no flight can notice, "" if one can."""

    name: str
    rule: str
    flights: int | None
    by: str
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Flown:
    violations: tuple[Violation, ...]
    margins: Mapping[str, float]
    reached: frozenset[str] = frozenset()


class Flights:
    """The flights of one seed. A name is a random flight's number, or a name of ``steered``."""

    def __init__(self, seed: int, known: Sequence[Subject]) -> None:
        self.seed, self.known, self.vehicle = seed, known, known[0].vehicle
        self._whole: dict[str, Flown] = {}

    def whole(self, name: str) -> Flown:
        if name not in self._whole:
            with reached() as rules:
                flown = _fly(self._plan(name))
            self._whole[name] = Flown(flown.violations, flown.margins, frozenset(rules))
        return self._whole[name]

    def without(self, rule: str, name: str) -> Flown:
        whole = self.whole(name)
        if rule not in whole.reached:
            return whole
        with broken(rule):
            return _fly(self._plan(name))

    def _plan(self, name: str) -> Plan:
        if name.isdecimal():
            return draw(self.seed, int(name), self.known)
        return plan_of(name, self.seed, self.known)


def _fly(plan: Plan) -> Flown:
    result, margins = fly_near(plan)
    return Flown(result.violations, margins)


@functools.lru_cache(maxsize=1)
def flights_of(seed: int, known: tuple[Subject, ...]) -> Flights:
    """Return the flights of this process, with those that it has already flown."""
    return Flights(seed, known)


def notice(rule: str, flights: Flights, most: int, *, searched: bool = False) -> Noticed:
    """Fly until a flight notices the broken rule, at most ``most`` flights."""
    row = BROKEN[rule]
    names = _searched(rule, flights) if searched else map(str, range(most))
    for number, name in zip(range(1, most + 1), names, strict=False):
        found = flights.without(rule, name).violations
        if found and not flights.whole(name).violations:
            return Noticed(rule, row.rule, number, _in_words(found[0]))
    return Noticed(rule, row.rule, None, "", unseen(rule, flights.vehicle))


def _searched(rule: str, flights: Flights) -> Iterator[str]:
    """Yield the flights of a search that learns from the broken program alone."""
    search = Search(flights.known)
    while True:
        names = search.generation()
        yield from names
        for name in names:
            flown = flights.without(rule, name)
            search.tell(name, flown.margins, broken=bool(flown.violations))


def in_table(noticed: Noticed) -> str:
    """Return a row of the table in docs/quality.md."""
    seen = "no" if noticed.flights is None else str(noticed.flights)
    return f"| {noticed.name} | {noticed.rule} | {seen} | {noticed.by or noticed.reason} |"


def _in_words(violation: Violation) -> str:
    return f"{violation.kind}: {violation.says.splitlines()[-1]}"
