"""Laws of a line to the vehicle that was away: what holds there is said again (R8).

What does not live here: what leaves before (word_laws), who asked for it (audit).
"""

from __future__ import annotations

from collections.abc import Iterator

from mission.model import MANUAL_DRIVING, SURFACED
from mission.verification.campaign.laws import Violation, stalls
from mission.verification.campaign.story import Story
from mission.verification.campaign.surface_laws import UNSENT
from mission.verification.rig.acts import Act
from mission.verification.rig.program import DEAD
from mission.verification.rig.trace import Done

_BESIDE = 0.5  # s before, from which on nothing else may have been done
_LONG = 1.0  # s in the state: what it says has left
_AGAIN = 2.5  # s


def line_laws(story: Story) -> Iterator[Violation]:
    """A stop, a leg's set, the way of an ascent, or what holds it up. Of boards that are told all
    the time, nothing."""
    for plug in story.done if story.board is None else ():
        due = plug.t + _AGAIN
        if plug.act is not Act.PLUG or due > story.end or not _holds(story, plug, due):
            continue
        if not _says(story, plug.t, due):
            says = f"the line is back, and nothing is said in {story.stay_at(due).state}"
            yield Violation(UNSENT, due, says)


def _holds(story: Story, plug: Done, due: float) -> bool:
    """It was and is in one state, in which something was said, and nothing else was done."""
    stay = story.stay_at(due)
    others = any(plug.t - _BESIDE <= d.t <= due and d is not plug for d in story.done)
    if others or stay.begin > plug.t - _LONG or stay.state in (DEAD, MANUAL_DRIVING):
        return False
    if any(begin <= plug.t <= end for begin, end in stalls(story.trial.events)):
        return False
    if stay.state == SURFACED and story.auto_closed(plug.t, due):
        return False
    return _says(story, stay.begin, plug.t)


def _says(story: Story, begin: float, end: float) -> bool:
    return any(word.data.startswith(b"@ZA") for word in story.words_in(begin, end))
