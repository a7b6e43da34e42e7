"""Restart of the program: a vehicle that was under way surfaces, one at rest stays at rest.

    a mission, an ascent     --> emergency/surfacing, at once. What proves the surface counts from
                                 6 s on. A depth proves it only once it has changed: five reports
                                 with a thruster on show whether a newly seen depth is frozen
    stopped, surfaced        --> the same state, everything stopped: the vehicle may be on deck
                                 (it was up in surfaced: deeper now, it has sunk meanwhile)
    the stick alone, a stop without its acknowledgement, or a rest in which the vehicle has sunk
    while AUTO was closed, or may have sunk while reports had no believed depth
                             --> idle, everything stopped. It is brought up if a depth shows that
                                 it is deep and stays so: there may be no operator whose silence
                                 could be counted
    nothing                  --> idle, also if it has sunk meanwhile: it may be on deck. X0 if
                                 reports show a thruster on: a program may have ended between a
                                 command and its record
    the store cannot tell    --> stopped. It is brought up as soon as two reports in a row, over a
                                 second, show a believed depth beyond 2 m, and AUTO is open: on
                                 deck no thruster turns, under water the vehicle rises

What does not live here: who keeps what is under way (resume_marker, store).
"""

from __future__ import annotations

import math

from mission.engine.core import Core
from mission.engine.rest import DEEP
from mission.model import AUTONOMOUS, STOPPED, SURFACED, UNKNOWN, By, Restarted
from mission.model.regions import EMERGENCY, IDLE, MANUAL

STICK = "the stick, without a mission"  # under way in manual
UNANSWERED = "a stop without its acknowledgement"  # in idle: thrusters may still turn
UNSEEN = "rest in which it may have sunk"  # unseen; or seen, while AUTO was closed
_UNSEEN_BEFORE = "rest that began without a depth to believe"  # in the store of an older program
STOPS = (STICK, UNANSWERED, UNSEEN, _UNSEEN_BEFORE)  # after these: everything stopped, in idle
LASTS = 1.0  # s, and two reports: a fast board repeats an outlier many times
UNWATCHED = 6.0  # s; with the surface's own 6 s this shows a frozen depth


def under_way(core: Core) -> str:
    """What this program would interrupt if it ended now; "" if nothing."""
    if unsure(core):
        return UNKNOWN
    if core.region in (AUTONOMOUS, EMERGENCY) or core.run is not None:
        return core.active
    if core.region == MANUAL:
        return STICK
    if core.stop_at is not None:
        return UNANSWERED
    return UNSEEN if _may_have_sunk(core) else ""


def _may_have_sunk(core: Core) -> bool:
    """Whether the vehicle may have sunk at rest while nothing brings it up. Either no depth was
    believed when it came to rest; or it was up, and reports have no believed depth any more (a
    silent board may be on deck, without power); or it sinks while AUTO is closed, which a restart
    opens."""
    rest, state = core.rest, core.vehicle_state
    lost = state.depth is None and not state.contradicted  # else it may have leapt on deck
    if not core.rested:  # no report has come since it came to rest
        return core.moved_blind
    blind = core.moved_blind if rest.is_dark else rest.was_up and core.is_heard and lost
    seen = bool(rest.sinks or rest.goes_down)
    return blind or rest.unseen or (seen and not state.receiver.at_surface(core.now))


def begin_again(core: Core, before: Restarted) -> None:
    if core.region != IDLE:
        return
    if not before.during:
        core.stopped_at = core.now  # a thruster that is on was commanded, but not recorded
        return
    why = f"the program restarted during {before.during}"
    if before.during in STOPS:
        core.stop_quietly(why)
        core.rest.begin(unseen=True)
    elif before.during in (STOPPED, SURFACED):
        core.stop_in("restart", before.during, why)
        if before.during == SURFACED:
            core.let_go_at, core.rested = core.now, ""
    elif before.during == UNKNOWN:
        core.stop_in("restart", STOPPED, why)
        core.deep_since = math.inf
    else:
        core.surface("restart", why, By.LIMIT)
        core.vehicle_state.expect_change()
        if core.ascent is not None:
            core.ascent.began += UNWATCHED


def unsure(core: Core) -> bool:
    return core.deep_since is not None and core.active == STOPPED


def doubt(core: Core) -> None:
    """Check each report while it is unknown what was under way, until an operator decides."""
    depth, since, report = core.vehicle_state.depth, core.deep_since, core.vehicle_state.telemetry
    if depth is None or since is None or report is None or not unsure(core):
        return
    core.deep_since = min(since, report.t) if depth > DEEP else math.inf
    if report.t >= core.deep_since + LASTS and core.auto:
        why = f"{core.reason}, and it is {depth:.1f} m deep"
        core.surface("restart", why, By.LIMIT)
