"""Margins: how near a flight came to breaking each law. They steer the search.

A margin is 1 where nothing of the kind happened, and 0 where the bound is used up. After a limit
has been passed, the margin is below 0.5: the share that is left of the time to answer it. (This is
robustness as in signal temporal logic: Fainekos and Pappas, Theoretical Computer Science 410, 2009;
here by law, each as a share of its own bound.) The excuses are those of the laws: a program that is
dead or stalled, and for the depth an unhealthy sensor.

    depth, radius, tilt   truly beyond the limit, and still in the mission
    time, reports, topside, answers                  the times of the mission's limits
    sensor    time flown with a failing sensor       AUTO       time closed, and under way
    rest      deep, or going down, at rest           ascent     time in which it does not rise
    upward    from a restart to an upward command    stop       time without an acknowledged X0
    turning   a thruster on at rest, and no X0       order      from an X or W to the line
    surface   how deep just before surfaced          begin      how deep at a start, or a clear
    stick     time without M, in manual              estimate   error of the estimate
    end       how deep at the end

What does not live here: the laws (laws, whole_flight), the excuses (excuses).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping

from links.simulated.link import Truth
from mission.model import MANUAL_DRIVING, SURFACED, SURFACING
from mission.verification.campaign.depth_laws import DEPTH_FAULTS
from mission.verification.campaign.laws import Span
from mission.verification.campaign.story import STOP_WORD, UPWARD_WORDS, Story, gaps
from mission.verification.campaign.trial import fault_ends
from mission.verification.rig.program import DEAD
from mission.verification.rig.trace import from_home

_ANSWER_TO_LIMIT = 10.0  # s: by report
_DEPTH, _TILT = 1.5, math.radians(6.0)  # m and rad beyond the bound
_FAR = 30.0  # s beyond the radius
_REPORTS, _WORDS = 5.5, 12
_RISE, _RISE_DEEP, _STAYS = (22, 0.3), 2.4, 70.0  # s and m; m; s
_FALL, _FALL_DEEP, _LIFTED = (10, 0.05), 1.5, 60.0
_SANK = 5.0  # m at rest
_UPWARD, _AGAIN, _ORDERED = 2.0, 1.6, 0.1  # s
_BEGIN, _END = 1.1, 0.5  # m
_SHALLOW, _SHALLOW_FOR, _FIXED, _FIXED_FOR = 1.0, 4.0, 0.4, 2.0  # m in s
_SILENT, _FORGOTTEN = 2.6, 61.5  # s
_BESIDE = 200.0  # m
_FAILS, _CLOSED = 60.0, 6.0  # s
_SENSORS = ("depth_", "heading_", "attitude_", "altitude_", "roll_", "gps_")
_STOPPED_ACK = re.compile(rb"@ACK_Z[XA]Y\$")
_ORDER = re.compile(rb"@ZA(?:X0|WF)\$")
# Margins that need acknowledgements, which only the AUV's board gives; and a place.
_ANSWERED, _PLACED = frozenset({"answers", "stop", "order"}), frozenset({"radius", "estimate"})
Margin = Callable[[Story], Iterable[float]]


def margins(story: Story) -> dict[str, float]:
    """Return the least margin of each kind, as far as the vehicle has them."""
    found = {}
    place = "position" in story.vehicle.reports
    for name, law in MARGINS.items():
        if (name in _ANSWERED and story.board is not None) or (name in _PLACED and not place):
            continue
        least = min(law(story), default=1.0)
        if least < 1.0:
            found[name] = round(max(least, 0.0), 4)
    return found


def _left(used: float, allowed: float) -> float:
    return 1.0 - max(used, 0.0) / allowed


def _plain(story: Story, begin: float, end: float) -> bool:
    """Whether nothing excuses the flight: neither the depth sensor nor a hindered program."""
    return not (story.hindered(begin, end) or story.faulty(DEPTH_FAULTS, begin, end))


# --- limits --------------------------------------------------------------------------------------


def _passed(story: Story, seconds: float, share: Callable[[Span, Truth], float]) -> Iterator[float]:
    """Yield margins at any second of a mission; ``share`` is the part of the bound that is used."""
    beyond = 0.0
    for span in story.spans:
        places = story.trial.track[math.ceil(span.begin) : int(span.end) + 1]
        for place in places if span.autonomous else ():
            used = share(span, place)
            beyond = beyond + 1.0 if used > 1.0 else 0.0
            if not story.hindered(place.t - beyond, place.t):
                yield 0.5 * _left(beyond, seconds) if beyond else 0.5 + 0.5 * _left(used, 1.0)


def _depth(story: Story) -> Iterator[float]:
    return _passed(story, _ANSWER_TO_LIMIT, lambda s, p: p.depth / (s.bounds.depth + _DEPTH))


def _radius(story: Story) -> Iterator[float]:
    return _passed(
        story, _FAR, lambda s, p: math.hypot(*from_home(story.trial, p)) / s.bounds.radius
    )


def _tilt(story: Story) -> Iterator[float]:
    most = story.vehicle.limits.roll + _TILT
    return _passed(story, _ANSWER_TO_LIMIT, lambda s, p: story.tilt(p.t) / most)


def _time(story: Story) -> Iterator[float]:
    return (_left(s.end - s.started, s.bounds.time + 1.0) for s in story.spans if s.autonomous)


def _pauses(story: Story, times: list[float]) -> Iterator[float]:
    """Yield the pauses between ``times`` in each mission, s."""
    for flight in story.flights():
        for begin, end in gaps(times, flight[0].begin, flight[-1].end):
            if not story.hindered(begin, end):
                yield end - begin


def _reports(story: Story) -> Iterator[float]:
    return (_left(s, _REPORTS) for s in _pauses(story, [told.t for told in story.told]))


def _topside(story: Story) -> Iterator[float]:
    if story.silence is not None:
        for seconds in _pauses(story, [said.t for said in story.said]):
            yield _left(seconds, story.silence + 1.0)


def _answers(story: Story) -> Iterator[float]:
    answers = [heard.t for heard in story.heard if b"@ACK_Z" in heard.data]
    for flight in story.flights():
        for begin, end in gaps(answers, flight[0].begin, flight[-1].end):
            if not story.hindered(begin, end):
                yield _left(len(story.words_in(begin, end)) - 1, _WORDS)


def _sensor(story: Story) -> Iterator[float]:
    for flight in story.flights():
        for fault in story.faults(_SENSORS, flight[0].begin, flight[-1].end):
            begin, end = max(fault.begin, flight[0].begin), min(fault_ends(fault), flight[-1].end)
            if not story.hindered(begin, end):
                yield _left(end - begin, _FAILS)


def _auto(story: Story) -> Iterator[float]:
    for flight in story.flights():
        for t in range(int(flight[0].begin), int(flight[-1].end)):
            closed = min(_CLOSED, flight[-1].end - t)
            yield _left(closed, _CLOSED) if story.auto_closed(t, t) else 1.0


# --- up ------------------------------------------------------------------------------------------


def _rest(story: Story) -> Iterator[float]:
    for stay in story.stays:
        if not stay.rests:
            continue
        if story.auto_closed(stay.begin, stay.end) or not _plain(story, stay.begin, stay.end):
            continue
        for begin, end in story.flat(stay.begin, stay.end, *_RISE, _RISE_DEEP):
            yield _left(end - begin, _STAYS)
        shallowest = math.inf
        for t in range(math.ceil(stay.begin), int(stay.end) + 1):
            shallowest = min(shallowest, story.depth(t))
            yield _left(story.depth(t) - shallowest, _SANK)


def _ascent(story: Story) -> Iterator[float]:
    for stay in story.stays:
        if stay.ascends:
            for begin, end in story.flat(stay.begin, stay.end, *_FALL, _FALL_DEEP):
                if _plain(story, begin, end):
                    yield _left(end - begin, _LIFTED)


def _upward(story: Story) -> Iterator[float]:
    """Yield margins of the time from a restart under way to the first upward command."""
    for was, dead, stay in zip(story.stays, story.stays[1:], story.stays[2:], strict=False):
        under_way = was.autonomous or was.state == SURFACING
        if dead.state == DEAD and under_way and story.end > stay.begin + _UPWARD:
            words = story.words_in(stay.begin, story.end)
            first = next((w.t for w in words if w.data in UPWARD_WORDS), story.end)
            yield _left(first - stay.begin, _UPWARD)


def _surface(story: Story) -> Iterator[float]:
    """Yield margins of the surface's proof: shallow for seconds, or an antenna above water."""
    for stay in story.stays:
        t = stay.begin
        claims = stay.state == SURFACED and stay.before == SURFACING
        if claims and _plain(story, t - 10.0, t):
            shallow = _left(story.deepest(t - _SHALLOW_FOR, t), _SHALLOW)
            yield max(shallow, _left(story.deepest(t - _FIXED_FOR, t), _FIXED))


