"""What was flown in a simulation: mission, vehicle, sea, seed, and the values that the seed drew.

What does not live here: the results (flightlog, legtable).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from links.simulated.sea import Sea

Current = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Flown:
    """``profile``: "" for a board that has only one. ``compass_bias``: the true bias, rad; None for
    a board whose compass has none."""

    mission: str
    vehicle: str
    profile: str
    seed: int
    settings: Sequence[str]  # the texts of --set, as given
    sea: Sea
    compass_bias: float | None
    drives: bool = False  # on the ground, without a sea

    def as_object(self) -> dict[str, Any]:
        bias = self.compass_bias
        return {
            "mission": self.mission,
            "vehicle": self.vehicle,
            "profile": self.profile,
            "seed": self.seed,
            "settings": list(self.settings),
            "sea": {
                "current": _current_object(self.sea.current),
                "deep_current": _current_object(self.sea.deep_current or self.sea.current),
                "floor_m": self.sea.floor,
                **({"bathymetry": self.sea.floor_from} if self.sea.floor_from else {}),
            },
            "compass_bias_deg": None if bias is None else round(math.degrees(bias), 3),
        }

    def as_notes(self) -> dict[str, str]:
        """Return notes for the metadata of a black box, and so for a page of it."""
        return {
            "mission": self.mission,
            "simulated": self.profile or self.vehicle,
            "seed": str(self.seed),
            "sea": self._where,
            "set": " ".join(self.settings),
        }

    @property
    def caption(self) -> str:
        """Sea, settings and seed, for a picture."""
        said = f"set {' '.join(self.settings)}" if self.settings else ""
        return ", ".join(filter(None, (self._where, said, f"seed {self.seed}")))

    def as_lines(self) -> list[str]:
        """Return rows in the form of the figures."""
        bias = self.compass_bias
        compass = "none" if bias is None else f"{math.degrees(bias):+.1f} deg (true)"
        profile = f", {self.profile}" if self.profile else ""
        return [
            f"simulated         {self.mission} on {self.vehicle}{profile}",
            f"sea               {self._where}",
            f"set               {' '.join(self.settings) or 'nothing'}",
            f"seed              {self.seed}",
            f"compass bias      {compass}",
        ]

    @property
    def _where(self) -> str:
        return "on the ground" if self.drives else _sea(self.sea)


def _current_object(current: Current) -> dict[str, float]:
    speed, towards = current
    return {"speed_m_s": speed, "towards_deg": round(math.degrees(towards), 3)}


def _sea(sea: Sea) -> str:
    deep = "" if sea.deep_current is None else f" ({_current(sea.deep_current)} at the floor)"
    other = f" where {sea.floor_from} knows none" if sea.floor_from else ""
    return f"{_current(sea.current)}{deep}, floor at {round(sea.floor, 1):g} m{other}"


def _current(current: Current) -> str:
    speed, towards = current
    if not speed:
        return "no current"
    return f"current {round(speed, 3):g} m/s towards {math.degrees(towards):.0f} deg"
