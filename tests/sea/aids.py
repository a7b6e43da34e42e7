"""Scenes of sensors on a line of their own: Doppler log, acoustic position, range to a beacon. Their line is away,
and they come back with what they said last, for ever.
"""

from __future__ import annotations

import math
import random
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field

from tests.sea.laws import UPWARD, Law, home, lives, never_deeper, noted, quiet, reached, said
from tests.sea.leftovers import silent
from tests.sea.receiver import EARTH, HOME, sentence
from tests.sea.scene import TRUE_FIXES, Scene, Script, boat, dive, go, mission, order, own_vehicle
from tests.sea.wire import Line
from tests.sea.world import World

Steps = Iterator[None]
KNOT = 1852 / 3600  # m/s
SOUND = 1500.0  # m/s
BEACON = (-150.0, 0.0, 4.0)  # m east, north, down: behind a vehicle that goes east
RADIUS = 80.0  # m, of the operator's limit
ROOM = 5.0  # m beyond it: 95 % are not all, and a report is 2 s old


def place(east: float, north: float) -> tuple[float, float]:
    """Latitude and longitude in degrees."""
    latitude = HOME[0] + math.degrees(north / EARTH)
    return latitude, HOME[1] + math.degrees(east / EARTH) / math.cos(math.radians(HOME[0]))


def minutes(degrees: float, width: int) -> str:
    """Degrees and minutes as NMEA has them."""
    whole = int(degrees)
    return f"{whole:0{width}d}{(degrees - whole) * 60:09.6f}"


@dataclass
class Aid:
    """What speaks on a line of its own, once in `period` s: `place`, `doppler` or `range`."""

    world: World
    kind: str
    period: float = 1.0
    stands: bool = False  # it says what it said last, to the bit
    said: str = ""
    farthest: float = 0.0  # m from home, of the vehicle
    line: Line = field(default_factory=lambda: Line(9600))

    def __post_init__(self) -> None:
        self.dice = random.Random(f"aid {self.world.seed}")
        self.before = (0.0, 0.0)

    def speaks(self) -> Steps:
        """All the time."""
        world = self.world
        while True:
            yield from world.wait(self.period)
            pose = world.body.pose
            self.farthest = max(self.farthest, math.hypot(pose.x, pose.y))
            if not self.stands:
                self.said = self._value()
            self.before = (pose.x, pose.y)
            second = int(world.now) % 60
            self.line.send(world.now, sentence(self.said.replace("TIME", f"0812{second:02d}.00")))

    def _value(self) -> str:
        pose, gauss = self.world.body.pose, self.dice.gauss
        if self.kind == "place":
            latitude, longitude = place(pose.y + gauss(0, 1.5), pose.x + gauss(0, 1.5))
            where = f"{minutes(latitude, 2)},N,{minutes(longitude, 3)},E"
            return f"GPGGA,TIME,{where},1,08,1.0,0.0,M,0.0,M,,"
        if self.kind == "doppler":
            north, east = (
                (a - b) / self.period for a, b in zip((pose.x, pose.y), self.before, strict=True)
            )
            yaw = math.radians(self.world.body.attitude()[2])
            ahead = (north * math.cos(yaw) + east * math.sin(yaw) + gauss(0, 0.02)) / KNOT
            aside = (east * math.cos(yaw) - north * math.sin(yaw) + gauss(0, 0.02)) / KNOT
            return f"VDVBW,,,V,{ahead:.3f},{aside:.3f},A"
        away = math.dist((pose.y, pose.x, pose.z), BEACON) + gauss(0, 1)
        return f"CAMPR,3,1,{away / SOUND:.4f}"


def aided(world: World, kind: str) -> Generator[None, None, Aid]:
    """Begin anew with such a sensor, and with a vehicle file that knows the beacon."""
    aid = Aid(world, kind)
    aid.line.link(world.folder / "sensors0")
    world.lines.append(aid.line)
    sensors = f'  sensors: "serial://{aid.line.path}"\n  topside:'
    world.pi.config.write_text(world.pi.config.read_text().replace("  topside:", sensors))
    latitude, longitude = place(*BEACON[:2])
    beacon = f"beacons: {{3: {latitude:.7f} {longitude:.7f} {BEACON[2]:.0f} m}}"
    yield from own_vehicle(world, **{"codec: auv": f"codec: auv\n{beacon}"})
    world.spawn(aid.speaks())
    return aid


