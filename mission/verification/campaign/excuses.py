"""Excuses for a vehicle that stays down: physical impossibility, and orders of an operator.

    net        buoyancy, N, with the weight or lift that faults add
    lift       upward force, N, by the best command that the board obeys: U12, or W where it sticks.
               Without such a command, with too little thrust or upside down, no program can bring
               up a vehicle that does not float
    unknown    whether the depth sensor reports nothing that moves with the vehicle: then an ascent
               cannot know what lifts it (R7)
    doubted    whether the depth at rest is unknown, or may stay contradicted
    lied       m by which wrong values of added sensors lead the estimate astray, uncontradicted
    left       the times in which nothing at rest may turn by itself: node AUTO is closed (R7, R13)
    unpowered  the times in which an operator has switched the receiver off (@RS)

All of these follow from the plant, the disturbances and the acknowledgements, never from what the
program believed.

What does not live here: the laws that it excuses (laws, depth_laws).
"""

from __future__ import annotations

import math
import re
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
FEEBLE = 4.0  # N of lift: 0.13 m/s, once the sinking has turned round
NEVER = 1e5  # s: by then every fault that ends is over
_CONTRADICTS = 0.8  # m: a depth that is off by so much is contradicted (R5)
MOVES = 60.0  # s until a depth has shown that it moves with the vehicle: two rounds of an ascent
_MOVES_STILL = ("too_deep", "too_shallow", "late")  # of a depth that still moves with it
WANDERING = ("gps_wanders", "gps2_wanders")
NEVER_BELIEVED = ("depth_silent", "depth_absurd", "depth_full_scale")
_STANDS = ("depth_frozen", "depth_stuck", "depth_dead")
NOT_MISLED = (*NEVER_BELIEVED, *_STANDS, "depth_intermittent")  # they show no false rise
_GARBAGE = ("depth_full_scale", "depth_absurd", "stm32_silent")
_SPEEDS = ("speed_log", "doppler")  # of the added sensors
_FAST, _TURNS = 1.5, 4  # m/s; courses of a mission: a late speed is late with each of them
_ANSWERED = 6.5  # s within which a switch is acknowledged
_REPORTED = 2.0  # s within which a board reports a depth
_UPWARD = {"documented": frozenset("UW"), "as-built": frozenset("U")}  # as built, W does not stick
_RESTS = (STOPPED, SURFACED, MANUAL_WAITING)
_SWITCHED, LIFT_WORD = b"@ACK_NSS$", b"@ZAU12$"
_NEWS = 20.0  # s within which a receiver must report a new place (R7)
_TURNED = 110.0  # deg of error that read as upside down: 120 (R7), less the true roll
_ROLLS = math.radians(8.0)  # rad: thrust adds it to a roll that a weight holds
_TICK = 0.1  # s: a fault begins at the next tick, a command counts when it is whole
_RECEIVER = re.compile(rb"@RS[OC]{2}([OC])[OC]{4}\$")
_CURES = {"dives_until_stop": b"@ZAX0$"}


def value_of(fault: FaultEvent) -> float:
    """Return a fault's value: as drawn, or the default of its row."""
    return ANY[fault.name].value if fault.value is None else fault.value


def _heel(fault: FaultEvent) -> float:
    """Return the roll at which a fault holds the vehicle, rad."""
    degrees = {"capsized": 180.0, "listing": value_of(fault)}
    return math.radians(degrees.get(fault.name, 0.0))


def overturns(fault: FaultEvent) -> bool:
    """Whether a fault rolls the vehicle so far that upward thrust leads down."""
    return _heel(fault) > math.pi / 2.0


def net(settings: Settings, t: float) -> float:
    """Return the buoyancy at ``t``, N; below 0 the vehicle sinks."""
    there = [f for f in settings.faults if f.begin <= t < fault_ends(f)]
    heavier = sum(value_of(f) for f in there if f.name == "heavy")
    lighter = sum(value_of(f) for f in there if f.name == "light")
    return settings.body.buoyancy - heavier + lighter


