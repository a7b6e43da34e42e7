"""What a sensor that is wrong, and looks well, makes of its value: stuck, drifting, late, or deaf.

One object for each slot of ``Sensors.sample``, for as long as it is wrong. What does not live
here: sensors that look ill (sensors.Health), constant errors (``Sensors.bent``).
"""

from __future__ import annotations

from collections import deque
from random import Random
from typing import Protocol


class Wrong(Protocol):
    def says(self, value: float, t: float, rng: Random) -> float:
        """Instead of ``value``, at ``t`` s; called once for each sample, in order."""
        ...


class Stuck:
    """Goes on about its first value, with noise: a port that is clogged."""

    def __init__(self, noise: float) -> None:
        self._noise, self._held = noise, float("nan")

    def says(self, value: float, t: float, rng: Random) -> float:
        if self._held != self._held:
            self._held = value
        return self._held + rng.gauss(0.0, self._noise)


class Deaf:
    """Says one level, whatever is true, with noise: a board that has begun anew says 0 of a sensor
    that is gone; an altimeter without an echo hears its own pulse."""

    def __init__(self, level: float, noise: float = 0.0) -> None:
        self._level, self._noise = level, noise

    def says(self, value: float, t: float, rng: Random) -> float:
        return self._level + (rng.gauss(0.0, self._noise) if self._noise else 0.0)


class Drifting:
    """Off by more and more, ``rate`` a second."""

    def __init__(self, rate: float) -> None:
        self._rate, self._since = rate, float("nan")

    def says(self, value: float, t: float, rng: Random) -> float:
        if self._since != self._since:
            self._since = t
        return value + self._rate * (t - self._since)


class Late:
    """Says what it would have said ``seconds`` ago; at first its first value."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._values: deque[tuple[float, float]] = deque()

    def says(self, value: float, t: float, rng: Random) -> float:
        values = self._values
        values.append((t, value))
        while len(values) > 1 and values[1][0] <= t - self._seconds:
            values.popleft()
        return values[0][1]
