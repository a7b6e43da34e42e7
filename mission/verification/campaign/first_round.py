"""The order in which a search flies the rows first: each next one acts by the safety rules that the
rows before it acted by least.

    make first-round      writes first_round.txt anew

Which rules a row acts by is seen in two flights of it on the whole program, with a seed that no
other campaign has (additional coverage: Rothermel, Untch, Chu and Harrold, IEEE Transactions on
Software Engineering 27, 2001). Shipped missions, which take as long as several scenes, come last.
A row that is not in the file, since it is new, comes first.

What does not live here: what a search flies next (search), which rules act (reached).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from mission.verification.campaign.draw import Subject, rows
from mission.verification.campaign.faults import fly_near, shipped, subjects
from mission.verification.campaign.reached import reached
from mission.verification.campaign.staging import scenes_of
from mission.verification.campaign.steered import plan_of

FILE = Path(__file__).with_name("first_round.txt")
VEHICLE = "auv"  # the others' rows are among its own, but for those that it has not
_SEED, _FLIGHTS = 0, 2
_AGAIN = 0.2  # of its worth: a rule that one more row before has acted by


def in_order(known: Sequence[str]) -> list[str]:
    """These rows, each once."""
    order = {row: place for place, row in enumerate(FILE.read_text("utf-8").split())}
    return sorted(known, key=lambda row: (order.get(row, -1), row))


def acted_by(known: Sequence[Subject]) -> dict[str, tuple[frozenset[str], ...]]:
    """The rules by which each flight of a row acts."""
    return {
        row: tuple(_reached(f"{row}/{n}", known) for n in range(_FLIGHTS)) for row in rows(known)
    }


def ordered(acted: Mapping[str, Sequence[Iterable[str]]], scenes: Iterable[str]) -> list[str]:
    """``acted``: rules by row and flight; ``scenes``: the rows that come before the others."""
    before: Counter[str] = Counter()
    first = set(scenes)

    def worth(row: str) -> tuple[bool, float, str]:
        return row in first, sum(_AGAIN ** before[rule] for rule in _rules(acted[row])), row

    left, order = set(acted), []
    while left:
        order.append(max(left, key=worth))
        left.remove(order[-1])
        before.update(_rules(acted[order[-1]]))
    return order


def _rules(flights: Iterable[Iterable[str]]) -> list[str]:
    return sorted({rule for flight in flights for rule in flight})


def _reached(name: str, known: Sequence[Subject]) -> frozenset[str]:
    with reached() as rules:
        fly_near(plan_of(name, _SEED, known))
    return frozenset(rules)


def main() -> None:
    known = subjects(shipped(), VEHICLE)
    order = ordered(acted_by(known), scenes_of(VEHICLE))
    FILE.write_text("\n".join(order) + "\n", "utf-8")


if __name__ == "__main__":
    main()
