"""Laws of the limits (R5, R8) over the whole flight: a limit is truly passed, and answered in time.

Each law defines when its limit is truly passed by more than the sensors explain. The limits act by
reports, so the laws count reports: when a limit is passed in as many as the rule says, and two
more, the mission must have been left. A sensor with a fault excuses, and so does a stalled program.
Limits that go by the clock are judged by the clock.

What does not live here: laws of one leg (leg_laws), depth, radius, time and silence as bounds
(laws).
"""

from __future__ import annotations

import bisect
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from links.simulated.settings import FaultEvent
from mission.model import Step, Tx
from mission.verification.campaign.audit import commands_of
from mission.verification.campaign.depth_laws import DEPTH_FAULTS
from mission.verification.campaign.excuses import beside
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.story import Stay, Story, gaps
from mission.verification.campaign.trial import FOREVER, fault_ends
from mission.verification.rig.trace import Told
from protocol.messages import Order, Setpoint

UNANSWERED = "unanswered"
SPARE = 2  # reports more than the rule asks for
_EDGE = 2  # reports more where the roll is about 90 degrees
_DEPTH, _ROLL = 1.0 + 0.5, math.radians(6.0)  # m and rad beyond the bound
_BLIND, _UNDER = 10.5, 1.0  # s and m: 6 s without a depth, from the next report on
_CLOGGED = 6.5  # m
_TOPSIDE = 1.0  # s
_LOST = 12  # frames: three tries of three commands, and of one that a set replaced
_LOST_OF_ONE, _LAST = 5, "3 of 3)"  # commands of one letter: three, and those that a set replaced
_APART = 60.0  # s at most between two of those (R8)
_BATTERY = {  # V below the bound, s until it is known: 10 and three reports; or noise
    "battery_low": (0.6, 16.0),
    "battery_flickers": (1.5, 120.0),
}
_AGAIN = 8.0  # s until a battery is believed again: three reports in range
_WET, _MUTE = 5.0, ("stm32_silent", "bytes_corrupted")  # s: three reports, and the time of one
_ANSWERED = 1.0  # s
ANSWER, _STOP, _SURFACE = re.compile(rb"@ACK_Z"), b"@ZAX0$", b"@ZAWF$"
_AFLOAT = 1.0  # m


@dataclass(frozen=True, slots=True)
class _Limit:
    """``passed`` of (story, stay, told): whether truly passed by more than sensors explain.

    ``more`` of (story, t): reports that the rule asks for beside ``reports``.
    """

    name: str
    passed: Callable[[Story, Stay, Told], bool]
    reports: int
    faults: tuple[str, ...] = ()
    more: Callable[[Story, float], int] = lambda story, t: 0


def limit_laws(story: Story) -> Iterator[Violation]:
    for flight in story.flights():
        for limit in _BY_REPORT:
            yield from _by_report(story, flight, limit)
        begin, end = flight[0].begin, flight[-1].end
        yield from _topside(story, begin, end)
        yield from _unanswered(story, begin, end)
        yield from _one_unanswered(story, begin, end)
        yield from _voltage(story, begin, end)
        yield from _leak(story, begin, end)
        yield from _blind(story, begin, end)
        yield from _blind_before(story, flight)
        yield from _false_alarm(story, flight[-1])
        yield from _clogged(story, flight)


def _by_report(story: Story, flight: list[Stay], limit: _Limit) -> Iterator[Violation]:
    seen = 0
    for stay in flight:
        for told in story.samples_in(stay.begin, stay.end):
            seen = seen + 1 if limit.passed(story, stay, told) else 0
            asked = limit.reports + limit.more(story, told.t)
            if seen <= asked + SPARE or story.hindered(told.t - 10.0, told.t):
                continue
            if not story.faulty(limit.faults, told.t - 10.0, told.t):
                says = f"{limit.name} passed in {seen} reports, and still in {stay.state}"
                yield Violation(UNANSWERED, told.t, says)
                return


def _depth(story: Story, stay: Stay, told: Told) -> bool:
    span = next((s for s in story.spans if s.begin <= told.t - 6.0 and told.t <= s.end), None)
    return span is not None and story.depth(told.t) > span.bounds.depth + _DEPTH


