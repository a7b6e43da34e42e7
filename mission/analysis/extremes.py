"""The greatest depth and distance and the least altitude of a vehicle, by its own readings.

    reports and states --Extremes--> sentences

A quantity that the vehicle cannot measure is not reported: a vehicle without a depth sensor was not
"0 m deep".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mission.model.shown import clock

TRACKED_BY = frozenset({"heading", "position"})  # with neither, the estimate stays at home


class Extremes:
    """The extremes of one run of the program while a mission or an emergency is under way: depths,
    altitudes and distances in m, with their times."""

    def __init__(self) -> None:
        self._deepest: tuple[float, float] | None = None
        self._lowest: tuple[float, float] | None = None
        self._farthest: tuple[float, float] | None = None
        self.last: float | None = None  # m, by the newest report; None if it is not believed

    @property
    def at_last(self) -> str:
        return "" if self.last is None else f", {max(self.last, 0.0):.1f} m deep by its last report"

    def report(self, t: float, depth: float | None) -> None:
        """``depth``: m; one that is believed."""
        if depth is not None and (self._deepest is None or depth > self._deepest[0]):
            self._deepest = depth, t

    def state(
        self, t: float, state: Mapping[str, Any], altitude_believed: bool, away: float | None
    ) -> None:
        """``away``: m from home; None if the vehicle cannot tell."""
        low = state["altitude_m"]
        if low is not None and altitude_believed:
            self._lowest = min(self._lowest or (low, t), (low, t))
        if away is not None and (self._farthest is None or away > self._farthest[0]):
            self._farthest = away, t

    def says(self) -> Iterator[str]:
        said = []
        if self._deepest is not None:
            deep, at = self._deepest
            said.append(f"by its own reports it was {deep:.1f} m deep at most, at {clock(at)}")
        if self._farthest is not None:
            away, at = self._farthest
            farthest = f"it was {away:.0f} m from home at its farthest, at {clock(at)}"
            said.append(f"by its own estimate {farthest}")
        if whole := ", and ".join(said):
            yield f"{whole[0].upper()}{whole[1:]}."
        if self._lowest is not None:
            metres, at = self._lowest
            yield f"By its altimeter the bottom was no nearer than {metres:.1f} m, at {clock(at)}."
