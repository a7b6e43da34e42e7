"""Laws of the stick (R6): what it takes over, and when it is let go. They go by the bytes that
operators sent, not by the engine's reading of them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

from mission.model import MANUAL_DRIVING, MANUAL_WAITING
from mission.model.regions import EMERGENCY
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.story import STOP_WORD, Stay, Story
from mission.verification.campaign.surface_laws import UNLAWFUL, UNSENT
from mission.verification.rig.acts import MODEM

_QUIET = (1.9, 2.1)  # s: between these, about 2 (R6), both readings may hold
_SILENT, _FORGOTTEN = 2.6, 61.5  # s
_PUSHED, _WAITED = 0.14, 3  # s that a push lasts; commands of a stick in that time
M = re.compile(rb"@M[TDMRSP][^@$]*\$")


def takes_over(story: Story, stay: Stay) -> Iterator[Violation]:
    """Only a push takes an emergency over, after every stick was still for 2 s in the emergency."""
    t = stay.begin
    sticks = [(s, found) for s in story.said if s.link != MODEM for found in M.findall(s.data)]
    now = [found for s, found in sticks if abs(s.t - t) < 0.01]
    if now and all(_neutral(found) for found in now):
        yield Violation(UNLAWFUL, t, f"{now[-1]!r} takes over {stay.before}")
    words = [s.t for s, _ in sticks if s.t < t + 0.01]  # refused or not (R6, G4)
    if not words:
        return  # the M came in parts
    begun = _emergency_began(story, t)
    wrong = [_wrong_push(_run(words, quiet), begun, t) for quiet in _QUIET]
    if all(wrong) and not story.hindered(t - 2.0 * max(_QUIET), t):
        yield Violation(UNLAWFUL, t, f"{wrong[0]} {stay.before}")


def _wrong_push(push: Sequence[float], begun: float, t: float) -> str:
    """Return why these M are no push that may take over at ``t``; "" if they are one.

    ``begun``: when the emergency began.
    """
    if push[0] < begun + _QUIET[0]:
        if len(push) > 1:
            return f"a stick heard {t - push[-2]:.1f} s before takes over"
        return f"an M {t - begun:.1f} s behind its begin takes over"
    if t < push[0] + _PUSHED:
        return f"a push of {t - push[0]:.2f} s takes over"
    at_once = sum(at < push[0] + _PUSHED for at in push)
    return f"{at_once} words that have waited take over" if at_once > _WAITED else ""


def _run(words: Sequence[float], quiet: float) -> list[float]:
    """Return the last of them that follow each other without pauses over ``quiet`` s."""
    run: list[float] = []
    for at in reversed(words):
        if run and run[0] - at > quiet:
            break
        run.insert(0, at)
    return run


def _emergency_began(story: Story, t: float) -> float:
    """Return when the emergency began that was taken over at ``t``, through all its states."""
    began = t
    for stay in reversed([stay for stay in story.stays if stay.end <= t]):
        if not stay.state.startswith(EMERGENCY):
            break
        began = stay.begin
    return began


def _neutral(frame: bytes) -> bool:
    """Whether an M is neutral: in MS and MP by the first number (speed, force), else the last."""
    numbers = re.findall(rb"-?\d+", frame[3:])
    return bool(numbers) and int(numbers[0 if frame[2:3] in b"SP" else -1]) == 0


def lets_go(story: Story, stay: Stay) -> Iterator[Violation]:
    driving = stay.state == MANUAL_DRIVING
    heard = [stay.begin] * driving  # by an M, even if the program dies before its relay
    last = max((*heard, *(t for t in story.stick if t <= stay.end)), default=math.nan)
    due = last + _SILENT if driving else story.auto_opens(last + _FORGOTTEN)
    if stay.end > due and not story.hindered(last - 0.1, due):
        says = f"{stay.end - last:.1f} s without M, and still in {stay.state}"
        yield Violation(UNLAWFUL, due, says)
    due = stay.begin + 1.5
    if stay.state != MANUAL_WAITING or stay.end < due or story.hindered(stay.begin - 0.1, due):
        return
    if not any(word.data == STOP_WORD for word in story.words_in(stay.begin, due)):
        yield Violation(UNSENT, stay.begin, "the stick is silent, and no X0 has left")
