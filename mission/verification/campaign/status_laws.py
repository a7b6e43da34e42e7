"""Laws of the unasked status (R11): sent at the surface, and not below.

What does not live here: the content of a status (the runtime's tests), whether a surfaced vehicle
is up (surface_laws).
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from mission.model import SURFACED, SURFACING, Tx
from mission.verification.campaign.depth_laws import DEPTH_FAULTS
from mission.verification.campaign.excuses import SLIGHT, beside, lift
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.story import SAME, Stay, Story
from mission.verification.campaign.surface_laws import REPEATING, UNLAWFUL
from mission.verification.rig.acts import TOPSIDE, Act

_UNASKED = "at the surface"
_UP, _SEEN = 1.0, 3  # m; within s: the first fix, and a report that is 2 s old
_DOUBTED, _SILENT = 40.0, 5.9  # s; the last report was sent before it was received
_DEEP = 0.8  # m: no fix proves the surface beside it (R11)
_TOLD = 5.0  # s from surfaced to the status
_STUCK = 15.0  # s: the oldest place by which fixes prove the surface is 20 s old (R7)
_CONTRADICT = (*DEPTH_FAULTS, "verticals_")


def status_laws(story: Story) -> Iterator[Violation]:
    unasked = [a for a in story.answers if b"@VS" in a.data and a.reason == _UNASKED]
    for told in unasked if story.upward else ():
        yield from _is_told_up(story, told.t)
    for stay in story.stays:
        if stay.state == SURFACED and stay.before == SURFACING:
            yield from _is_told(story, stay, unasked)


def _is_told_up(story: Story, t: float) -> Iterator[Violation]:
    """The vehicle is up when the status says so.

    Where no depth is believed, fixes as at the surface count, true or not; the end of an ascent by
    such fixes is judged in surface_laws. A report counts until it is stale: with a pulled cable or
    a silent board no other one comes.
    """
    state = story.stay_at(t).state
    late = story.hindered(t - _SILENT, t) or not story.told_in(t - _SEEN, t)
    seen = math.ceil(_SILENT) + 1 if late else _SEEN
    shallowest = min(story.depth(t - i) for i in range(seen))
    up = _UP + beside(story.settings)
    if state != SURFACED and shallowest > up and not _is_doubted(story, t):
        says = f"told to be at the surface {story.depth(t):.1f} m deep, in {state}"
        yield Violation(UNLAWFUL, t, says)


def _is_doubted(story: Story, t: float) -> bool:
    in_vain = lift(story.settings, story.profile, t) < SLIGHT  # pushes contradict a true depth
    silent = not story.told_in(t - _SILENT, t)
    return in_vain or silent or story.faulty(_CONTRADICT, t - _DOUBTED, t)


def _is_told(story: Story, stay: Stay, unasked: list[Tx]) -> Iterator[Violation]:
    t, due = stay.begin, stay.begin + _TOLD
    parts = any(d.act is Act.PART for d in story.done)
    if stay.end <= due or parts or story.hindered(t - 2.0, due) or _is_stuck(story, t):
        return
    if _says_deep(story, t) or _is_alone(story, t):
        return
    if not any(a.link == TOPSIDE and t - SAME <= a.t <= due for a in unasked):
        yield Violation(UNLAWFUL, t, "at the surface, and nobody was told")


def _is_alone(story: Story, t: float) -> bool:
    """Whether no boat has connected since the program ended: connections end with it.

    The status is sent once. It then leaves by modem, or to nobody.
    """
    last = [d.act for d in story.done if d.t <= t and d.act in (Act.KILL, Act.JOIN)]
    return last[-1:] == [Act.KILL]


def _says_deep(story: Story, t: float) -> bool:
    """Whether the last depth contradicts the surface that the 6 s before had proved (R7).

    The status then waits for the next depth that does not (R11).
    """
    last = next((report for report in reversed(story.reports) if report.t <= t), None)
    return last is not None and last.depth >= _DEEP


def _is_stuck(story: Story, t: float) -> bool:
    """Whether the vehicle surfaced by fixes alone, of a receiver that has repeated its place since.

    A moment later those fixes prove nothing any more. The status waits for a depth or a new place.
    """
    stuck = any(f.begin <= t - _STUCK for f in story.faults(REPEATING, t, t))
    return stuck and story.faulty(_CONTRADICT, t - _DOUBTED, t)
