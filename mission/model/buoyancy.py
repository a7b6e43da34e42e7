"""What X rests on: that the vehicle rises with nothing turning, and how well that is known.

The figure is the vehicle file's ``ascent_buoyancy``; the float test measures it. What does not live
here: the measuring (navigation.floating), the file (vehicle_file).
"""

from __future__ import annotations

from datetime import date

from mission.model.vehicle import Vehicle

OLD = 90  # days: ballast, hull and water are others by then
_BY_FLIGHT = "fly float-test, then auvmission calibrate"
_BY_HAND = (
    "let it go some metres deep, time its rise, and set ascent_buoyancy and ascent_measured in the "
    "vehicle file"
)


def learn(vehicle: Vehicle) -> str:
    """How the figure is measured: the shipped float test is in the words of document 000."""
    return _BY_FLIGHT if vehicle.codec == "auv" else _BY_HAND


def rises(vehicle: Vehicle) -> bool:
    """Whether it rises by itself; True for what drives on the ground and need not."""
    return vehicle.drives or vehicle.ascent_buoyancy > 0.0


def heavy(vehicle: Vehicle) -> str:
    """Why nothing may be flown that counts on it, and what to do; "" if it rises."""
    if rises(vehicle):
        return ""
    return (
        f"{vehicle.name} does not rise by itself ({told(vehicle)}): X would leave it down there; "
        f"take ballast out, {learn(vehicle)}"
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
        return f"its rise by buoyancy alone is {told(vehicle)}: {learn(vehicle)}"
    if not 0 <= days <= OLD:
        return f"its rise by buoyancy alone is {told(vehicle)}, {days} days ago: {learn(vehicle)}"
    return ""
