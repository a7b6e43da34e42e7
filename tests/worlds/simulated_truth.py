"""Flights of the simulated vehicle, open loop, and what the estimate made of their bytes.

    surface   15 s until the first fix; with ``learning`` three legs at the surface under fixes
    dive      600 s of legs at 3 to 15 m: gear, heading and depth drawn from the seed
    ascent    until 20 s after the first fix that comes again

Current 0 to 0.5 m/s, compass bias to 10 deg, declination as the magnetic model has it there.

    python tests/worlds/simulated_truth.py 500            the full sample (fixes | one: half of it)
    python tests/worlds/simulated_truth.py 500 one waves  the same, in waves
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from random import Random

import numpy as np

from links.simulated.link import SimulatedVehicle, Truth
from links.simulated.sea import Sea
from links.simulated.sensors import SensorErrors
from links.simulated.settings import Settings
from mission.model import Estimate, Position
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from mission.navigation import LocalFrame, Navigation
from mission.navigation.model import Figures, Markov, figures
from protocol.messages import Fix, Order, Setpoint, Telemetry
from protocol.nmea import NmeaDecoder
from protocol.vehicles.auv import AuvCodec

HOME = Position(30.2874595, 120.1535765)
CHI2_95 = 5.991
_FOR_EVER = 1e9  # s
KINDS = {"fixes": True, "one": False}  # whether there is time to learn before the dive
Built = Callable[[str, int, Settings], SimulatedVehicle]


@dataclass(frozen=True, slots=True)
class Leg:
    begin: float
    setpoint: Setpoint | Order


@dataclass(slots=True)
class Flight:
    """NEES by state group at every report under water, and the error when fixes came again."""

    nees: dict[str, list[float]] = field(default_factory=dict)
    dof: dict[str, int] = field(default_factory=dict)
    fix_nis: list[float] = field(default_factory=list)
    inside: list[bool] = field(default_factory=list)
    error: float = math.nan  # m, just before the first fix after the dive
    distance: float = 0.0  # m, over ground under water

    def add(self, group: str, value: float, dof: int) -> None:
        self.nees.setdefault(group, []).append(value)
        self.dof[group] = dof


def _waves(rng: Random) -> tuple[float, float]:
    return rng.uniform(0.2, 0.75), rng.uniform(3.5, 12.0)


def plan(rng: Random, *, learning: bool) -> list[Leg]:
    legs, t = [], 15.0
    if learning:
        for _ in range(3):
            gear = rng.choice((6, 8))
            legs.append(Leg(t, Setpoint(surge=gear / 12, heading=rng.uniform(0.0, 2.0 * math.pi))))
            t += rng.uniform(40.0, 70.0)
    dive, depth = t, rng.uniform(3.0, 15.0)
    while t < dive + 600.0:
        depth = rng.uniform(3.0, 15.0) if rng.random() < 0.3 else depth
        heading, gear = rng.uniform(0.0, 2.0 * math.pi), rng.choice((6, 8, 8, 10))
        legs.append(Leg(t, Setpoint(surge=gear / 12, heading=heading, depth=round(depth))))
        t += rng.uniform(60.0, 160.0)
    legs.append(Leg(t, Order.STOP))
    return legs


def calibrated(vehicle: Vehicle, scale: float) -> Vehicle:
    """With the noise that the simulated sensors have, and a speed table that is off by ``scale``."""
    e = SensorErrors()
    return replace(
        vehicle,
        sensors=replace(
            vehicle.sensors,
            depth=math.hypot(e.depth_noise, 0.05),
            altitude=e.altitude_noise,
            heading=e.compass_noise,
            heading_bias=math.radians(10.0) / math.sqrt(3.0),  # as large as what is drawn
        ),
        calibration=replace(
            vehicle.calibration,
            speed_scale=scale,
            speed_noise=0.025,  # the table's shape, from gear to gear
            speed_time=150.0,
            surface_drift=1e-4,  # no wind, no waves
            sway_noise=0.007,  # of the hull on a steady course: 0.7 %, for some ten seconds
            deviation_sigma=e.deviation / math.sqrt(2.0),  # an amplitude
            compass_wander=e.compass_slow,
            compass_wander_time=300.0,
        ),
    )


def truthful(vehicle: Vehicle) -> Figures:
    """The simulated sea has a steady current and a flat floor, the compass a steady bias."""
    known = figures(vehicle)
    return replace(
        known,
        current=Markov(known.current.sigma, _FOR_EVER),
        compass=Markov(known.compass.sigma, _FOR_EVER),
        slope=0.003,
        ground_velocity=SensorErrors().speed_noise,
    )


def fly(seed: int, profile: str, *, learning: bool, waves: bool = False) -> Flight:
    rng = Random(seed)
    sea = Sea(current=(rng.uniform(0.0, 0.5), rng.uniform(0.0, 2.0 * math.pi)))
    if waves:
        sea = replace(sea, waves=_waves(Random(f"waves {seed}")))
    errors = SensorErrors(
        declination=math.radians(-6.2), compass_bias=math.radians(rng.uniform(-10.0, 10.0))
    )
    ship = SimulatedVehicle(profile, seed, Settings(sea=sea, errors=errors))
    legs, flight = plan(rng, learning=learning), Flight()
    vehicle = calibrated(load_vehicle("auv"), math.exp(rng.gauss(0.0, 0.1)))
    nav, frame = Navigation(vehicle, HOME, figures=truthful(vehicle)), LocalFrame(HOME)
    surfaced = math.inf
    dive = next(leg.begin for leg in legs if _depth(leg) is not None)
    end = legs[-1].begin
    was = (0.0, 0.0)
    for item in _bytes(ship, legs, profile, end + 240.0):
        if not math.isnan(flight.error) and item.t > surfaced + 20.0:
            break
        if isinstance(item, Fix):
            core = nav.core
            if item.t > end and math.isnan(flight.error):
                estimate, truth = nav.estimate(item.t), ship.track[round(item.t)]
                assert estimate is not None
                flight.error = math.dist((estimate.north, estimate.east), _place(truth, frame))
                surfaced = item.t
            before = core.fix_nis
            nav.fix(item)
            if core.fix_nis is not None and core.fix_nis != before:
                flight.fix_nis.append(core.fix_nis)
            continue
        nav.telemetry(item)
        truth = ship.track[round(item.t)]
        here = _place(truth, frame)
        if dive + 20.0 < item.t < end:
            flight.distance += math.dist(was, here)
            estimate = nav.estimate(item.t)
            assert estimate is not None
            _judge(flight, estimate, truth, here)
        was = here
    return flight


@dataclass(frozen=True, slots=True)
class Flown:
    items: tuple[Telemetry | Fix, ...]
    truth: tuple[Truth, ...]  # one a second


def fly_plan(seed: int, bias_deg: float, *, learning: bool) -> Flown:
    """What came in, for those who look at it afterwards."""
    rng = Random(seed)
    sea = Sea(current=(rng.uniform(0.0, 0.3), rng.uniform(0.0, 2.0 * math.pi)))
    errors = SensorErrors(declination=math.radians(-6.2), compass_bias=math.radians(bias_deg))
    return _flown(rng, seed, Settings(sea=sea, errors=errors), learning=learning)


def flown(
    seed: int, settings: Settings, *, learning: bool, built: Built = SimulatedVehicle
) -> Flown:
    """The same in a sea that is given; ``built``: the vehicle in it."""
    return _flown(Random(seed), seed, settings, learning=learning, built=built)


def _flown(
    rng: Random, seed: int, settings: Settings, *, learning: bool, built: Built = SimulatedVehicle
) -> Flown:
    ship = built("as-built", seed, settings)
    legs = plan(rng, learning=learning)
    items = tuple(_bytes(ship, legs, "as-built", legs[-1].begin + 120.0))
    return Flown(items, tuple(ship.track))


def _depth(leg: Leg) -> float | None:
    return leg.setpoint.depth if isinstance(leg.setpoint, Setpoint) else None


def _place(truth: Truth, frame: LocalFrame) -> tuple[float, float]:
    return frame.to_local(truth.latitude, truth.longitude)


def _bytes(
    ship: SimulatedVehicle, legs: Sequence[Leg], profile: str, stop: float
) -> Iterator[Telemetry | Fix]:
    """Commands out at their times, everything else in, through the real decoders."""
    codec, gps, second, waiting = AuvCodec(profile), NmeaDecoder(), 0, list(legs)
    while second < stop:
        while waiting and waiting[0].begin <= second:
            for frame in codec.encode(waiting.pop(0).setpoint):
                ship.vehicle_link.send(frame, ship.now)
                ship.advance(ship.now + 0.1)
        now = second + 0.8
        items: list[object] = []
        for link, decoder in ((ship.vehicle_link, codec), (ship.gps_link, gps)):
            for rx in link.receive(now):
                items += decoder.receive(rx.data, rx.t)
        items += gps.flush(now)
        found = [i for i in items if isinstance(i, Telemetry | Fix)]
        yield from sorted(found, key=lambda i: i.t)
        second += 1


def _judge(flight: Flight, e: Estimate, truth: Truth, here: tuple[float, float]) -> None:
    dn, de = here[0] - e.north, here[1] - e.east
    a, b, d = e.covariance
    position = (d * dn * dn - 2.0 * b * dn * de + a * de * de) / (a * d - b * b)
    flight.add("position", position, 2)
    flight.inside.append(position < CHI2_95)
    s = e.sigmas
    cn, ce = truth.current[0] - e.current_north, truth.current[1] - e.current_east
    flight.add("current", (cn * cn + ce * ce) / s["current"] ** 2, 2)
    assert e.heading is not None
    turned = math.remainder(truth.heading - e.heading, 2.0 * math.pi)
    flight.add("heading", (turned / s["heading"]) ** 2, 1)
    flight.add("speed", ((truth.speed - e.speed) / s["speed"]) ** 2, 1)
    assert e.depth is not None
    assert e.depth_rate is not None
    flight.add("depth", ((truth.depth - e.depth) / s["depth"]) ** 2, 1)
    flight.add("depth rate", ((truth.depth_rate - e.depth_rate) / s["depth_rate"]) ** 2, 1)
    if e.altitude is not None:
        flight.add("altitude", ((truth.altitude - e.altitude) / s["altitude"]) ** 2, 1)


@dataclass(frozen=True, slots=True)
class Summary:
    """Means over flights; ``nees`` is divided by its degrees of freedom: 1 is honest."""

    flights: int
    nees: dict[str, float]
    bounds: dict[str, tuple[float, float]]  # 95 %, were every flight one independent sample
    coverage: float
    nis: float
    error_pct: tuple[float, float]  # median and 95th, of the distance under water


def sum_up(flights: Sequence[Flight]) -> Summary:
    from scipy.stats import chi2

    n, nees, bounds = len(flights), {}, {}
    for group in flights[0].nees:
        dof = flights[0].dof[group]
        known = [f.nees[group] for f in flights if group in f.nees]
        nees[group] = float(np.mean([np.mean(v) for v in known]) / dof)
        low, high = chi2.ppf((0.025, 0.975), dof * len(known)) / (dof * len(known))
        bounds[group] = float(low), float(high)
    pct = [100.0 * f.error / f.distance for f in flights if not math.isnan(f.error)]
    return Summary(
        flights=n,
        nees=nees,
        bounds=bounds,
        coverage=float(np.mean([i for f in flights for i in f.inside])),
        nis=float(np.mean([v for f in flights for v in f.fix_nis]) / 2.0),
        error_pct=(float(np.median(pct)), float(np.percentile(pct, 95))),
    )


def main(seeds: int, kinds: Sequence[bool], *, waves: bool) -> None:
    """Odd seeds fly as built, even ones as documented."""
    for learning in kinds:
        flights = [
            fly(i, ("documented", "as-built")[i % 2], learning=learning, waves=waves)
            for i in range(seeds)
        ]
        s = sum_up(flights)
        groups = ", ".join(
            f"{g} {v:.2f} ({s.bounds[g][0]:.2f}..{s.bounds[g][1]:.2f})" for g, v in s.nees.items()
        )
        sys.stdout.write(
            f"{'fixes before' if learning else 'one fix'}: {s.flights} flights; "
            f"ellipse {s.coverage:.3f}; NIS/dof {s.nis:.2f}; error {s.error_pct[0]:.1f} % "
            f"median, {s.error_pct[1]:.1f} % 95th; NEES/dof {groups}\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    count, asked = next(filter(str.isdigit, sys.argv[1:]), "500"), set(sys.argv[1:])
    main(
        int(count),
        [learning for word, learning in KINDS.items() if word in asked] or [*KINDS.values()],
        waves="waves" in asked,
    )
