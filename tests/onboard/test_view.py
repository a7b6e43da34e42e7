"""What viewers see of a leg: each way by which it ends, and how far it is to there."""

from __future__ import annotations

import itertools
import json

import pytest

from mission.analysis.replay.playback import Playback
from mission.authoring.prepare import prepare_text
from mission.onboard.runtime.records import ListRecorder
from mission.topside.monitor import Watched
from mission.verification.simulation.flight import fly

TEXT = """mission: there-and-back
vehicle: auv
home: {latitude: 30.2874595, longitude: 120.1535765}
safety: {radius: 500 m, time: 20 min, depth: 10 m}
legs:
  - there: {goto: north 60 east 0, gear: 6, depth: 2 m, within: 12 m, timeout: 5 min}
  - about: {follow: [north 90 east 0, north 60 east 30], gear: 6, depth: 2 m, within: 8 m, timeout: 8 min}
  - up: {surface: true, timeout: 5 min}
"""


@pytest.mark.proof
def test_a_leg_that_goes_to_places_tells_how_far_it_is_until_it_is_there() -> None:
    prepared, recorder = prepare_text(TEXT, "there.yaml", None), ListRecorder()
    fly(prepared.mission, prepared.vehicle, recorder=recorder)
    playback, watched, seen = Playback(recorder.records), Watched(), dict[str, list[float]]()
    for step in range(int(playback.end)):
        _, answers = watched.receive(playback.until(float(step)), 0.0)
        playback.answer(answers)
        for text, values in watched.state.get("leg_ends") or ():
            if watched.state["leg"] and "distance" in values:
                seen.setdefault(json.dumps([watched.state["leg"], text]), []).append(
                    values["distance"]
                )
    there = seen[json.dumps(["there", "distance <= 12 m"])]
    assert there[0] == pytest.approx(60.0, abs=15.0)
    assert all(b < a + 1.0 for a, b in itertools.pairwise(there))
    assert there[-1] < 14.0
    about = seen[json.dumps(["about", "each corner: distance <= 8 m"])]
    assert any(b > a + 10.0 for a, b in itertools.pairwise(about)), "on to the second corner"
    assert len(seen) == 2
