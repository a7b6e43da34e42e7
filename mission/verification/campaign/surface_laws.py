"""Laws of what is allowed only at the surface, over the whole flight.

    surface    only a vehicle at the surface is surfaced
    end        while fixes come, a vehicle at the surface is surfaced at the latest when buoyancy
               has had the time to lift it from the vehicle's own depth
    clear      an emergency is cleared at the surface (or by the second @AC, up to 2 m)
    start      a mission begins at the surface (without a fix: up to 2 m)

What does not live here: how an ascent gets there (depth_laws, word_laws).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import pairwise

from mission.model import STOPPED, SURFACED, SURFACING, By
from mission.model.regions import EMERGENCY, MANUAL
from mission.model.vehicle import STALE_AFTER
from mission.verification.campaign.depth_laws import DEPTH_FAULTS
from mission.verification.campaign.excuses import (
    NEVER_BELIEVED,
    SLIGHT,
    WANDERING,
    beside,
    lift,
    value_of,
)
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.story import AGAIN, SAME, Stay, Story
from mission.verification.rig.acts import Act

UNLAWFUL = "unlawful"
UNSENT = "unsent"
REPEATING = ("gps_stuck", "gps2_stuck", "gps_in_turn")
_SHALLOW, _AFLOAT, _FIXED = 1.0, 4.0, 0.4  # m, in the s before; m that allow a fix
_REPORTS = 2.0  # s between two reports
_NEARLY = 1.2  # m: 0.8 (R7), and the sensor
_NEW = 20.0  # s after a restart in which no place has come twice
_FIRST_FIX = 1.5  # s from the begin of a fault to its first fix: one a second, and its time
_DOUBTED = 40.0  # s
_OVER, _NO_FIXES = 60.0, ("gps", "capsized", "listing")  # s; faults that hide fixes
_START, _START_FREE, _CLEAR = 1.1, 2.6, 1.1  # m
_CLEAR_AGAIN = 4.9, 30.5  # s: 5 to 30 (R7), and the time of a frame
_PROVED = 14  # s: without a depth the surface was proved 10 s ago (R7); two reports
_AC, _ORDER = re.compile(rb"@AC\$"), re.compile(rb"@ZA(?:X0|WF)\$")
_UNDETECTED = ("depth_too", "depth_drifting", "depth_late", "depth_stuck", "depth_inter")
_IDENTICAL = 5  # reports while a thruster turns, by which a depth counts as frozen
_DIED = 4.5  # m: 2 m/s between two reports are no leap (R5), and the sensor


def surface_laws(story: Story) -> Iterator[Violation]:
    for stay in story.stays:
        if stay.autonomous and _begins_anew(story, stay):
            yield from _starts_at_surface(story, stay)
        if stay.state == SURFACING and story.board is None:
            yield from _is_over(story, stay)
    for before, stay in pairwise(story.stays):
        if before.ascends and _is_told_surfaced(before, stay):
            yield from _is_at_surface(story, stay)
        if stay.state.startswith("idle"):
            yield from _is_cleared(story, stay)


def _starts_at_surface(story: Story, stay: Stay) -> Iterator[Violation]:
    if story.faulty(DEPTH_FAULTS, stay.begin - 10.0, stay.begin):
        return
    depth = story.depth(stay.begin)
    if depth > (_START_FREE if story.mission.start_without_fix else _START):
        yield Violation(UNLAWFUL, stay.begin, f"a mission begins {depth:.1f} m deep")


def _begins_anew(story: Story, stay: Stay) -> bool:
    """Whether a mission begins: out of idle, or out of a stick that has interrupted none."""
    for before in reversed(story.stays[: story.stays.index(stay)]):
        if not before.state.startswith(MANUAL):
            return not before.autonomous
    return False


def _is_told_surfaced(before: Stay, stay: Stay) -> bool:
    """Whether the emergency's ascent, or a leg's, has ended at the surface, as it is meant to."""
    if stay.state == SURFACED:
        return before.state == SURFACING
    return before.autonomous and stay.step is not None and stay.step.by is By.END


def _is_at_surface(story: Story, stay: Stay) -> Iterator[Violation]:
    """Judge by 6 s of shallow depth, or by a fix: its antenna is above water for a while."""
    t = stay.begin
    told = t - _REPORTS  # the last report may be that old: nobody knows of sinking since
    shallow = story.deepest(told - _AFLOAT, told) <= _SHALLOW
    trough = story.settings.sea.waves[0]  # m: by so much less water may be over the antenna
    fixed = story.deepest(t - 2.0, t) <= _FIXED + trough
    in_vain = lift(story.settings, story.profile, t) < SLIGHT  # pushes contradict a true depth
    unknown = in_vain or not story.told_in(t - 6.0, t) or story.faulty(DEPTH_FAULTS, t - 20.0, t)
    wanders = story.faulty(WANDERING, t - 20.0, t)
    repeats = story.faulty(REPEATING, t - 20.0, t) and story.hindered(t - _NEW, t)
    repeats = repeats or _come_round(story, t)
    if (wanders or repeats) and story.depth(t) < _NEARLY + beside(story.settings):
        return  # nothing contradicts fixes as at the surface
    if wanders and unknown and _may_be_up(story, stay):
        return
    if not (shallow or fixed) and not story.faulty(_UNDETECTED, t - 10.0, t):
        says = (
            f"surfaced, said {story.depth(t):.1f} m deep, {story.depth(t - _AFLOAT):.1f} m before"
        )
        yield Violation(UNLAWFUL, t, says)


def _come_round(story: Story, t: float) -> bool:
    """Whether a receiver sends its old places for the first time since the program began.

    No fix has come since then, because the vehicle was under water until just before the fault. A
    receiver looks for a place once a second. The first place after a dive comes a second after it
    finds its antenna above water, or later. So none of the old places has come twice to this
    program.
    """
    booted = max((done.t for done in story.done if done.act is Act.BOOT and done.t < t), default=t)
    for fault in story.faults(REPEATING, booted, t):
        places = value_of(fault) if fault.name == "gps_in_turn" else 1.0
        times = (booted, *range(math.ceil(booted), math.ceil(fault.begin) - 1))  # until then no fix
        under = all(story.depth(at) > _FIXED + story.settings.sea.waves[0] for at in times)
        if booted < fault.begin and under and t <= fault.begin + places + _FIRST_FIX:
            return True
    return False


def _is_over(story: Story, stay: Stay) -> Iterator[Violation]:
    """Even without a depth, an ascent ends after the rise from the vehicle's own depth (R7)."""
    way = story.vehicle.limits.depth / story.vehicle.ascent_buoyancy
    since = begin = max(_ascends_since(story, stay) + way, stay.begin)
    lies = story.faults(("depth_",), 0.0, stay.end)
    if any(fault.name not in NEVER_BELIEVED for fault in lies) or story.is_switched(0.0, stay.end):
        return
    for place in story.trial.track[math.ceil(begin) : int(stay.end)]:
        t = place.t
        if place.depth > _FIXED or story.hindered(t, t) or story.faulty(_NO_FIXES, t, t):
            since = t
        elif t - since > _OVER:
            yield Violation(UNLAWFUL, t, f"it surfaces, and was up for {_OVER:.0f} s by its fixes")
            return


