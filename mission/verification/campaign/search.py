"""A search for flights that break a law: rows in turn, and neighbours of what came nearest.

Chance flies some rows thrice before it has flown others once. A round is one flight of each row of
the tables, in the order of ``first_round``: those come first that act by rules by which the rows
before them did not act. From the second round on two of three flights are of the rounds, and one is
a neighbour of the flight that came nearest to breaking some law, with less than half of its bound
left. The laws take turns: first those whose neighbours were tried least often in vain, then those
with less left. So no easy law takes all. A neighbour that came nearer takes its parent's place
(importance splitting, one level at a time; Cerou and Guyader, Stochastic Analysis and Applications
25, 2007). What has broken a law is found: it is told, and not steered by.

A generation is asked for at once, and told before the next: what is flown depends on seed and
answers alone, never on the workers.

What does not live here: how a flight follows from its name (steered), how near it came (margins).
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from mission.verification.campaign.draw import Subject, rows
from mission.verification.campaign.faults import FlightResult, fly_near
from mission.verification.campaign.first_round import in_order
from mission.verification.campaign.steered import neighbour, plan_of
from mission.verification.workers import working
from mission.verification.workers.kept import Kept
from mission.verification.workers.outcome import Lost
from mission.verification.workers.places import Place
from mission.verification.workers.progress import Progress

GENERATION, STEERED = 18, 6  # flights after the first round; of them neighbours, at most
Searched = tuple[FlightResult, dict[str, float]]  # with how near it came, by law
NEARLY = 0.5  # of its bound: a law with more left is not followed up


@dataclass(slots=True)
class Nearest:
    """Of one law: the flight that came nearest; ``tried`` neighbours of it since, in vain."""

    name: str
    left: float
    tried: int = 0


class Search:
    def __init__(self, known: Sequence[Subject]) -> None:
        self.nearest: dict[str, Nearest] = {}
        self._rows = in_order(rows(known))
        self._round: list[str] = []
        self._rounds = 0
        self._neighbours: dict[str, int] = {}  # of a flight, so far

    def generation(self) -> list[str]:
        """The names of the flights that are due: the first round, later GENERATION."""
        if not self._rounds:
            self._begin_round()
            names, self._round = self._round, []
            return names
        steered = self._steered()
        explored = [self._next_of_round() for _ in range(GENERATION - len(steered))]
        names = []
        while explored:
            names += [*explored[:2], *steered[:1]]
            explored, steered = explored[2:], steered[1:]
        return names

    def tell(self, name: str, margins: Mapping[str, float], *, broken: bool) -> None:
        """What came of a flight; ``margins`` by law."""
        for law, left in () if broken else margins.items():
            known = self.nearest.get(law)
            if known is None or left < known.left:
                self.nearest[law] = Nearest(name, left)

    def _begin_round(self) -> None:
        self._round = [f"{row}/{self._rounds}" for row in self._rows]
        self._rounds += 1

    def _next_of_round(self) -> str:
        if not self._round:
            self._begin_round()
        return self._round.pop(0)

    def _steered(self) -> list[str]:
        """A neighbour each for the laws whose turn it is."""
        near = [known for known in self.nearest.values() if known.left < NEARLY]
        near.sort(key=lambda known: (known.tried, known.left))
        return [self._neighbour(known) for known in near[:STEERED]]

    def _neighbour(self, known: Nearest) -> str:
        known.tried += 1
        number = self._neighbours.get(known.name, 0)
        self._neighbours[known.name] = number + 1
        return neighbour(known.name, number)


def flown(
    search: Search,
    seed: int,
    most: int,
    known: Sequence[Subject],
    at: Place,
    kept: Kept[Searched] | None = None,
    progress: Progress | None = None,
) -> Iterator[tuple[str, FlightResult | Lost]]:
    """``most`` flights, with their names, as ``search`` asks for them."""
    work = functools.partial(fly_named, seed, known)
    with working(work, at, kept=kept, progress=progress) as batch:
        while most > 0:
            names = search.generation()[:most]
            most -= len(names)
            for name, done in zip(names, batch(names), strict=True):
                if isinstance(done, Lost):
                    yield name, done
                    continue
                result, margins = done
                search.tell(name, margins, broken=bool(result.violations))
                yield name, result


def fly_named(seed: int, known: Sequence[Subject], name: str) -> Searched:
    """ValueError for a name that is none (steered)."""
    return fly_near(plan_of(name, seed, known))
