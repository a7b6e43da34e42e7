"""Texts of a page beside pictures and story: which dive it is, and the smoother's results."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from mission.analysis.report.dive import Dive
from mission.navigation.distribution import PLANE_95


def headline(dive: Dive) -> str:
    """Mission, vehicle and time of a dive."""
    none = "no mission is started" if dive.goes_on else "no mission"
    return f"{', '.join(dive.missions) or none}, {dive.vehicle.name}, {_begun(dive)}"


def day(dives: list[Dive]) -> str:
    """Return the headline of one dive; for several, when the first and the last began."""
    if len(dives) == 1:
        return headline(dives[0])
    count = sum(not dive.goes_on for dive in dives)
    if count == 1:
        return f"{headline(dives[0])}, in {len(dives)} recordings"
    return f"{count} dives, {_begun(dives[0])} to {_begun(dives[-1])}"


def source(dive: Dive) -> str:
    """Return the name of its file; for a simulation also sea and seed."""
    return ", ".join(filter(None, (dive.name, simulated(dive))))


def simulated(dive: Dive) -> str:
    """Describe the simulation; "" for a real dive."""
    notes = dive.notes
    if "seed" not in notes:
        return ""
    said = f"set {notes['set']}" if notes.get("set") else ""
    return ", ".join(filter(None, ("simulated", notes.get("sea"), said, f"seed {notes['seed']}")))


def _begun(dive: Dive) -> str:
    return datetime.fromtimestamp(dive.wall, UTC).strftime("%Y-%m-%d %H:%M UTC")


def figures(dive: Dive) -> dict[str, Any] | None:
    """Return the smoother's figures as ``report --json`` prints them; None without a smoothed
    track."""
    import numpy as np

    if (track := dive.smoothed) is None:
        return None
    used = [f for f in track.fixes if f.used]
    determinants = np.maximum(np.linalg.det(track.smoothed_covariance), 0.0)
    radius = PLANE_95 * determinants**0.25
    apart = np.hypot(*(track.filtered - track.smoothed).T)
    return {
        "seconds": float(track.t[-1] - track.t[0]),
        "fixes": len(track.fixes),
        "fixes_refused": len(track.fixes) - len(used),
        "mean_nis": float(np.mean([f.nis for f in used])) if used else None,
        "filtered_from_smoothed_m": {"max": float(apart.max()), "mean": float(apart.mean())},
        "smoothed_radius_95_m": {"max": float(radius.max()), "mean": float(radius.mean())},
        "speed_scale": [float(track.states[-1, 6]), float(track.sigmas[-1, 6])],
        "compass_error_deg": [
            float(np.degrees(track.states[-1, 8])),
            float(np.degrees(track.sigmas[-1, 8])),
        ],
        "current_m_s": [float(v) for v in track.states[-1, 2:4]],
        "sensors": [
            {
                "sensor": s.sensor,
                "begin_s": s.first,
                "noticed_s": s.begin,
                "end_s": s.end,
                "reason": s.reason,
            }
            for s in dive.spells
        ],
    }


def track_words(dive: Dive) -> str:
    """Return the same as lines."""
    if (f := figures(dive)) is None:
        return "track      there is no fix of a receiver: no smoothed track"
    apart, radius = f["filtered_from_smoothed_m"], f["smoothed_radius_95_m"]
    nis = "" if f["mean_nis"] is None else f", mean NIS {f['mean_nis']:.2f} (2 is honest)"
    rows = [
        f"track      {f['seconds']:.0f} s, {f['fixes']} fixes, {f['fixes_refused']} refused{nis}",
        f"smoothed   95 % radius {radius['mean']:.1f} m in the mean, {radius['max']:.1f} m at most",
        f"filtered   off the smoothed by {apart['mean']:.1f} m, {apart['max']:.1f} m at most",
        *(f"{s.sensor:10} {s.reason} from {s.first:.0f} to {s.end:.0f} s" for s in dive.spells),
    ]
    return "\n".join(rows)
