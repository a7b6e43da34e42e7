"""Laws of the depth over the whole flight: a vehicle that is under water or sinks comes up.

The laws go by the true depth and the commands on the line, and are written from R7 alone:

    at rest    a vehicle that sinks where everything is stopped is brought up: over 2 m deep (in
               surfaced 1 m) and 0.5 m deeper than it has been, it is surfacing by the fourth report
    told       so is a vehicle whose reports show for 40 s how it sinks, whatever their zero
    stopped    over 2 m deep, and not risen by 0.5 m in 20 s: the same
    held       a vehicle that sank out of surfaced and is brought up does not sink out of it again
    upward     whatever begins an ascent, an upward command leaves within 3 s
    ways       while the depth does not fall, all ways are tried: W, X0 and U12, X0 alone
    down       upside down, D12 is one of the ways; W and U12 push down there, and need not be
    again      upside down, a command that has led deeper is not sent again
    up         a vehicle that its thrusters (or its buoyancy) could lift comes up

Excuses: physics (``_liftable``), a program that is dead or stalled, a closed node AUTO, and a depth
sensor that is not healthy, where the rule goes by the believed depth. At rest an unknown depth
turns no thruster; when the depth is known again, the depths before do not count. A depth that came
back with a jump is known again only when it has shown the surface (R5). Until then its change alone
counts, and only a change that no drift at the surface makes, since fixes may come (R7).
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Iterator, Sequence
from itertools import compress, pairwise

from mission.model import STOPPED, SURFACED, SURFACING, Tx
from mission.verification.campaign.excuses import LIFT_WORD, value_of
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.reports import Report
from mission.verification.campaign.story import (
    DOWN_WORD,
    STOP_WORD,
    UPWARD_WORDS,
    Stay,
    Story,
    apart,
)
from mission.verification.campaign.trial import fault_ends

SUNK = "sunk"
DEPTH_FAULTS = ("depth_",)
_ERROR = 0.4  # m: error of the depth sensor
_DEEP, _DEEP_AGAIN = 2.0 + _ERROR, 1.0 + _ERROR  # m
_DEEPER = 0.5 + _ERROR  # m deeper than it has been
_ROSE = 1.1  # m more where the vehicle rose before: 6 s of smoothing
_REPORTS = 3  # two in a row, and one that noise may cost
_STALE = 9.0  # s without a report: counting restarts
_GROUND = 1.0  # m above the ground: the vehicle lies on it
_RISE = 22, 0.3  # s and m: less than 0.5 m in 20 s, by reports that come every 2 s
_STEPS, _STEP_S = 4, 10.0  # means of so many s: waves average out
_EVEN = 2.5, 12.5  # m from each mean to the next: 0.25 m/s, and what no body exceeds (R5)
_HEALED = 20.0  # s before: a depth that leaps is contradicted and followed by then (R5)
_NEVER_RISEN = 70.0  # s: at least two such times fit, whenever they begin
_FALL = 10, 0.05  # s and m: no way makes the depth fall
_FIRST = 3.0  # s until an upward command has left: three tries, and the X0 before U12
_ROUND = 70.0  # s: three ways, 10 s more of U12, D12, a turn that raised it, its way once more
_OVERTURNED_ROUND = 120.0  # s: D12 comes once a minute, after the last way
_TELL = 3  # reports; of more than these, three agree on a roll
_AFLOAT = 0.5  # m
_SHALLOW = 1.5  # m: so near the surface no way need be tried
_NOT_LIFTED = 70.0  # s: a round, and 10 s more
_UPRIGHT, _OVERTURNED = math.radians(60.0), math.radians(130.0)
_MAY_BE_OVER = math.radians(117.0)  # roll or pitch: 120 degrees (R7), less noise of the attitude
_MOSTLY = 0.9  # share of the seconds
_KNOWN_OVER = 12.0  # s of reports until a roll-over is known
_TRIED, _LED = 9.0, 2.0  # s of a turn, m: R7's metre, two errors of the sensor, an old report
_WAYS = (*UPWARD_WORDS, STOP_WORD, DOWN_WORD)
_TRIES = 3  # of a command (R1)
_SINKS_ON = 8.0  # s from an X0 that U12 follows late, until its thrust has turned the sinking round
_SPARE = 8.0  # N of lift that raise the vehicle within a turn
_OUT_OF_HAND = (
    *("stm32_", "command_", "unexplained_dive", "deaf_to", "dives_until", "obeys_late"),
    *("ack_lost", "verticals_", "thrust_dead", "bytes_corrupted", "line_noise", "splice"),
)


def depth_laws(story: Story) -> Iterator[Violation]:
    if not story.upward:  # it drives on the ground
        return
    for stay in story.stays:
        if stay.rests and stay.state != STOPPED:
            yield from _sinks_from_rest(story, stay)
        if stay.rests:
            yield from _sinks_in_reports(story, stay)
        if stay.state == STOPPED:
            yield from _stays_down(story, stay)
        if stay.state == SURFACING:
            yield from _begins_upward(story, stay)
        if stay.ascends:
            yield from _tries_all(story, stay)
            yield from _comes_up(story, stay)
            yield from _pushes_again(story, stay)
    yield from _is_held_up(story)


def _excused(story: Story, begin: float, end: float) -> bool:
    return (
        story.faulty(DEPTH_FAULTS, begin, end)
        or story.has_leapt(end)
        or story.hindered(begin, end)
        or story.auto_closed(begin, end)
    )


def _sinks_from_rest(story: Story, stay: Stay) -> Iterator[Violation]:
    deep = _DEEP_AGAIN if stay.state == SURFACED else _DEEP
    deep += story.settings.sea.waves[0]  # by crests, single reports are less deep than that
    shallowest, seen, last = math.inf, 0, -math.inf
    deeper = _DEEPER + (_ROSE if story.depth(stay.begin) > 1.0 else 0.0)
    reports = story.told_in(stay.begin, stay.end)
    for told in compress(reports, apart(r.t for r in reports)):
        depth = story.depth(told.t)
        excused = _excused(story, told.t - 20.0, told.t)
        if told.t - last > _STALE or excused:
            shallowest, seen = math.inf, 0
        shallowest, last = min(shallowest, depth), told.t
        seen = seen + 1 if depth > deep and depth > shallowest + deeper else 0
        if seen > _REPORTS:
            yield Violation(SUNK, told.t, f"sinks in {stay.state}, {depth:.1f} m deep: no response")
            return


def _sinks_in_reports(story: Story, stay: Stay) -> Iterator[Violation]:
    """The zero of the depth may be contradicted. It moves as the vehicle does, and no depth goes
    down so fast at the surface: fixes that come meanwhile are made up (R7)."""
    lasts = _STEPS * _STEP_S
    for begin in range(math.ceil(stay.begin), int(min(stay.end, story.end) - lasts)):
        t, end = float(begin), begin + lasts
        sinks = story.depth(end) - story.depth(t) >= (_STEPS - 1) * _EVEN[0]
        if not (sinks and _reads_evenly(story.reports, t)):
            continue
        healed = not any(
            t - _HEALED <= at <= end
            for fault in story.settings.faults
            if fault.name.startswith(DEPTH_FAULTS)
            for at in (fault.begin, fault_ends(fault))
        )
        stops = any(t <= s.t <= end and STOP_WORD in s.data for s in story.said)
        if healed and not (stops or story.hindered(t, end) or story.auto_closed(t, end)):
            says = f"sinks in {stay.state}, {story.depth(end):.1f} m deep, as its reports show"
            yield Violation(SUNK, end, f"{says}: no response")
            return


def _reads_evenly(reports: Sequence[Report], begin: float) -> bool:
    """Whether the reported depth goes down evenly from ``begin`` on, in all steps."""
    means = list[float]()
    for step in range(_STEPS):
        since = begin + step * _STEP_S
        low, high = (
            bisect.bisect_left(reports, at, key=lambda report: report.t)
            for at in (since, since + _STEP_S)
        )
        depths = [report.depth for report in reports[low:high]]
        means.append(sum(depths) / len(depths) if len(depths) > _REPORTS else math.nan)
    return all(_EVEN[0] <= after - before <= _EVEN[1] for before, after in pairwise(means))


def _stays_down(story: Story, stay: Stay) -> Iterator[Violation]:
    for begin, end in story.flat(stay.begin, stay.end, *_RISE, _DEEP):
        if end - begin < _NEVER_RISEN or _excused(story, begin, end):
            continue
        if _pressed_unseen(story, begin, end):
            continue
        if max(b - a for a, b in _pauses(story, begin, end)) <= _STALE:
            says = f"stopped {story.depth(end):.1f} m deep for {end - begin:.0f} s: no response"
            yield Violation(SUNK, end, says)


def _pressed_unseen(story: Story, begin: float, end: float) -> bool:
    """Whether the board drives the vehicle onto ground that the altimeter does not report.

    Then the depth is contradicted, and at rest an unknown depth turns no thruster.
    """
    near = story.settings.sea.floor - story.depth(end) < _GROUND
    return (
        near and story.faulty(("dives_",), begin, end) and story.faulty(("altitude_",), begin, end)
    )


def _pauses(story: Story, begin: float, end: float) -> list[tuple[float, float]]:
    times = [begin, *(told.t for told in story.told_in(begin, end)), end]
    return list(pairwise(times))


def _begins_upward(story: Story, stay: Stay) -> Iterator[Violation]:
    """Not where a leg's ascent continues, nor where the vehicle is upside down or was so in its
    last report: there the ascent begins by letting go."""
    goes_on = stay.step is not None and not stay.step.actions
    end = stay.begin + _FIRST
    if goes_on or stay.end < end or story.hindered(stay.begin - 1.0, end):
        return
    tilts = map(story.tilt, (stay.begin, story.told_before(stay.begin)))
    if max(tilts) > _UPRIGHT or story.faulty(("attitude_", "roll_"), stay.begin, end):
        return
    if not any(word.data in story.upward for word in story.words_in(stay.begin, end)):
        yield Violation(SUNK, end, f"no upward word within {_FIRST:g} s of {stay.state}")


def _tries_all(story: Story, stay: Stay) -> Iterator[Violation]:
    for begin, end in story.flat(stay.begin, stay.end, *_FALL, _SHALLOW):
        if end - begin < _ROUND or story.hindered(begin, end):
            continue
        if story.faulty(DEPTH_FAULTS, begin, end):
            continue
        missing = _missing(story, begin, end)
        if missing:
            says = f"{end - begin:.0f} s of an ascent without {' or '.join(missing)}"
            yield Violation(SUNK, end, f"{says}, {story.depth(end):.1f} m deep")


def _missing(story: Story, begin: float, end: float) -> list[str]:
    words = story.words_in(begin, end)
    sent = {word.data for word in words}
    seconds = int(end - begin)
    over = sum(story.tilt(begin + i) > _OVERTURNED for i in range(seconds)) > _MOSTLY * seconds
    over = over and not story.faulty(("attitude_", "roll_"), begin, end)
    over = over and len(story.told_in(begin, end)) > _TELL
    turned = over or not _upright_for_a_round(story, begin, end)
    missing = [word.decode() for word in story.upward if word not in sent and not turned]
    if not any(_lets_go(story, word.t) for word in words if word.data == STOP_WORD):
        missing.append("letting go")
    if over and seconds > _OVERTURNED_ROUND and DOWN_WORD not in sent:
        missing.append(DOWN_WORD.decode())
    return missing


def _upright_for_a_round(story: Story, begin: float, end: float) -> bool:
    """Whether no report of the last round before ``end`` can have shown the vehicle upside down.

    Upside down, a push that led deeper is not tried again; upright, each way has its turn again.
    """
    lay = [t for i in range(int(end - begin)) if story.heel(t := begin + i) > _MAY_BE_OVER]
    return not lay or end - lay[-1] >= _ROUND


def _lets_go(story: Story, t: float) -> bool:
    """Whether an X0 lets go: it is not the first half of another command."""
    after = story.words_in(t, t + 2.0)
    return not any(word.data[:4] in (b"@ZAU", b"@ZAD") for word in after)


def _comes_up(story: Story, stay: Stay) -> Iterator[Violation]:
    for begin, end in story.flat(stay.begin, stay.end, *_FALL, _SHALLOW):
        if end - begin < _NOT_LIFTED or story.hindered(begin, end):
            continue
        if story.faulty((*_OUT_OF_HAND, *DEPTH_FAULTS), begin, end):
            continue
        if _liftable(story, begin, end):
            says = f"not risen for {end - begin:.0f} s, {story.depth(end):.1f} m deep"
            yield Violation(SUNK, end, f"{says}, though it could")


def _pushes_again(story: Story, stay: Stay) -> Iterator[Violation]:
    """Upside down, a command that has led deeper is not sent again."""
    led: set[bytes] = set()
    for way, then in pairwise(_ways(story, stay)):
        if not _lies_over(story, way.t):
            led.clear()
            continue
        if way.data in led:
            says = f"{way.data.decode()} upside down again, which had led deeper"
            yield Violation(SUNK, way.t, f"{says}, {story.depth(way.t):.1f} m deep")
            return
        deeper = story.depth(then.t) - story.depth(then.t - _TRIED)
        if way.data in UPWARD_WORDS and then.t - way.t >= _TRIED and deeper > _LED:
            led.add(way.data)


def _ways(story: Story, stay: Stay) -> list[Tx]:
    """Return the commands that begin a way: no second tries, no X0 of another command."""
    words = [w for w in story.words_in(stay.begin, stay.end) if w.data in _WAYS]
    news = [w for w in words if not w.reason.endswith(("(held)", " of 3)"))]
    return [w for w in news if w.data != STOP_WORD or _lets_go(story, w.t)]


def _lies_over(story: Story, t: float) -> bool:
    """Whether the vehicle is upside down for so long that reports have shown it.

    It must not be turning upright just now. The track has one place a second, and shows such a turn
    in the next place.
    """
    begin = t - _KNOWN_OVER
    if not story.told_in(begin, t):
        return False
    if story.faulty((*DEPTH_FAULTS, "attitude_", "roll_"), begin, t) or story.hindered(begin, t):
        return False
    return all(story.tilt(begin + i) > _OVERTURNED for i in range(int(_KNOWN_OVER) + 2))


def net_buoyancy(story: Story, begin: float, end: float) -> float:
    """Return the least buoyancy in this time, N."""
    heavier = sum(f.value or 8.0 for f in story.faults(("heavy",), begin, end))
    return story.settings.body.buoyancy - heavier


def _liftable(story: Story, begin: float, end: float) -> bool:
    """Whether thrust (upright) or buoyancy (upside down) can lift the vehicle."""
    net = net_buoyancy(story, begin, end)
    if story.faulty(("capsized", "listing"), begin, end):
        return net > _SPARE
    return net + 3.0 * story.settings.body.vertical_thrust > _SPARE


def _is_held_up(story: Story) -> Iterator[Violation]:
    """A vehicle sinks out of surfaced only once, unless somebody acts in between.

    A closed AUTO is such an act. Waves that wash over an antenna are no sinking.
    """
    sank = False
    for stay in story.stays:
        if stay.state not in (SURFACING, SURFACED):
            sank = False
        elif stay.state == SURFACING:
            again = stay.before == SURFACED and _by_itself(stay)
            begin = stay.begin - 20.0
            free = story.hindered(begin, stay.begin) or story.faulty(
                (*_OUT_OF_HAND, *DEPTH_FAULTS, "capsized", "listing"), begin, stay.begin
            )
            free = free or _misses_its_lift(story, stay.begin)
            sinks = story.deepest(begin, stay.begin) > _AFLOAT
            if again and sank and sinks and not free:
                yield Violation(SUNK, stay.begin, "sank out of surfaced again: it was not held up")
            sank = again or (sank and _by_itself(stay))
        elif story.auto_closed(stay.begin, stay.end):
            sank = False


def _misses_its_lift(story: Story, t: float) -> bool:
    """Whether a board that was busy with an X0 received none of the three tries of its U12.

    Then no thruster turns until U12 is repeated 1.5 s later (R7), and a heavy vehicle sinks.
    """
    for busy in story.faults(("busy",), t - _SINKS_ON, t):
        for stop in story.words_in(t - _SINKS_ON, t):
            if stop.data != STOP_WORD or not busy.begin < stop.t < min(t, fault_ends(busy)):
                continue
            deaf = story.words_in(stop.t, stop.t + value_of(busy))
            if sum(word.data == LIFT_WORD for word in deaf) >= _TRIES:
                return True
    return False


def _by_itself(stay: Stay) -> bool:
    return stay.step is not None and stay.step.trigger == "limit"
