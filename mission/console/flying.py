"""A ghost flight, in a process of its own: a text flown in a sea, and where it would have been.

    python -m mission.console.flying < {"text", "source", "vehicle", "settings", "seed"}

One JSON object comes out: the flight as the page draws it (docs/design/console.md), or ``says``,
why there is none. What does not live here: who asks, and how long it may take (ghost).
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Sequence
from typing import Any

from links.simulated.settings import SettingError, parse_settings
from mission.authoring.prepare import Unreadable, prepare_text
from mission.model import Mission
from mission.navigation.distribution import PLANE_95, principal
from mission.navigation.geodesy import LocalFrame
from mission.verification.simulation import reaching
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight, Sample

_MOST = 1500  # places of the track
_UNDER, _UP = 1.0, 0.5  # m: below the one it has dived, above the other it has come up


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
    """``track``: where it truly was; ``believed``: the estimate, with its ellipse; ``up``: where it
    came up."""
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
    """Half axes, m, and the bearing of the long one, deg."""
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


if __name__ == "__main__":
    json.dump(flown(json.load(sys.stdin)), sys.stdout)
