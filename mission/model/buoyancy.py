"""The rise of the vehicle with no thruster on, which X relies on, and how well it is known.

The figure is the vehicle file's ``ascent_buoyancy``; the float test measures it. What does not live
here: the measurement (analysis.floating), the file (vehicle_file).
"""

from __future__ import annotations

from datetime import date

from mission.model.vehicle import Vehicle

OLD = 90  # days, after which ballast, hull and water may have changed
_BY_FLIGHT = "fly float-test, then auvmission calibrate"
_BY_HAND = (
    "let it go some metres deep, time its rise, and set ascent_buoyancy and ascent_measured in the "
    "vehicle file"
)


def learn(vehicle: Vehicle) -> str:
    """Return how to measure the figure; the shipped float test uses commands of document 000."""
    return _BY_FLIGHT if vehicle.codec == "auv" else _BY_HAND


def rises(vehicle: Vehicle) -> bool:
    """Whether it rises by itself; True if it drives on the ground and need not rise."""
    return vehicle.drives or vehicle.ascent_buoyancy > 0.0


def heavy(vehicle: Vehicle) -> str:
    """Return why no mission may be flown, and what to do; "" if the vehicle rises."""
    if rises(vehicle):
        return ""
    return (
        f"{vehicle.name} does not rise by itself ({told(vehicle)}): X would leave it down there; "
        f"take ballast out, {learn(vehicle)}"
    )


def told(vehicle: Vehicle) -> str:
    """The figure and its source, in words."""
    day = vehicle.ascent_measured
    since = f"measured {day}" if day else "a planning figure, never measured"
    return f"{vehicle.ascent_buoyancy:g} m/s, {since}"


def age(vehicle: Vehicle, today: date) -> int | None:
    """Days since the float test; None where there was none."""
    day = vehicle.ascent_measured
    return (today - date.fromisoformat(day)).days if day else None


def doubt(vehicle: Vehicle, today: date) -> str:
    """Return why the figure needs a new float test; "" if it does not."""
    days = age(vehicle, today)
    if vehicle.drives:
        return ""
    if days is None:
        return f"its rise by buoyancy alone is {told(vehicle)}: {learn(vehicle)}"
    if not 0 <= days <= OLD:
        return f"its rise by buoyancy alone is {told(vehicle)}, {days} days ago: {learn(vehicle)}"
    return ""
