"""Wrong values that look plausible: a sensor that is stuck, drifting, late, or deaf.

There is one object for each value of ``Sensors.sample`` while it is wrong. What does not live here:
obviously bad sensors (sensors.Health), constant errors (``Sensors.bent``).
"""

from __future__ import annotations

from collections import deque
from random import Random
from typing import Protocol


class Wrong(Protocol):
    def says(self, value: float, t: float, rng: Random) -> float:
        """The value reported instead of ``value``, at ``t`` s. Call once per sample, in order."""
        ...


class Stuck:
    """Repeats its first value, with noise: a clogged pressure port."""

    def __init__(self, noise: float) -> None:
        self._noise, self._held = noise, float("nan")

    def says(self, value: float, t: float, rng: Random) -> float:
        if self._held != self._held:
            self._held = value
        return self._held + rng.gauss(0.0, self._noise)


class Deaf:
    """Reports one level, with noise, whatever the truth. A rebooted board reports 0 for a lost
    sensor; an altimeter without an echo receives its own pulse."""

    def __init__(self, level: float, noise: float = 0.0) -> None:
        self._level, self._noise = level, noise

    def says(self, value: float, t: float, rng: Random) -> float:
        return self._level + (rng.gauss(0.0, self._noise) if self._noise else 0.0)


class Drifting:
    """An error that grows by ``rate`` a second."""

    def __init__(self, rate: float) -> None:
        self._rate, self._since = rate, float("nan")

    def says(self, value: float, t: float, rng: Random) -> float:
        if self._since != self._since:
            self._since = t
        return value + self._rate * (t - self._since)


class Late:
    """Reports the value of ``seconds`` ago; at first its first value."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._values: deque[tuple[float, float]] = deque()

    def says(self, value: float, t: float, rng: Random) -> float:
        values = self._values
        values.append((t, value))
        while len(values) > 1 and values[1][0] <= t - self._seconds:
            values.popleft()
        return values[0][1]
