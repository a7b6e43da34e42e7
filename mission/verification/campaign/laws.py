"""Laws of a disturbed flight: no vehicle is lost, no limit is overrun, the program raises nothing.

**Lost**: at the end, by `home`.

**Overrun**: while autonomous or surfacing, the vehicle is truly beyond a limit in force by more
than detection and physics explain. In force is the tightest of the mission's, the vehicle's and the
operator's limits (an acknowledged @SP). The laws explain:

    depth   the bound, or the depth when the bound came into force, and
              1 m        beyond which R5 counts
              0.4 m      of the depth sensor (bias and noise, three sigma)
              v * s      v: the terminal speed of the dive, from thrust, drag and the least
                         buoyancy of the flight; s: the seconds that the dive may continue:
                4.2        two samples in a row, 2 s apart, and the frame of the second
                10 + 1     as built, W does not stick: U12 follows after 10 s (R7), three tries
                3          until the thrusters have turned the dive round
                +18        if depths or reports were ever missing or wrong: 12 s until a frozen
                           one is known (five identical samples), 6 s without a depth (design)
                + all      the time in which nobody controls the vehicle: a board that hangs, is
                           deaf or dives by itself, a pulled cable, a dead program, each with the
                           11 s of another ascent, or the 50 s of another round where the board
                           obeys only one of its ways; a stalled program; the time in which no
                           command that the board obeys could lift the vehicle, or it sinks by
                           itself while its depth sensor does not move with it (excuses)
                + a round  50 s of sinking by its weight, if the board is deaf to full thrust
                + beside   m by which depths read too shallow: an offset, a drift, a delay; a depth
                           that is stuck within half a metre of the setpoint leads down with
                           0.25 m/s unseen
    radius  the bound, and 8 s of way (two samples, their age, the limit's own step), and the error
            of dead reckoning since the last fix (a receiver that an operator has
            switched off gives none): 15 m, the current's way, a quarter of the way
            through the water (or twice the whole way, if the compass or a main thruster was not
            healthy); the error of the GPS, and that of wrong added sensors (excuses)
    time    the bound, and 1 s, in the mission's legs; time under the stick counts
    report  5 s without a good report (R8), and 0.5 s, in the mission's legs

What does not live here: bytes to the vehicle (audit).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from links.simulated.board_faults import ANY
from links.simulated.settings import Settings
from mission.engine.bounds import Bounds, in_force
from mission.engine.limits import SILENCE
from mission.model import AUTONOMOUS, STOPPED, SURFACING, Mission, Step, Tx
from mission.model.vehicle import Vehicle
from mission.verification.campaign import board_laws as of_board
from mission.verification.campaign.audit import audit
from mission.verification.campaign.excuses import (
    helpless,
    left,
    lied,
    overturned_untold,
    overturns,
    sinks_for_a_round,
    spoils_a_turn,
    unknown_and_heavy,
    unpowered,
    untamed,
)
from mission.verification.campaign.home import WHOLE_ROUND, lost
from mission.verification.campaign.obedience import ignored
from mission.verification.rig.acts import Act
from mission.verification.rig.speech import MOTION
from mission.verification.rig.trace import Done, Event, Said, Told, Trace, from_home
from protocol.messages import SetSafety

LOST, OVERRUN, SPURIOUS, RAISED, IGNORED = "lost", "overrun", "spurious", "raised", "ignored"
DEPTH_MARGIN, DEPTH_ERROR = 1.0, 0.4  # m
SAMPLES, UNPROVED, TURNED, BLIND = 4.2, 11.0, 3.0, 18.0  # s
ROUND = 30.0  # s of an ascent's three ways
WAY, FIX_ERROR, SHARE = 8.0, 15.0, 0.25  # s, m, share of the way
LATE = 1.0  # s
NEAR = 0.25  # m/s
DOWN = 8.0  # s that a killed program is down at most (disturbances)
FIX_DEPTH, FIX_TIME = 0.3, 15.0  # m, s at the surface that give a fix
_OUT_OF_HAND = (
    *("stm32_hang", "command_lost", "command_corrupted", "unexplained_dive", "stm32_restart"),
)
_UNSEEN = ("depth_", "stm32_silent", "bytes_corrupted", "line_noise", "splice", "stm32_restart")
_ASTRAY = (
    "heading_",
    "left_main",
    "right_main",
    "mains_dead",
    "attitude_",
    "gps_stuck",
    "gps_in_turn",
    "gps2_stuck",
)
_JUMPS = ("gps_jump", "gps2_jump")
_GPS_CLOSED = re.compile(rb"@NS[OC]{2}C[OC]{3}\$")
_SP = re.compile(rb"@SP,([^,$]*),([^,$]*),([^,$]*),([^,$]*),\$")
_AUTO_CLOSED = re.compile(rb"@NS[OC]{5}C\$")
_SET = b"@ACK_SPP$"


@dataclass(frozen=True, slots=True)
class Violation:
    kind: str
    t: float
    says: str


def violations(
    trial: Trace, mission: Mission, vehicle: Vehicle, profile: str, settings: Settings
) -> list[Violation]:
    board = vehicle.codec in MOTION
    spurious = of_board.audit(trial.events, vehicle) if board else audit(trial.events, profile)
    found = [Violation(SPURIOUS, s.t, s.says) for s in spurious]
    if trial.raised:
        found.append(Violation(RAISED, trial.truth.t, trial.raised))
    elif why := lost(trial, profile, settings):
        found.append(Violation(LOST, trial.truth.t, why))
    late = (
        of_board.ignored(trial.events, vehicle, settings)
        if board
        else ignored(trial.events, profile)
    )
    found += [Violation(IGNORED, i.t, i.says) for i in late]
    flown = list(spans(trial, mission, vehicle))
    found += _depths(trial, flown, dive(settings, profile, trial))
    if vehicle.codec == "auv" or "position" in vehicle.reports:  # else the limit is disarmed
        found += _ranges(trial, flown, settings, mission.home is not None)
    found += _times(trial, flown)
    return sorted(found, key=lambda violation: violation.t)


@dataclass(frozen=True, slots=True)
class Span:
    """A time in which neither the region nor the limits in force changed."""

    begin: float
    end: float
    state: str  # at its begin
    bounds: Bounds
    started: float  # of the mission

    @property
    def autonomous(self) -> bool:
        return self.state.startswith(AUTONOMOUS)


def spans(trial: Trace, mission: Mission, vehicle: Vehicle) -> Iterator[Span]:
    given, asked = SetSafety(), SetSafety()
    span = Span(0.0, 0.0, "idle/empty", in_force(vehicle, mission.safety, given), 0.0)
    interrupted = False
    for event in trial.events:
        news = span
        match event:
            case Step(t=t, entered=(*_, state)):
                before, now = _region(span.state), _region(state)
                fresh = now == AUTONOMOUS and before != AUTONOMOUS and not interrupted
                interrupted = now == "manual" and (interrupted or before == AUTONOMOUS)
                if before != now or STOPPED in (state, span.state):
                    news = replace(span, state=state, started=t if fresh else span.started)
            case Done(t=t, act=Act.KILL):
                interrupted, news = False, replace(span, state="dead")
            case Said(t=t, data=data):
                if found := _SP.search(data):
                    asked = _merged(given, found)
                interrupted = interrupted and not _AUTO_CLOSED.search(data)
            case Tx(t=t, data=data) if _SET in data:  # by modem within an envelope
                given = asked
                news = replace(span, bounds=in_force(vehicle, mission.safety, given))
            case _:
                pass
        if news is not span:
            yield replace(span, end=t)
            span = replace(news, begin=t)
    yield replace(span, end=trial.truth.t)


def _region(state: str) -> str:
    return state.partition("/")[0]


def _merged(given: SetSafety, found: re.Match[bytes]) -> SetSafety:
    values = [_number(text) for text in found.groups()]
    if values[1] is not None:
        values[1] *= 60.0
    news = dict(zip(("radius", "time", "depth", "voltage"), values, strict=True))
    return replace(given, **{name: value for name, value in news.items() if value})


def _number(text: bytes) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


# --- depth ---------------------------------------------------------------------------------------


def dive(settings: Settings, profile: str, trial: Trace) -> float:
    """Return how far a dive may continue beyond its bound, m.

    Without end, by physics, where the vehicle stays upside down and nothing shows it: thrust then
    leads down.
    """
    if overturned_untold(settings, trial.events):
        return math.inf
    body = settings.body
    heavy = sum(f.value or 8.0 for f in settings.faults if f.name == "heavy")
    weight = heavy - body.buoyancy  # in water
    speed = math.sqrt(max(3.0 * body.vertical_thrust + weight, 0.0) / body.quadratic[2])
    diving = [f for f in settings.faults if f.name.startswith("dives_")]
    dives = [f.name for f in diving]
    in_vain = profile == "as-built" or bool(dives)
    seconds = SAMPLES + TURNED + (UNPROVED if in_vain else 1.0)  # 1 s: a W
    seconds += WHOLE_ROUND * max(len(dives) - 1, 0)  # each may begin in the cure of the last
    seconds += WHOLE_ROUND * sum(spoils_a_turn(f, trial.events) for f in diving)
    if any(f.name.startswith(_UNSEEN) for f in settings.faults) or _acts(trial, Act.UNPLUG):
        seconds += BLIND
    again = WHOLE_ROUND if dives else UNPROVED
    for fault in settings.faults:
        if fault.name in _OUT_OF_HAND:
            seconds += (fault.duration or 0.0) + again
        if overturns(fault):  # until that is known
            seconds += ROUND
    end = trial.truth.t
    seconds += helpless(settings, profile, end) + unknown_and_heavy(settings, end)
    seconds += untamed(settings, trial.events, end)
    seconds += len(_acts(trial, Act.KILL)) * (DOWN + UNPROVED)
    pulled = zip(_acts(trial, Act.UNPLUG), _acts(trial, Act.PLUG), strict=False)
    seconds += sum(plug - unplug + UNPROVED for unplug, plug in pulled)
    seconds += sum(end - begin for begin, end in stalls(trial.events))
    beside = DEPTH_MARGIN + DEPTH_ERROR + _unseen(settings, trial, speed)
    if sinks_for_a_round(settings, end):
        beside += WHOLE_ROUND * math.sqrt(max(weight, 0.0) / body.quadratic[2])
    return beside + speed * seconds


def _unseen(settings: Settings, trial: Trace, speed: float) -> float:
    """Return how far a depth that looks healthy is off, or leads the vehicle too deep, m."""
    metres = 0.0
    for fault in settings.faults:
        lasts = min(fault.duration or ANY[fault.name].duration, trial.truth.t)
        value = abs(fault.value or ANY[fault.name].value)
        if fault.name == "depth_too_shallow":
            metres += value
        elif fault.name == "depth_drifting":
            metres += value * lasts
        elif fault.name == "depth_late":
            metres += value * speed
        elif fault.name == "depth_stuck":
            metres += NEAR * lasts
    return metres


def stalls(events: Iterable[Event]) -> list[tuple[float, float]]:
    """Return the times in which the program was stalled."""
    found: list[tuple[float, float]] = []
    since: float | None = None
    for event in events:
        if not isinstance(event, Done):
            continue
        if event.act is Act.STALL and since is None:
            since = event.t
        elif event.act in (Act.RUN, Act.KILL) and since is not None:
            found.append((since, event.t))
            since = None
    return found


def _acts(trial: Trace, act: Act) -> list[float]:
    return [e.t for e in trial.events if isinstance(e, Done) and e.act is act]


def _depths(trial: Trace, spans: list[Span], dive: float) -> Iterator[Violation]:
    base = 0.0
    bound = math.inf
    alone = left(trial.events)  # R7: while AUTO is closed a vehicle that sinks at rest stays down
    for span in spans:
        acts = span.autonomous or span.state == SURFACING
        places = [p for p in trial.track if span.begin <= p.t <= span.end]
        if span.autonomous and places and (bound != span.bounds.depth or base == 0.0):
            bound, base = span.bounds.depth, max(span.bounds.depth, places[0].depth)
        if not acts:
            base = 0.0
        for place in places if base else ():
            if any(b <= place.t <= e for b, e in alone):
                base = max(base, place.depth)
            elif place.depth > base + dive:
                says = f"{place.depth:.1f} m, limit {bound:g} m, explained {dive:.1f} m more"
                yield Violation(OVERRUN, place.t, f"depth {says}")
                break


# --- radius --------------------------------------------------------------------------------------


def _ranges(
    trial: Trace, spans: list[Span], settings: Settings, has_home: bool
) -> Iterator[Violation]:
    """Check the radius. A mission without a home has its home where it began (R9)."""
    astray = any(f.name.startswith(_ASTRAY) for f in settings.faults)
    beside = sum(f.value or 200.0 for f in settings.faults if f.name in _JUMPS)
    beside += lied(settings, trial.truth.t)
    closed = any(isinstance(e, Said) and _GPS_CLOSED.search(e.data) for e in trial.events)
    blind = closed or any(f.name.startswith("gps_") for f in settings.faults)
    off = unpowered(trial.events)
    stalled = sum(end - begin for begin, end in stalls(trial.events))
    share = 2.0 if astray else SHARE
    unknown = shallow = 0.0
    flown = iter(span for span in spans if span.autonomous)
    span = next(flown, None)
    for place in trial.track:
        speed, current = abs(place.speed), math.hypot(*place.current)
        silent = place.depth > FIX_DEPTH or any(begin <= place.t <= end for begin, end in off)
        shallow = 0.0 if silent else shallow + 1.0
        unknown += current + share * speed
        if shallow > FIX_TIME and not blind:
            unknown = 0.0
        while span is not None and span.end < place.t:
            span = next(flown, None)
        if span is None or place.t < span.begin:
            continue
        north, east = from_home(trial, place)
        if not has_home:
            first = from_home(trial, trial.track[int(span.started)])
            north, east = north - first[0], east - first[1]
        far = math.hypot(north, east)
        explained = FIX_ERROR + unknown + beside + (WAY + stalled) * (speed + current)
        if place.t == math.ceil(span.begin) and far > span.bounds.radius:
            explained += far - span.bounds.radius  # it was outside when the bound came into force
        if far > span.bounds.radius + explained and place.t > span.begin + WAY:
            says = f"{far:.0f} m, limit {span.bounds.radius:g} m, explained {explained:.0f} m"
            yield Violation(OVERRUN, place.t, f"radius {says}")
            return


# --- time and reports -----------------------------------------------------------------------------


def _times(trial: Trace, spans: list[Span]) -> Iterator[Violation]:
    told = [event.t for event in trial.events if isinstance(event, Told)]
    stood = stalls(trial.events)
    for span in spans:
        if not span.autonomous:
            continue
        due = max(span.started + span.bounds.time, span.begin)
        if span.end > due + LATE + _share(stood, due, span.end):
            says = f"autonomous for {span.end - span.started:.0f} s, limit {span.bounds.time:g} s"
            yield Violation(OVERRUN, span.end, says)
        last = span.begin
        for t in [*(t for t in told if span.begin < t <= span.end), span.end]:
            if t - last > SILENCE + 0.5 + _share(stood, last, t):
                yield Violation(OVERRUN, t, f"autonomous for {t - last:.1f} s without a report")
            last = t


def _share(stood: list[tuple[float, float]], begin: float, end: float) -> float:
    """Return the seconds between ``begin`` and ``end`` in which the program was stalled."""
    return sum(max(min(e, end) - max(b, begin), 0.0) for b, e in stood)
