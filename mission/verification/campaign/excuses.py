"""Excuses for a vehicle that stays down: what is physically impossible, and what an operator
ordered.

    net        N of buoyancy, with what has become heavy or light
    lift       N upward by the best word that this board obeys: U12, W where it sticks. Where no
               such word is left, or too little thrust, or it lies upside down, no program brings
               up what does not float
    unknown    whether the depth sensor says nothing that moves with the vehicle: then an ascent has
               no way to know what lifts it (R7)
    doubted    whether the depth of what rests is unknown, or may be contradicted for good
    lied       m that lies of added sensors lead the estimate astray where nothing contradicts them
    left       from when to when nothing at rest may turn by itself: node AUTO is closed (R7, R13)

All from the plant, the disturbances and what was acknowledged; never from what was believed.

What does not live here: the laws that it excuses (laws, depth_laws).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from links.simulated.added import SENSORS
from links.simulated.board_faults import ANY
from links.simulated.settings import FaultEvent, Settings
from mission.model import MANUAL_WAITING, STOPPED, SURFACED, Step, Tx
from mission.onboard.runtime.runtime import VEHICLE
from mission.verification.campaign.trial import AUTO_NODE, fault_ends
from mission.verification.rig.acts import Act
from mission.verification.rig.trace import Done, Event, Said, Told

SLIGHT, SPARE = 1.0, 8.0  # N that may lift too slowly; N of lift that make a rise within a turn
FEEBLE = 4.0  # N of lift: 0.13 m/s, once what sank has turned round
NEVER = 1e5  # s: by then what ends is over
_CONTRADICTS = 0.8  # m that a depth is off (R5)
MOVES = 60.0  # s in which a depth shows that it moves as the vehicle does: two rounds of an ascent
_MOVES_STILL = ("too_deep", "too_shallow", "late")  # faults of a depth that goes on moving with it
WANDERING = ("gps_wanders", "gps2_wanders")
NEVER_BELIEVED = ("depth_silent", "depth_absurd", "depth_full_scale")
_STANDS = ("depth_frozen", "depth_stuck", "depth_dead")
NOT_MISLED = (*NEVER_BELIEVED, *_STANDS, "depth_intermittent")  # no rise is seen that is none
_GARBAGE = ("depth_full_scale", "depth_absurd", "stm32_silent")
_SPEEDS = ("speed_log", "doppler")  # of the sensors that are added
_FAST, _TURNS = 1.5, 4  # m/s; courses of a mission, each known too late by a speed that comes late
_ANSWERED = 6.5  # s within which a switch is acknowledged
_REPORTED = 2.0  # s within which a board reports a depth
_UPWARD = {"documented": frozenset("UW"), "as-built": frozenset("U")}  # as built, W does not stick
_RESTS = (STOPPED, SURFACED, MANUAL_WAITING)
_SWITCHED, _UP = b"@ACK_NSS$", b"@ZAU12$"
_NEWS = 20.0  # s in which a receiver has to say something new (R7)
_TURNED = 110.0  # deg off that read as upside down: 120 (R7), less what it rolls
_ROLLS = math.radians(8.0)  # by which thrust rolls farther what a weight holds at a roll
_TICK = 0.1  # s: a fault begins with the next tick, a word is heard whole
_CURES = {"dives_until_stop": b"@ZAX0$"}


def value_of(fault: FaultEvent) -> float:
    """As drawn, or as its row says."""
    return ANY[fault.name].value if fault.value is None else fault.value


def _heel(fault: FaultEvent) -> float:
    """rad that it holds the vehicle at."""
    degrees = {"capsized": 180.0, "listing": value_of(fault)}
    return math.radians(degrees.get(fault.name, 0.0))


def overturns(fault: FaultEvent) -> bool:
    """Thrust upward leads down."""
    return _heel(fault) > math.pi / 2.0


def net(settings: Settings, t: float) -> float:
    """N of buoyancy at ``t``; below 0 it sinks."""
    there = [f for f in settings.faults if f.begin <= t < fault_ends(f)]
    heavier = sum(value_of(f) for f in there if f.name == "heavy")
    lighter = sum(value_of(f) for f in there if f.name == "light")
    return settings.body.buoyancy - heavier + lighter


def lift(settings: Settings, profile: str, t: float) -> float:
    """N upward at ``t``, by the best word that the board obeys."""
    there = [f for f in settings.faults if f.begin <= t < fault_ends(f)]
    shares = [value_of(f) for f in there if f.name.startswith("verticals_")]
    thrust = 3.0 * settings.body.vertical_thrust * min([1.0, *shares])
    deaf = {f.name[-1].upper() for f in there if f.name.startswith("deaf_to_")}
    names = {f.name for f in there}
    heel = max((_heel(f) for f in there), default=0.0)
    thrust *= max(math.cos(heel + (_ROLLS if heel else 0.0)), 0.0)
    untamed = ("dives_until_up" in names and "U" in deaf) or (
        "dives_until_stop" in names and "X" in deaf
    )
    if untamed:
        return net(settings, t) - thrust
    if names & {"stm32_restart", "stm32_hang", "thrust_dead"}:  # nobody is there who could obey
        return net(settings, t)
    # Upside down D12 has 5 s of a minute (R7): that holds nothing up.
    return net(settings, t) + (thrust if _UPWARD[profile] - deaf else 0.0)


def obeys_no_stop(settings: Settings, events: Sequence[Event]) -> bool:
    """A board that dives until it hears U12, which nothing says at the surface."""
    begins = [f.begin for f in settings.faults if f.name == "dives_until_up"]
    said = max((e.t for e in events if isinstance(e, Tx) and e.data == _UP), default=-math.inf)
    return any(said < begin for begin in begins)


def spoils_a_turn(dive: FaultEvent, events: Sequence[Event]) -> bool:
    """It begins in a turn of what would end it or lift the vehicle: that comes a round later."""
    by = dive.begin + _TICK
    words = [e.data for e in events if isinstance(e, Tx) and e.link == VEHICLE and e.t <= by]
    return bool(words) and words[-1] in (_UP, _CURES.get(dive.name))


def helpless(settings: Settings, profile: str, end: float) -> int:
    """Seconds until ``end`` in which no command that the board obeys can lift the vehicle, or so
    slowly that its turn does not show it (R7: 0.6 m less than the deepest of it), and it sinks
    faster in the turns of the others."""
    return sum(lift(settings, profile, float(t)) < FEEBLE for t in range(int(end)))


def unknown(settings: Settings, t: float) -> bool:
    """The depth sensor, or the board, says nothing at ``t`` from which could be known whether the
    vehicle rises: while it does not move with it, and for ``MOVES`` s after that. One whose every
    second sample repeats moves."""
    for fault in settings.faults:
        sensor, _, how = fault.name.partition("_")
        begin, end = fault.begin, fault_ends(fault)
        shown = begin + MOVES if how in _MOVES_STILL else end
        gone = (sensor == "depth" and how != "intermittent") or fault.name == "stm32_silent"
        if gone and (begin <= t < shown or end <= t < end + MOVES):
            return True
    return False


def doubted_at_rest(settings: Settings, end: float) -> bool:
    """A depth that is unknown in the end, or may have been left contradicted (R5): nothing turns by
    it. Garbage is neither, once it is over for ``MOVES`` s."""
    faults = [f for f in settings.faults if f.name.startswith(("depth_", "stm32_silent"))]
    faults = [f for f in faults if fault_ends(f) >= end - MOVES or not _is_slight(f)]
    return any(f.name not in _GARBAGE or fault_ends(f) >= end - MOVES for f in faults)


def _is_slight(fault: FaultEvent) -> bool:
    """An offset that nothing contradicts."""
    return fault.name.startswith("depth_too_") and abs(value_of(fault)) < _CONTRADICTS


def blind_from_its_begin(settings: Settings, events: Sequence[Event]) -> bool:
    """It sank while its depth was garbage from the program's first report on, or behind verticals
    that contradicted it (R5): at rest nobody knows of a depth that it has sunk from, and it may be
    on deck (R7)."""
    begun = max((e.t for e in events if isinstance(e, Done) and e.act is Act.BOOT), default=0.0)
    vain = [f.begin for f in settings.faults if f.name.startswith("verticals_")]
    doubted = min(vain, default=math.inf)
    return any(
        f.name in _GARBAGE
        and (f.begin <= begun + _REPORTED < fault_ends(f) or doubted < f.begin)
        and net(settings, fault_ends(f)) < SLIGHT
        for f in settings.faults
    )


def overturned_untold(settings: Settings, events: Sequence[Event]) -> bool:
    """It lies upside down in the end, and no report has come since, or its roll has stood since
    before that and no depth tells either: nothing says that two of the three ways, which take turns
    (R7), push it down. It may as well be heavy, and let go longer would be lost then."""
    told = max((e.t for e in events if isinstance(e, Told)), default=-math.inf)
    lasting = [f for f in settings.faults if fault_ends(f) >= NEVER]
    blind = any(f.name.startswith("depth_") and f.name[6:] not in _MOVES_STILL for f in lasting)
    stuck = min((f.begin for f in lasting if blind and f.name == "roll_stuck"), default=math.inf)
    return any(overturns(f) and (told < f.begin or stuck < f.begin) for f in lasting)


def says_overturned(settings: Settings, end: float) -> bool:
    """Its roll says so for good, and no depth tells, or one that may have been left contradicted:
    then it is let go and nothing else (R7), whatever is true. Thrust for a third of the time would
    drive down what lies upside down, and would not lift what is heavy."""
    turned = [f for f in settings.faults if f.name == "attitude_off" and fault_ends(f) >= NEVER]
    return doubted_at_rest(settings, end) and any(abs(value_of(f)) > _TURNED for f in turned)


def dives_unseen(settings: Settings, t: float) -> bool:
    """A board dives by itself, and no report or none with a depth to believe tells of it. Nor does
    one later, where the sensor was wrong meanwhile: it comes back elsewhere, and on the ground
    nothing moves by which it could be believed again (R5)."""
    there = [f for f in settings.faults if f.begin <= t < fault_ends(f)]
    dives = [f.begin for f in there if f.name.startswith("dives_")]
    wrong = [
        fault_ends(f)
        for f in settings.faults
        if f.name.startswith("depth_") and f.name not in _GARBAGE and f.begin <= t
    ]
    doubted = bool(dives and wrong) and max(wrong) > min(dives)
    return doubted or (bool(dives) and unknown(settings, t))


def unknown_and_heavy(settings: Settings, end: float) -> int:
    """s until ``end`` in which it sinks by itself and nobody knows whether it does: the ways that
    take turns then (R7) lift it for ten seconds of thirty at first, and forty of sixty at last."""
    return sum(
        net(settings, float(t)) < SLIGHT and unknown(settings, float(t)) for t in range(int(end))
    )


def untamed(settings: Settings, events: Sequence[Event], end: float) -> int:
    """s until ``end`` in which a board dives by itself until it hears U12, and no depth tells: at
    rest, where an unknown depth turns nothing, X alone is said (R7), and once it is obeyed not even
    that: one that dives until it hears X goes on, too."""
    rests = list(_rests(events))
    dives = [f for f in settings.faults if f.name in ("dives_until_up", "dives_until_stop")]
    seconds = {
        t
        for f in dives
        for t in range(int(f.begin), int(min(fault_ends(f), end)))
        if f.name == "dives_until_up" or any(a <= t <= b for a, b in rests)
    }
    return sum(unknown(settings, float(t)) for t in seconds)


def lied(settings: Settings, end: float) -> float:
    """m until ``end``: north and east each by as much. A constant offset of a place, a drift that
    looks like a current, and a delay cannot be told from the sea; what is frozen or wild can."""
    metres = 0.0
    for fault in settings.faults:
        sensor, _, how = fault.name.rpartition("_")
        if sensor not in SENSORS:
            continue
        lasts, value = max(min(fault_ends(fault), end) - fault.begin, 0.0), abs(value_of(fault))
        if how == "delay":
            metres += value * _FAST * (_TURNS if sensor in _SPEEDS else 1)
        elif how == "drift":
            metres += value * lasts * (0.5 * lasts if sensor in _SPEEDS else 1.0)
        elif how == "offset":
            metres += value * (lasts if sensor in _SPEEDS else 1.0)
    return math.sqrt(2.0) * metres


def auto_closed(events: Sequence[Event]) -> Iterator[tuple[float, float]]:
    """From when to when node AUTO is closed: acknowledged, and not opened, nor begun anew."""
    since: float | None = None
    for i, event in enumerate(events):
        found = AUTO_NODE.search(event.data) if isinstance(event, Said) else None
        opened = found is not None and found[1] == b"O" and _is_answered(events, i)
        begun = isinstance(event, Done) and event.act is Act.BOOT
        if found is not None and found[1] == b"C" and since is None:
            since = event.t if _is_answered(events, i) else None
        elif since is not None and (begun or opened):
            yield since, event.t
            since = None
    if since is not None:
        yield since, math.inf


def beside(settings: Settings) -> float:
    """m by which a depth that is sound may be off the truth: waves, and the air's pressure."""
    return settings.sea.waves[0] + abs(settings.errors.depth_bias or 0.0)


