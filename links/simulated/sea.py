"""The water that a simulated vehicle is in."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Sea:
    """``current`` is speed (m/s) and direction towards which it sets (rad)."""

    current: tuple[float, float] = (0.0, 0.0)
    deep_current: tuple[float, float] | None = None  # at the floor; linear in between
    floor: float = 30.0  # m