def _roll(story: Story, stay: Stay, told: Told) -> bool:
    return story.tilt(told.t) > story.vehicle.limits.roll + _ROLL


def _on_edge(story: Story, t: float) -> int:
    """Return the reports more that a roll of about 90 degrees takes.

    Reports of more than 90 degrees are believed from the third in a row on (R5). A report of less
    restarts that row, and counts as one of the two samples. So the sixth report acts at the latest.
    """
    return _EDGE if abs(story.tilt(t) - math.pi / 2.0) < _ROLL else 0


_BY_REPORT = (
    _Limit("depth", _depth, 2, DEPTH_FAULTS),
    _Limit("roll", _roll, 2, ("attitude_", "roll_"), _on_edge),
)


def _false_alarm(story: Story, stay: Stay) -> Iterator[Violation]:
    """A limit ended the mission, though it was not truly passed and its sensor was healthy.

    A sensor at full scale is no excuse: it reports nothing.
    """
    step = next((s for s in story.steps if s.t == stay.end and s.trigger == "limit"), None)
    names = {e.trigger for e in step.evaluations if e.result} if step is not None else set()
    if "limit depth" in names and not story.faulty(DEPTH_FAULTS, stay.end - 20.0, stay.end):
        bound = min(s.bounds.depth for s in story.spans if s.end >= stay.end - 8.0)
        told = story.deepest(stay.end - 8.0, stay.end) + beside(story.settings)
        if told < bound + 0.5:
            yield Violation(UNANSWERED, stay.end, "a limit of depth that was not passed")
    odd = [
        f for f in story.faults(("attitude_", "roll_"), 0.0, stay.end) if "full_scale" not in f.name
    ]
    ahead = 0 if story.board is None else 1  # s: the truth is sampled each second, a board
    worst = max(story.tilt(stay.end + ahead - i) for i in range(9 + ahead))  # reports ten times
    if "limit roll-over" in names and not odd and worst < story.vehicle.limits.roll - _ROLL:
        yield Violation(UNANSWERED, stay.end, "a limit of roll that was not passed")


# --- by the clock --------------------------------------------------------------------------------


def _topside(story: Story, begin: float, end: float) -> Iterator[Violation]:
    if story.silence is None:
        return
    for quiet, until in gaps((said.t for said in story.said), begin, end):
        if until - quiet > story.silence + _TOPSIDE and not story.hindered(quiet, until):
            says = f"nothing heard from topside for {until - quiet:.0f} s, and still autonomous"
            yield Violation(UNANSWERED, until, says)
            return


def _unanswered(story: Story, begin: float, end: float) -> Iterator[Violation]:
    """Commands to the vehicle that stay unanswered end the mission.

    The stop of an ascent at the surface does not count: it is sent until it is answered (R7, R8).
    """
    if story.board is not None:
        return
    answers = [h.t for h in story.heard if ANSWER.search(h.data)]
    for quiet, until in gaps(answers, begin, end):
        words = [w for w in story.words_in(quiet, until) if _asks(story, w)]
        lost = len(words) > _LOST and until > words[_LOST].t + 1.0
        if lost and not story.hindered(quiet, until):
            says = f"{len(words)} words without an answer, and still autonomous"
            yield Violation(UNANSWERED, until, says)
            return


def _one_unanswered(story: Story, begin: float, end: float) -> Iterator[Violation]:
    """One command of the sets stays unanswered, though the others are answered.

    W belongs to no set: the ascent that sends it also tries its other ways (R7).
    """
    if story.board is not None:
        return
    answers = [h.t for h in story.heard if ANSWER.search(h.data)]
    words = [w for w in story.words_in(begin, end) if w.data.startswith(b"@ZA")]
    lost: dict[bytes, list[float]] = {}
    for word, until in pairwise([*words, None]):
        assert word is not None
        due = min(until.t if until is not None else end, word.t + _ANSWERED)
        first = bisect.bisect_right(answers, word.t)
        if first < len(answers) and answers[first] <= due:
            lost.pop(word.data[:4], None)
        elif word.reason.endswith(_LAST) and word.data != _SURFACE and _asks(story, word):
            before = lost.get(word.data[:4], [])
            near = before and word.t - before[-1] <= _APART
            lost[word.data[:4]] = [*(before if near else []), word.t]
        since = lost.get(word.data[:4], [])
        late = len(since) >= _LOST_OF_ONE and end > word.t + 1.0
        others = late and bisect.bisect_right(answers, since[0]) < first
        if others and not story.hindered(since[0], word.t):
            letter = word.data[3:4].decode("ascii")
            says = f"{letter} without an answer {len(since)} times, and still autonomous"
            yield Violation(UNANSWERED, word.t, says)
            return


