"""What an operator may order, and when: one function per command, each with its verdict.

    X, W   in every state, never refused (R7)
    @AA    from idle, or from manual 2 s after the stick, with everything known that it takes
    @AC    from idle, stopped, surfaced
    @SP    always, in force at once (R5)
    M      always; in an emergency only after 2 s without one (R6)

What does not live here: who is the commander, and by which path (drive).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from mission.engine.core import Core
from mission.engine.outset import too_far
from mission.engine.senses import FIX_AGE, metres
from mission.envelope import SILENCE, admit
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
from mission.regions import EMERGENCY, IDLE, MANUAL
from protocol.messages import ClearMission, Emergency, Manual, Order, SetSafety, StartMission

STICK_QUIET = 2.0  # s (R6)

ACCEPTED = Verdict(True)


def emergency(core: Core, command: Emergency) -> Verdict:
    if command.order is Order.STOP:
        core.emergency_stop("X from the operator")
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
    quiet = core.now - core.stick
    core.stick = core.now
    same_step = core.emergency_at == core.now  # X and W overtake what came with them
    if core.region == EMERGENCY and (quiet < STICK_QUIET or same_step):
        return Verdict(False, "an emergency: let the stick go for 2 s before taking over")
    if core.active != MANUAL_DRIVING:
        core.take_stick()
    return ACCEPTED


def may_clear(core: Core) -> bool:
    return core.region == IDLE or core.active in (STOPPED, SURFACED)


def clear(core: Core, command: ClearMission) -> Verdict:
    if may_clear(core):
        core.clear()
        return ACCEPTED
    if core.region == EMERGENCY:
        return Verdict(False, "surfacing: wait until it is at the surface")
    return Verdict(False, "a mission runs or is interrupted: stop the vehicle first")


def start(core: Core, command: StartMission) -> Verdict:
    if core.region == AUTONOMOUS:
        return Verdict(True, "it runs already")
    why = _why_not_start(core)
    if why:
        return Verdict(False, why)
    if core.region == MANUAL and core.run is not None:
        core.resume(core.run)
        return ACCEPTED
    assert core.chart is not None
    why = _why_not_fly(core, core.chart) or _settle_home(core, core.chart)
    if why:
        return Verdict(False, why)
    core.begin(core.chart)
    return ACCEPTED


def _why_not_start(core: Core) -> str:
    if core.region == EMERGENCY:
        return "an emergency: clear it (@AC), or take the stick"
    if not core.auto:
        return "node AUTO is closed"
    if core.chart is None:
        return "no mission is stored"
    if core.senses.navigation is None:
        return "navigation is still being loaded"
    if core.region == MANUAL:
        if core.now - core.stick < STICK_QUIET:
            return "the stick was moved less than 2 s ago"
        if core.emergency_since_idle:
            return "an emergency preceded: idle first"
    return ""


def _why_not_fly(core: Core, chart: Chart) -> str:
    report = core.senses.telemetry
    if report is None or core.now - report.t > SILENCE:
        return f"the vehicle was not heard for {SILENCE:g} s"
    if "depth" in core.vehicle.reports and core.senses.depth is None:
        why = core.senses.health("depth").reason or "missing"
        return f"the depth is not to be believed ({why}): no limit of depth could act"
    bounds = core.watch.bounds
    for state in chart.states:
        if state.leg is None or state.setpoint is None or state.path == IMPLICIT_SURFACE:
            continue
        depths = LEGS[type(state.leg.kind)].depths(state.leg.kind)
        sets = [state.setpoint, *(replace(state.setpoint, depth=d) for d in depths)]
        for each in sets:
            if fault := admit(each, bounds, core.vehicle):
                return f"{state.leg.name}: {fault}"
    return ""


_ALLOW = "; 'start without fix' in the mission allows it"


def _settle_home(core: Core, chart: Chart) -> str:
    """R9: where home is, and that it is near enough; tells navigation. Why not, or ""."""
    senses, mission, navigation = core.senses, chart.mission, core.senses.navigation
    assert navigation is not None
    home = mission.home or senses.home_from_fixes()
    fresh = senses.fix is not None and core.now - senses.fix.t <= FIX_AGE
    if home is None and not mission.start_without_fix:
        return f"no home: it takes five fixes in a row within 10 m and HDOP 3 at most{_ALLOW}"
    if home is not None and not fresh and not mission.start_without_fix:
        return f"no fix for 5 s: how far home is cannot be told{_ALLOW}"
    if home is not None and fresh:
        within = mission.start_within(core.vehicle.sensors.fix)
        if why := too_far(_from(home, core), core.watch.bounds, within):
            return why
    if home is not None:
        navigation.set_origin(home, core.now)
    if home is None or not fresh:
        navigation.start_here(core.now)
    navigation.assume_current(mission.current(core.vehicle.current))
    senses.estimate = navigation.estimate(core.now)
    return ""


def _from(home: Position, core: Core) -> float:
    fix = core.senses.fix
    assert fix is not None
    latitude, longitude = math.radians(home.latitude_deg), math.radians(home.longitude_deg)
    return metres(latitude, longitude, fix.latitude, fix.longitude)


ORDERS: Mapping[type, Callable[[Core, Any], Verdict]] = MappingProxyType(
    {
        Emergency: emergency,
        SetSafety: set_safety,
        Manual: manual,
        ClearMission: clear,
        StartMission: start,
    }
)
