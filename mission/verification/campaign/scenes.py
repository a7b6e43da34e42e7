"""Scenes: flights that differ when a rule is broken. One row each, with its own random figures.

A random draw seldom meets the one situation in which a rule matters (a vehicle that sinks while the
operator has stopped it; a stick that is held while another boat orders W). A scene sets this
situation up, with a mission of its own, faults, disturbances and settings of the vehicle.

What does not live here: what else happens in the flight (draw), what the rules are (the laws).
"""

from __future__ import annotations

from collections.abc import Mapping
from random import Random

from mission.verification.campaign.scene import DOWN, Scene, SceneRow, W, X, fault, say
from mission.verification.campaign.scenes_aboard import ABOARD
from mission.verification.campaign.scenes_at_sea import AT_SEA

SCENES: Mapping[str, SceneRow] = {**AT_SEA, **ABOARD}


def _leak(rng: Random) -> Scene:
    return Scene("away", (fault("leak", rng.uniform(DOWN, 90.0)),))


def _lit(rng: Random) -> Scene:
    """The mission and the operator set outputs, as the vehicle has them. Then comes an emergency,
    and one more @AO, which it refuses."""
    t = rng.uniform(DOWN, 80.0)
    short = b"@SP,2000,%d,100,10,$" % rng.randint(1, 2)
    said = [say(DOWN - 4.0 + 0.2 * i, words) for i, words in enumerate(_BY_HAND)]
    return Scene("lit", (), (*said, say(t, rng.choice((X, W, short))), say(t + 2.0, _BY_HAND[0])))


_BY_HAND = (
    b"@AO,servo,-10,$",  # ROV
    *(b"@AO,usbl_frequency,45,$", b"@AO,ins,0,$", b"@AO,dvl,0,$"),  # core board
    *(b"@AO,led2,50,$", b"@AO,side_scan,1,$"),  # sensor board
    *(b"@AO,zoom,9,$", b"@AO,video,2,$"),  # robot
)
# Scenes that only boards of documents 002 to 004 can have.
ON_BOARDS_ALONE: Mapping[str, SceneRow] = {
    "leak": SceneRow("water inside, and it is told", _leak),
    "lit": SceneRow("outputs are on, and an emergency comes", _lit),
}
