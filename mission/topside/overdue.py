"""Overdue vehicles: when a vehicle is overdue, and where to search for it.

    Plan (proved worst time, range, current assumed) + start + last contact --now--> words

A vehicle is overdue after its proved latest time at the surface, if nothing was received since that
time, or for ``AGAIN_S`` from a vehicle that was not up. Where it may be:

    under way when last heard   around home: the proved range, and the drift from the time on at
                                which it is up at the latest; without a home around the contact
    at the surface or stopped   around the contact: its own uncertainty, and the drift since then

The vehicle drifts with the current that it estimated, and by the assumed current to any side. So
the area is an ellipse: that of the estimate, moved and enlarged. Sans-IO; times are wall times, s
since 1970 UTC.

What does not live here: what is kept between two commands, and which dive a path leads to (dives).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TYPE_CHECKING, Any

from mission.model import AUTONOMOUS, Position
from mission.model.alarms import ago
from mission.navigation import distribution
from mission.navigation.geodesy import LocalFrame

if TYPE_CHECKING:
    from mission.authoring.check import Proved
    from mission.authoring.prepare import Prepared

AGAIN_S = 600.0  # of silence, from a vehicle heard after its time and not up
LATE_S = 5.0  # after a start: so long, reports from before it may still arrive
UNSURE_M = 30.0  # 95 % radius of a fix of unknown accuracy
BY_HAND = "manual"
SWIMS = (AUTONOMOUS, BY_HAND)
OVER = ("idle", "emergency/surfaced")  # it is up, and was heard


@dataclass(frozen=True, slots=True)
class Plan:
    """What was proved of an uploaded mission. ``current``: m/s, the greatest that is assumed."""

    name: str
    worst_s: float
    range_m: float
    current: float
    home: tuple[float, float] | None = None  # degrees


@dataclass(frozen=True, slots=True)
class Contact:
    """When the vehicle answered last, and what it knew then.

    ``covariance``: of its position (nn, ne, ee), m^2. ``current``: its estimate, m/s north and
    east. ``mission``: the first 16 digits of the digest of its mission. ``began``: when that began,
    if known."""

    wall: float
    state: str
    latitude: float | None = None  # degrees
    longitude: float | None = None
    covariance: tuple[float, float, float] | None = None
    current: tuple[float, float] = (0.0, 0.0)
    mission: str = ""
    began: float | None = None

    @property
    def is_under_way(self) -> bool:
        return self.state.startswith(AUTONOMOUS)

    @property
    def is_over(self) -> bool:
        return self.state.startswith(OVER)


@dataclass(frozen=True, slots=True)
class Dive:
    """``started``: None if it is not known to be under way. ``mission``: its digest, as of a
    contact."""

    started: float | None = None
    plan: Plan | None = None
    contact: Contact | None = None
    mission: str = ""

    @property
    def due(self) -> float | None:
        """When the vehicle is at the surface at the latest."""
        return (
            None if self.started is None or self.plan is None else self.started + self.plan.worst_s
        )

    def goes_on(self, plan: Plan | None, wall: float) -> bool:
        """Whether a start at ``wall`` continues this dive: the stick has interrupted it since it
        began."""
        if self.started is None or self.due is None or self.contact is None:
            return False
        by_hand = self.contact.wall >= self.started and self.contact.state.startswith(BY_HAND)
        return by_hand and self.plan == plan and wall <= self.due


@dataclass(frozen=True, slots=True)
class Area:
    """An ellipse; ``bearing`` of its long axis, degrees from north."""

    latitude: float
    longitude: float
    long_m: float  # half axes
    short_m: float
    bearing: float

    def __str__(self) -> str:
        place = f"{self.latitude:.5f} {self.longitude:.5f}"
        if self.long_m - self.short_m < 1.0:
            return f"within {self.long_m:.0f} m of {place}"
        return (
            f"around {place}: {self.long_m:.0f} m towards {self.bearing:03.0f} and "
            f"{(self.bearing + 180) % 360:03.0f} deg, {self.short_m:.0f} m across"
        )


def plan_of(prepared: Prepared, proved: Proved) -> Plan:
    """Return what the boat must know if the vehicle does not come back."""
    mission, home = prepared.mission, prepared.mission.home
    return Plan(
        mission.name,
        proved.worst_time,
        proved.max_range,
        mission.current(prepared.vehicle.current),
        None if home is None else (home.latitude_deg, home.longitude_deg),
    )


def contact_with(state: Mapping[str, Any], wall: float, began: float | None = None) -> Contact:
    """Make a contact of a monitor's state at ``wall``; ``began``: when its mission began."""
    covariance = None
    if (ellipse := state.get("ellipse")) is not None:
        great, small = (float(axis) / distribution.PLANE_95 for axis in ellipse[:2])
        covariance = distribution.of_principal(great, small, math.radians(ellipse[2]))
    north, east = state.get("current") or (0.0, 0.0)
    place = state.get("latitude"), state.get("longitude")
    return Contact(
        wall,
        str(state.get("state") or AUTONOMOUS),
        *place,
        covariance,
        (north, east),
        str(state.get("mission") or ""),
        began,
    )