def _asks(story: Story, word: Tx) -> bool:
    stops = word.data == _STOP and story.deepest(word.t - 1.0, word.t) < _AFLOAT
    return word.data.startswith(b"@ZA") and not stops


def _voltage(story: Story, begin: float, end: float) -> Iterator[Violation]:
    """Check the voltage, where the vehicle reports its batteries."""
    if story.vehicle.constant_batteries or story.profile != "documented":
        return
    for fault in story.settings.faults:
        below, lasts = _BATTERY.get(fault.name, (0.0, math.inf))
        for since, until in _alone(story, fault, max(fault.begin, begin), end):
            known = since + lasts
            least = min(s.bounds.voltage for s in story.spans if s.begin < known and s.end > since)
            told = len(story.told_in(since, min(known, until))) > lasts / 2.0 - 2.0
            low = (fault.value or 9.0) < least - below
            if low and until > known and told and not story.hindered(since, known):
                yield Violation(UNANSWERED, until, f"{fault.value} V, and still autonomous")
                break


def _alone(
    story: Story, fault: FaultEvent, begin: float, end: float
) -> Iterator[tuple[float, float]]:
    """Yield the times in which nothing else is wrong with the battery, and it is believed."""
    end = min(fault_ends(fault), end)
    others = [f for f in story.settings.faults if f.name.startswith("battery_") and f is not fault]
    for other in sorted(others, key=lambda f: f.begin):
        if fault_ends(other) + _AGAIN <= begin or other.begin >= end:
            continue
        if other.begin > begin:
            yield begin, other.begin
        begin = fault_ends(other) + _AGAIN
    if begin < end:
        yield begin, end


def _leak(story: Story, begin: float, end: float) -> Iterator[Violation]:
    """Check the leak, where the vehicle reports it several times a second."""
    for fault in story.settings.faults:
        since = max(fault.begin, begin)
        known = since + _WET
        there = fault.name == "leak" and known < min(fault_ends(fault), end)
        unheard = story.faulty(_MUTE, since, known) or story.hindered(since, known)
        if there and not unheard:
            state = story.stay_at(known).state
            yield Violation(UNANSWERED, known, f"water inside for {_WET:g} s: still in {state}")


def _blind(story: Story, begin: float, end: float) -> Iterator[Violation]:
    """A mission without a depth ends in time."""
    for fault, lag in _no_depths(story):
        if fault.begin < begin + 10.0:
            continue
        until = min(fault_ends(fault), end, FOREVER)
        known = fault.begin + lag
        under = min(story.depth(t) for t in (fault.begin - 6.0, fault.begin, known)) > _UNDER
        alone = len(story.faults(("depth_",), fault.begin - 10.0, until)) == 1
        told = len(story.told_in(fault.begin, known)) > 3
        if not _may_be_told(story, fault, fault.begin, known):
            continue
        if until > known and under and alone and told and not story.hindered(fault.begin, known):
            yield Violation(UNANSWERED, known, "under water without a depth, and still autonomous")


def _blind_before(story: Story, flight: list[Stay]) -> Iterator[Violation]:
    """The same where no depth of a dive was believed: its set leads down and needs no depth."""
    spans = [span for stay in flight for span in sets_of(story, stay)]
    downward = [s for s in spans if s[2].altitude is not None or (s[2].heave or 0.0) > 0.0]
    for fault, lag in _no_depths(story):
        for begin, end, _ in downward:
            known = begin + lag
            until = min(fault_ends(fault), end, FOREVER)
            if fault.begin > begin or until <= known or story.depth(known) <= _UNDER:
                continue
            alone = len(story.faults(("depth_",), begin - 10.0, until)) == 1
            told = len(story.told_in(begin, known)) > 3 and _may_be_told(story, fault, begin, known)
            if alone and told and not story.hindered(begin, known):
                yield Violation(UNANSWERED, known, "dives without a depth, and still autonomous")


