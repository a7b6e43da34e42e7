"""The order in which a search flies the rows: next is the row whose safety rules acted least in the
rows before it.

    make first-round      rewrites first_round.txt: ten minutes of two cores

A rule acts in a flight if the flight would differ without it, in any byte. One flight of each row
shows this, with a seed that no other campaign has. (Tests are ordered in the same way by the faults
that they could expose: Rothermel, Untch, Chu and Harrold, IEEE Transactions on Software Engineering
27, 2001.) Shipped missions come last, since each takes as long as several scenes. A new row, which
is not in the file, comes first.

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
VEHICLE = "auv"  # its rows include those of the others, but for scenes of boards alone
_SEED = 0
_AGAIN = 0.3  # factor of a rule's worth, for each earlier row in which it acted


def in_order(known: Sequence[str]) -> list[str]:
    """Return the rows in the order of the file; those that are not in it come first."""
    order = {row: place for place, row in enumerate(FILE.read_text("utf-8").split())}
    return sorted(known, key=lambda row: (order.get(row, -1), row))


def acts(known: Sequence[Subject], row: str) -> frozenset[str]:
    """Return the rules without which a flight of the row would differ."""
    plan = plan_of(f"{row}/0", _SEED, known)
    with reached() as rules:
        whole = fly_near(plan)[0].digest
    return frozenset(rule for rule in rules if _without(rule, plan) != whole)


def ordered(acted: Mapping[str, Iterable[str]], scenes: Iterable[str]) -> list[str]:
    """Return the rows in order. ``acted``: rules by row; ``scenes``: the rows that come first."""
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
