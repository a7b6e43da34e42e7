"""The interface of navigation, and of its local frame, that the engine uses.

What does not live here: the filter itself (mission.navigation), what the engine makes of it
(vehicle_state).
"""

from __future__ import annotations

from typing import Any, Protocol

from mission.model import Estimate, Health, Position, Vertical
from protocol.messages import Aid, Fix, Telemetry


class Frame(Protocol):
    @property
    def origin(self) -> Position: ...

    def to_local(self, latitude: float, longitude: float) -> tuple[float, float]: ...

    def to_geodetic(self, north: float, east: float) -> tuple[float, float]: ...


class Navigator(Protocol):
    """The methods of mission.navigation.Navigation that the engine calls."""

    @property
    def frame(self) -> Frame | None: ...

    def set_origin(self, position: Position, now: float) -> None: ...

    def start_here(self, now: float, within: float = 0.0) -> None: ...

    def assume_current(self, most: float) -> None: ...

    def telemetry(self, t: Telemetry, push: Vertical) -> None: ...

    def fix(self, f: Fix) -> None: ...

    def less_off(self, own: Fix) -> Fix: ...

    def aid(self, a: Aid) -> None: ...

    def estimate(self, now: float) -> Estimate | None: ...

    def health(self, sensor: str, now: float) -> Health: ...

    def snapshot(self) -> Any: ...

    def restore(self, snapshot: Any) -> None: ...
