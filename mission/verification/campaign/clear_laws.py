"""Laws of legs that keep a depth above the bottom: the commanded depth respects the altitude.

    asked      never deeper than the depth that the leg asks for
    above      with a healthy altimeter: never deeper than the true bottom less the altitude
    blind      with an altimeter that is silent or frozen for so long that this must be known: never
               deeper than the assumed sea floor less the altitude

What does not live here: whether the vehicle follows its command (limit_laws), who asked for the
command (audit).
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
_KNOWN = 24.0  # s until silence (6), missing echoes (6), a frozen value (12) are known
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
    """Whether the altimeter alone has failed, for so long that this must be known.

    Only time in legs counts: at rest an altitude may stand still. Nobody has switched the sensor's
    power meanwhile, which ends a silence.
    """
    faults = story.faults(_SENSORS, t - _KNOWN, t)
    if len(faults) != 1 or faults[0].name not in _GONE:
        return False
    begin = faults[0].begin
    others = story.faults(_SENSORS[:1], begin, t)  # while one of them lasted, that one counted
    begin = max([begin, *(fault_ends(f) for f in others if fault_ends(f) <= t)])
    legs = (s for s in story.stays if s.state.startswith(AUTONOMOUS))
    flown = sum(max(min(s.end, t) - max(s.begin, begin), 0.0) for s in legs)
    return not story.is_switched(begin, t) and flown > _KNOWN and t < fault_ends(faults[0])
