"""The order in which a search flies the rows: each next one acts by the safety rules that the rows
before it acted by least.

    make first-round      writes first_round.txt anew: ten minutes of two cores

A rule acts in a flight that would be another without it, in any byte. One flight of each row says
so, with a seed that no other campaign has (as tests are put in order by the faults that they could
expose: Rothermel, Untch, Chu and Harrold, IEEE Transactions on Software Engineering 27, 2001).
Shipped missions, which take as long as several scenes, come last. A row that is not in the file,
since it is new, comes first.

What does not live here: what a search flies next (search), how a rule is broken (broken).
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from mission.verification.campaign.broken import broken
from mission.verification.campaign.draw import Plan, Subject, rows
from mission.verification.campaign.faults import fly_near, shipped, subjects
from mission.verification.campaign.reached import reached
from mission.verification.campaign.staging import scenes_of
from mission.verification.campaign.steered import plan_of
from mission.verification.workers import working
from mission.verification.workers.outcome import Lost
from mission.verification.workers.places import place

FILE = Path(__file__).with_name("first_round.txt")
VEHICLE = "auv"  # the others' rows are among its own, but for those that it has not
_SEED = 0
_AGAIN = 0.3  # of its worth: a rule that one more row before has acted by


def in_order(known: Sequence[str]) -> list[str]:
    """These rows, each once."""
    order = {row: place for place, row in enumerate(FILE.read_text("utf-8").split())}
    return sorted(known, key=lambda row: (order.get(row, -1), row))


def acts(known: Sequence[Subject], row: str) -> frozenset[str]:
    """The rules without which a flight of the row would be another."""
    plan = plan_of(f"{row}/0", _SEED, known)
    with reached() as rules:
        whole = fly_near(plan)[0].digest
    return frozenset(rule for rule in rules if _without(rule, plan) != whole)


def ordered(acted: Mapping[str, Iterable[str]], scenes: Iterable[str]) -> list[str]:
    """``acted``: rules by row; ``scenes``: the rows that come before the others."""
    before: Counter[str] = Counter()
    first = set(scenes)

    def worth(row: str) -> tuple[bool, float, str]:
        return row in first, sum(_AGAIN ** before[rule] for rule in sorted(acted[row])), row

    left, order = set(acted), []
    while left:
        order.append(max(left, key=worth))
        left.remove(order[-1])
        before.update(acted[order[-1]])
    return order


def _without(rule: str, plan: Plan) -> str:
    with broken(rule):
        return fly_near(plan)[0].digest


def main() -> None:
    known = subjects(shipped(), VEHICLE)
    names = rows(known)
    with working(functools.partial(acts, known), place()) as batch:
        found = dict(zip(names, batch(names), strict=True))
    acted = {row: rules for row, rules in found.items() if not isinstance(rules, Lost)}
    order = ordered(acted, scenes_of(VEHICLE))
    FILE.write_text("\n".join(order) + "\n", "utf-8")


if __name__ == "__main__":
    main()
