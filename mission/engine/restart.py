"""Restart of the program: what was under way surfaces, what was at rest stays at rest.

    a mission, an ascent     --> emergency/surfacing, at once; what proves the surface is counted
                                 from 6 s on, and by a depth only when that has changed: of one that
                                 nobody saw before, it is known only after five reports with a
                                 thruster on whether it is frozen
    stopped, surfaced        --> the same again, everything stopped: the vehicle may be on deck
                                 (what was surfaced was up: deeper now, it has sunk meanwhile)
    the stick alone, a stop that nothing has acknowledged, or a rest in which it has sunk while AUTO
    was closed, or may have while reports brought no depth to believe
                             --> stopped, idle; and up by the first depth that says it is deep, and
                                 stays so: nobody may be there whose silence could be counted
    nothing                  --> idle, also where it has sunk meanwhile: it may be on deck; X0 where
                                 reports show a thruster on all the same, since a program may have
                                 ended between a word and the record of it
    the store cannot tell    --> stopped, and up as soon as two reports in a row, over a second,
                                 say a depth to believe beyond 2 m, and AUTO is open: on deck no
                                 thruster turns, under water it rises

What does not live here: who keeps what is under way (resume_marker, store).
"""

from __future__ import annotations

import math

from mission.engine.core import Core
from mission.engine.rest import DEEP
from mission.model import AUTONOMOUS, STOPPED, SURFACED, UNKNOWN, By, Restarted
from mission.model.regions import EMERGENCY, IDLE, MANUAL

STICK = "the stick, without a mission"  # under way in manual: a restart stops, and is idle
UNANSWERED = "a stop without its acknowledgement"  # in idle: thrusters may still turn
UNSEEN = "rest in which it may have sunk"  # unseen; or seen, while AUTO was closed
_UNSEEN_BEFORE = "rest that began without a depth to believe"  # in the store of an older program
STOPS = (STICK, UNANSWERED, UNSEEN, _UNSEEN_BEFORE)  # under which a restart stops, and is idle
LASTS = 1.0  # s, and two reports: a fast board says a wild depth many times
UNWATCHED = 6.0  # s; with the surface's own 6 s a frozen depth shows


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
    """At rest, and nobody brings it up: no depth was believed when it came to rest; or what was up
    has reports without one (a board that is silent may be on deck, without power); or it sinks and
    AUTO is closed, which a restart opens."""
    rest, state = core.rest, core.vehicle_state
    lost = state.depth is None and not state.contradicted  # what leapt may be on deck
    if not core.rested:  # no report has come since it came to rest
        return core.moved_blind
    blind = core.moved_blind if rest.is_dark else rest.was_up and core.is_heard and lost
    seen = bool(rest.sinks or rest.goes_down)
    return blind or rest.unseen or (seen and not state.receiver.at_surface(core.now))


def begin_again(core: Core, before: Restarted) -> None:
    if core.region != IDLE:
        return
    if not before.during:
        core.stopped_at = core.now  # what turns was told so before a record of it was kept
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
    """Looks at each report while nobody knows what was under way, until an operator decides."""
    depth, since, report = core.vehicle_state.depth, core.deep_since, core.vehicle_state.telemetry
    if depth is None or since is None or report is None or not unsure(core):
        return
    core.deep_since = min(since, report.t) if depth > DEEP else math.inf
    if report.t >= core.deep_since + LASTS and core.auto:
        why = f"{core.reason}, and it is {depth:.1f} m deep"
        core.surface("restart", why, By.LIMIT)
