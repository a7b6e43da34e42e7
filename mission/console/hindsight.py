"""The whole track of a dive afterwards: as estimated on board, and as smoothed now.

    records --report's Dive--> one object (docs/design/console.md)

``then`` is the vehicle's own estimate. ``now`` is the smoother's, which also uses later fixes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mission.analysis.report.dive import Dive
from mission.analysis.report.words import figures
from mission.model import Record
from mission.navigation.geodesy import LocalFrame

MOST = 4000  # points of a track
NOTHING: dict[str, Any] = {
    "begin": None, "wall": 0.0, "then": [], "now": [], "apart": None, "problem": "",
}  # fmt: skip


def hindsight(records: Sequence[Record]) -> dict[str, Any]:
    try:
        dive = Dive.of(records, None)
    except (ValueError, KeyError, TypeError) as error:
        return {**NOTHING, "problem": f"no track can be made of it: {error}"}
    stays = dive.stays()
    then = [[round(t, 1), round(lat, 7), round(lon, 7)] for t, lat, lon in _thinned(dive.places)]
    found = {"begin": stays[0].begin if stays else None, "wall": dive.wall, "then": then}
    known = figures(dive)
    if known is None or dive.origin is None:
        return {**NOTHING, **found, "problem": "no fix: nothing to smooth the track by"}
    now, apart = _smoothed(dive), known["filtered_from_smoothed_m"]
    return {**NOTHING, **found, "now": now, "apart": apart}


def _smoothed(dive: Dive) -> list[list[float]]:
    assert dive.smoothed is not None
    assert dive.origin is not None
    track, plane = dive.smoothed, LocalFrame(dive.origin)
    found = []
    for t, (north, east) in _thinned(list(zip(track.t, track.smoothed, strict=True))):
        place = np.degrees(plane.to_geodetic(float(north), float(east)))
        found.append([round(float(t), 1), round(float(place[0]), 7), round(float(place[1]), 7)])
    return found


def _thinned(points: Sequence[Any]) -> list[Any]:
    """Thin out points, keeping the first and the last."""
    if len(points) <= MOST:
        return list(points)
    return [points[i] for i in np.linspace(0, len(points) - 1, MOST).astype(int)]