def _no_depths(story: Story) -> Iterator[tuple[FaultEvent, float]]:
    """Yield the faults that leave no depth, and the s after which each ends a mission.

    A depth at full scale is known at once, and so is a silent one on a board that reports this.
    """
    for fault in story.settings.faults:
        silent = fault.name == "depth_silent" and story.profile == "documented"
        if silent or fault.name in ("depth_frozen", "depth_full_scale"):
            yield fault, _BLIND + (10.0 if fault.name == "depth_frozen" else 0.0)


def _may_be_told(story: Story, fault: FaultEvent, begin: float, end: float) -> bool:
    """Whether the fault can be known: a frozen depth only while a thruster turns (R5).

    If reports do not show the thrusters, the last command to the vehicle counts (R7).
    """
    told = [r for r in story.reports if begin <= r.t <= end]
    shown = any(r.pwm for r in told)
    turns = all(r.may_turn for r in told) and (shown or not _is_stopped(story, begin, end))
    return turns or fault.name != "depth_frozen"


def _is_stopped(story: Story, begin: float, end: float) -> bool:
    """Whether the command in force at ``begin``, or a later one until ``end``, is a stop."""
    said = [(step.t, found[-1]) for step in story.steps if (found := commands_of(step))]
    before = [command for t, command in said if t <= begin][-1:]
    return Order.STOP in (*before, *(command for t, command in said if begin < t <= end))


def _clogged(story: Story, flight: list[Stay]) -> Iterator[Violation]:
    """A port clogs 1 m or more above the depth setpoint: at most 6 m beyond the bound then (R5).

    Nobody can keep a bound without a depth that an operator tightens later.
    """
    for fault in story.faults(("depth_stuck",), flight[0].begin, flight[-1].end):
        stay = story.stay_at(fault.begin)
        sets = [c for b, e, c in sets_of(story, stay) if b <= fault.begin < e]
        short = sets and (sets[0].depth or 0.0) - story.depth(fault.begin) > 1.0 + _DEPTH
        end = min(fault_ends(fault), story.end)
        others = (
            *DEPTH_FAULTS,
            "heavy",
            "capsized",
            "listing",
            "stm32_",
            "command_",
            "verticals_",
            "dives_",
        )
        alone = (
            len(story.faults((*others, "unexplained", "obeys", "deaf_to", "thrust_dead"), 0.0, end))
            == 1
        )
        if not short or not alone or story.hindered(fault.begin, end):
            continue
        bound = next(s.bounds.depth for s in story.spans if s.end >= fault.begin)
        if (deepest := story.deepest(fault.begin, end)) > bound + _CLOGGED:
            says = f"{deepest:.1f} m deep with a clogged port, limit {bound:g} m"
            yield Violation(UNANSWERED, end, says)


# --- by the set in force -------------------------------------------------------------------------


def is_plain(story: Story, begin: float, end: float, faults: tuple[str, ...]) -> bool:
    """Whether nothing excuses: the program was not hindered, and these faults were not there."""
    return not (story.hindered(begin, end) or story.faulty(faults, begin, end))


def sets_of(story: Story, stay: Stay) -> list[tuple[float, float, Setpoint]]:
    """Return (begin, end, set) of a leg, without the sets of a leg that ended just before it."""
    steps = [step for step in story.steps if stay.begin <= step.t < stay.end]
    steps = steps[next((i for i, step in enumerate(steps) if step is stay.step), 0) :]
    found = [(step.t, command) for step in steps if (command := _set_of(step)) is not None]
    ends = [*(t for t, _ in found[1:]), stay.end][: len(found)]
    return [(t, end, command) for (t, command), end in zip(found, ends, strict=True)]


def _set_of(step: Step) -> Setpoint | None:
    commands = commands_of(step)
    return None if not commands or isinstance(commands[-1], Order) else commands[-1]
