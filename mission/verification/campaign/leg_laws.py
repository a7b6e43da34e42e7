"""Laws of the limits that look at one leg (R5, R8): what the leg sets, and what the vehicle does.

    no progress    the depth comes no nearer to the setpoint
    descent        the vehicle goes down, and nothing asks for that
    heading        the error of the heading grows
    power          thrust is set, and no thruster turns
    uncertain      the 95 % bound of the position reaches the radius
    course         at the surface the course over ground differs from the heading

What does not live here: when a response is late, and what excuses it (limit_laws).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import compress, groupby

from mission.verification.campaign.depth_laws import DEPTH_FAULTS
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.limit_laws import ANSWER, SPARE, UNANSWERED, is_plain, sets_of
from mission.verification.campaign.reports import Report
from mission.verification.campaign.story import Stay, Story, apart
from protocol.messages import Setpoint

_NEARER, _OFF, _STUCK = 0.5, 2.6, 136.0  # m, m, s: 0.5 m, 2 m and 120 s (R5)
_NEARLY = 0.45  # m nearer: a report that only the engine or only the law takes may decide
_UNASKED, _SINKING = 3.0, 0.2  # m and m/s: 2 m and 0.1 m/s (R5)
_SLOWLY = 32.0  # s: 20 where no depth is held (R5), and delays of reports
_ASTRAY, _GROWN, _STEERED = 40.0, 28.0, 14.0  # deg, deg, s: 30, 20 and 10 (R5)
_SET, _POWERLESS = 1.5, 7  # s; reports: two, the set again, two more (R8), and the time of answers
_FALLEN = 6.0  # deg: 10 (R5), and the noise of two reports
_APART, _UNDER_WAY, _DRIFTS = math.radians(75.0), 0.7, 32.0  # rad, m/s, s: 60 deg, 0.4, 20 s
_SURE = 1.645  # sigmas of a normal distribution: 95 % one-sided
_STANDS = 6.0  # s for which the last sample stands (R5)
_NO_COURSE = (
    *("gps_", "gps2_", "depth_", "heading_absurd", "heading_full"),
    *("heading_silent", "heading_frozen", "heading_inter"),
)
_SAYS_THE_SAME = ("heading_frozen", "heading_silent", "heading_inter")


def leg_laws(story: Story) -> Iterator[Violation]:
    for stay in (stay for flight in story.flights() for stay in flight):
        yield from _no_progress(story, stay)
        yield from _unasked_descent(story, stay)
        yield from _heading_astray(story, stay)
        yield from _without_power(story, stay)
        yield from _uncertain(story, stay)
        yield from _course_apart(story, stay)


def _no_progress(story: Story, stay: Stay) -> Iterator[Violation]:
    for since, t, wanted in waits(sets_of(story, stay), story.reports):
        if t >= stay.end:
            return
        if t - since > _STUCK and is_plain(story, since, t, DEPTH_FAULTS):
            says = f"no nearer to {wanted:g} m for {t - since:.0f} s"
            yield Violation(UNANSWERED, t, f"{says}, and still in {stay.state}")
            return


def waits(
    sets: Iterable[tuple[float, float, Setpoint]], reports: Sequence[Report]
) -> Iterator[tuple[float, float, float]]:
    """Yield at each report: since when the depth came no nearer, the report's time, the setpoint.

    The law goes by the reports: noise of a constant depth may look like a step nearer. A report
    that brings another set, of a heading, still counts for the set before it.
    """
    since = nearest = 0.0
    wanted: float | None = None
    for begin, end, command in sets:
        if command.depth is None:
            wanted = None
            continue
        if command.depth != wanted:
            wanted, since, nearest = command.depth, begin, math.inf
        for report in reports:
            if not begin < report.t <= end:
                continue
            off = abs(report.depth - wanted)
            if off <= max(nearest - _NEARLY, _OFF):
                since = report.t
            if off <= max(nearest - _NEARER, _OFF):
                nearest = off
            yield since, report.t, wanted


def _unasked_descent(story: Story, stay: Stay) -> Iterator[Violation]:
    if stay.ascends:
        return
    shallowest, seen, since = math.inf, 0, math.inf
    sets = sets_of(story, stay)
    for told in story.told_in(stay.begin, stay.end):
        depth = story.depth(told.t)
        command = next((c for b, e, c in sets if b <= told.t < e), None)
        if command is None or _asks_down(command, depth):
            shallowest, seen = depth, 0
        shallowest = min(shallowest, depth)
        sinks = depth > shallowest + _UNASKED and story.depth(told.t - 2.0) < depth - 2.0 * _SINKING
        seen = seen + 1 if sinks else 0
        slow = command is not None and command.depth is None and depth > shallowest + _UNASKED
        since = min(since, told.t) if slow else math.inf
        late = seen > 2 + SPARE or told.t - since > _SLOWLY
        if late and is_plain(story, min(told.t - 20.0, since), told.t, DEPTH_FAULTS):
            says = f"{depth:.1f} m and sinking, which nothing asks for, in {stay.state}"
            yield Violation(UNANSWERED, told.t, says)
            return


def _asks_down(command: Setpoint, depth: float) -> bool:
    if command.depth is not None:
        return depth < command.depth + 1.0
    nose_first = (command.pitch or 0.0) * command.surge < 0.0
    return nose_first or command.altitude is not None or (command.heave or 0.0) > 0.0


def _heading_astray(story: Story, stay: Stay) -> Iterator[Violation]:
    """Go by the reports: the limit knows only the compass."""
    for begin, end, heading in _headings(story, stay):
        if heading is None or story.faulty(("heading_absurd", "heading_full"), begin, end):
            continue
        wanted = math.degrees(heading)
        errors = [
            (r.t, abs(math.remainder(-r.yaw - wanted, 360.0)))
            for r in compress(story.reports, apart(r.t for r in story.reports))
            if begin < r.t < end and abs(r.yaw) <= 180.0
        ]
        seen, (since, least), peak = 0, errors[0] if errors else (begin, 0.0), 0.0
        for (t, error), (_, last) in zip(errors[1:], errors, strict=False):
            if error < peak - _FALLEN:  # its time restarts
                since, least, peak = t, error, error
            peak = max(peak, error)
            grown = error - least > _GROWN and error >= last - 4.0
            late = t - since > _STEERED and error > _ASTRAY
            seen = seen + 1 if grown and late else 0
            if seen > SPARE + 1 and is_plain(story, t - 10.0, t, _SAYS_THE_SAME):
                says = f"heading {error:.0f} deg off and growing, and still in {stay.state}"
                yield Violation(UNANSWERED, t, says)
                return


def _headings(story: Story, stay: Stay) -> Iterator[tuple[float, float, float | None]]:
    """Yield each commanded heading with its begin and end, over one set or several."""
    for heading, group in groupby(sets_of(story, stay), lambda found: found[2].heading):
        sets = list(group)
        yield sets[0][0], sets[-1][1], heading


def _without_power(story: Story, stay: Stay) -> Iterator[Violation]:
    """Thrust is set, and no thruster turns: a command leaves. Where it is answered and changes
    nothing, the mission ends."""
    dead: list[Report] = []
    for begin, end, command in sets_of(story, stay):
        still: list[Report] = []
        if not (command.surge or command.turn or (command.heave or 0.0) > 0.0):
            dead = []
            continue
        for report in story.reports:
            if not begin + _SET <= report.t <= end:
                continue
            if report.may_turn:
                dead, still = [], []
                continue
            still = [*still, report] if begin + 3.0 < report.t < end else still
            dead = [*dead, report] if _is_answered(story, begin, report.t) else dead
            if not still and not dead:
                continue
            if story.hindered((dead or still)[0].t - 5.0, report.t):
                continue
            if len(dead) > _POWERLESS:
                says = f"no thruster turns in {len(dead)} reports, and still in {stay.state}"
            elif len(still) > 3 and not story.words_in(still[0].t, report.t):
                says = f"no thruster turns in {len(still)} reports, and no word in {stay.state}"
            else:
                continue
            yield Violation(UNANSWERED, report.t, says)
            return


def _is_answered(story: Story, begin: float, t: float) -> bool:
    """Whether the last command of the set that left before ``t`` was answered."""
    words = [w.t for w in story.words_in(begin, t) if w.data.startswith(b"@ZA")]
    heard = (h.t for h in story.heard if begin <= h.t <= t and ANSWER.search(h.data))
    return bool(words) and story.board is None and max(heard, default=-math.inf) > words[-1]


# --- by the estimate -----------------------------------------------------------------------------


def _uncertain(story: Story, stay: Stay) -> Iterator[Violation]:
    """An uncertain position leads to another leg, unless it is that leg, or on its way up."""
    if stay.ascends or stay.state.endswith(("/surface", f"/{story.mission.on_uncertain}")):
        return
    certain, seen = False, 0
    for told in story.samples_in(stay.begin, stay.end):
        e, radius = told.estimate, _radius(story, told.t)
        far = math.hypot(e.north, e.east)
        a, b, d = e.covariance
        north, east = (e.north / far, e.east / far) if far > 1.0 else (1.0, 0.0)
        sigma = math.sqrt(max(a * north * north + 2.0 * b * north * east + d * east * east, 0.0))
        certain = certain or radius - far > 3.0 * math.sqrt(a + d)
        seen = seen + 1 if certain and radius - far < _SURE * sigma else 0
        if seen > 2 + SPARE and not story.hindered(told.t - 10.0, told.t):
            says = f"{far:.0f} m off, sigma {sigma:.0f} m, limit {radius:g} m: still {stay.state}"
            yield Violation(UNANSWERED, told.t, says)
            return


def _radius(story: Story, t: float) -> float:
    """Return the largest radius in force in the last 10 s, m."""
    near = [s.bounds.radius for s in story.spans if s.begin <= t and s.end >= t - 10.0]
    return max(near, default=math.inf)


def _course_apart(story: Story, stay: Stay) -> Iterator[Violation]:
    """At the surface, under way, with fixes of a receiver that no operator has switched off."""
    since: float | None = None
    last = stay.begin
    speeds = story.vehicle.speed_by_gear
    sets = [
        (b, e, c) for b, e, c in sets_of(story, stay) if speeds.at(12.0 * c.surge) >= _UNDER_WAY
    ]
    for told in story.told_in(stay.begin, stay.end):
        place = story.trial.track[min(int(told.t), len(story.trial.track) - 1)]
        if story.is_switched(0.0, told.t):
            return
        age, dark, last = told.estimate.fix_age, told.t - last, told.t
        if since is not None and (age is None or age > _STANDS):
            since += dark  # waves wash over the antenna: nobody can know
        moves = place.ground_speed > _UNDER_WAY and place.depth < 0.25
        set_out = any(b + 6.0 < told.t < e for b, e, _ in sets)
        known = told.estimate.heading is not None
        apart = known and abs(
            math.remainder(place.course - (told.estimate.heading or 0.0), math.tau)
        )
        if not (moves and set_out and apart > _APART):
            since = None
        elif since is None:
            since = told.t
        elif told.t - since > _DRIFTS and is_plain(story, since - 10.0, told.t, _NO_COURSE):
            says = f"course and heading apart for {told.t - since:.0f} s in {stay.state}"
            yield Violation(UNANSWERED, told.t, says)
            return