def _may_be_up(story: Story, stay: Stay) -> bool:
    """Whether the ascent has lasted as long as buoyancy takes from where it truly began (R7).

    It counts as well where a pulled cable or a stalled program kept its commands back.
    """
    begin = _ascends_since(story, stay)
    if lift(story.settings, story.profile, stay.begin) < SLIGHT:  # it may have sunk all the while
        return True
    if story.hindered(begin + 2.0 * AGAIN, stay.begin):  # after a restart the ascent restarts
        return True
    faults = [f.begin for f in story.faults(DEPTH_FAULTS, begin, stay.begin)]
    known = max(begin, min(faults, default=begin))  # until then its depth was believed (R7)
    return stay.begin - known >= story.depth(known) / story.vehicle.ascent_buoyancy


def _ascends_since(story: Story, stay: Stay) -> float:
    """Return when the ascent of this stay began; an emergency continues a leg's ascent."""
    begin = stay.begin
    for before in reversed(story.stays[: story.stays.index(stay)]):
        if not before.ascends:
            break
        begin = before.begin
    return begin


def _is_cleared(story: Story, stay: Stay) -> Iterator[Violation]:
    if stay.step is None or stay.step.trigger != "clear" or not stay.before.startswith(EMERGENCY):
        return
    t, depth = stay.begin, story.depth(stay.begin)
    if stay.before == SURFACING:
        yield Violation(UNLAWFUL, t, "cleared while it surfaces")
    asked = _is_asked_twice(story, t)
    bound = _START_FREE if asked else _CLEAR
    in_vain = story.faulty(("verticals_",), t - _DOUBTED, t)  # pushes contradict a true depth
    unknown = asked and (in_vain or not story.told_in(t - STALE_AFTER, t))  # none is believed (R7)
    under = not asked and min(story.depth(t - i) for i in range(_PROVED + 1)) > _CLEAR
    untold = story.faulty((*_UNDETECTED, *REPEATING, *WANDERING), t - _DOUBTED, t)
    told = under and not untold and not _died_near(story, t) and not _froze_near(story, t)
    faulty = story.faulty(DEPTH_FAULTS, t - 10.0, t) and not told
    if depth > bound and not unknown and not faulty:
        yield Violation(UNLAWFUL, t, f"cleared {depth:.1f} m deep")


def _died_near(story: Story, t: float) -> bool:
    """Whether the depth died (it reads 0) so near the surface that this looks like a rise."""
    dead = story.faults(("depth_dead",), t - _DOUBTED, t)
    return any(story.depth(fault.begin) < _DIED for fault in dead)


def _froze_near(story: Story, t: float) -> bool:
    """A depth that froze near the surface, and since then, or since the program's last start, no
    thruster has turned for long enough to show it (R7)."""
    booted = [done.t for done in story.done if done.act is Act.BOOT and done.t < t]
    for fault in story.faults(("depth_frozen",), t - _DOUBTED, t):
        since = max([fault.begin, *booted])
        turning = sum(since < report.t < t and report.may_turn for report in story.reports)
        if story.depth(fault.begin) < _CLEAR and turning < _IDENTICAL:
            return True
    return False


def _is_asked_twice(story: Story, t: float) -> bool:
    """Whether a first @AC came 5 to 30 s ago, in a state where it may be repeated (R7).

    After an X or W it does not count: it belonged to another emergency.
    """
    orders = [s.t for s in story.said if s.t <= t and _ORDER.search(s.data)]
    early = max([t - _CLEAR_AGAIN[1], *orders])
    return any(
        early <= s.t <= t - _CLEAR_AGAIN[0]
        and _AC.search(s.data)
        and story.stay_at(s.t + SAME).state in (STOPPED, SURFACED)
        and not any(x.state == SURFACING and s.t < x.begin < t for x in story.stays)
        for s in story.said
    )
