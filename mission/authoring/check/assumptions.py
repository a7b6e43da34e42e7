"""The worst case that the check assumes for sea and vehicle, and its constants."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from mission.authoring.compiler.granularity import rounded
from mission.engine.clearance import Clearance, is_guarded
from mission.engine.limits import LIMITS
from mission.engine.variables import VARIABLES
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    Chart,
    Mission,
    Trend,
    buoyancy,
    terms,
)
from mission.model.vehicle import Vehicle
from mission.navigation.declination import declination
from protocol.messages import Setpoint

TWO_SIGMA = 2.0
SPEED_SHARE = 0.2  # two sigma of the thruster model, as a share of the speed
OVERSHOOT = 1.0  # m beyond a depth that is held; R5 acts at 1 m beyond
FROZEN = 10.0  # s until a reading is known to be frozen: five equal reports, 2 s apart
LATE = 8.0  # s until a change of depth is known: one report (2 s) after 6 s without
TURNED = 3.0  # s until thrusters and buoyancy have reversed a dive
STICKS = 10.0  # s that a descent may continue after it was ended: as built, W does not last (R7)
ASCENT_TRIES = 20.0  # s: W and X0 with U12, 10 s each, until the better is known (R7)
SURFACED = 8.0  # s: depth below 0.5 m for 6 s, and the report that shows it (R7)


@dataclass(frozen=True, slots=True)
class Assumptions:
    """The assumptions in SI, from the mission's ``assume`` or the vehicle file."""

    current: float
    start: float
    depth: float  # m, at the start (R7)
    floor: float  # m, the deepest sea floor; the depth allowed if none is assumed
    depth_without_floor: float  # m, up to which clocks alone bound an altitude hold
    heading: float  # rad, two sigma
    declination: float  # rad, at home: a heading hold follows the compass

    @staticmethod
    def of(mission: Mission, vehicle: Vehicle, allowed: float) -> Assumptions:
        """``allowed``: the depth in force, m."""
        given = dict(mission.assume)
        sensors = vehicle.sensors
        return Assumptions(
            current=mission.current(vehicle.current),
            start=mission.start_within(sensors.fix),
            depth=2.0 if mission.start_without_fix else 0.5,
            floor=mission.floor(allowed),
            depth_without_floor=0.0 if "floor" in given else allowed,
            heading=TWO_SIGMA * math.hypot(sensors.heading, sensors.heading_bias),
            declination=_declination(mission, vehicle),
        )


def _declination(mission: Mission, vehicle: Vehicle) -> float:
    """rad; 0 if home is not known: then all directions turn by the same angle, without effect."""
    if vehicle.declination is not None or mission.home is None:
        return vehicle.declination or 0.0
    home = mission.home
    return declination(math.radians(home.latitude_deg), math.radians(home.longitude_deg))


def told(chart: Chart, vehicle: Vehicle, assume: Assumptions, floor: bool) -> Iterator[str]:
    """The assumptions as lines of the report; ``floor``: a bound uses the assumed floor."""
    given = dict(chart.mission.assume)
    source = "the mission" if "current" in given else "the vehicle file"
    yield f"current at most {assume.current:g} m/s ({source})"
    yield f"started within {assume.start:g} m of home"
    yield f"speed by gear as in the vehicle file, within {SPEED_SHARE:.0%} (two sigma)"
    yield f"heading within {math.degrees(assume.heading):.0f} deg (two sigma of sensor and bias)"
    yield f"ascent by buoyancy alone at {buoyancy.told(vehicle)}"
    yield f"battery {vehicle.battery.usable / 3600:.0f} Wh usable, powers as in the vehicle file"
    yield from _stated_rounding(chart, vehicle)
    yield from _kept_clear(chart, vehicle)
    if floor:
        why = "" if "floor" in given else ", the depth allowed; state assume floor where it is"
        yield f"sea floor nowhere deeper than {assume.floor:g} m{why}"
    yield from too_fast(chart, vehicle)
    yield from _off(chart.mission, vehicle)
    yield from _constant(chart, vehicle)
    yield "a dead Pi, or a board that hangs with its thrusters on, does not happen"


