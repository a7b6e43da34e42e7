"""What viewers see of a running serve: one flat table of values.

Times are the engine's, s. The age of a value is the frame's time minus its own, so that a delayed
value shows its age. Angles in degrees, lengths in m. None: not known.

What does not live here: who is sent what (monitor); the health on disk (health).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from typing import Any

from mission.authoring.language.render import guard_text
from mission.engine.variables import VARIABLES
from mission.legs import LEGS
from mission.model import Guard, LegKind, terms
from mission.model.alarms import Alarm
from mission.navigation import distribution
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.stream.places import fix_value, rounded
from protocol.state_frame import setpoint_words

_READINGS = ("depth", "altitude", "heading", "pitch", "roll", "speed", "battery")


def view(runtime: Runtime, alarms: Iterable[Alarm], now: float | None = None) -> dict[str, Any]:
    """The state at ``now`` s, by default at the engine's last step. The most important values stand
    first, so that a slow radio gets them first."""
    engine, known = runtime.engine, runtime.situation
    now = engine.core.now if now is None else now
    return {
        "state": engine.state,
        "alarms": [asdict(alarm) for alarm in alarms],
        "leg": engine.leg,
        "depth": _bare(runtime, "depth"),
        **_place(runtime, now),
        "report_at": _rounded(known.telemetry.t) if known.telemetry else None,
        "fix_at": _fixed(runtime),
        "setpoint": setpoint_words(known.setpoint),
        "commander": str(runtime.commander.peer or ""),
        **_margins(runtime, now),
        "reason": engine.reason,
        "mission": engine.chart.digest[:16] if engine.chart else "",
        "mission_began": _rounded(engine.core.run.started) if engine.core.run else None,
        **_leg(runtime),
        **{name: _bare(runtime, name) for name in _READINGS if name != "depth"},
        "fix": rounded(fix_value(known.fix)) if known.fix else None,
        "origin": _origin(runtime),
    }


def _origin(runtime: Runtime) -> list[float] | None:
    """Home, the origin of north and east, in degrees."""
    navigation = runtime.engine.core.vehicle_state.navigation
    if navigation is None or navigation.frame is None:
        return None
    origin = navigation.frame.origin
    return [round(origin.latitude_deg, 8), round(origin.longitude_deg, 8)]


def _place(runtime: Runtime, now: float) -> dict[str, Any]:
    """The estimate, its 95 % ellipse (half axes, bearing of the long one) and the current."""
    engine, known = runtime.engine, runtime.situation
    estimate, navigation = known.estimate(now), engine.core.vehicle_state.navigation
    frame = navigation.frame if navigation is not None else None
    if estimate is None or frame is None or known.uncertainty(now) is None:
        return {"latitude": None, "longitude": None, "ellipse": None, "current": None}
    latitude, longitude = frame.to_geodetic(estimate.north, estimate.east)
    great, small, bearing = distribution.principal(estimate.covariance)
    axes = [round(distribution.PLANE_95 * sigma, 1) for sigma in (great, small)]
    return {
        "latitude": round(math.degrees(latitude), 7),
        "longitude": round(math.degrees(longitude), 7),
        "ellipse": [*axes, round(math.degrees(bearing) % 180.0)],
        "current": [round(estimate.current_north, 2), round(estimate.current_east, 2)],
    }


def _fixed(runtime: Runtime) -> float | None:
    """When the last fix came; without a receiver, the vehicle's own position."""
    now = runtime.engine.core.now
    age = runtime.situation.fix_age(now)
    return None if age is None else _rounded(now - age)


def _margins(runtime: Runtime, now: float) -> dict[str, Any]:
    """What is left to each limit, with the limit."""
    bounds = runtime.engine.bounds
    left = runtime.situation.margins(now)
    limits = {"depth": bounds.depth, "radius": bounds.radius, "time": bounds.time / 60.0,
              "voltage": bounds.voltage}  # fmt: skip
    return {
        f"to_{name}": [_rounded(left[name], 1), round(limit, 1)] for name, limit in limits.items()
    }


def _leg(runtime: Runtime) -> dict[str, Any]:
    """When the leg began, how long it may last, and what ends it."""
    run, chart = runtime.engine.core.run, runtime.engine.chart
    if run is None or chart is None:
        return {"leg_began": None, "leg_timeout": None, "leg_ends": None}
    guards = [e.guard for e in chart.edges if e.source == run.leaf and e.guard is not None]
    leg = next((state.leg for state in chart.states if state.path == run.leaf), None)
    return {
        "leg_began": _rounded(run.entered),
        "leg_timeout": leg.timeout if leg is not None else None,
        "leg_ends": [
            *(_guard(runtime, guard) for guard in dict.fromkeys(guards)),
            *(_arrival(runtime, leg.kind) if leg is not None else ()),
        ],
    }


def _arrival(runtime: Runtime, kind: LegKind) -> Iterator[list[Any]]:
    """What ends a leg that steers to places, or a corner on its way."""
    row = LEGS[type(kind)]
    if row.ends and (within := row.within(kind)) > 0.0:
        corner = "" if row.ends_at_last and len(row.places(kind)) == 1 else "each corner: "
        yield [f"{corner}distance <= {within:g} m", {"distance": _bare(runtime, "distance")}]


def _guard(runtime: Runtime, guard: Guard) -> list[Any]:
    """The guard's text, and its variables as they are now, in the unit of a bare number."""
    names = dict.fromkeys(name for term in terms(guard.expression) for name in term.asks)
    return [guard_text(guard, True), {name: _bare(runtime, name) for name in names}]


def _bare(runtime: Runtime, name: str) -> float | None:
    """The reading's value in the unit of a bare number; None if it is not valid now."""
    reading = runtime.engine.readings[name]
    if not reading.valid or not math.isfinite(reading.value):
        return None
    row = VARIABLES.get(name)  # or a reading that the vehicle file names
    is_angle = row is not None and row.unit == "deg"
    return _rounded(math.degrees(reading.value) if is_angle else reading.value)


def _rounded(value: float | None, places: int = 2) -> float | None:
    return None if value is None else round(value, places)
