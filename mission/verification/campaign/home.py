"""Whether a flight has brought its vehicle home.

**Lost**: at the end the vehicle is not at the surface, or a thruster turns. The end comes at the
latest ``trial.ASCENT`` after the last fault is over and the last mission must have ended. A
thruster may turn while the vehicle still surfaces: without depth and fix it never knows that it is
up (R7). Faults that make surfacing physically impossible end before that (draw.OUT_OF_HAND,
WEIGHT). The campaign does not draw what the check assumes away: a dead Pi while the STM32 is in
automatic, and an STM32 that hangs for ever with its thrusters on.

What does not live here: what may not happen on the way (laws, whole_flight).
"""

from __future__ import annotations

import math

from links.simulated.settings import Settings
from mission.model import AUTONOMOUS, SURFACED, SURFACING, Step, Tx
from mission.verification.campaign.excuses import (
    LIFT_WORD,
    NEVER,
    NOT_MISLED,
    SLIGHT,
    SPARE,
    afloat_by_fixes,
    beside,
    blind_from_its_begin,
    dives_unseen,
    doubted_at_rest,
    left,
    lift,
    net,
    obeys_no_stop,
    overturned_untold,
    says_overturned,
    unknown,
)
from mission.verification.campaign.trial import fault_ends
from mission.verification.rig.acts import Act
from mission.verification.rig.trace import Done, Trace

AFLOAT = 0.5  # m (R7)
HELD = 3.0  # m: depth of a body that its thrusters hold up
SANK = 0.6  # m: 1 m by a sensor that may be 0.4 m off (R7, at rest)
UNDER, ENDED = 0.3, 6  # m, s: an antenna under water, fixes missing for so long
WASHED = 2  # s at most from a wave over the antenna to the next fix
PUSHED = 14.0  # s of a push in vain that contradict a depth (R5)
UNSEEN = 60.0  # s after letting go in which the end of the fixes counts (R7, at rest)
RECEIVER_OFF = b"BDGPS C"  # to the receiver's node
TOLD = 10  # s until the end of the fixes shows it (R7, at rest)
_SPOIL = (
    *("attitude_", "roll_", "capsized", "listing"),
    *("deaf_to_u", "deaf_to_x", "dives_", "stm32_", "busy"),
    *("obeys_", "refuses", "ack_", "command_", "bytes_", "line_", "splice", "verticals_"),
)
WHOLE_ROUND = 50.0  # s of an ascent's three ways, the last two of them twice as long


def lost(trial: Trace, profile: str, settings: Settings) -> str:
    """Return why the vehicle is lost, or ""."""
    if _depth_at_end(trial, settings) > _allowed(settings, profile, trial):
        return f"{trial.truth.depth:.1f} m deep at the end, in {trial.state}"
    if trial.turning and trial.state != SURFACING and not _may_turn(trial, settings):
        return f"its thrusters turn at the end, in {trial.state}"
    return ""


def _depth_at_end(trial: Trace, settings: Settings) -> float:
    """Return the depth at the end, m; of a heavy vehicle in a long ascent, the least of a round.

    An ascent lets go in its turn (R7), and a heavy vehicle sinks for that time.
    """
    since = trial.truth.t - WHOLE_ROUND
    entered = max((e.t for e in trial.events if isinstance(e, Step) and e.entered), default=0.0)
    if trial.state != SURFACING or entered > since or net(settings, NEVER) >= SLIGHT:
        return trial.truth.depth
    return min(place.depth for place in trial.track if place.t >= since)


