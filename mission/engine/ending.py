"""An orderly end of the program: the vehicle surfaces first, then the program ends.

    a mission, also under the stick    --> emergency/surfacing, as by W; surfaced if proved already
    the stick in use under water       --> continues until it is silent (R6)
    the stick in use elsewhere         --> X0, and every further M is refused
    the stick taken elsewhere          --> is refused
    an ascent                          --> continues
    elsewhere                          --> stays as it is: no thruster is started

``settled`` tells when the program may end. It waits until a vehicle that an ascent let go at the
surface was seen to stay there: one that is too heavy sinks again. It also waits while a stop is not
acknowledged, unless no board seems to be there to do so (without power, on deck). If the program
must end before the surface is proved, its last commands are X0 and U12: on the vehicle as built W
does not last, and no program is left to try another way.

What does not live here: for how long the program may stay (serve), the ascent (ascent).
"""

from __future__ import annotations

from mission.engine.core import Core
from mission.engine.rest import DEEP
from mission.engine.vehicle_state import SURFACE_DEPTH, SURFACE_TIME
from mission.engine.watch import leads_down
from mission.model import (
    AUTONOMOUS,
    MANUAL_DRIVING,
    SURFACED,
    SURFACING,
    Action,
    By,
    Ending,
)
from mission.model.regions import IDLE, MANUAL
from protocol.messages import UPWARD

WHY = "the program is ended"
STAYS_UP = 30.0  # s; a vehicle that is 0.3 N too heavy is 1 m deep after 25 s
UNHEARD = 30.0  # s without a report, at the surface as far as is known: no board is there


def begin(core: Core, order: Ending) -> None:
    if core.ending_since is None:
        core.ending_since = core.now
    if order.now:
        last_words(core)
        core.out_of_time = True


def go_on(core: Core) -> None:
    """Continue the end. Call this in every step once the end was ordered."""
    leaves_below = _ascends_from_stick(core)
    if core.region == AUTONOMOUS or (leaves_below and core.active != MANUAL_DRIVING):
        if _at_surface(core):
            core.stop_in("end", SURFACED, f"{WHY}, at the surface")
        else:
            core.surface("end", f"{WHY}: up first", By.LIMIT)
    elif core.region == MANUAL and not leaves_below and core.stop_at is core.stopped_at is None:
        core.stop_quietly(WHY)


def settled(core: Core) -> bool:
    """Whether the vehicle no longer needs the program."""
    return _is_left_alone(core) and not _may_still_turn(core)


def _is_left_alone(core: Core) -> bool:
    """Whether the vehicle needs the program no more once it has carried out the last command."""
    deep = _is_deep(core) or _may_be_deep(core)
    return not (_is_under_way(core) or _may_sink_again(core) or deep)


def hears_stick(core: Core) -> bool:
    """Whether an M still counts: the stick has the vehicle, or would have it, under water. None
    counts after the last commands, or while AUTO is closed: nothing would bring the vehicle up."""
    return not core.out_of_time and _leads_under_water(core)


def last_words(core: Core) -> None:
    """Send the commands that have to last after the program has ended. A vehicle that an ascent has
    let go at the surface stays let go."""
    sank = core.active == SURFACED and _is_deep(core) and core.auto
    if not (_is_under_way(core) or sank):
        return
    if core.active != SURFACING and _at_surface(core):
        core.stop_in("end", SURFACED, f"{WHY}, at the surface")
    else:
        core.say_last(Action(UPWARD, f"{WHY} before the surface is proved"))


def _is_under_way(core: Core) -> bool:
    """Whether the end brings the vehicle up from this state."""
    ascends = core.active == SURFACING or _ascends_from_stick(core)
    return ascends or core.region == AUTONOMOUS


def _ascends_from_stick(core: Core) -> bool:
    return core.region == MANUAL and _leads_under_water(core)


def _leads_under_water(core: Core) -> bool:
    return core.auto and (core.run is not None or _is_deep(core))


def _may_sink_again(core: Core) -> bool:
    """Whether an ascent has let the vehicle go so recently that depth or fixes cannot show yet that
    it floats. A vehicle that drives on the ground does not float."""
    told = core.vehicle_state.depth is not None or core.rest_due() is not None
    floats = told and not core.vehicle.drives
    return floats and core.active == SURFACED and core.now < core.let_go_at + STAYS_UP


def _may_still_turn(core: Core) -> bool:
    """Whether a stop is not acknowledged, and a board may still acknowledge it."""
    if core.stop_at is None:
        return False
    report = core.vehicle_state.telemetry
    heard = [core.ending_since or 0.0] + ([] if report is None else [report.t])
    return core.vehicle_state.submerged or core.now < max(heard) + UNHEARD


def _is_deep(core: Core) -> bool:
    """Whether the vehicle is over 2 m deep, by a believed depth; while reports are missing, by the
    last believed one."""
    depth = core.vehicle_state.depth
    if depth is None and _is_lost_under_water(core):
        depth = core.vehicle_state.believed_depth
    return depth is not None and depth > DEEP


def _may_be_deep(core: Core) -> bool:
    """Whether something led the vehicle, which was under water, and no report has come since: it
    may have gone deeper. In idle nothing has led it."""
    return core.region != IDLE and core.vehicle_state.depth is None and _is_lost_under_water(core)


def _is_lost_under_water(core: Core) -> bool:
    """Whether reports are missing, the last believed depth was under water, and no fixes show that
    the vehicle is up: recovered, its board without power."""
    state = core.vehicle_state
    return not core.is_heard and state.submerged and not state.receiver.at_surface(core.now)


def _at_surface(core: Core) -> bool:
    """Whether the surface was proved just now (R7), no believed depth contradicts it, and the set
    in force does not lead down: a clogged depth port shows the surface until the dive contradicts
    it."""
    state = core.vehicle_state
    if not (state.depth is None or state.depth < SURFACE_DEPTH):
        return False
    return not leads_down(state.command) and state.surfaced(core.now - SURFACE_TIME)