def too_fast(chart: Chart, vehicle: Vehicle) -> Iterator[str]:
    """Report trends over less depth than a dive makes between two reports: the report before is
    then never within the window, and the trend is unknown during the dive."""
    least = vehicle.dive_rate * vehicle.sensors.telemetry_period
    asked: dict[Trend, dict[str, None]] = {}
    for edge in chart.edges:
        for term in terms(edge.guard.expression) if edge.guard is not None else ():
            if isinstance(term, Trend) and term.of_depth and term.window <= least:
                asked.setdefault(term, {})[edge.source.removeprefix(f"{AUTONOMOUS}/")] = None
    for trend, legs in asked.items():
        way = "rises" if trend.rises else "falls"
        yield (
            f"{', '.join(legs)}: whether {trend.variable} {way} within {trend.window:g} m is not "
            f"known in a dive at {vehicle.dive_rate:g} m/s, which makes {least:g} m from report to "
            f"report: ask within {math.ceil(3.0 * least):g} m or more"
        )


def _off(mission: Mission, vehicle: Vehicle) -> Iterator[str]:
    """Report the limits that can never act on this vehicle, with the reason (R5): somebody else
    has to watch for them."""
    off: dict[str, list[str]] = {}
    for row in LIMITS.values():
        if why := row.disarmed(vehicle):
            areas = row.name == "radius" and mission.areas
            off.setdefault(why, []).append("radius and all areas" if areas else row.name)
    for why, names in off.items():
        yield f"{why}: limits that are off, to be watched from outside: {', '.join(names)}"


def _constant(chart: Chart, vehicle: Vehicle) -> Iterator[str]:
    """Report guards on readings that never change: they are true from the start on, or never."""
    guards = (edge.guard for edge in chart.edges if edge.guard is not None)
    asked = (name for guard in guards for term in terms(guard.expression) for name in term.asks)
    names = [name for name in dict.fromkeys(asked) if "battery" in _source(name)]
    if names and vehicle.constant_batteries:
        yield (
            f"what the mission asks of {' and '.join(names)} is so from the start on or never: "
            f"{vehicle.name} reports the same in every flight"
        )


def _source(name: str) -> tuple[str, ...]:
    variable = VARIABLES.get(name)
    return () if variable is None else variable.source


def _kept_clear(chart: Chart, vehicle: Vehicle) -> Iterator[str]:
    for path, held, blind in _blind(chart, vehicle):
        yield (
            f"{path} holds {blind:g} m while its altitude is not believed: "
            f"no less than {held.altitude:g} m above the sea floor assumed"
        )


def not_clear(chart: Chart, vehicle: Vehicle) -> Iterator[tuple[str, str]]:
    """Path and message of legs with a least altitude for which the assumed floor leaves no depth
    to hold."""
    for path, held, blind in _blind(chart, vehicle):
        if blind <= 0.0:
            message = (
                f"{path} is kept {held.altitude:g} m above the sea floor: without an altitude the "
                "floor that is assumed leaves no depth to hold"
            )
            yield f"{AUTONOMOUS}/{path}", message


def _blind(chart: Chart, vehicle: Vehicle) -> Iterator[tuple[str, Setpoint, float]]:
    """Legs with a depth and a least altitude: path, setpoint, and the depth in m that each holds
    without an altitude."""
    clearance = Clearance.of(chart.mission, vehicle)
    for state in chart.states:
        held = state.setpoint
        if held is not None and is_guarded(held):
            yield state.path.removeprefix(f"{AUTONOMOUS}/"), held, clearance.blind(held)


def _stated_rounding(chart: Chart, vehicle: Vehicle) -> Iterator[str]:
    """Report values between the vehicle's steps whose rounding is below the sensor's noise."""
    legs = (
        (s.leg, s.setpoint)
        for s in chart.states
        if s.leg and s.setpoint and s.path != IMPLICIT_SURFACE
    )
    found = (r for leg, held in legs for r in rounded(leg, held, vehicle))
    for text in dict.fromkeys(f"{r} is sent as {r.nearest:g} {r.unit}" for r in found):
        yield f"{text}, the nearest that {vehicle.name} can be told"