def lift(settings: Settings, profile: str, t: float) -> float:
    """Return the upward force at ``t``, N, by the best command that the board obeys."""
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
    if names & {"stm32_restart", "stm32_hang", "thrust_dead"}:  # nothing obeys
        return net(settings, t)
    # Upside down D12 has 5 s of a minute (R7): that holds nothing up.
    return net(settings, t) + (thrust if _UPWARD[profile] - deaf else 0.0)


def obeys_no_stop(settings: Settings, events: Sequence[Event]) -> bool:
    """Whether a board dives until it receives a U12, which nothing sends at the surface."""
    begins = [f.begin for f in settings.faults if f.name == "dives_until_up"]
    said = max(
        (e.t for e in events if isinstance(e, Tx) and e.data == LIFT_WORD), default=-math.inf
    )
    return any(said < begin for begin in begins)


def spoils_a_turn(dive: FaultEvent, events: Sequence[Event]) -> bool:
    """Whether a dive begins in the turn of the command that would end it or lift the vehicle.

    That command comes again a round later.
    """
    by = dive.begin + _TICK
    words = [e.data for e in events if isinstance(e, Tx) and e.link == VEHICLE and e.t <= by]
    return bool(words) and words[-1] in (LIFT_WORD, _CURES.get(dive.name))


def helpless(settings: Settings, profile: str, end: float) -> int:
    """Return the seconds before ``end`` in which no command that the board obeys lifts the vehicle.

    A slow lift counts as none: its turn does not show it (R7: 0.6 m less than the deepest of the
    turn), and the vehicle sinks faster in the other turns.
    """
    return sum(lift(settings, profile, float(t)) < FEEBLE for t in range(int(end)))


def unknown(settings: Settings, t: float) -> bool:
    """Whether at ``t`` no reported depth shows if the vehicle rises.

    That holds while the depth sensor or the board reports nothing that moves with the vehicle, and
    for ``MOVES`` s after that. A depth whose every second sample repeats moves.
    """
    for fault in settings.faults:
        sensor, _, how = fault.name.partition("_")
        begin, end = fault.begin, fault_ends(fault)
        shown = begin + MOVES if how in _MOVES_STILL else end
        gone = (sensor == "depth" and how != "intermittent") or fault.name == "stm32_silent"
        if gone and (begin <= t < shown or end <= t < end + MOVES):
            return True
    return False


def doubted_at_rest(settings: Settings, end: float) -> bool:
    """Whether the depth is unknown at the end, or may have stayed contradicted (R5).

    Such a depth turns no thruster at rest. Garbage is neither, ``MOVES`` s after it is over.
    """
    faults = [f for f in settings.faults if f.name.startswith(("depth_", "stm32_silent"))]
    faults = [f for f in faults if fault_ends(f) >= end - MOVES or not _is_slight(f)]
    return any(f.name not in _GARBAGE or fault_ends(f) >= end - MOVES for f in faults)


def _is_slight(fault: FaultEvent) -> bool:
    """Whether the fault is an offset so small that nothing contradicts it."""
    return fault.name.startswith("depth_too_") and abs(value_of(fault)) < _CONTRADICTS


def blind_from_its_begin(settings: Settings, events: Sequence[Event]) -> bool:
    """Whether the vehicle sank while its depth was garbage from the program's first report on.

    It also holds where the garbage came after verticals that contradicted the depth (R5). At rest
    the program then knows no depth that the vehicle sank from: it may be on deck (R7).
    """
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
    """Whether the vehicle lies upside down at the end, and nothing shows it.

    No report has come since, or the roll has been stuck since before, with no depth to go by. So
    nothing shows that two of the three ways, which take turns (R7), push the vehicle down. It may
    as well be heavy; letting go for longer would then lose it.
    """
    told = max((e.t for e in events if isinstance(e, Told)), default=-math.inf)
    lasting = [f for f in settings.faults if fault_ends(f) >= NEVER]
    blind = any(f.name.startswith("depth_") and f.name[6:] not in _MOVES_STILL for f in lasting)
    stuck = min((f.begin for f in lasting if blind and f.name == "roll_stuck"), default=math.inf)
    return any(overturns(f) and (told < f.begin or stuck < f.begin) for f in lasting)


