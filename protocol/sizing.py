"""The best length of an acoustic burst and of its blocks, from what the channel has shown so far.

Bytes are lost in two ways: a whole burst is lost (probability ``loss``), or a bit error spoils the
block that it is in (``errors`` per bit). Every result is evidence of both:

    P(a block comes, of a burst that came) = exp(-8 errors (bytes of the block))
    P(question and answer come) = (1 - loss)^2 exp(-8 errors (bytes of both))

Bayes' rule gives the posterior over a small grid of both, from a prior that excludes neither. From
it follow the expected bytes per second of each length of burst and block, of which the best is
taken. No constant has to be tuned at sea.

What does not live here: what is sent (protocol.batch), when (protocol.arq).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from protocol.arq import GATHER, SOUND_SPEED, Acoustics
from protocol.modem import MOST, OVERHEAD

LOSSES = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5)
ERRORS = (0.0, 1e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3)
PRIOR = (0.2, 0.15, 0.15, 0.15, 0.15, 0.1, 0.1)  # of ERRORS; all LOSSES are equally likely
SIZES = (100, 150, 225, 340, 500, 750, 1100, 1600, 2300, MOST)
BLOCKS = (1, 2, 3, 5, 8, 13, MOST)  # lines
_QUESTION = 4  # bytes


@dataclass(frozen=True, slots=True)
class Plan:
    """Bytes of a burst, and of one block in it. If they are equal, the burst is one block."""

    size: int
    block: int


@dataclass(frozen=True, slots=True)
class Task:
    """Bytes: those ``left`` to send, their average ``line``, the ``head`` that every burst also
    has, the ``answer`` that is expected, and the ``longest`` answer that the timeout allows."""

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
        """Return P(no bit error) in a content of ``size`` bytes."""
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
        """Learn from an exchange of so many bytes of content: answered or not."""
        for guess in self._guesses:
            both = guess.arrives(request) * guess.arrives(answer)
            guess.weight *= both if came else 1.0 - both
        self._norm()

    def learn_block(self, size: int, *, came: bool) -> None:
        """Learn from a block of a burst that arrived: whole or spoilt."""
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
        """Whether a short question is better than repeating a burst of ``size`` bytes, which was
        sent ``sent`` times without an answer. With p = P(the burst arrived), t the time of its way
        and q the mean time of a question: if t p > q (1 - p), a needless repetition costs more than
        a needless question."""
        asked = task.head + _QUESTION
        good, bad = self._seconds(asked, task)
        question = came = 0.0
        for guess in self._guesses:
            there, back = guess.arrives(asked), guess.arrives(task.answer)
            unanswered = there * (1.0 - back) / (1.0 - there * back)  # arrived, but no answer
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
        """Return the time, s, of an exchange: answered, and not answered."""
        water = self._acoustics
        travel = 2.0 * water.range_m / SOUND_SPEED
        good = travel + water.way(size) + water.way(task.answer) + GATHER
        return good, water.patience(size, task.longest)
