"""The output of `auvmission status`: no value without its age, alarms first.

    Looked --as_object--> one object (JSON)      --as_lines--> lines for people

What does not live here: how it is asked for (looking), what an alarm is (model.alarms).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

from mission.model import Position
from mission.model.alarms import ALARMS, Alarm, Condition, ago, alarms_of, mask_of, standing
from mission.navigation.distribution import PLANE_95
from mission.navigation.geodesy import LocalFrame
from mission.topside.looking import NEW, Looked
from mission.topside.overdue import Contact
from protocol.messages import Fix, StateReport
from protocol.state_frame import setpoint_words

COMMANDERS = {"nobody": "nobody", "asker": "you", "network": "another, by the network",
              "modem": "another, by modem"}  # fmt: skip
EMERGENCY = mask_of(["emergency"])
UNTOLD = "not told: the vehicle's program knows no @AE"


def alarms_in(looked: Looked) -> tuple[Alarm, ...]:
    """Return the alarms that the vehicle reports, worded with what is known here. Without ``@AE``,
    the alarms that its reports and its store show."""
    state, refusal = looked.state, looked.store.refusal if looked.store else ""
    known = Condition(
        state=state.state if state else "",
        report_age=looked.report_age if state else None,
        unobeyed=refusal.startswith("X:"),
        refusal=refusal,
        refusal_age=0.0 if refusal else None,
    )
    words = {alarm.name: alarm for alarm in standing(known)}
    if state is not None:
        told = (EMERGENCY * state.state.startswith("emergency")) | state.alarms
        return tuple(words.get(alarm.name, alarm) for alarm in alarms_of(told))
    if looked.reports != NEW:
        row = ALARMS["old report"]
        words[row.name] = Alarm(row.name, row.level, looked.reports, row.do)
    return tuple(words.values())


def as_object(looked: Looked) -> dict[str, Any]:
    """None: not known. Angles in degrees, lengths in m, ages in s at the time of printing."""
    told, store, state = looked.last, looked.store, looked.state
    fix, own = told.fix, told.telemetry
    batteries = own.batteries if own is not None and own.batteries else (None, None)
    return {
        "time": told.time,
        **_state(looked),
        "reports": looked.reports,
        "report_age_s": looked.report_age,
        "position": looked.position,
        "fix_age_s": looked.fix_age,
        "latitude": _degrees(fix.latitude, 7) if fix else None,
        "longitude": _degrees(fix.longitude, 7) if fix else None,
        "estimate": _estimate(fix, state),
        "depth_m": own.depth if own else None,
        "altitude_m": own.altitude if own else None,
        "heading_deg": bearing(own.heading, 1) if own else None,
        "pitch_deg": _degrees(own.pitch, 1) if own else None,
        "roll_deg": _degrees(own.roll, 1) if own else None,
        "battery_v": batteries[0],
        "power_v": batteries[1],
        "margins": _margins(state),
        "store": store.state if store else None,
        "lines": f"{store.have} of {store.total}" if store and store.total else None,
        "missing": store.missing if store else None,
        "digest": store.digest if store else None,
        "refusal": store.refusal if store else None,
        "alarms": [asdict(alarm) for alarm in alarms_in(looked)],
    }


def contact_of(looked: Looked, wall: float) -> Contact:
    """Return the contact that the boat stores, at ``wall`` s since 1970 UTC."""
    found, state, fix = as_object(looked), looked.state, looked.last.fix
    place = found["estimate"] or found
    radius = state.uncertainty_m if state is not None and found["estimate"] else None
    one = None if radius is None else (radius / PLANE_95) ** 2
    return Contact(
        wall,
        state.state if state is not None else "autonomous",
        place["latitude"] if fix else None,
        place["longitude"] if fix else None,
        None if one is None else (one, 0.0, one),
        mission=looked.store.digest if looked.store is not None else "",
    )


def _state(looked: Looked) -> dict[str, Any]:
    state = looked.state
    if state is None:
        return {"state": None, "leg": None, "setpoint": None, "commander": None}
    return {
        "state": state.state,
        "leg": state.leg,
        "setpoint": setpoint_words(state.setpoint),
        "commander": COMMANDERS[state.commander],
    }


def _estimate(fix: Fix | None, state: StateReport | None) -> dict[str, float] | None:
    """Return where it is now by its own estimate; the last fix is where it was."""
    if fix is None or state is None or state.north_m is None or state.east_m is None:
        return None
    frame = LocalFrame(Position(math.degrees(fix.latitude), math.degrees(fix.longitude)))
    latitude, longitude = frame.to_geodetic(state.north_m, state.east_m)
    found = {"latitude": round(math.degrees(latitude), 6)}
    found["longitude"] = round(math.degrees(longitude), 6)
    found["from_last_fix_m"] = round(math.hypot(state.north_m, state.east_m))
    return found | ({} if state.uncertainty_m is None else {"within_m": state.uncertainty_m})


def _margins(state: StateReport | None) -> dict[str, float | None] | None:
    if state is None:
        return None
    return {
        "depth_m": state.to_depth_m,
        "radius_m": state.to_radius_m,
        "time_min": state.to_time,
        "voltage_v": state.to_voltage_v,
    }


# --- for people ---

_OF_REPORT = ("depth_m", "altitude_m", "heading_deg", "pitch_deg", "roll_deg", "battery_v",
              "power_v")  # fmt: skip
_REPORTED = ("depth_m", "voltage_v")  # margins as old as the report
_OF_STORE = ("lines", "missing", "digest", "refusal")
_HELD = "takes no upload: not idle"  # the document's `running`, also in an emergency


def as_lines(looked: Looked) -> Iterator[str]:
    found = as_object(looked)
    yield from (f"ALARM {alarm}" for alarm in alarms_in(looked))
    yield from _rows({"state": found["state"] or UNTOLD})
    yield from _rows({name: found[name] for name in ("leg", "setpoint", "commander")})
    yield from _rows({"time": found["time"], "reports": _aged(looked.reports, looked.report_age)})
    age = "" if looked.report_age is None else f"   {ago(looked.report_age)}"
    stale = "" if looked.reports == NEW else "   OLD"
    for name in _OF_REPORT:
        if found[name] is not None:
            yield f"{name:12} {found[name]}{age}{stale}"
    yield from _rows({"position": _aged(looked.position, looked.fix_age)})
    yield from _rows({name: found[name] for name in ("latitude", "longitude")})
    if (guess := found["estimate"]) is not None and looked.position != NEW:
        within = f" within {guess['within_m']:g} m (95 %)" if "within_m" in guess else ""
        yield f"{'estimate':12} {guess['latitude']} {guess['longitude']}{within}, " \
              f"{guess['from_last_fix_m']} m from the last fix"  # fmt: skip
    for name, left in (found["margins"] or {}).items():
        unit = name.rpartition("_")[2]
        shown = "not known" if left is None else f"{left:g} {unit.replace('v', 'V')}"
        if left is None and name == "time_min":
            continue  # no mission is under way
        old = stale if name in _REPORTED and left is not None else ""
        yield f"to {name.partition('_')[0]:9} {shown}{old}"
    yield from _rows({"store": _HELD if found["store"] == "running" else found["store"]})
    yield from _rows({name: found[name] for name in _OF_STORE})


def _rows(found: Mapping[str, Any]) -> Iterator[str]:
    for name, value in found.items():
        if value not in (None, ""):
            yield f"{name:12} {value}"


def _aged(words: str, age: float | None) -> str:
    return f"{words}, {ago(age)}" if words == NEW and age is not None else words


def bearing(heading: float | None, places: int) -> float | None:
    """Return degrees from 0 to below 360, also after rounding. ``heading`` in rad."""
    rounded = _degrees(heading, places)
    return None if rounded is None else rounded % 360.0


def _degrees(angle: float | None, places: int) -> float | None:
    return None if angle is None else round(math.degrees(angle), places)
