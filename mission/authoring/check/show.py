"""The check's report as text for people and as an object for programs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from mission.authoring.check import seabed
from mission.authoring.check.purpose import Outlook
from mission.authoring.check.rules import Report
from mission.authoring.check.seabed import Ground
from mission.model.diagnostics import Diagnostic

_ROWS = 12  # most rows of an outlook in the text for people


def as_object(report: Report) -> dict[str, Any]:
    proved = report.proved
    return {
        "ok": report.ok,
        "refusals": [r.as_object() for r in report.refusals],
        "proved": None
        if proved is None
        else {
            "states": proved.states,
            "transitions": proved.transitions,
            "worst_time_s": round(proved.worst_time, 1),
            "worst_energy_wh": round(proved.worst_energy / 3600.0, 1),
            "max_range_m": round(proved.max_range, 1),
            "max_depth_m": round(proved.max_depth, 1),
            "blind_depth_m": round(proved.blind_depth, 1),
            "blind_time_s": round(proved.blind_time, 1),
            "dark_time_s": round(proved.dark_time, 1) if math.isfinite(proved.dark_time) else None,
            "uncertainty_m": round(proved.uncertainty, 1),
            "worst_path": list(proved.path),
        },
        "assumed": list(report.assumed),
        "expected": [_outlook(one) for one in report.outlook],
        "sea_floor": [_ground(one) for one in report.grounds],
    }


def _ground(one: Ground) -> dict[str, Any]:
    place = one.place
    return {
        "leg": one.leg,
        "shallowest_m": None if one.shallowest is None else round(one.shallowest, 2),
        "deepest_m": None if one.deepest is None else round(one.deepest, 2),
        "shallowest_at": None if place is None else [place.latitude_deg, place.longitude_deg],
        "known": round(one.known, 3),
    }


def _outlook(one: Outlook) -> dict[str, Any]:
    return {
        "leg": one.leg,
        "achieve": dict(one.aims),
        "coverage": None if one.coverage is None else round(one.coverage, 3),
        "error_m": [round(error, 1) for error in one.errors],
        **({} if one.needs is None else {"needs_s": _finite(one.needs)}),
    }


def _finite(seconds: float) -> int | None:
    return None if math.isinf(seconds) else math.ceil(seconds)


def unreadable_object(found: Iterable[Diagnostic]) -> dict[str, Any]:
    """The same object for a text that has no chart."""
    return {
        "ok": False,
        "refusals": [d.as_object() for d in found],
        "proved": None,
        "assumed": [],
        "expected": [],
        "sea_floor": [],
    }


def _without_a_depth(more: float) -> str:
    """How much longer the ascent takes if no depth is believed: ``more`` s."""
    if not more:
        return ""
    if math.isinf(more):
        return " (without a believed depth until an X: nothing reports a position)"
    minutes = f"{more / 60:.1f} min"
    return f" (without a believed depth up to {minutes} more until fixes prove the surface)"


def as_text(source: str, report: Report, digest: str) -> str:
    """The report as text. ``digest``: of the canonical text; its first part is shown, as the
    vehicle reports it."""
    rows = [refusal.rendered for refusal in report.refusals]
    proved = report.proved
    if proved is not None:
        rows += [
            "proved" if report.ok else "found",
            f"  states and transitions  {proved.states}, {proved.transitions}",
            f"  worst-case time         {proved.worst_time / 60:.1f} min, the ascent included"
            + _without_a_depth(proved.dark_time),
            f"  worst-case energy       {proved.worst_energy / 3600:.0f} Wh",
            f"  greatest range          {proved.max_range:.0f} m from home",
            f"  greatest depth          {proved.max_depth:.1f} m"
            f" ({proved.blind_depth:.1f} m if the sensor of a hold fails,"
            f" and {proved.blind_time / 60:.1f} min more to the surface)",
            f"  uncertainty added       {proved.uncertainty:.0f} m at the end",
            "  way to the surface      from every state, by clocks alone"
            if report.ok
            else "  way to the surface      see above",
            "worst-case path",
            *(f"  {step}" for step in proved.path),
        ]
    rows += [f"expected of {one.leg}  {_expected(one)}" for one in report.outlook]
    rows += [f"sea floor under {one.leg}  {seabed.told(one)}" for one in report.grounds]
    rows += ["assumed", *(f"  {line}" for line in report.assumed)]
    rows.append(f"{source}: {'ok' if report.ok else 'refused'}, digest {digest[:16]}")
    return "\n".join(rows)


def _expected(one: Outlook) -> str:
    coverage = "" if one.coverage is None else f"coverage {one.coverage:.0%}, "
    rows = ", ".join(f"{error:.0f}" for error in one.errors[:_ROWS])
    more = " ..." if len(one.errors) > _ROWS else ""
    ends = "the end of each row" if one.rows else "its end"
    return f"{coverage}position within {rows}{more} m at {ends} (95 % of dives){_late(one)}"


def _late(one: Outlook) -> str:
    if one.needs is None:
        return ""
    if math.isinf(one.needs):
        return "; its clock may end it before: it makes no way against the current"
    if one.rows:
        return (
            f"; its clock may end it before: {math.ceil(one.needs)} s would do for 95 % of dives, "
            "wherever the current comes from"
        )
    time = f"it takes {math.ceil(one.needs)} s"
    return f"; its clock may end it before: {time} straight against the current"
