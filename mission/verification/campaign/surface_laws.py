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
from mission.onboard.runtime.receivers import RECEIVERS
from mission.verification.campaign.depth_laws import DEPTH_FAULTS
from mission.verification.campaign.excuses import (
    NEVER_BELIEVED,
    SLIGHT,
    WANDERING,
    beside,
    lift,
)
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.story import AGAIN, SAME, Stay, Story
from mission.verification.rig.acts import Act
from mission.verification.rig.trace import Done, Located
from protocol.messages import Fix
from protocol.nmea import NmeaDecoder

UNLAWFUL = "unlawful"
UNSENT = "unsent"
REPEATING = ("gps_stuck", "gps2_stuck", "gps_in_turn")
_SHALLOW, _AFLOAT, _FIXED = 1.0, 4.0, 0.4  # m, in the s before; m that allow a fix
_REPORTS = 2.0  # s between two reports
_NEARLY = 1.2  # m: 0.8 (R7), and the sensor
_PROOF = 6.0  # s for which a proof counts (R7)
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
    """Judge by 6 s of shallow depth, or by a fix: its antenna is above water for a while.

    A receiver may send places under water. One that is new to the program proves the surface if
    nothing contradicts it then (R7).
    """
    t = stay.begin
    told = t - _REPORTS  # the last report may be that old: nobody knows of sinking since
    shallow = story.deepest(told - _AFLOAT, told) <= _SHALLOW
    trough = story.settings.sea.waves[0]  # m: by so much less water may be over the antenna
    fixed = story.deepest(t - 2.0, t) <= _FIXED + trough
    if shallow or fixed or story.faulty(_UNDETECTED, t - 10.0, t):
        return
    new_at = _given_new_place(story, t)
    if t - new_at <= _PROOF:
        in_vain = lift(story.settings, story.profile, t) < SLIGHT  # pushes contradict a true depth
        silent = not story.told_in(t - 6.0, t)
        unknown = in_vain or silent or story.faulty(DEPTH_FAULTS, t - 20.0, t)
        near = story.depth(new_at) < _NEARLY + beside(story.settings)
        if near or (unknown and _may_be_up(story, stay)):
            return
    says = f"surfaced, said {story.depth(t):.1f} m deep, {story.depth(t - _AFLOAT):.1f} m before"
    yield Violation(UNLAWFUL, t, says)


def _given_new_place(story: Story, t: float) -> float:
    """Return when the program of ``t`` was last given a place that it had not been given; or -inf.

    To a restarted program, old places that a receiver repeats are new once.
    """
    decoders = {link: NmeaDecoder() for link in RECEIVERS}
    given, new_at = set[tuple[float, float]](), -math.inf
    for event in story.trial.events:
        if event.t > t:
            break
        if isinstance(event, Done) and event.act is Act.BOOT:
            given, new_at = set(), -math.inf
        elif isinstance(event, Located):
            fixes = decoders[event.link].receive(event.data, event.t)
            places = {(fix.latitude, fix.longitude) for fix in fixes if isinstance(fix, Fix)}
            new_at = new_at if places <= given else event.t
            given |= places
    return new_at


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