def afloat_by_fixes(settings: Settings, events: Sequence[Event]) -> bool:
    """A program ended while AUTO was closed and a receiver said places, in truth under water: what
    sank meanwhile may as well be on deck, and a restart turns nothing (R7)."""
    closed = list(auto_closed(events))
    ended = [e.t for e in events if isinstance(e, Done) and e.act is Act.KILL]
    wanders = [f for f in settings.faults if f.name in WANDERING]
    return any(
        a <= t <= b and any(f.begin <= t < fault_ends(f) + _NEWS for f in wanders)
        for t in ended
        for a, b in closed
    )


def _is_answered(events: Sequence[Event], i: int) -> bool:
    due = events[i].t + _ANSWERED
    for event in events[i + 1 :]:
        if event.t > due:
            return False
        if isinstance(event, Tx) and event.link != VEHICLE and _SWITCHED in event.data:
            return True
    return False


def left(events: Sequence[Event]) -> list[tuple[float, float]]:
    """From when to when AUTO is closed and everything should be stopped."""
    rests = list(_rests(events))
    return [
        (max(a, c), min(b, d)) for a, b in auto_closed(events) for c, d in rests if c < b and a < d
    ]


def _rests(events: Sequence[Event]) -> Iterator[tuple[float, float]]:
    since: float | None = 0.0
    for event in events:
        if not (isinstance(event, Step) and event.entered):
            continue
        state = event.entered[-1]
        rests = state.startswith("idle") or state in _RESTS
        if rests and since is None:
            since = event.t
        elif not rests and since is not None:
            yield since, event.t
            since = None
    if since is not None:
        yield since, math.inf
