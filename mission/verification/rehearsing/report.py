"""The results of many flights together: shares, spreads, use of the limits, and the worst ten."""

from __future__ import annotations

import math
import shlex
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from mission.verification.rehearsing.flights import Flown
from mission.verification.simulation.seafloor import TOUCHES

SHARES = (0.5, 0.9, 0.99)
WORST = 10
_Z = 1.96  # of a normal distribution: 95 %


@dataclass(frozen=True, slots=True)
class Spread:
    """Values that 5 %, half and 95 % of the flights do not exceed."""

    low: float
    middle: float
    high: float

    @staticmethod
    def of(values: Sequence[float]) -> Spread:
        ranked = sorted(values)
        return Spread(*(quantile(ranked, share) for share in (0.05, 0.5, 0.95)))


@dataclass(frozen=True, slots=True)
class Region:
    """The ellipse that holds ``share`` of the places where flights came up; m and rad."""

    share: float
    north: float
    east: float
    axes: tuple[float, float]  # half axes
    bearing: float  # of the longer one


@dataclass(frozen=True, slots=True)
class Rehearsal:
    flights: int
    outcomes: dict[str, int]
    chance: tuple[float, float]  # 95 % interval of the probability of completion
    time: Spread
    energy: Spread
    error: Spread
    coverage: dict[str, tuple[Spread, Spread]]  # by leg: true, by the estimate
    reached: dict[str, tuple[int, float, float]]  # by leg: flights, 95 % interval of the share
    regions: tuple[Region, ...]
    near: dict[str, float]  # for each limit, the greatest share that any flight used
    worst: tuple[Flown, ...]
    clearance: tuple[Spread, int] | None = None  # m over the floor of a file; flights aground
    legs: dict[str, int] = field(default_factory=dict)  # in how many flights each was flown
    given: tuple[str, ...] = ()  # settings of every flight
    undone: int = 0  # flights that nobody saw the end of; ``flights`` are the others

    @property
    def asked(self) -> int:
        return self.flights + self.undone

    @property
    def never(self) -> tuple[str, ...]:
        """Legs that no flight reached."""
        return tuple(leg for leg, flights in self.legs.items() if not flights)


def report_of(
    flown: Sequence[Flown],
    legs: Sequence[str] = (),
    given: Sequence[str] = (),
    undone: int = 0,
) -> Rehearsal:
    """Report on at least one flight. ``legs``: those of the mission; ``given``: settings of every
    flight; ``undone``: number of flights without a result, which widen each share."""
    came = Counter(leg for f in flown for leg in f.legs)
    completed = sum(f.outcome == "completed" for f in flown)
    return Rehearsal(
        flights=len(flown),
        outcomes=dict(Counter(f.outcome for f in flown)),
        chance=share_of(completed, len(flown), undone),
        time=Spread.of([f.time for f in flown]),
        energy=Spread.of([f.energy for f in flown]),
        error=Spread.of([f.error for f in flown]),
        coverage=_coverage(flown),
        reached=_reached(flown, undone),
        regions=regions([f.surfaced for f in flown if f.surfaced is not None]),
        near={name: max(dict(f.near)[name] for f in flown) for name, _ in flown[0].near},
        worst=tuple(sorted(flown, key=_goodness)[:WORST]),
        clearance=_clearance([f.clearance for f in flown if f.clearance is not None]),
        legs={leg: came[leg] for leg in legs},
        given=tuple(given),
        undone=undone,
    )


def _clearance(least: Sequence[float]) -> tuple[Spread, int] | None:
    return (Spread.of(least), sum(m < TOUCHES for m in least)) if least else None


def _goodness(flown: Flown) -> tuple[bool, float, float]:
    return flown.outcome == "completed", flown.covered, -flown.error


def _coverage(flown: Sequence[Flown]) -> dict[str, tuple[Spread, Spread]]:
    legs = [c.leg for c in flown[0].coverage]
    return {
        leg: (
            Spread.of([f.coverage[i].true for f in flown]),
            Spread.of([f.coverage[i].estimated for f in flown]),
        )
        for i, leg in enumerate(legs)
    }


def _reached(flown: Sequence[Flown], undone: int) -> dict[str, tuple[int, float, float]]:
    found = {}
    for i, one in enumerate(flown[0].achieved):
        hits = sum(f.achieved[i].reached for f in flown)
        found[one.leg] = (hits, *share_of(hits, len(flown), undone))
    return found


def quantile(ranked: Sequence[float], share: float) -> float:
    """Return the smallest value that at least ``share`` of the values do not exceed."""
    return ranked[max(0, math.ceil(share * len(ranked)) - 1)]


def wilson(hits: int, of: int) -> tuple[float, float]:
    """Return the 95 % interval of a probability (Wilson 1927, score interval)."""
    share, z2 = hits / of, _Z * _Z
    middle = (share + z2 / (2 * of)) / (1 + z2 / of)
    half = _Z / (1 + z2 / of) * math.sqrt(share * (1 - share) / of + z2 / (4 * of * of))
    return max(0.0, middle - half), min(1.0, middle + half)


def share_of(hits: int, of: int, undone: int) -> tuple[float, float]:
    """Return an interval that holds ``wilson`` of all flights, whatever the undone ones would have
    come to."""
    low, _ = wilson(hits, of + undone)
    _, high = wilson(hits + undone, of + undone)
    return low, high


