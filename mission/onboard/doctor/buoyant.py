"""Check whether the vehicle rises by itself, as a stop (X) requires, and how well that is known."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime

from mission.model import buoyancy
from mission.model.vehicle import Vehicle
from mission.onboard.doctor.findings import Finding, fault, ok, warning


def buoyant(vehicle: Vehicle) -> Iterator[Finding]:
    says = f"rises at {buoyancy.told(vehicle)}"
    if vehicle.drives:
        return
    if buoyancy.heavy(vehicle):
        says = f"does not rise: {buoyancy.told(vehicle)}; no mission passes its check"
        yield fault("buoyancy", says, f"take ballast out, {buoyancy.learn(vehicle)}")
    elif why := buoyancy.doubt(vehicle, datetime.now(UTC).date()):
        yield warning("buoyancy", why.partition(": ")[0], buoyancy.learn(vehicle))
    else:
        yield ok("buoyancy", says)