def heard(dive: Dive, contact: Contact) -> Dive:
    """Return the dive after this contact: it is over if the vehicle is up or has another mission. A
    contact is ignored if it is from before the start (or up to ``LATE_S`` after it, if it would end
    the dive) or from before the last contact."""
    known = -math.inf if dive.contact is None else dive.contact.wall
    is_another = bool(contact.mission and dive.mission) and contact.mission != dive.mission
    ends = contact.is_over or is_another
    if dive.started is not None:
        counts = max(dive.started + (LATE_S if ends else 0.0), known)
        if contact.wall < counts:
            return dive
    if ends:
        return Dive(None, dive.plan, contact, dive.mission)
    return replace(dive, contact=contact)


def silent_for(dive: Dive, now: float) -> float:
    """Return the time since the last contact, s; inf if there was none."""
    return math.inf if dive.contact is None else max(0.0, now - dive.contact.wall)


def overdue(dive: Dive, now: float) -> str:
    """Describe an overdue vehicle; "" if it is not overdue, or if that is not known."""
    due, silent = dive.due, silent_for(dive, now)
    if due is None or now <= due or silent < min(now - due, AGAIN_S):
        return ""
    since = f"it was to be up {ago(now - due)} at the latest, heard {ago(silent)}"
    area = search_area(dive, now)
    return f"{since}; search {area}" if area else f"{since}; nobody knows where"


def moment(due: float, now: float) -> str:
    """Say when it is up at the latest, in this computer's local time."""
    clock = datetime.fromtimestamp(due).astimezone().strftime("%H:%M:%S")
    left = f"in {(due - now) / 60.0:.0f} min" if due > now else ago(now - due)
    return f"{clock} at the latest, {left}"


def search_area(dive: Dive, now: float) -> Area | None:
    """Return where it may be at ``now``; None if no position is known. A contact from before the
    start gives a position, but does not show what followed."""
    plan, contact = dive.plan, dive.contact
    if plan is None:
        return None
    began = -math.inf if dive.started is None else dive.started
    swam = contact is None or contact.wall < began or contact.state.startswith(SWIMS)
    if swam and plan.home is not None:
        adrift = max(0.0, now - (dive.due or now))
        return _moved(plan.home, plan.range_m, None, contact, plan.current * adrift, adrift)
    if contact is None or contact.latitude is None or contact.longitude is None:
        return None
    swims = 2.0 * plan.range_m if swam else 0.0
    adrift = max(0.0, now - contact.wall)
    place = (contact.latitude, contact.longitude)
    return _moved(place, swims, contact.covariance, contact, plan.current * adrift, adrift)


def _moved(
    place: tuple[float, float],
    radius: float,
    covariance: tuple[float, float, float] | None,
    contact: Contact | None,
    grown: float,
    adrift: float,
) -> Area:
    """Move the area with the current; ``radius`` and ``grown`` are added to both half axes."""
    north, east = contact.current if contact is not None else (0.0, 0.0)
    latitude, longitude = LocalFrame(Position(*place)).to_geodetic(north * adrift, east * adrift)
    great, small, bearing = UNSURE_M, UNSURE_M, 0.0
    if covariance is not None:
        great, small, bearing = distribution.principal(covariance)
        great, small = distribution.PLANE_95 * great, distribution.PLANE_95 * small
    elif radius:
        great = small = 0.0
    more = radius + grown
    return Area(
        math.degrees(latitude),
        math.degrees(longitude),
        great + more,
        small + more,
        math.degrees(bearing) % 180.0,
    )
