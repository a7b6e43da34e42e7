"""How long an acoustic burst should be, and its blocks: what the channel has shown, what pays best.

Two things lose bytes: something that takes a burst whole (``loss``), and wrong bits, of which one
spoils the block that it falls into (``errors`` per bit). What became of each says something:

    P(a block comes, of a burst that came) = exp(-8 errors (bytes of the block))
    P(question and answer come) = (1 - loss)^2 exp(-8 errors (bytes of both))

The posterior over a small grid of both, from a prior that takes neither for granted, gives the
expected bytes per second of each burst in blocks of each length; the best is taken (Bayes' rule, no
constant to tune at sea).

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
BLOCKS = (1, 2, 3, 5, 8, 13, MOST)  # lines
_QUESTION = 4  # bytes


@dataclass(frozen=True, slots=True)
class Plan:
    """Bytes of a burst, and of one block in it; a block of ``size`` is a burst in one piece."""

    size: int
    block: int


@dataclass(frozen=True, slots=True)
class Task:
    """Bytes: what is ``left``, a ``line`` of it on average, ``head`` beside it in every burst, the
    ``answer`` that is expected, and the ``longest`` that is waited for."""

    left: int
    line: int
    head: int
    answer: int
    longest: int


@dataclass(slots=True)
class _Guess:
    loss: float
    errors: float
    weight: float

    def whole(self, size: int) -> float:
        """P(no wrong bit) in a content of so many bytes."""
        return math.exp(-8.0 * self.errors * (size + OVERHEAD))

    def arrives(self, size: int) -> float:
        return (1.0 - self.loss) * self.whole(size)


class Channel:
    def __init__(self, acoustics: Acoustics) -> None:
        self._acoustics = acoustics
        self._guesses = [
            _Guess(loss, errors, prior)
            for loss in LOSSES
            for errors, prior in zip(ERRORS, PRIOR, strict=True)
        ]
        self._norm()

    def learn(self, request: int, answer: int, *, came: bool) -> None:
        """An exchange of so many bytes of content: answered or not."""
        for guess in self._guesses:
            both = guess.arrives(request) * guess.arrives(answer)
            guess.weight *= both if came else 1.0 - both
        self._norm()

    def learn_block(self, size: int, *, came: bool) -> None:
        """A block of a burst that came: whole or spoilt."""
        for guess in self._guesses:
            whole = guess.whole(size)
            guess.weight *= whole if came else max(1.0 - whole, 1e-6)
        self._norm()

    def best(self, task: Task) -> Plan:
        plans = {
            Plan(size, min(size, task.line * lines)): None for size in SIZES for lines in BLOCKS
        }
        return max(plans, key=lambda plan: self._bytes_per_second(plan, task))

    def asking_pays(self, size: int, sent: int, task: Task) -> bool:
        """Whether a question is better than a burst of so many bytes said again, after ``sent`` of
        them without an answer. With p = P(the burst came), t the time of its way and q the mean
        time of a question: where t p > q (1 - p), what is said in vain costs more than what is
        asked so."""
        asked = task.head + _QUESTION
        good, bad = self._seconds(asked, task)
        question = came = 0.0
        for guess in self._guesses:
            there, back = guess.arrives(asked), guess.arrives(task.answer)
            unanswered = there * (1.0 - back) / (1.0 - there * back)  # came, and yet no answer
            question += guess.weight * (there * back * good + (1.0 - there * back) * bad)
            came += guess.weight * (1.0 - (1.0 - unanswered) ** sent)
        return self._acoustics.way(size) * came > question * (1.0 - came)

    def _norm(self) -> None:
        total = sum(guess.weight for guess in self._guesses)
        for guess in self._guesses:
            guess.weight /= total

    def _bytes_per_second(self, plan: Plan, task: Task) -> float:
        content = min(plan.size, task.left + task.head + _QUESTION)
        block = min(plan.block, content)
        pieces = -(-content // block)
        asked, head = content, task.head + _QUESTION
        if pieces > 1:  # line 1 goes first and, with the question, last
            asked, head = head, head + task.head
        good, bad = self._seconds(content + (OVERHEAD * pieces if pieces > 1 else 0), task)
        gain = seconds = 0.0
        for guess in self._guesses:
            held = guess.whole(block) if pieces > 1 and task.head else 1.0
            both = guess.arrives(asked) * guess.arrives(task.answer)
            gain += guess.weight * guess.arrives(block) * held * max(0, content - head)
            seconds += guess.weight * (both * good + (1.0 - both) * bad)
        return gain / seconds

    def _seconds(self, size: int, task: Task) -> tuple[float, float]:
        """That an exchange takes: answered, and not answered."""
        water = self._acoustics
        travel = 2.0 * water.range_m / SOUND_SPEED
        good = travel + water.way(size) + water.way(task.answer) + GATHER
        return good, water.patience(size, task.longest)
