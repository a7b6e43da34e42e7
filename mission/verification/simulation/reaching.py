"""Whether a flight truly achieved what its legs were flown for (`achieve`).

coverage    the share of the area that was truly seen (coverage.py)
position    m, the greatest true error of the estimate along the leg
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from mission.legs.purposes import purposes
from mission.model import Aims, Mission
from mission.verification.simulation.coverage import Coverage, coverage_of, is_of
from mission.verification.simulation.flightlog import Flight

_UNIT = {"coverage": (100.0, "%"), "position": (1.0, "m")}


@dataclass(frozen=True, slots=True)
class Achieved:
    """``figures`` has the value that was reached for each aim; an aim is missing if the leg was
    never flown."""

    leg: str
    aims: Aims
    figures: Aims

    @property
    def reached(self) -> bool:
        found = dict(self.figures)
        return all(
            name in found and (found[name] >= aim if name == "coverage" else found[name] <= aim)
            for name, aim in self.aims
        )


def achieved_by(
    flight: Flight, mission: Mission, covered: Iterable[Coverage] | None = None
) -> tuple[Achieved, ...]:
    """Return what each leg with an aim achieved, in the mission's order. ``covered``: the result of
    ``coverage_of`` for this flight, if it is known already."""
    found = coverage_of(flight, mission) if covered is None else covered
    seen = {one.leg: one.true for one in found}
    return tuple(
        Achieved(path, tuple(sorted(aims.items())), tuple(_figures(flight, path, seen, aims)))
        for path, _, aims in purposes(mission)
    )


def _figures(
    flight: Flight, path: str, seen: dict[str, float], aims: dict[str, float]
) -> Iterable[tuple[str, float]]:
    if "coverage" in aims and path in seen:
        yield "coverage", seen[path]
    runs = [leg for leg in flight.legs if is_of(leg.name, path)]
    errors = [s.error for leg in runs for s in flight.samples if leg.entered <= s.t <= leg.left]
    if "position" in aims and errors:
        yield "position", max(errors)


def as_json_of(found: Iterable[Achieved]) -> list[dict[str, Any]]:
    return [
        {
            "leg": one.leg,
            "achieve": dict(one.aims),
            "achieved": {name: round(value, 4) for name, value in one.figures},
            "reached": one.reached,
        }
        for one in found
    ]


def told(found: Iterable[Achieved]) -> list[str]:
    """Return one line of text for each."""
    return [
        f"purpose           {one.leg}: {'reached' if one.reached else 'missed'}: "
        + ", ".join(_aim(one, name, aim) for name, aim in one.aims)
        for one in found
    ]


def _aim(one: Achieved, name: str, aim: float) -> str:
    factor, unit = _UNIT[name]
    value = dict(one.figures).get(name)
    came = "nothing" if value is None else f"{factor * value:.0f} {unit}"
    return f"{name} {came}, to be {factor * aim:g} {unit}"
