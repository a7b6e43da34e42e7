"""Scenes: flights that look different when a rule is broken. One row each, with its own random
figures.

What is drawn at random seldom meets the one situation in which a rule matters (a body that sinks
while the operator has stopped it; a stick that is held while another boat orders W). A scene puts
it there: missions of its own, faults, disturbances and how the vehicle is set up.

What does not live here: what else happens in the flight (draw), what the rules are (the laws).
"""

from __future__ import annotations

from collections.abc import Mapping
from random import Random

from mission.verification.campaign.scene import DOWN, Scene, SceneRow, fault
from mission.verification.campaign.scenes_aboard import ABOARD
from mission.verification.campaign.scenes_at_sea import AT_SEA

SCENES: Mapping[str, SceneRow] = {**AT_SEA, **ABOARD}


def _leak(rng: Random) -> Scene:
    return Scene("away", (fault("leak", rng.uniform(DOWN, 90.0)),))


# What only boards of documents 002 to 004 report.
ON_BOARDS_ALONE: Mapping[str, SceneRow] = {"leak": SceneRow("water inside, and it is told", _leak)}
