"""Flights by name: the row that they belong to, and how near they are to another flight.

    heavy_for_ever/3        the fourth flight of this row of the tables
    heavy_for_ever/3/0/2    the third neighbour of its first neighbour

A flight depends on the seed and its name alone, not on earlier flights. A plan is drawn from a
point: the first DIMENSIONS random numbers. Among four flights of a row, each number is once in each
quarter of its range; among each two, once in each half (Latin hypercubes: McKay, Beckman, Conover,
Technometrics 21, 1979). So a few flights try both profiles and all parts of a range. A neighbour is
the same point moved a little, and sometimes by any distance in one number (Kelemen et al., A simple
and robust mutation strategy, Eurographics 2002).

What does not live here: which flights are flown (search), what the numbers mean (draw).
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import TYPE_CHECKING, TypeVar

from mission.verification.campaign.draw import (
    Plan,
    Subject,
    draw_row,
    on_profile,
    profiles_of,
    rows,
)

if TYPE_CHECKING:
    from _typeshed import SupportsLenAndGetItem

_T = TypeVar("_T")
DIMENSIONS = 48
NEAR, ANEW = 0.04, 0.08  # share of the range: a neighbour's distance; chance of any distance


class Steered(Random):
    """Returns the numbers of ``point`` first, each in [0, 1), and then those of ``seed``."""

    def __init__(self, seed: str, point: Sequence[float]) -> None:
        super().__init__(seed)
        self._ahead = iter(point)

    def random(self) -> float:
        ahead = next(self._ahead, None)
        return super().random() if ahead is None else ahead

    def choice(self, seq: SupportsLenAndGetItem[_T]) -> _T:
        """Choose by the part of the range that the number is in; Random uses its last bits."""
        return seq[int(self.random() * len(seq))]

    def randint(self, a: int, b: int) -> int:
        return a + int(self.random() * (b - a + 1))


def neighbour(name: str, number: int) -> str:
    return f"{name}/{number}"


def plan_of(name: str, seed: int, subjects: Sequence[Subject]) -> Plan:
    """Return the plan of a flight. Raises ValueError for a name that is none."""
    row, *numbers = name.split("/")
    if row not in rows(subjects) or not numbers or not all(map(str.isdecimal, numbers)):
        raise ValueError(f"no flight {name!r}: a row of the tables, and /0 or more")
    number, *moves = map(int, numbers)
    rng = Steered(f"steered {seed} {name}", _point(seed, row, number, moves))
    # First: otherwise the count of numbers before it would be random, too.
    profile = rng.choice(profiles_of(subjects[0].vehicle))
    return on_profile(draw_row(row, rng, seed, number, subjects), profile)


def _point(seed: int, row: str, number: int, moves: Sequence[int]) -> list[float]:
    rng = Random(f"row {seed} {row} {number // 4}")
    quarters = [_quarters(rng)[number % 4] for _ in range(DIMENSIONS)]
    name = f"{row}/{number}"
    rng = Random(f"flight {seed} {name}")
    point = [(quarter + rng.random()) / 4.0 for quarter in quarters]
    for move in moves:
        name = neighbour(name, move)
        rng = Random(f"move {seed} {name}")
        point = [_moved(rng, x) for x in point]
    return point


def _quarters(rng: Random) -> list[int]:
    """Return 0 to 3 in an order whose first two, and last two, are in different halves."""
    low, high = rng.sample((0, 1), 2), rng.sample((2, 3), 2)
    return [quarter for pair in zip(low, high, strict=True) for quarter in rng.sample(pair, 2)]


def _moved(rng: Random, x: float) -> float:
    near, anew = rng.gauss(0.0, NEAR), rng.random()
    return rng.random() if anew < ANEW else (x + near) % 1.0
