"""The sea of one rehearsed flight, drawn from the mission's assumptions and the vehicle file.

    current        uniform over the disc with the radius of `assume current`
    compass bias   normal about the bias in the vehicle file, with the sigma that is there
    speed          normal, one sigma half of what the check allows (thrust ~ speed squared)
    buoyancy       normal, one sigma a tenth of what the simulated vehicle has
    floor          that of `assume floor`, else the simulator's own

Everything else (noise, slow errors, when the receiver finds its first fix) follows from the seed.
Drawn values are texts of ``simulate --set``, so that any flight can be flown again. A setting that
is given as such a text has that value in every flight, and is not drawn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random

from mission.authoring.check.assumptions import SPEED_SHARE, TWO_SIGMA
from mission.model import Mission
from mission.model.vehicle import Vehicle
from mission.verification.rig.vehicle import body_of


def sea_of(
    mission: Mission, vehicle: Vehicle, seed: int, number: int, given: Sequence[str]
) -> tuple[str, ...]:
    """Return the settings of flight ``number``: those drawn, except for the keys in ``given``, then
    ``given``."""
    keys = {_key(text) for text in given}
    kept = (text for text in drawn(mission, vehicle, seed, number) if _key(text) not in keys)
    return (*kept, *given)


def _key(text: str) -> str:
    return text.partition("=")[0].strip()


def drawn(mission: Mission, vehicle: Vehicle, seed: int, number: int) -> tuple[str, ...]:
    """Draw the settings of flight ``number``, as texts; the same for the same arguments."""
    rng = Random(f"{seed}/{number}")
    speed = mission.current(vehicle.current) * math.sqrt(rng.random())
    towards = rng.uniform(0.0, 360.0)
    bias = math.degrees(rng.gauss(vehicle.compass_bias, vehicle.sensors.heading_bias))
    thrust = (1.0 + max(-0.5, rng.gauss(0.0, SPEED_SHARE / TWO_SIGMA))) ** 2
    buoyancy = max(0.3, rng.gauss(1.0, 0.1)) * body_of(vehicle.codec).buoyancy
    texts = [
        f"current={speed:.3f}@{towards:.0f}",
        f"compass_bias={bias:.1f}",
        f"thrust={thrust:.3f}",
        f"buoyancy={buoyancy:.1f}",
    ]
    floor = dict(mission.assume).get("floor")
    return (*texts, f"floor={floor:g}") if floor is not None else tuple(texts)
