"""What X rests on: that the vehicle rises with nothing turning, and how well that is known.

The figure is the vehicle file's ``ascent_buoyancy``; the float test measures it. What does not live
here: the measuring (navigation.floating), the file (vehicle_file).
"""

from __future__ import annotations

from datetime import date

from mission.model.vehicle import Vehicle

OLD = 90  # days: ballast, hull and water are others by then
LEARN = "fly float-test, then auvmission calibrate"


def rises(vehicle: Vehicle) -> bool:
    """By itself; what drives on the ground has no need to."""
    return vehicle.drives or vehicle.ascent_buoyancy > 0.0


def heavy(vehicle: Vehicle) -> str:
    """Why nothing may be flown that counts on it, and what to do; "" if it rises."""
    if rises(vehicle):
        return ""
    return (
        f"{vehicle.name} does not rise by itself ({told(vehicle)}): X would leave it down there; "
        f"take ballast out, {LEARN}"
    )


def told(vehicle: Vehicle) -> str:
    """The figure, and where it is from."""
    day = vehicle.ascent_measured
    since = f"measured {day}" if day else "a planning figure, never measured"
    return f"{vehicle.ascent_buoyancy:g} m/s, {since}"


def age(vehicle: Vehicle, today: date) -> int | None:
    """Days since the float test; None where there was none."""
    day = vehicle.ascent_measured
    return (today - date.fromisoformat(day)).days if day else None


def doubt(vehicle: Vehicle, today: date) -> str:
    """Why the figure is not to be relied on without a new float test; "" if it is."""
    days = age(vehicle, today)
    if vehicle.drives:
        return ""
    if days is None:
        return f"its rise by buoyancy alone is {told(vehicle)}: {LEARN}"
    if not 0 <= days <= OLD:
        return f"its rise by buoyancy alone is {told(vehicle)}, {days} days ago: {LEARN}"
    return ""
