"""What sensors say instead of the truth, and boards that act on their own.

A `Lie` stands between a true value and what is told. Sources: what went wrong at sea ("cables, plugs and
boards failed at random: sensors fell silent, came back, or gave full-scale garbage"; "it dived by
itself at full power, more than once, with no command known, and did not stop").
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field

Lie = Callable[[float, float], float]  # (time s, truth) -> told


def honest(_now: float, truth: float) -> float:
    """The truth."""
    return truth


def clogged(value: float, seed: int, noise: float = 0.03) -> Lie:
    """A closed port: the pressure that was caught in it, and the converter's noise."""
    draw = random.Random(f"clogged {seed}")
    return lambda _now, _truth: value + draw.gauss(0, noise)


def drifting(since: float, rate: float) -> Lie:
    """A reading that leaves the truth by `rate` a second; negative: it tells too little."""
    return lambda now, truth: truth + rate * (now - since)


def shifted(by: float) -> Lie:
    """A constant offset, from one report to the next."""
    return lambda _now, truth: truth + by


def slow(by: float) -> Lie:
    """The truth as it was `by` seconds ago."""
    past: list[tuple[float, float]] = []

    def tell(now: float, truth: float) -> float:
        past.append((now, truth))
        while len(past) > 1 and past[1][0] <= now - by:
            past.pop(0)
        return past[0][1]

    return tell


def garbage(seed: int, full: float = 1000.0) -> Lie:
    """Full-scale values in turn."""
    draw = random.Random(f"garbage {seed}")
    return lambda _now, _truth: draw.choice((-full, full, 0.0))


def flicker(around: float, by: float, seed: int) -> Lie:
    """A value that swings evenly around a place: 21 +- 0.8 V."""
    draw = random.Random(f"flicker {seed}")
    return lambda _now, _truth: around + draw.uniform(-by, by)


@dataclass
class Will:
    """A board's own will: verticals at `gear`, whatever it was told, until a word that it obeys.

    `obeys` has code letters of Z words (`U`, `X`, ...). `again`: seconds until it begins anew after
    it has obeyed; None: never. `times`: so often in all.
    """

    gear: float = -10.0
    obeys: frozenset[str] = frozenset("U")
    again: float | None = None
    times: int = 1_000_000
    active: bool = field(default=True)
    _resumes: float = field(default=0.0)

    def heard(self, now: float, code: str) -> None:
        """A word came."""
        if code in self.obeys and self.active:
            self.active = False
            self.times -= 1
            never = self.again is None or self.times <= 0
            self._resumes = float("inf") if never else now + float(self.again or 0)

    def rules(self, now: float) -> bool:
        """Whether the board's own will decides now."""
        if not self.active and now >= self._resumes:
            self.active = True
        return self.active