def _allowed(settings: Settings, profile: str, trial: Trace) -> float:
    """Return the depth that is allowed at the end, m.

    Physics: a vehicle stays down that no command its board obeys can lift. An order: a vehicle that
    sinks while AUTO is closed is not brought up (nor in idle over a restart, where fixes spoke
    against it); nothing ends the dive of a board that waits for U12; a vehicle stays down that
    sinks at rest with a depth that is not believed, or was not from the begin (R7). Reports that
    showed the sinking all the same are judged by depth_laws. Knowledge: two of three ways push a
    vehicle down that lies upside down while nothing shows it. A heavy vehicle whose sensor cannot
    show a rise has its thrusters for a third to two thirds of the time. Physics promises that this
    brings it up only where nothing else is wrong with what thrusters do.
    """
    floats, lifted = net(settings, NEVER), lift(settings, profile, NEVER)
    rests = not trial.state.startswith(AUTONOMOUS) and trial.state != SURFACING
    is_left = any(end == math.inf for _, end in left(trial.events))
    dives = is_left and obeys_no_stop(settings, trial.events)
    if rests and (dives or dives_unseen(settings, trial.truth.t)):
        return math.inf
    if overturned_untold(settings, trial.events):
        return math.inf
    if trial.state == SURFACING and says_overturned(settings, trial.truth.t):
        return math.inf
    if trial.state.startswith("idle") and afloat_by_fixes(settings, trial.events):
        return math.inf
    if floats > SLIGHT and lifted >= floats:
        return AFLOAT
    blind = blind_from_its_begin(settings, trial.events)
    doubted = rests and (blind or doubted_at_rest(settings, trial.truth.t))
    rises = lifted >= -floats and _turns_lift(trial, settings)
    alone = doubted or is_left or (unknown(settings, NEVER) and not rises)
    return math.inf if alone or lifted < SPARE else HELD


def _turns_lift(trial: Trace, settings: Settings) -> bool:
    """Whether the turns of full thrust lift the vehicle: no depth tells, and no angle is doubted.

    Full thrust then has forty seconds of sixty (R7). That lifts more than the other turns let sink,
    where the net thrust is at least as large as the net weight.
    """
    lasting = [f.name for f in settings.faults if fault_ends(f) >= NEVER]
    return trial.state == SURFACING and not any(
        name.startswith(_SPOIL) or (name.startswith("depth_") and name not in NOT_MISLED)
        for name in lasting
    )


def _may_turn(trial: Trace, settings: Settings) -> bool:
    """Whether a thruster may turn at the end.

    The vehicle sank out of surfaced, or a sensor reported that: a thruster holds it up (R7, at
    rest). Or its board obeys no stop, and at rest nothing but X is sent. Or the board turns it by
    itself, and nothing shows that.
    """
    if obeys_no_stop(settings, trial.events) or dives_unseen(settings, trial.truth.t):
        return True
    said = any(f.name.startswith(("depth_", "gps_")) for f in settings.faults)
    return trial.state == SURFACED and (said or _sank(trial, settings))


def _sank(trial: Trace, settings: Settings) -> bool:
    """Whether the vehicle sank out of surfaced and was brought up without an order.

    It sank in truth, or by a depth that may read deeper. The end of the fixes shows that later; so
    does a receiver that an operator switches off, or whose line is pulled.
    """
    before, off, sank, more = "", -math.inf, False, beside(settings)
    for event in trial.events:
        if isinstance(event, Tx) and event.data == RECEIVER_OFF:
            off = event.t
        if isinstance(event, Done) and event.act is Act.UNPLUG and trial.mission.vehicle != "auv":
            off = event.t  # a board's place comes by the board's own line
        if not (isinstance(event, Step) and event.entered):
            continue
        state = event.entered[-1]
        again = before == SURFACED and state == SURFACING and event.trigger == "limit"
        second = min(int(event.t), len(trial.track) - 1)
        seen = trial.track[max(second - TOLD, 0) : second + 1]
        deep, under = (
            any(p.depth + more > SANK for p in seen),
            all(p.depth > UNDER for p in seen[-ENDED:]),
        )
        under = under or _is_washed(trial, settings, event.t)
        sank = sank or (again and (deep or under or event.t - off < UNSEEN))
        sank = sank and state in (SURFACED, SURFACING)  # until the stick or a clear ends it
        before = state
    return sank


def _is_washed(trial: Trace, settings: Settings, t: float) -> bool:
    """Whether a board that dives by itself, and waves, have hidden the antenna until ``t``.

    The board pushes down a hull that stays at the surface. So the depth is contradicted, and the
    end of the fixes counts (R5, R7). Each wave over the antenna costs up to ``WASHED`` s.
    """
    lifts = [e.t for e in trial.events if isinstance(e, Tx) and e.data == LIFT_WORD and e.t < t]
    dives = [f for f in settings.faults if f.name == "dives_until_up" and f.begin <= t - PUSHED]
    if all(any(lift >= f.begin for lift in lifts) for f in dives):
        return False
    crest = 0.5 * settings.sea.waves[0]  # m over a hull that floats
    second = int(t)
    return all(
        any(place.depth + crest > UNDER for place in trial.track[max(i - WASHED, 0) : i + 1])
        for i in range(second - ENDED + 1, second + 1)
    )