def regions(places: Sequence[tuple[float, float]]) -> tuple[Region, ...]:
    """Return ellipses of the places' covariance, each just large enough to hold its share; none of
    fewer than three places."""
    if len(places) < 3:
        return ()
    import numpy as np

    points = np.array(places)
    centre = points.mean(axis=0)
    covariance = np.cov((points - centre).T) + 1e-6 * np.eye(2)
    values, vectors = np.linalg.eigh(covariance)
    turned = (points - centre) @ vectors
    reach = sorted(np.sqrt((turned**2 / values).sum(axis=1)).tolist())
    bearing = math.atan2(float(vectors[1, 1]), float(vectors[0, 1]))
    sigma = math.sqrt(float(values[1])), math.sqrt(float(values[0]))
    return tuple(
        Region(share, float(centre[0]), float(centre[1]), (sigma[0] * k, sigma[1] * k), bearing)
        for share in SHARES
        for k in (quantile(reach, share),)
    )


def again(flown: Flown, source: str, seed: int) -> str:
    """Return the command that repeats this flight."""
    return command(flown.number, flown.settings, source, seed)


def command(number: int, settings: Sequence[str], source: str, seed: int) -> str:
    """Return the command that flies flight ``number``. ``source``: the mission, and what all
    flights have in common, as a command line has them."""
    said = " ".join(f"--set {shlex.quote(text)}" for text in settings)
    return f"auvmission simulate {source} --seed {seed + number} {said}"


# --- output ---------------------------------------------------------------------------------------


def as_text(made: Rehearsal, source: str, seed: int) -> str:
    done = made.outcomes.get("completed", 0)
    low, high = made.chance
    rows = [
        *(f"set               {text}" for text in made.given),
        f"completed         {done} of {made.asked}: {low:.1%} to {high:.1%} (95 %)",
        *(f"  {name:15} {count}" for name, count in sorted(made.outcomes.items())),
        *([f"  {'undone':15} {made.undone}"] if made.undone else []),
        f"{'':18}{'5 %':>9}{'half':>9}{'95 %':>9}",
        _row("time, min", made.time, 60.0),
        _row("energy, Wh", made.energy, 3600.0),
        _row("error, m", made.error, 1.0),
    ]
    if made.clearance is not None:
        spread, aground = made.clearance
        rows.append(_row("clearance, m", spread, 1.0) + f"  aground in {aground}" * bool(aground))
    for leg, (true, estimated) in made.coverage.items():
        rows.append(_row("coverage, %", true, 0.01) + f"  {leg}")
        rows.append(_row("  by estimate, %", estimated, 0.01) + f"  {leg}")
    for leg, (hits, least, most) in made.reached.items():
        share = f"{least:.1%} to {most:.1%} (95 %)"
        rows.append(f"purpose reached   {hits} of {made.asked}: {share}  {leg}")
    for r in made.regions:
        axes = f"{r.axes[0]:.0f} by {r.axes[1]:.0f} m about"
        rows.append(f"surfaced, {r.share:.0%}     {axes} north {r.north:.0f} east {r.east:.0f} m")
    if made.never:
        rows.append(f"never flown       {', '.join(made.never)}")
    used = ", ".join(f"{name} {share:.0%}" for name, share in made.near.items())
    rows += [f"limits, at most   {used}", "the worst, and how to fly them again"]
    for f in made.worst:
        figures = f"coverage {f.covered:.0%}, error {f.error:.0f} m"
        rows += [f"  {f.number}: {f.outcome}, {figures}", f"    {again(f, source, seed)}"]
    return "\n".join(rows)


def _row(name: str, spread: Spread, unit: float) -> str:
    figures = (spread.low, spread.middle, spread.high)
    return f"{name:18}" + "".join(f"{value / unit:9.1f}" for value in figures)


def as_object(made: Rehearsal, source: str, seed: int) -> dict[str, Any]:
    return {
        "flights": made.flights,
        "undone": made.undone,
        "seed": seed,
        "set": list(made.given),
        "outcomes": made.outcomes,
        "completion_95": [round(p, 4) for p in made.chance],
        "time_s": _spread(made.time),
        "energy_wh": _spread(made.energy, 3600.0),
        "error_m": _spread(made.error),
        **({} if made.clearance is None else _of_floor(*made.clearance)),
        "coverage": {
            leg: {"true": _spread(true), "estimated": _spread(estimated)}
            for leg, (true, estimated) in made.coverage.items()
        },
        "purpose": {
            leg: {"reached": hits, "share_95": [round(low, 4), round(high, 4)]}
            for leg, (hits, low, high) in made.reached.items()
        },
        "surfaced": [
            {
                "share": r.share,
                "north_m": round(r.north, 1),
                "east_m": round(r.east, 1),
                "half_axes_m": [round(a, 1) for a in r.axes],
                "bearing_deg": round(math.degrees(r.bearing) % 180.0, 1),
            }
            for r in made.regions
        ],
        "legs": made.legs,
        "never_flown": list(made.never),
        "limits_used": {name: round(share, 3) for name, share in made.near.items()},
        "worst": [
            {
                "flight": f.number,
                "outcome": f.outcome,
                "reason": f.reason,
                "coverage": round(f.covered, 4),
                "error_m": round(f.error, 1),
                "again": again(f, source, seed),
            }
            for f in made.worst
        ],
    }


def _of_floor(least: Spread, aground: int) -> dict[str, Any]:
    return {"clearance_m": _spread(least), "aground": aground}


def _spread(spread: Spread, unit: float = 1.0) -> list[float]:
    return [round(value / unit, 4) for value in (spread.low, spread.middle, spread.high)]