def _begin(story: Story) -> Iterator[float]:
    for stay in story.stays:
        starts = stay.autonomous and stay.before.startswith("idle")
        clears = stay.state.startswith("idle") and stay.before.startswith("emergency")
        if (starts or clears) and _plain(story, stay.begin - 10.0, stay.begin):
            yield _left(story.depth(stay.begin), _BEGIN)


def _end(story: Story) -> Iterator[float]:
    yield _left(story.trial.truth.depth, _END)


# --- words ---------------------------------------------------------------------------------------


def _stop(story: Story) -> Iterator[float]:
    answers = [heard.t for heard in story.heard if _STOPPED_ACK.search(heard.data)]
    for stay in story.stays:
        if stay.rests and stay.step is not None and stay.step.actions:
            end = next((t for t in answers if t > stay.begin), stay.end)
            words = story.words_in(stay.begin, min(end, stay.end))
            stops = [w.t for w in words if w.data == STOP_WORD]
            if not story.hindered(stay.begin, end):
                yield _left(max(b - a for a, b in gaps(stops, stay.begin, end)), _AGAIN)


def _turning(story: Story) -> Iterator[float]:
    for stay in story.stays:
        seen = 0
        for report in story.reports if stay.rests else ():
            inside = stay.begin + 2.0 < report.t < stay.end
            if not inside or story.hindered(report.t - 4.0, report.t):
                continue
            words = story.words_in(report.t - 2.0, report.t)
            seen = seen + 1 if report.turning and not words else 0
            yield _left(seen, 2.0)


