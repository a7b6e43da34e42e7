"""Every word of the mission language, flown without what it waits for: no fix, no arrival, a guard
that never holds, a sensor that is stuck or silent, ``else`` taken.

The check bounds what can happen, not what is likely. So each row of the language's tables has
missions. (A word without one fails a test; leg types and variables have theirs in their own rows.)
Each mission is flown at the edge of the assumptions: the whole current, the farthest start, the
deepest floor, the compass and the speed as far off as they may be, and something withheld to the
end of the flight.

What does not live here: the laws of a flight (proofs), the words themselves (language.words).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from random import Random

from links.simulated.sea import Sea
from links.simulated.sensors import Health, Sensor, SensorErrors
from links.simulated.settings import FaultEvent, Settings
from mission.authoring.check import check_mission
from mission.authoring.check.assumptions import Assumptions
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.engine.variables import VARIABLES
from mission.legs import LEGS
from mission.legs.base import WAY
from mission.legs.guidance import GIVES
from mission.model.vehicle import Vehicle
from mission.verification.campaign.draw import profiles_of
from mission.verification.campaign.proofs import BIAS, SPEED, Claim, Draw, Proof, draw_proof
from mission.verification.campaign.staging import faults_of
from mission.verification.campaign.trial import FOREVER
from mission.verification.rig.vehicle import body_of

HEAD = (
    "mission {name} vehicle auv\nhome 30.2874595 120.1535765\n"
    "safety radius 400 time 30min depth 30\n"
)
_TO = "goto north 60 east 0 gear 8 depth 4"
_SENSORS = (Sensor.DEPTH, Sensor.ALTITUDE, Sensor.HEADING, Sensor.ATTITUDE)
_HELD = (Sensor.DEPTH, Sensor.ALTITUDE)  # stuck and noisy, they look healthy
_NO_FIX = "gps_lost"
SOURCE = "--word"  # on the command line of the campaign, with its number

SETTINGS: Mapping[str, tuple[str, ...]] = {
    "depth": (
        "a: depth 5 gear 4 heading 0 for 60\nb: depth 2 gear 4 heading 0 for 30",
        "assume floor 8\na: depth 6 never below altitude 3 gear 4 heading 0 for 60",
    ),
    "altitude": ("a: altitude 3 gear 4 heading 0 for 90",),
    "up": ("a: gear 0 down 8 for 20\nb: up 8 for 20",),
    "down": ("a: gear 0 down 8 for 30", "a: gear 0 down 8 until depth > 6 timeout 60"),
    "heading": (f"a: {WAY} for 20\nb: heading 180 for 40",),
    "gear": ("a: gear 10 heading 0 for 30\nb: gear 0 heading 0 for 20", "a: gear -6 for 20"),
    "speed": ("a: speed 0.75 m/s heading 0 depth 3 for 30",),
    "left": ("a: gear 0 left 6 for 20",),
    "right": ("a: gear 0 right 6 for 20",),
}
# What this vehicle cannot do or report: the compiler refuses these words.
REFUSED: Mapping[str, str] = {
    "pitch": "a: pitch 5 for 20",
    "roll": "a: roll 5 for 20",
    "leak": f"a: {WAY} until leak > 0 timeout 20",
    "output": f"a: {WAY} output lamp 80 for 20",
}
CLAUSES: Mapping[str, tuple[str, ...]] = {
    "until": (
        f"a: {WAY} until travelled >= 20 until depth > 9 -> c timeout 40\nc: heading 90 for 10",
    ),
    "for": (f"a: {WAY} for 15\nb: heading 90 for 15",),
    "timeout": (f"a: {WAY} until range > 900 timeout 30",),
    "else": (
        f"a: {WAY} until altitude < 1 timeout 40 else b\nb: heading 180 for 20",
        "a: altitude 3 gear 4 heading 0 until range > 900 timeout 60 else b\n"
        "b: depth 2 gear 4 heading 0 for 15",
    ),
    "achieve": (
        "a: rows 2 bearing 90 length 20 spacing 10 within 5 swath 20 gear 6 depth 4 "
        "achieve coverage 1% timeout 60",
    ),
}
ASSUMPTIONS: Mapping[str, tuple[str, ...]] = {
    "current": (f"assume current 0.5\na: {WAY} for 40", f"assume current 0\na: {WAY} for 40"),
    "floor": ("assume floor 8\na: altitude 3 gear 4 heading 0 for 60",),
    "start": (f"assume start 150\na: {WAY} for 30", f"assume start 0\na: {WAY} for 30"),
}
_BAY = "north -130 east -130, north -130 east 130, north 900 east 130, north 900 east -130"
STATEMENTS: Mapping[str, tuple[str, ...]] = {
    # Areas as near as the check allows.
    "keep": (
        "keep out bar: north 170 east -399, north 170 east 399, north 900 east 0\n"
        f"keep in bay: {_BAY}\na: heading 0 gear 8 depth 4 for 40",
    ),
    "repeat": (
        f"repeat 3 r:\n a: {WAY} until range > 900 timeout 15\n b: heading 180 for 15\nend",
    ),
    "on": (
        f"a: {WAY} for 30\nb: heading 180 for 30\non depth > 3 held 4s -> b",
        f"a: {WAY} for 30\nb: surface until fix timeout 90\non uncertain -> b",
        f"a: {WAY} until range > 900 timeout 20\nb: heading 90 for 20\n"
        "c: surface timeout 60 else surface\non timeout -> c",
    ),
    "start": (f"start without fix\na: {WAY} for 30",),
}


def drawn_for(claim: Claim, flight: int) -> Draw:
    """Return how a flight is drawn: withheld for every word, and every third time for a mission."""
    return draw_withheld if claim.source.startswith(SOURCE) or flight % 3 == 2 else draw_proof


def missions() -> Iterator[tuple[str, str]]:
    """Yield every word with each of its mission texts."""
    kinds = {row.name: row.trials for row in LEGS.values()}
    for table in (kinds, SETTINGS, CLAUSES, ASSUMPTIONS, STATEMENTS):
        for word, bodies in table.items():
            for body in bodies:
                yield word, body
    for row in VARIABLES.values():
        way = _TO if row.name in GIVES else WAY
        if row.trial:
            yield row.name, f"a: {way} until {row.trial} timeout 40"


def claims(vehicle: Vehicle) -> Iterator[Claim]:
    """Yield what the check proves of each mission."""
    for number, (word, body) in enumerate(missions()):
        yield claim_of(vehicle, word, body, number)


def claim_of(vehicle: Vehicle, word: str, body: str, number: int) -> Claim:
    """Return what the check proves. Raises ValueError if it refuses: these tables are wrong."""
    mission = parse(f"{HEAD.format(name=f'{word}-{number}')}{body}\n")
    report = check_mission(compile_mission(mission, vehicle, digest(mission)), vehicle)
    if not report.ok or report.proved is None:
        raise ValueError(f"{word}: the check refuses {body!r}: {report.refusals}")
    return Claim(f"{SOURCE} {number}", mission, report.proved)


def draw_withheld(claim: Claim, vehicle: Vehicle, seed: int, flight: int) -> Proof:
    """Draw a flight at the edge of the assumptions, with something withheld to the end."""
    rng = Random(f"withheld {seed} {claim.mission.name} {flight}")
    allowed = claim.mission.safety.depth or vehicle.limits.depth
    assume = Assumptions.of(claim.mission, vehicle, min(allowed, vehicle.limits.depth))
    sea = Sea((assume.current, _direction(rng)), None, assume.floor)
    of, body = claim.mission.vehicle, body_of(claim.mission.vehicle)
    edge = math.sqrt(body.main_thrust) * (1.0 + 2.0 * SPEED * rng.choice((-1.0, 0.0, 1.0)))
    errors = SensorErrors(compass_bias=2.0 * BIAS * rng.choice((-1.0, 0.0, 1.0)))
    away, towards = 0.9 * assume.start, _direction(rng)
    of_vehicle = rng.randrange(1 << 31)
    lost = [fault for fault in _withheld(rng, claim) if fault.name in faults_of(of)]
    return Proof(
        profiles_of(of)[flight % len(profiles_of(of))],
        of_vehicle,
        Settings(sea, errors, replace(body, main_thrust=edge * edge), tuple(lost)),
        (),
        (away * math.cos(towards), away * math.sin(towards)),
        rng.uniform(0.0, math.tau),
        (),
    )


def _direction(rng: Random) -> float:
    """Return north, where most of the texts lead, or any of eight directions, rad."""
    return rng.choice((0.0, rng.choice(range(8)) * math.tau / 8.0))


def _withheld(rng: Random, claim: Claim) -> Iterator[FaultEvent]:
    """Yield the fault of a sensor, if any, and the loss of the fixes.

    The fixes are not lost along with the depth: then nothing would prove the surface.
    """
    begin = round(rng.uniform(10.0, 12.0 + 0.5 * claim.proved.worst_time), 1)
    sensor = rng.choice((*_SENSORS, None))
    if sensor is not None:
        ways = [h.value for h in Health if h is not Health.HEALTHY]
        ways += ["stuck"] if sensor in _HELD else []
        yield FaultEvent(f"{sensor.name.lower()}_{rng.choice(ways)}", begin, FOREVER)
    if sensor is not Sensor.DEPTH:
        yield FaultEvent(_NO_FIX, begin, FOREVER)
