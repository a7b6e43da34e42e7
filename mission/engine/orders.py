"""The commands of operators, and when they are accepted: one function each, with its verdict.

    X, W   in every state, never refused (R7)
    @AA    from idle, or from manual 2 s after the stick, if everything that it needs is known
    @AC    from idle; from stopped and surfaced at the surface, or if repeated (R7)
    @SP    always, in force at once (R5)
    @AO    an output that neither the mission under way nor an emergency holds
    M      always; in an emergency only after 2 s without any, and not a neutral one (R6)

What does not live here: who is the commander, and by which channel (onboard.runtime).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from mission.engine.auxiliary import set_output
from mission.engine.bounds import admit
from mission.engine.clearance import at_depth, is_guarded
from mission.engine.core import Core
from mission.engine.ending import WHY, hears_stick
from mission.engine.limits import SILENCE
from mission.engine.outset import too_far
from mission.engine.thrust import dives
from mission.engine.vehicle_state import FIX_AGE, SURFACE_DEPTH
from mission.legs import LEGS
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    MANUAL_DRIVING,
    STOPPED,
    SURFACED,
    By,
    Chart,
    Position,
    Verdict,
)
from mission.model.buoyancy import heavy
from mission.model.regions import EMERGENCY, IDLE, MANUAL
from mission.model.tables import Table
from mission.navigation.fixes import metres
from protocol.messages import (
    ClearMission,
    Emergency,
    Manual,
    Order,
    SetOutput,
    SetSafety,
    StartMission,
)
from protocol.operator_words import WORDS, OperatorWord

STICK_QUIET = 2.0  # s (R6)
PUSHED, WAITED = 0.15, 3  # s of a push, and the most M that a stick sends in that time (R6)
START_DEPTH = 2.0  # m: with ``start without fix`` a mission starts above it (R7)
CLEAR_AGAIN = (5.0, 30.0)  # s after a refused @AC, between which a second one is obeyed (R7)
PROOF_AGE = 10.0  # s: the greatest age of fixes that prove the surface

ACCEPTED = Verdict(True)
_UNCLEARED = {
    AUTONOMOUS: "a mission runs: stop it (X), then clear at the surface",
    MANUAL: "the stick has the vehicle: stop it (X), then clear at the surface",
    EMERGENCY: "surfacing: wait until it is at the surface",
}


def emergency(core: Core, command: Emergency) -> Verdict:
    if command.order is Order.STOP:
        core.stop_in("X", STOPPED, "X from the operator", By.OPERATOR)
    else:
        core.surface("W", "W from the operator", By.OPERATOR)
    return ACCEPTED


def set_safety(core: Core, command: SetSafety) -> Verdict:
    named = ("radius", "time", "depth", "voltage")
    news = {n: v for n in named if (v := getattr(command, n)) is not None}
    if any(not 0.0 < v < math.inf for v in news.values()):
        return Verdict(False, "limits are numbers greater than 0")
    core.operator = replace(core.operator, **news)
    core.renew_bounds()
    return ACCEPTED


def manual(core: Core, command: Manual) -> Verdict:
    not_pushed = _not_pushed(core)
    core.any_stick = core.now
    if core.ending_since is not None and not hears_stick(core):
        return Verdict(False, f"{WHY}: nobody would stop what the stick moves")
    if core.region == EMERGENCY:
        if command.neutral:
            core.push_at = None
            return Verdict(False, "an emergency: a stick in neutral does not take it over")
        if not_pushed:
            return Verdict(False, f"an emergency: {not_pushed}")
    core.stick = core.watch.led_down = core.now
    core.stop_at = core.stopped_at = None  # a stop from before it is over
    if core.active != MANUAL_DRIVING:
        core.take_stick()
    return ACCEPTED


def _not_pushed(core: Core) -> str:
    """Why this M does not take over an emergency; "" if it does. It has to continue a push that
    began after every stick was still for 2 s. The first M of a push does not suffice: after a
    dropout of the radio, or a stall of the Pi, the M of a stick that was held all the time arrive
    together, more of them than a stick sends in that time."""
    if core.now - max(core.any_stick, core.emergency_at) >= STICK_QUIET:
        core.push_at, core.push_words = core.now, 0
    if core.push_at is None or core.push_at <= core.emergency_at:
        return "every stick has to be still for 2 s before"
    begins = core.now < core.push_at + PUSHED
    core.push_words += begins
    if core.push_words > WAITED:
        return "every stick has to be still for 2 s before"
    return "a push that goes on takes it over" if begins else ""


def _at_surface(core: Core) -> bool:
    """Whether a believed depth, or without one the proof of the surface, shows the surface. True
    for a vehicle that never reports a depth."""
    depth = core.vehicle_state.depth
    if depth is not None:
        return depth < SURFACE_DEPTH
    return "depth" not in core.vehicle.reports or core.vehicle_state.surfaced(core.now - PROOF_AGE)


def why_not_clear(core: Core) -> str:
    """Why an @AC is refused now; "" if it is not."""
    if core.region == IDLE:
        return ""
    if core.active not in (STOPPED, SURFACED):
        return _UNCLEARED[core.region]
    depth, since = core.vehicle_state.depth, core.now - core.clear_refused
    meant = core.clear_refused >= core.emergency_at and CLEAR_AGAIN[0] <= since <= CLEAR_AGAIN[1]
    if _at_surface(core):
        return ""
    if depth is not None and depth > START_DEPTH:
        return f"{depth:.1f} m deep: an emergency is cleared at the surface"
    if meant:
        return ""
    seen = "the depth is not known" if depth is None else f"{depth:.1f} m deep"
    return f"{seen}: if it is at the surface clear again in 5 to 30 s"


def clear(core: Core, command: ClearMission) -> Verdict:
    why = why_not_clear(core)
    if why:
        if core.active in (STOPPED, SURFACED):
            core.clear_refused = core.now
        return Verdict(False, why)
    core.clear()
    return ACCEPTED


def start(core: Core, command: StartMission) -> Verdict:
    if core.region == AUTONOMOUS:
        return Verdict(True, "it runs already")
    why = why_not_start(core)
    if why:
        return Verdict(False, why)
    if core.region == MANUAL and core.run is not None:
        core.resume(core.run)
        return ACCEPTED
    assert core.chart is not None
    why = why_not_fly(core, core.chart) or _settle_home(core, core.chart)
    if why:
        return Verdict(False, why)
    core.begin(core.chart)
    return ACCEPTED


def why_not_start(core: Core) -> str:
    if core.ending_since is not None:
        return f"{WHY} when it has surfaced"
    if core.region == EMERGENCY:
        return "an emergency: clear it (@AC), or take the stick"
    if not core.auto:
        return "node AUTO is closed"
    if core.chart is None:
        return "no mission is stored"
    if core.vehicle_state.navigation is None:
        return "navigation is still being loaded"
    if core.region == MANUAL:
        if core.now - core.stick < STICK_QUIET:
            return "the stick was moved less than 2 s ago"
        if core.emergency_since_idle:
            return "an emergency preceded: idle first"
    return ""


def why_not_fly(core: Core, chart: Chart) -> str:
    if why := heavy(core.vehicle):
        return why
    report = core.vehicle_state.telemetry
    if report is None or core.now - report.t > SILENCE:
        return f"the vehicle was not heard for {SILENCE:g} s"
    if "depth" in core.vehicle.reports and core.vehicle_state.depth is None:
        why = core.vehicle_state.health("depth").reason or "missing"
        return f"the depth is not to be believed ({why}): no limit of depth could act"
    depth, free = core.vehicle_state.depth or 0.0, chart.mission.start_without_fix
    if depth >= (START_DEPTH if free else SURFACE_DEPTH):
        return f"{depth:.1f} m deep: a mission starts at the surface"
    if dives(report) and not (core.vehicle.drives or core.vehicle_state.overturned):
        return "the verticals push it down: a mission starts at the surface"
    bounds = core.watch.bounds
    for state in chart.states:
        if state.leg is None or state.setpoint is None or state.path == IMPLICIT_SURFACE:
            continue
        depths = LEGS[type(state.leg.kind)].depths(state.leg.kind)
        told = at_depth(state.setpoint) if is_guarded(state.setpoint) else state.setpoint
        for each in (told, *(replace(told, depth=d) for d in depths)):
            if fault := admit(each, bounds, core.vehicle):
                return f"{state.leg.name}: {fault}"
    return ""


LATELY = 60.0  # s: the greatest age of a fix that tells whether home is near (R9)
_ALLOW = "; 'start without fix' in the mission allows it"


def _settle_home(core: Core, chart: Chart) -> str:
    """Find home, check that it is near enough, and set it in navigation (R9). Why not, or ""."""
    vehicle_state, mission, navigation = (
        core.vehicle_state,
        chart.mission,
        core.vehicle_state.navigation,
    )
    assert navigation is not None
    fresh = vehicle_state.fix is not None and core.now - vehicle_state.fix.t <= FIX_AGE
    home = mission.home or (vehicle_state.home_from_fixes() if fresh else None)
    if home is None and not mission.start_without_fix:
        return f"no home: it takes five fixes in a row within 10 m and HDOP 3 at most{_ALLOW}"
    if home is not None and not fresh and not mission.start_without_fix:
        return f"no fix for 5 s: how far home is cannot be told{_ALLOW}"
    within = mission.start_within(core.vehicle.sensors.fix)
    known, fix = False, vehicle_state.fix
    if home is not None and fix is not None and core.now - fix.t <= LATELY:
        if why := too_far(_from(home, core), core.watch.bounds, within):
            return why
        known = vehicle_state.located(fix.t - FIX_AGE)
    if not known:
        navigation.start_here(core.now, 0.0 if home is None else within)
    if home is not None:
        navigation.set_origin(home, core.now)
    navigation.assume_current(mission.current(core.vehicle.current))
    vehicle_state.estimate = navigation.estimate(core.now)
    return ""


def _from(home: Position, core: Core) -> float:
    fix = core.vehicle_state.fix
    assert fix is not None
    latitude, longitude = math.radians(home.latitude_deg), math.radians(home.longitude_deg)
    return metres(latitude, longitude, fix.latitude, fix.longitude)


@dataclass(frozen=True, slots=True)
class OrderRow:
    """One command of the operator: its ``word`` (frame, acknowledgement) and what it does.

    ``regions``: where it is allowed; empty: in all. ``by_modem``: whether it may come by modem.
    ``does`` runs within the engine's step: no clock, no IO, everything from the core.
    """

    word: OperatorWord
    does: Callable[[Core, Any], Verdict]
    regions: frozenset[str] = frozenset()
    by_modem: bool = True

    def obey(self, core: Core, command: object) -> Verdict:
        if self.regions and core.region not in self.regions:
            where = " or ".join(sorted(self.regions))
            return Verdict(False, f"@{self.word.code} is for {where}, not for {core.region}")
        return self.does(core, command)


ORDERS: Table[type, OrderRow] = Table(
    lambda row: row.word.message,
    (
        OrderRow(WORDS[SetSafety], set_safety),
        OrderRow(WORDS[SetOutput], set_output),
        OrderRow(WORDS[ClearMission], clear),
        OrderRow(WORDS[StartMission], start),
    ),
)


@contextmanager
def registered(row: OrderRow) -> Iterator[OrderRow]:
    """Register the command, with its frame, for the length of a ``with`` block."""
    with WORDS.registered(row.word), ORDERS.registered(row):
        yield row


def obey(core: Core, command: object) -> Verdict:
    if isinstance(command, Emergency):
        return emergency(core, command)
    if isinstance(command, Manual):
        return manual(core, command)
    row = ORDERS.get(type(command))
    if row is None:
        return Verdict(False, f"{type(command).__name__} is not for the engine")
    return row.obey(core, command)


def may_come_by_modem(command: object) -> bool:
    row = ORDERS.get(type(command))
    return row is None or row.by_modem
