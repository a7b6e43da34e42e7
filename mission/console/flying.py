"""A ghost flight, in a process of its own: a text flown in a simulated sea, and its track.

    python -m mission.console.flying < {"do", "text", "source", "vehicle", "settings", "seed"}

The output is one JSON object: the flight as the page draws it (docs/design/console.md), or ``says``
with the reason why there is none. For ``plan``: the planned track in still water. What does not
live here: who asks, and how long it may take (ghost).
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

from links.simulated.settings import SettingError, parse_settings
from mission.authoring.prepare import Unreadable, prepare_text
from mission.model import Mission
from mission.navigation.distribution import PLANE_95, principal
from mission.navigation.geodesy import LocalFrame
from mission.verification.planned.track import Plan, Spot, Unplanned, planned
from mission.verification.simulation import reaching
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight, Sample

_T = TypeVar("_T")
_MOST = 1500  # points of the track
_MOST_TURNS = 300
_LOWER = 5  # nice: lower than the console's own process, X and W go first
_UNDER, _UP = 1.0, 0.5  # m: it has dived if deeper, surfaced if shallower


def flown(said: dict[str, Any]) -> dict[str, Any]:
    settings = tuple(map(str, said["settings"]))
    try:
        prepared = prepare_text(said["text"], said["source"], said["vehicle"])
        sea = parse_settings(settings)
    except Unreadable as error:
        return {"says": error.diagnostics[0].brief}
    except SettingError as error:
        return {"says": str(error)}
    mission = prepared.mission
    flight = fly(mission, prepared.vehicle, seed=int(said["seed"]), settings=sea)
    told = flight.as_json()
    return {
        "is": "done",
        "outcome": flight.outcome,
        "reason": flight.reason,
        "digest": flight.digest[:16],
        "seed": int(said["seed"]),
        "settings": list(settings),
        "seconds": told["mission_time_s"],
        "max_depth": told["max_depth_m"],
        "max_range": told["max_range_m"],
        "error": told["navigation_error_m"],
        "legs": told["legs"],
        "purpose": reaching.as_json_of(reaching.achieved_by(flight, mission)),
        **_drawn(flight, mission),
    }


def _drawn(flight: Flight, mission: Mission) -> dict[str, Any]:
    """``track``: the true positions; ``believed``: the estimate, with its ellipse; ``up``: where
    the vehicle surfaced."""
    if mission.home is None:
        return {"track": [], "believed": [], "up": []}
    frame = LocalFrame(mission.home)
    samples = flight.samples
    step = max(1, math.ceil(len(samples) / _MOST))
    shown = [*samples[::step], *samples[-1:]]
    return {
        "track": [[round(s.t, 1), *_degrees(frame, *_true(s)), round(s.true.depth, 1)]
                  for s in shown],
        "believed": [[round(s.t, 1), *_degrees(frame, s.estimate.north, s.estimate.east),
                      _ellipse(s)] for s in shown],
        "up": [[round(s.t, 1), *_degrees(frame, *_true(s))] for s in _risen(samples)],
    }  # fmt: skip


def _true(sample: Sample) -> tuple[float, float]:
    return sample.true.north, sample.true.east


def _degrees(frame: LocalFrame, north: float, east: float) -> tuple[float, float]:
    latitude, longitude = frame.to_geodetic(north, east)
    return round(math.degrees(latitude), 7), round(math.degrees(longitude), 7)


def _ellipse(sample: Sample) -> list[float]:
    """Return the half axes, m, and the bearing of the long one, deg."""
    great, small, direction = principal(sample.estimate.covariance)
    bearing = math.degrees(direction) % 180.0
    return [round(great * PLANE_95, 2), round(small * PLANE_95, 2), round(bearing, 1)]


def _risen(samples: Sequence[Sample]) -> Iterator[Sample]:
    under = False
    for sample in samples:
        if sample.true.depth > _UNDER:
            under = True
        elif under and sample.true.depth < _UP:
            under = False
            yield sample


# --- in still water -------------------------------------------------------------------------------


def meant(said: dict[str, Any]) -> dict[str, Any]:
    """``track``: the planned positions; ``turns``: where legs turn and end, with an ellipse."""
    try:
        prepared = prepare_text(said["text"], said["source"], said["vehicle"])
        if prepared.mission.home is None:
            return {"says": "the mission names no home"}
        plan = planned(prepared.mission, prepared.chart, prepared.vehicle)
    except Unreadable as error:
        return {"says": error.diagnostics[0].brief}
    except Unplanned as error:
        return {"says": str(error)}
    frame = LocalFrame(prepared.mission.home)
    spots = [spot for stretch in plan.stretches for spot in stretch.spots]
    turns = list(_turns(plan))
    where = _thinned(spots, _MOST)
    return {
        "is": "planned",
        "seconds": round(plan.seconds, 1),
        "track": [[round(s.t, 1), *_degrees(frame, s.north, s.east)] for s in where],
        "turns": [[round(s.t, 1), *_degrees(frame, s.north, s.east), _around(s), name]
                  for name, s in _thinned(turns, _MOST_TURNS)],
    }  # fmt: skip


def _turns(plan: Plan) -> Iterator[tuple[str, Spot]]:
    for stretch in plan.stretches:
        found = {spot.t: spot for spot in (*stretch.turns, *stretch.spots[-1:])}
        for t in sorted(found):
            yield stretch.name, found[t]


def _thinned(of: Sequence[_T], most: int) -> Sequence[_T]:
    step = max(1, math.ceil(len(of) / most))
    return [*of[:-1:step], *of[-1:]]


def _around(spot: Spot) -> list[float]:
    great, small = spot.axes
    return [round(great, 2), round(small, 2), round(math.degrees(spot.bearing) % 180.0, 1)]


if __name__ == "__main__":
    os.nice(_LOWER)
    asked = json.load(sys.stdin)
    json.dump(meant(asked) if asked["do"] == "plan" else flown(asked), sys.stdout)
