"""Overdue: a vehicle that should be up by proof, of which nothing was heard since, or nothing any
more though it was not up, and where it may be.

    Plan (proved worst time, range, current assumed) + start + last contact --now--> words

    under way when last heard   around home: the proved range, and what the sea does from then on
                                when it is up at the latest; without a home around the contact
    at the surface or stopped   around the contact: its own uncertainty, and what the sea does since

The sea takes it along with the current that it had estimated, and with as much as was assumed to
any side. So the area is an ellipse: that of the estimate, moved and grown. Sans-IO; times are of
the wall clock, s since 1970 UTC.

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

AGAIN_S = 600.0  # of silence, of one that was heard behind its time and was not up
LATE_S = 5.0  # behind a start what was told before it may still come
UNSURE_M = 30.0  # 95 % of a fix whose accuracy nobody tells
BY_HAND = "manual"
SWIMS = (AUTONOMOUS, BY_HAND)
OVER = ("idle", "emergency/surfaced")  # it is up, and was heard


@dataclass(frozen=True, slots=True)
class Plan:
    """What was proved of the mission that was uploaded. ``current``: m/s, assumed at most."""

    name: str
    worst_s: float
    range_m: float
    current: float
    home: tuple[float, float] | None = None  # degrees


@dataclass(frozen=True, slots=True)
class Contact:
    """When the vehicle answered last, and what it knew. ``covariance``: m^2 of its place (nn, ne,
    ee); ``current``: m/s north and east, as it had estimated it. ``mission``: the digest of what it
    holds, its first 16 digits; ``began``: when that began, where it tells."""

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
    """``started``: None where it is not known to be under way. ``mission``: its digest, as that of
    a contact."""

    started: float | None = None
    plan: Plan | None = None
    contact: Contact | None = None
    mission: str = ""

    @property
    def due(self) -> float | None:
        """When it is at the surface at the latest."""
        return (
            None if self.started is None or self.plan is None else self.started + self.plan.worst_s
        )

    def goes_on(self, plan: Plan | None, wall: float) -> bool:
        """By a start at ``wall``: the stick has interrupted it, as was heard since it began."""
        if self.started is None or self.due is None or self.contact is None:
            return False
        by_hand = self.contact.wall >= self.started and self.contact.state.startswith(BY_HAND)
        return by_hand and self.plan == plan and wall <= self.due


@dataclass(frozen=True, slots=True)
class Area:
    """An ellipse; ``bearing`` is that of its long axis, degrees from north."""

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
    """What the boat has to know where the vehicle does not come back."""
    mission, home = prepared.mission, prepared.mission.home
    return Plan(
        mission.name,
        proved.worst_time,
        proved.max_range,
        mission.current(prepared.vehicle.current),
        None if home is None else (home.latitude_deg, home.longitude_deg),
    )


def contact_with(state: Mapping[str, Any], wall: float, began: float | None = None) -> Contact:
    """What a monitor's state says, at ``wall``; ``began``: when its mission did."""
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
    """The dive after this contact: over where the vehicle is up, or flies another mission. What was
    told before the start says nothing of what came of it (it may come up to ``LATE_S`` behind it),
    nor what was told before the last one, by whatever way."""
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
    """s since the last contact; inf: there was none."""
    return math.inf if dive.contact is None else max(0.0, now - dive.contact.wall)


def overdue(dive: Dive, now: float) -> str:
    """In words, "" while it is not, or where nobody knows."""
    due, silent = dive.due, silent_for(dive, now)
    if due is None or now <= due or silent < min(now - due, AGAIN_S):
        return ""
    since = f"it was to be up {ago(now - due)} at the latest, heard {ago(silent)}"
    area = search_area(dive, now)
    return f"{since}; search {area}" if area else f"{since}; nobody knows where"


def moment(due: float, now: float) -> str:
    """When it is up at the latest, in the local time of this computer."""
    clock = datetime.fromtimestamp(due).astimezone().strftime("%H:%M:%S")
    left = f"in {(due - now) / 60.0:.0f} min" if due > now else ago(now - due)
    return f"{clock} at the latest, {left}"


def search_area(dive: Dive, now: float) -> Area | None:
    """Where it may be at ``now``; None: no place is known. What was heard before the start tells
    a place, and nothing of how it went on."""
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
    """``radius`` and ``grown`` are added to both half axes."""
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
