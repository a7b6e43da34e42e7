"""Laws of a line to the vehicle that was disconnected: the command in force is sent again (R8).

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

_BESIDE = 0.5  # s before the line is back: no other disturbance since then
_LONG = 1.0  # s in the state: its command has left
_AGAIN = 2.5  # s


def line_laws(story: Story) -> Iterator[Violation]:
    """A stop, a leg's set, the way of an ascent or the thrust that holds up is sent again.

    Boards that get their commands all the time are left out.
    """
    for plug in story.done if story.board is None else ():
        due = plug.t + _AGAIN
        if plug.act is not Act.PLUG or due > story.end or not _holds(story, plug, due):
            continue
        if not _says(story, plug.t, due):
            says = f"the line is back, and nothing is said in {story.stay_at(due).state}"
            yield Violation(UNSENT, due, says)


def _holds(story: Story, plug: Done, due: float) -> bool:
    """Whether the state stayed the same, a command had left in it, and nothing else happened."""
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
