"""Laws of legs that keep a depth above the bottom: the depth that is asked for is never below what
the altitude allows.

    asked      never deeper than the depth that the leg asks for
    above      with an altimeter that is well: never deeper than the true bottom less the height
    blind      with one that is silent or frozen for longer than that can be unknown: never deeper
               than the sea floor assumed less the height

What does not live here: whether it follows what it is told (limit_laws), who asked for it (audit).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse, script
from mission.model import AUTONOMOUS
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.story import Stay, Story
from mission.verification.campaign.surface_laws import UNLAWFUL
from mission.verification.campaign.trial import fault_ends
from mission.verification.rig.vehicle import flown
from protocol.messages import Setpoint

_ERROR = 1.0  # m: bias and noise of both sensors
_KNOWN = 24.0  # s until silence is known (6), echoes are missed (6), it is frozen (12)
_SENSORS = ("altitude_", "depth_")
_GONE = ("altitude_silent", "altitude_frozen")
_WORD = b"@ZAS"


def clear_laws(story: Story) -> Iterator[Violation]:
    text = "\n".join(script(story.mission)) + "\n"
    legs = _kept_clear(text, story.mission.vehicle)
    allowed = min(story.mission.safety.depth or math.inf, story.vehicle.limits.depth)
    assumed = story.mission.floor(allowed)
    for stay in story.stays if legs else ():
        if stay.state in legs:
            yield from _too_deep(story, stay, legs[stay.state], assumed)


@functools.lru_cache(maxsize=64)
def _kept_clear(text: str, vehicle: str) -> Mapping[str, Setpoint]:
    mission = parse(text)
    chart = compile_mission(mission, flown(vehicle), digest(mission))
    sets = {state.path: state.setpoint for state in chart.states if state.setpoint is not None}
    return {p: s for p, s in sets.items() if s.depth is not None and s.altitude is not None}


def _too_deep(story: Story, stay: Stay, held: Setpoint, assumed: float) -> Iterator[Violation]:
    asked, height = held.depth or 0.0, held.altitude or 0.0
    for word in story.words_in(stay.begin, stay.end):
        if not word.data.startswith(_WORD):
            continue
        level = float(word.data[len(_WORD) : -1])
        most = asked
        if _gone(story, word.t):
            most = min(asked, max(assumed - height, 0.0))
        elif not story.faulty(_SENSORS, word.t - _KNOWN, word.t):
            seen = story.settings.sea.floor - height + _ERROR
            most = min(asked, max(seen, assumed - height, 0.0))
        if level > most:
            says = f"told {level:g} m in {stay.state}, {most:.1f} m would be clear"
            yield Violation(UNLAWFUL, word.t, says)


def _gone(story: Story, t: float) -> bool:
    """The altimeter alone is at fault, and has been in legs for as long as that can be unknown, for
    at rest an altitude may stand; nobody has switched its power meanwhile, which ends a silence."""
    faults = story.faults(_SENSORS, t - _KNOWN, t)
    if len(faults) != 1 or faults[0].name not in _GONE:
        return False
    begin = faults[0].begin
    others = story.faults(_SENSORS[:1], begin, t)  # meanwhile one of them counted
    begin = max([begin, *(fault_ends(f) for f in others if fault_ends(f) <= t)])
    legs = (s for s in story.stays if s.state.startswith(AUTONOMOUS))
    flown = sum(max(min(s.end, t) - max(s.begin, begin), 0.0) for s in legs)
    return not story.is_switched(begin, t) and flown > _KNOWN and t < fault_ends(faults[0])
