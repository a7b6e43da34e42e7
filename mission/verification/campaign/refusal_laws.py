"""A set that the vehicle answers N leads to the leg's else (R8).

What does not live here: other laws of commands (word_laws).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from mission.model import Tx
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.story import SAME, STOP_WORD, Story
from mission.verification.campaign.surface_laws import UNLAWFUL
from mission.verification.rig.trace import Heard

_ANSWER = re.compile(rb"@ACK_Z[A-Z][A-Z]\$")
_REFUSED = re.compile(rb"@ACK_Z([A-Z])N\$")


def heeds_refusals(story: Story) -> Iterator[Violation]:
    """A refused set ends the leg.

    An N counts where it is clear what it answers: each command in the second before was answered in
    its turn. The stop of an ascent that is over is no part of the leg's set.
    """
    for heard in story.heard:
        found = _REFUSED.search(heard.data)
        if found is None:
            continue
        word = _answered(story, heard)
        if word is None or found[1] not in (b"A", word.data[3:4]):
            continue  # it answers another command
        stay = story.stay_at(heard.t)
        if (
            not stay.autonomous
            or stay.ascends
            or (word.data == STOP_WORD and story.stay_at(stay.begin - SAME).ascends)
            or story.hindered(heard.t - 1.0, heard.t)
        ):
            continue
        if word.data.startswith(b"@ZA") and stay.end > heard.t + 0.5 and stay.begin < word.t + SAME:
            says = f"{word.data!r} was answered N, and still in {stay.state}"
            yield Violation(UNLAWFUL, heard.t, says)
            return


def _answered(story: Story, heard: Heard) -> Tx | None:
    """Return the last command, if each one in the last second had one answer before the next."""
    words = story.words_in(heard.t - 1.0, heard.t - 0.005)
    if not words:
        return None
    answers = [h.t for h in story.heard if words[0].t < h.t <= heard.t and _ANSWER.search(h.data)]
    ends = [*(word.t for word in words[1:]), heard.t + 1e-6]
    for word, end in zip(words, ends, strict=True):
        if len([t for t in answers if word.t < t < end]) != 1:
            return None
    return words[-1]