def to_the_limit(world: World, aid: Aid) -> Steps:
    """Eastward until it is told to come up; how far it came until then is noted."""
    yield from world.until(
        lambda: aid.farthest > 2 * RADIUS or bool(said(world, UPWARD, world.marks["down"])), 400
    )
    world.notes.append(f"farthest={aid.farthest:.0f}")
    world.mark("due")
    yield from world.rest(200)


def freezes(kind: str, at: float) -> Script:
    """Its line is away for 12 s, and then it says for ever what it said before; the radius is 80 m."""

    def script(world: World) -> Steps:
        aid = yield from aided(world, kind)
        yield from dive(world)
        letter = yield from boat(world).ask(f"@SP,{RADIUS:.0f},40,10,10,$", "SP")
        world.notes.append(f"limits={letter}")
        yield from world.until(lambda: aid.farthest > at, 200)
        aid.line.plugged = False
        aid.stands = True
        yield from world.wait(12)
        aid.line.plugged = True
        yield from to_the_limit(world, aid)

    return script


def from_the_deck(world: World) -> Steps:
    """The log's line is away from the start on; under way it is back, and says the speed of the deck."""
    aid = yield from aided(world, "doppler")
    yield from world.wait(8)
    aid.line.plugged = False
    aid.stands = True
    yield from dive(world)
    letter = yield from boat(world).ask(f"@SP,{RADIUS:.0f},40,10,10,$", "SP")
    world.notes.append(f"limits={letter}")
    yield from world.wait(10)
    aid.line.plugged = True
    yield from to_the_limit(world, aid)


def starts_nothing(world: World) -> Steps:
    """No receiver speaks; places from outside come each second, and a start."""
    assert world.receiver
    world.receiver.mode = "silent"
    world.receiver.dry_since = math.inf
    yield from aided(world, "place")
    yield from go(world, mission(8, 10))
    world.mark("due")
    yield from world.wait(20)


def proves_nothing(buoyancy: float) -> Script:
    """No depth any more, W, and another trim: places from outside come under water, too."""

    def script(world: World) -> Steps:
        yield from aided(world, "place")
        yield from dive(world)
        world.board.senses.depth = silent
        order(world, "@ZAWF$")
        world.body.buoyancy = buoyancy
        yield from (world.wait(260) if buoyancy < 0 else world.rest(230))

    return script


def near(limit: float) -> Law:
    """The vehicle was never farther from home than this."""

    def law(world: World) -> str:
        note = next((note for note in world.notes if note.startswith("farthest=")), "")
        far = float(note.partition("=")[2] or "inf")
        return f"{far:.0f} m from home, {limit:.0f} m allowed" if far > limit else ""

    return law


WITHIN: tuple[Law, ...] = (
    *(reached(), noted("limits=P"), near(RADIUS + ROOM), home(150)),
    *(never_deeper(16), lives()),
)
EAST = {"current": (0.0, 0.0), "yaw": 0.0}
SCENES: tuple[Scene, ...] = (
    Scene(
        "place-freezes",
        "the same to the last bit opens no gate",
        freezes("place", 25),
        WITHIN,
        body=EAST,
    ),
    Scene(
        "place-freezes-in-current",
        "the same to the last bit opens no gate",
        freezes("place", 40),
        WITHIN,
        body={"current": (0.05, 0.15), "yaw": 1.0},
    ),
    Scene(
        "doppler-freezes",
        "it is believed or not, the thrusters tell the same",
        freezes("doppler", 25),
        WITHIN,
        body=EAST,
    ),
    Scene(
        "doppler-says-the-deck",
        "a speed that stands while the vehicle's changes is frozen",
        from_the_deck,
        WITHIN,
        body=EAST,
    ),
    Scene(
        "range-freezes",
        "the same to the last bit opens no gate",
        freezes("range", 25),
        WITHIN,
        body=EAST,
    ),
    Scene(
        "place-starts-nothing",
        "a place from outside starts no mission",
        starts_nothing,
        (reached(), noted("start=N"), quiet("due"), home(1), lives()),
    ),
    Scene(
        "place-proves-nothing-heavy",
        "a place from outside proves no surface: thrust holds it within 4 m",
        proves_nothing(-4.0),
        (reached(), home(300, 4.0, off=False), never_deeper(30), lives()),
        world=TRUE_FIXES,
    ),
)
