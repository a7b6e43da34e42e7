"""The results of a flight as text: a row per leg with the guard that ended it, then the figures.

What does not live here: the figures themselves (flightlog), pictures (plot).
"""

from __future__ import annotations

from mission.analysis.ended import ended_by
from mission.model import Chart, Mission
from mission.verification.simulation import reaching
from mission.verification.simulation.coverage import coverage_of, told
from mission.verification.simulation.flightlog import Flight, LegFlown


def table(flight: Flight, chart: Chart) -> str:
    width = max([3, *(len(leg.name) for leg in flight.legs)])
    rows = [f"{'leg':{width}}  {'entered':>9}  {'left':>9}  {'lasted':>9}  {'by':8}  because"]
    for leg in flight.legs:
        times = (leg.entered, leg.left, leg.left - leg.entered)
        cells = "  ".join(f"{t:7.1f} s" for t in times)
        because = _because(leg, chart)
        rows.append(f"{leg.name:{width}}  {cells}  {leg.by or '(active)':8}  {because}".rstrip())
    return "\n".join([*rows, "", *_figures(flight), *_brought(flight, chart.mission)])


def _brought(flight: Flight, mission: Mission) -> list[str]:
    covered = coverage_of(flight, mission)
    return [*told(covered), *reaching.told(reaching.achieved_by(flight, mission, covered))]


def _figures(flight: Flight) -> list[str]:
    far = f"{flight.max_range:.1f} m from home (true)"
    deep = f"{'range':17} " if flight.on_land else f"depth, range      {flight.max_depth:.1f} m, "
    error_end, error_p95 = flight.error_end, flight.error_p95
    errors = (
        "unknown"
        if error_end is None
        else f"{error_end:.1f} m at the end, 95 % below {error_p95:.1f} m"
    )
    speed = f", {flight.mission_time / flight.wall:.0f} times real time" if flight.wall else ""
    return [
        f"outcome           {flight.outcome}: {flight.reason}",
        f"final state       {flight.final_state}",
        f"mission           {flight.mission_time:.1f} s, digest {flight.digest[:16]}",
        f"{deep}{far}",
        f"navigation error  {errors}",
        f"flown in          {flight.wall:.2f} s{speed}",
    ]


def _because(leg: LegFlown, chart: Chart) -> str:
    """Return why a leg ended: the guard of its edge, or the reason if it was no edge of the
    mission."""
    return ended_by(chart, leg.trigger, leg.seen) or leg.why
