"""The sea of a simulated vehicle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

FloorAt = Callable[[float, float], float | None]  # latitude, longitude (rad) -> m
_AFLOAT = 0.5  # m: on land it would lie aground; the plant has no beach


@dataclass(frozen=True, slots=True)
class Sea:
    """``current`` is speed (m/s) and direction towards which it flows (rad)."""

    current: tuple[float, float] = (0.0, 0.0)
    deep_current: tuple[float, float] | None = None  # at the floor; linear in between
    floor: float = 30.0  # m
    floor_at: FloorAt | None = None  # by position; None there: ``floor``
    floor_from: str = ""  # source of ``floor_at``
    waves: tuple[float, float] = (0.0, 8.0)  # amplitude, m, and period, s

    def floor_under(self, place: tuple[float, float]) -> float:
        """Depth of the floor, m, at a latitude and longitude, rad; at least _AFLOAT."""
        known = None if self.floor_at is None else self.floor_at(*place)
        return self.floor if known is None else max(known, _AFLOAT)
