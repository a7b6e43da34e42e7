"""What may not happen at any instant of a disturbed flight, by the truth and by the bytes.

    sunk        under water or going down, and no way up in time (depth_laws)
    unanswered  a limit passed in truth, and no response in time (limit_laws)
    unsent      a set or a stop that had to leave, and did not (word_laws)
    unlawful    a move that the rules forbid (word_laws, surface_laws, clear_laws)

Written from the rules (docs/rules.md) alone, never from what the engine does. What does not live
here: the end of a flight and its bounds (laws), who asked for a byte (audit).
"""

from __future__ import annotations

from collections.abc import Iterator

from links.simulated.settings import Settings
from mission.model import Mission
from mission.model.vehicle import Vehicle
from mission.verification.campaign.clear_laws import clear_laws
from mission.verification.campaign.depth_laws import SUNK, depth_laws
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.limit_laws import UNANSWERED, limit_laws
from mission.verification.campaign.story import Story
from mission.verification.campaign.surface_laws import UNLAWFUL, surface_laws
from mission.verification.campaign.word_laws import UNSENT, word_laws
from mission.verification.rig.trace import Trace

KINDS = (SUNK, UNANSWERED, UNSENT, UNLAWFUL)


def throughout(
    trial: Trace,
    mission: Mission,
    vehicle: Vehicle,
    profile: str,
    settings: Settings,
    silence: float | None = None,
) -> Iterator[Violation]:
    """``silence``: how long the topside may be silent, s."""
    if trial.raised:
        return
    story = Story(trial, mission, vehicle, profile, settings, silence)
    for laws in (clear_laws, depth_laws, limit_laws, surface_laws, word_laws):
        yield from laws(story)