def says_overturned(settings: Settings, end: float) -> bool:
    """Whether the roll reports upside down to the end, with no depth or a contradicted one.

    Then the vehicle is let go and nothing else (R7), whatever is true. Thrust for a third of the
    time would drive a vehicle down that lies upside down, and would not lift a heavy one.
    """
    turned = [f for f in settings.faults if f.name == "attitude_off" and fault_ends(f) >= NEVER]
    return doubted_at_rest(settings, end) and any(abs(value_of(f)) > _TURNED for f in turned)


def dives_unseen(settings: Settings, t: float) -> bool:
    """Whether a board dives by itself, and no report with a depth to believe shows it.

    Nor does a later report, where the sensor was wrong meanwhile: the depth comes back with a jump,
    and on the ground nothing moves by which it could be believed again (R5).
    """
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
    """Return the seconds before ``end`` in which the vehicle sinks by itself and nobody can know.

    The ways that take turns then (R7) lift it for ten seconds of thirty at first, and for forty of
    sixty at last.
    """
    return sum(
        net(settings, float(t)) < SLIGHT and unknown(settings, float(t)) for t in range(int(end))
    )


def sinks_for_a_round(settings: Settings, end: float) -> bool:
    """Whether before ``end`` the vehicle sinks by itself under a board that is deaf to full thrust.

    From rest the ascent begins with that, twice as long if it was let go at the surface before;
    letting go comes next, twice as long behind a push that led deeper; only then W (R7).
    """
    deaf = [f for f in settings.faults if f.name == "deaf_to_u"]
    return any(
        f.begin <= t < min(fault_ends(f), end) and net(settings, float(t)) < SLIGHT
        for f in deaf
        for t in range(int(end))
    )


def untamed(settings: Settings, events: Sequence[Event], end: float) -> int:
    """Return the seconds before ``end`` in which a board dives until U12 or X, and no depth tells.

    At rest an unknown depth turns no thruster: only X is sent there (R7), and no X after it was
    obeyed. So a board that dives until it receives X continues there, too.
    """
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
    """Return how far wrong added sensors mislead the estimate until ``end``, m.

    North and east may each be off by as much. A constant offset of a place, a drift that looks like
    a current, and a delay cannot be told from the sea; a frozen or wild value can.
    """
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
    """Yield the times of a closed node AUTO: from an acknowledged close to an open or a restart."""
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


def unpowered(events: Sequence[Event]) -> list[tuple[float, float]]:
    """Return the times in which an operator's @RS at the vehicle keeps the receiver off."""
    times: list[tuple[float, float]] = []
    since: float | None = None
    for event in (e for e in events if isinstance(e, Tx) and e.link == VEHICLE):
        if (found := _RECEIVER.search(event.data)) is None:
            continue
        if found[1] == b"C":
            since = event.t if since is None else since
        elif since is not None:
            times.append((since, event.t))
            since = None
    return times if since is None else [*times, (since, math.inf)]


def beside(settings: Settings) -> float:
    """Return the error of a healthy depth, m: waves, and the air's pressure."""
    return settings.sea.waves[0] + abs(settings.errors.depth_bias or 0.0)


def afloat_by_fixes(settings: Settings, events: Sequence[Event]) -> bool:
    """Whether a program ended with AUTO closed, while a receiver reported places under water.

    A vehicle that sank meanwhile may as well be on deck, so a restart turns no thruster (R7).
    """
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
    """Return the times in which AUTO is closed and everything should be stopped."""
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
