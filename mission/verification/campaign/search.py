"""A search for flights that break a law: rows in turn, and neighbours of the nearest flights.

Random draws fly some rows thrice before others once. A round is one flight of each row of the
tables, in the order of ``first_round``: first the rows in which rules act that have not acted in
the rows before. From the second round on, two of three flights belong to the rounds. One is a
neighbour of the flight that came nearest to breaking some law, with less than half of its bound
left. The laws take turns: first those whose neighbours were tried least often in vain, then those
with less left. So no easy law takes all flights. A neighbour that comes nearer replaces its parent
(importance splitting, one level at a time; Cerou and Guyader, Stochastic Analysis and Applications
25, 2007). A flight that breaks a law is reported, and does not steer the search.

The search asks for a whole generation, and learns its results before the next. So the flights
depend on the seed and the results alone, never on the workers.

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
Searched = tuple[FlightResult, dict[str, float]]  # with the margins, by law
NEARLY = 0.5  # share of the bound: a law with more left is not followed up


@dataclass(slots=True)
class Nearest:
    """The flight that came nearest to one law; ``tried`` counts its neighbours since, in vain."""

    name: str
    left: float
    tried: int = 0


class Search:
    def __init__(self, known: Sequence[Subject]) -> None:
        self.nearest: dict[str, Nearest] = {}
        self._rows = in_order(rows(known))
        self._round: list[str] = []
        self._rounds = 0
        self._neighbours: dict[str, int] = {}  # of each flight, so far

    def generation(self) -> list[str]:
        """Return the names of the next flights: first a whole round, later GENERATION of them."""
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
        """Take the result of a flight; ``margins`` by law."""
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
        """Return one neighbour for each law whose turn it is."""
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
    """Fly ``most`` flights that ``search`` asks for; yield their names and results."""
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
    """Fly a flight by its name. Raises ValueError for an unknown name (steered)."""
    return fly_near(plan_of(name, seed, known))
