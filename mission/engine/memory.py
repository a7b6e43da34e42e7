"""The memory of guards: the extremes of a reading in this leg, and its peak in the leg before.

    temperature falls 2 C within 5 m            a Window, which starts empty with each leg
    depth back at highest metal within 0.5 m    a Peak: this leg's is kept for the next one

The memory is bounded: a window has at most PARTS parts, each with its least and greatest value, and
drops parts that are out of reach. Of each three reports in a row, at least 0.9 s apart, the median
is remembered, so that a single outlier is no peak. Values that are not believed are not remembered.

What does not live here: what follows from it (guards), which readings are believed (variables).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Self

from mission.engine.readings import Scope
from mission.engine.variables import Variable, row_of, value_of
from mission.model import Back, Chart, Trend, terms
from mission.model.copies import copied
from mission.model.vehicle import SAMPLED

PARTS = 32  # of a window; the memory reaches as far as the window, or up to 1/32 less

_Pair = tuple[float, float]


class Middle:
    """The median of each three samples in a row, and where the second one was."""

    __slots__ = ("_last",)

    def __init__(self) -> None:
        self._last: tuple[_Pair, ...] = ()  # two at most: value, where

    def clone(self) -> Self:
        return copied(self)

    def of(self, value: float, where: float) -> _Pair | None:
        """None until there are three."""
        three = (*self._last, (value, where))
        self._last = three[-2:]
        if len(three) < 3:
            return None
        return sorted(one[0] for one in three)[1], three[1][1]


class Window:
    """The extremes of a reading within ``reach`` (s, or m of depth) of the time or depth now."""

    __slots__ = ("_middle", "_parts", "_step")

    def __init__(self, reach: float) -> None:
        """An infinite ``reach`` is the whole leg."""
        self._step = reach / PARTS
        self._middle = Middle()
        self._parts: dict[int, _Pair] = {}  # least and greatest, by part

    def clone(self) -> Self:
        return copied(self)

    def take(self, at: float, value: float) -> None:
        here = self._part(at)
        found = self._middle.of(value, at)
        if found is not None:
            middle, part = found[0], self._part(found[1])
            low, high = self._parts.get(part, (middle, middle))
            self._parts[part] = min(low, middle), max(high, middle)
        for part in [p for p in self._parts if abs(p - here) >= PARTS]:
            del self._parts[part]

    def _part(self, at: float) -> int:
        return math.floor(at / self._step)

    def extreme(self, *, highest: bool) -> float | None:
        """None while nothing is remembered."""
        if not self._parts:
            return None
        if highest:
            return max(high for _, high in self._parts.values())
        return min(low for low, _ in self._parts.values())


class Peak:
    """The highest (or lowest) value of one reading, and the value of another one there."""

    __slots__ = ("_middle", "_sign", "best", "there")

    def __init__(self, highest: bool) -> None:
        self._sign = 1.0 if highest else -1.0
        self._middle = Middle()
        self.best, self.there = -math.inf, math.nan  # best: times the sign

    def clone(self) -> Self:
        return copied(self)

    def take(self, value: float, other: float) -> None:
        found = self._middle.of(value, other)
        if found is not None and self._sign * found[0] > self.best:
            self.best, self.there = self._sign * found[0], found[1]


class Memory:
    def __init__(self, chart: Chart) -> None:
        guards = [edge.guard for edge in chart.edges if edge.guard is not None]
        asked = dict.fromkeys(t for guard in guards for t in terms(guard.expression))
        self._backs = tuple(term for term in asked if isinstance(term, Back))
        self._sources = dict(chart.sources)
        self._rows: dict[str, Variable] = {}
        self._windows: dict[Trend, Window] = {}
        self._peaks: dict[Back, Peak] = {}
        self._before: dict[Back, float] = {}
        self._taken = -math.inf

    def clone(self) -> Self:
        windows = {term: window.clone() for term, window in self._windows.items()}
        peaks = {term: peak.clone() for term, peak in self._peaks.items()}
        return copied(self, _windows=windows, _peaks=peaks)

    def begin(self, trends: Iterable[Trend], *, again: bool) -> None:
        """Begin a leg that watches ``trends``. ``again``: it is the interrupted leg, and the peaks
        of the leg before stay. A leg in which nothing was known leaves the peaks before it, too."""
        if not again:
            found = {b: peak.there for b, peak in self._peaks.items() if peak.best > -math.inf}
            self._before |= found
        self._windows = {trend: Window(trend.window) for trend in trends}
        self._peaks = {back: Peak(back.highest) for back in self._backs}
        asked = [name for trend in self._windows for name in trend.asks]
        asked += [name for back in self._backs for name in back.asks]
        self._rows = {name: row_of(name, self._sources) for name in dict.fromkeys(asked)}

    @property
    def watching(self) -> bool:
        return bool(self._rows)

    def take(self, scope: Scope) -> None:
        """Remember a report, once; of a fast board, one every ``SAMPLED`` s."""
        report = scope.telemetry
        if report is None or report.t < self._taken + SAMPLED:
            return
        self._taken = report.t
        known = {name: value_of(row, scope) for name, row in self._rows.items()}
        for trend, window in self._windows.items():
            value, at = known[trend.variable], known["depth"] if trend.of_depth else report.t
            if value is not None and at is not None:
                window.take(at, value)
        for back, peak in self._peaks.items():
            value, there = known[back.peak], known[back.variable]
            if value is not None and there is not None:
                peak.take(value, there)

    def extreme(self, trend: Trend) -> float | None:
        """The highest value if the trend falls, the lowest if it rises; None: not known."""
        window = self._windows.get(trend)
        return None if window is None else window.extreme(highest=not trend.rises)

    def peak(self, back: Back) -> float | None:
        """The variable's value at the peak of the leg before; None: not known."""
        return self._before.get(back)