def _order(story: Story) -> Iterator[float]:
    for said in story.said:
        for frame in _ORDER.findall(said.data)[-1:]:
            words = story.words_in(said.t, said.t + 5.0)
            left = next((w.t for w in words if w.data == frame), min(said.t + 5.0, story.end))
            if not story.hindered(said.t - 0.1, left):
                yield _left(left - said.t, _ORDERED)


def _stick(story: Story) -> Iterator[float]:
    sticks = story.stick
    for stay in story.stays:
        if stay.state.startswith("manual"):
            last = max((t for t in sticks if t <= stay.end), default=stay.begin)
            driving = stay.state == MANUAL_DRIVING
            if not story.hindered(last - 0.1, stay.end):
                yield _left(stay.end - last, _SILENT if driving else _FORGOTTEN)


def _estimate(story: Story) -> Iterator[float]:
    track = story.trial.track
    for told in story.told:
        north, east = from_home(story.trial, track[min(int(told.t), len(track) - 1)])
        e = told.estimate
        yield _left(math.hypot(e.north - north, e.east - east), _BESIDE)


MARGINS: Mapping[str, Margin] = {
    "depth": _depth,
    "radius": _radius,
    "tilt": _tilt,
    "time": _time,
    "reports": _reports,
    "topside": _topside,
    "answers": _answers,
    "sensor": _sensor,
    "AUTO": _auto,
    "rest": _rest,
    "ascent": _ascent,
    "upward": _upward,
    "surface": _surface,
    "begin": _begin,
    "end": _end,
    "stop": _stop,
    "turning": _turning,
    "order": _order,
    "stick": _stick,
    "estimate": _estimate,
}
