"""The lines of a mission during its upload (R3): a set beside the stored one, until it is whole.

    line 1      begins a set and drops the previous one, as another total does; a repeated line 1
                drops nothing if it has a sum, because no other mission has that sum
    line 2..n   in any order, any number of times; a line already held has no effect
    whole       each offer returns ``Whole`` until the set is stored (``clear``) or dropped:
                sending one line again can repair a set that was refused
    10 minutes  without a line drop the set

What does not live here: judging the mission (language, compiler, check), the store, the frames.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from protocol.messages import MissionLine

GREATEST_TOTAL = 9999  # E-F3: a line cut inside its counters always claims more
FORGOTTEN_AFTER_S = 600.0
_SUM = " sum "
MISSING_CHARACTERS = 120  # in an @AR; the sender sends these lines, then asks again


@dataclass(frozen=True, slots=True)
class Held:
    """The line is held, or repeats one of the stored mission."""


@dataclass(frozen=True, slots=True)
class Whole:
    """All lines of the set are held."""

    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class OutOfPlace:
    """The line belongs to no set."""

    why: str


class Staging:
    def __init__(self) -> None:
        self._lines: dict[int, str] = {}
        self._total = 0
        self._last = 0.0  # when the last line came

    def offer(
        self, line: MissionLine, stored: tuple[str, ...], now: float
    ) -> Held | Whole | OutOfPlace:
        self.forget(now)
        if line.total > GREATEST_TOTAL:
            return OutOfPlace(f"{line.total} lines: a mission has at most {GREATEST_TOTAL}")
        if not 1 <= line.current <= line.total:
            return OutOfPlace(f"line {line.current} of {line.total}: count from 1 to the total")
        if line.total != self._total or (line.current == 1 and not self._goes_on(line.payload)):
            self.clear()
            if line.current != 1:
                return _repeated(line, stored)
        self._total, self._last = line.total, now
        self._lines[line.current] = line.payload
        if len(self._lines) < self._total:
            return Held()
        return Whole(tuple(self._lines[i] for i in range(1, self._total + 1)))

    def _goes_on(self, first: str) -> bool:
        """Whether this line 1 is of the same mission. Without a sum, an edited script may begin
        like the previous one, and lines of both would be mixed."""
        return _SUM in first and first == self._lines.get(1)

    def holds(self, line: MissionLine) -> bool:
        return line.total == self._total and self._lines.get(line.current) == line.payload

    def copy(self) -> Staging:
        """Return a copy, to try further lines on."""
        other = Staging()
        other._lines, other._total, other._last = dict(self._lines), self._total, self._last
        return other

    def forget(self, now: float) -> None:
        if self._total and now - self._last >= FORGOTTEN_AFTER_S:
            self.clear()

    def clear(self) -> None:
        self._lines, self._total = {}, 0

    def incomplete(self, stored: tuple[str, ...], now: float) -> bool:
        """Whether lines are missing. False if all lines so far repeat the stored mission (a late
        duplicate of a finished upload), as the sum in its line 1 shows."""
        self.forget(now)
        repeats = self._goes_on("".join(stored[:1])) and all(
            len(stored) == self._total and stored[i - 1] == payload
            for i, payload in self._lines.items()
        )
        return len(self._lines) < self._total and not repeats

    @property
    def total(self) -> int:
        return self._total

    @property
    def have(self) -> int:
        return len(self._lines)

    @property
    def missing(self) -> str:
        """Ranges of line numbers, ``3-5.9``, as many as fit."""
        texts: list[str] = []
        for first, last in _ranges(i for i in range(1, self._total + 1) if i not in self._lines):
            texts.append(str(first) if first == last else f"{first}-{last}")
            if len(".".join(texts)) > MISSING_CHARACTERS:
                texts.pop()
                break
        return ".".join(texts)


def _repeated(line: MissionLine, stored: tuple[str, ...]) -> Held | OutOfPlace:
    if line.total == len(stored) and stored[line.current - 1] == line.payload:
        return Held()
    return OutOfPlace(f"line {line.current} of {line.total} before its line 1: send line 1 first")


def _ranges(numbers: Iterable[int]) -> list[tuple[int, int]]:
    """Return rising numbers as (first, last) of each run without a gap."""
    runs: list[tuple[int, int]] = []
    for number in numbers:
        if runs and runs[-1][1] == number - 1:
            runs[-1] = (runs[-1][0], number)
        else:
            runs.append((number, number))
    return runs
