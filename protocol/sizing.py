"""How long an acoustic content should be: what the channel has shown so far, and what pays best.

Two things lose a frame: something that takes it whole (``loss``), and wrong bits, of which one is
enough (``errors`` per bit). Every exchange says something about both:

    P(request and answer come) = (1 - loss)^2 exp(-8 errors (bytes of both))

The posterior over a small grid of both, from a prior that takes neither for granted, gives the
expected bytes per second of each candidate size; the best one is taken (Bayes' rule, no constant
to tune at sea).

What does not live here: what is sent (protocol.batch), when (protocol.arq).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from protocol.arq import GATHER, SOUND_SPEED, Acoustics
from protocol.modem import MOST, OVERHEAD

LOSSES = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5)
ERRORS = (0.0, 1e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3)
PRIOR = (0.2, 0.15, 0.15, 0.15, 0.15, 0.1, 0.1)  # of ERRORS; the losses are alike
SIZES = (100, 150, 225, 340, 500, 750, 1100, 1600, 2300, MOST)


@dataclass(slots=True)
class _Guess:
    loss: float
    errors: float
    weight: float

    def arrives(self, size: int) -> float:
        return (1.0 - self.loss) * math.exp(-8.0 * self.errors * (size + OVERHEAD))


class Channel:
    def __init__(self, acoustics: Acoustics) -> None:
        self._acoustics = acoustics
        self._guesses = [
            _Guess(loss, errors, prior)
            for loss in LOSSES
            for errors, prior in zip(ERRORS, PRIOR, strict=True)
        ]

    def learn(self, request: int, answer: int, *, came: bool) -> None:
        """An exchange of so many bytes of content: answered or not."""
        for guess in self._guesses:
            both = guess.arrives(request) * guess.arrives(answer)
            guess.weight *= both if came else 1.0 - both
        total = sum(guess.weight for guess in self._guesses)
        for guess in self._guesses:
            guess.weight /= total

    def best_size(self, left: int, overhead: int, answer: int, longest_answer: int) -> int:
        """``left`` bytes are to be sent, ``overhead`` of every content are something else."""
        return max(
            SIZES,
            key=lambda size: self._bytes_per_second(size, left, overhead, answer, longest_answer),
        )

    def _bytes_per_second(
        self, size: int, left: int, overhead: int, answer: int, longest_answer: int
    ) -> float:
        size = min(size, left + overhead)
        water = self._acoustics
        travel = 2.0 * water.range_m / SOUND_SPEED
        good = travel + water.airtime(size) + water.airtime(answer) + GATHER
        bad = water.patience(size, longest_answer)
        gain = seconds = 0.0
        for guess in self._guesses:
            arrives = guess.arrives(size)
            both = arrives * guess.arrives(answer)
            gain += guess.weight * arrives * max(0, size - overhead)
            seconds += guess.weight * (both * good + (1.0 - both) * bad)
        return gain / seconds
