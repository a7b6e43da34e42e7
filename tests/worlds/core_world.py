"""The core of serve between two boats with faulty links and a simulated vehicle, in lock step.

    boats (upload.Conversation) --link that loses, doubles, garbles, cuts--> Program <--> vehicle

What does not live here: what is asked of it (test_serve_core).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from random import Random

from links.simulated.faults import FAULTS
from links.simulated.link import START
from links.simulated.sea import Sea
from links.simulated.settings import Settings
from mission.authoring.language import digest, parse, script
from mission.model import Tx
from mission.model.shipped import load_vehicle
from mission.topside.upload import Conversation, Script
from mission.verification.rig.acts import TOPSIDE, Act, Disturbance
from mission.verification.rig.lockstep import Due
from mission.verification.rig.program import FillableStore, Program
from mission.verification.rig.rig import Rig
from mission.verification.rig.vehicle import simulated

TEXT = """mission {name} vehicle auv
home 30.2874595 120.1535765
safety radius 600 time 20min depth 10 voltage 10
assume current 0.1 start 150
dive: depth {depth} heading {heading} gear 4 until depth >= {until} timeout 90
repeat 2 rows:
out: heading 90 gear 6 for 20s
back: heading 270 gear 6 for 20s
end
up: surface timeout 3min
"""


@dataclass(frozen=True, slots=True)
class Known:
    """A mission that a boat may send."""

    lines: tuple[str, ...]
    digest: str

    @classmethod
    def of(cls, **values: object) -> Known:
        mission = parse(TEXT.format(**values))
        return cls(tuple(script(mission)), digest(mission))


MISSIONS = (
    Known.of(name="one", depth=3, until=2.5, heading=0),
    Known.of(name="two", depth=4, until=3.5, heading=45),  # as many lines, nearly the same
    Known.of(name="one", depth=5, until=4.5, heading=90),
)


@dataclass(slots=True)
class Faults:
    """Of the links between boats and Pi, frame by frame; shares."""

    lost: float = 0.0
    doubled: float = 0.0
    garbled: float = 0.0
    cut: float = 0.0

    def of(self, data: bytes, rng: Random) -> list[bytes]:
        if rng.random() < self.lost:
            return []
        if rng.random() < self.garbled:
            at = rng.randrange(len(data))
            data = data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1 :]
        if rng.random() < self.cut:
            data = data[: rng.randrange(len(data))]
        return [data] * (2 if rng.random() < self.doubled else 1)


class Boat:
    def __init__(self, name: str) -> None:
        self.name = name
        self.talk: Conversation | None = None
        self.sends: Known | None = None  # what ``talk`` uploads, if it does


class CoreWorld(Rig):
    """A rig whose boats talk over links that fail."""

    def __init__(self, profile: str, seed: int) -> None:
        self.profile, self.rng = profile, Random(seed)
        self.vehicle = replace(load_vehicle("auv"), dialect=profile)
        self.store = FillableStore()
        super().__init__(
            simulated(self.vehicle, seed, Settings(Sea((0.1, 1.0), floor=20.0))),
            Program(self.vehicle, self.store, START.timestamp()),
        )
        self.faults = Faults()
        self.boats = (Boat("boat"), Boat("other boat"))
        self.delivered = b""  # to the program, by the boats, in the current call
        self.program.boot(0.0, 0.0)
        self.connect(self.boats[0])

    @property
    def runtime(self):
        return self.program.runtime

    # --- boats -----------------------------------------------------------------------------------

    def connect(self, boat: Boat) -> None:
        if self.program.lives:
            self.join(boat.name)

    def is_connected(self, boat: Boat) -> bool:
        return self.program.lives and boat.name in self.joined

    def part(self, boat: Boat) -> None:
        boat.talk = None
        self.do(Disturbance(self.now, Act.PART, address=boat.name))

    def hold(self, boat: Boat, talk: Script, sends: Known | None = None) -> Conversation:
        boat.talk, boat.sends = Conversation(talk), sends
        self.over_the_air(boat, boat.talk.begin(self.now))
        return boat.talk

    def over_the_air(self, boat: Boat, frames: list[bytes]) -> None:
        for frame in frames:
            for data in self.faults.of(frame, self.rng):
                if data and self.is_connected(boat):
                    self.delivered += data
                    self.send(self.say(TOPSIDE, boat.name, data))

    def answered(self, tx: Tx) -> list[Tx]:
        """Over the air, too, and at once."""
        boat = next(b for b in self.boats if b.name == tx.address)
        for piece in self.faults.of(tx.data, self.rng):
            if boat.talk is not None and not boat.talk.over:
                self.over_the_air(boat, boat.talk.receive(piece, self.now))
        return []

    # --- the loop --------------------------------------------------------------------------------

    def operators(self) -> Iterator[Due]:
        for boat in self.boats:
            if boat.talk is not None:
                yield boat.talk.next_timer(), partial(self._talk, boat, boat.talk)

    def _talk(self, boat: Boat, talk: Conversation) -> None:
        self.over_the_air(boat, talk.handle_timer(self.now))

    def run(self, seconds: float) -> None:
        self.run_until(self.now + seconds)

    # --- program and vehicle ---------------------------------------------------------------------

    def begin_anew(self) -> None:
        """When the test says so."""

    def boot(self) -> None:
        self.do(Disturbance(self.now, Act.BOOT))

    def die(self) -> None:
        self.do(Disturbance(self.now, Act.KILL))

    def fail(self, name: str) -> None:
        row = FAULTS[name]
        row.begin(self.sea, row.value)

    def mend(self, name: str) -> None:
        row = FAULTS[name]
        row.end(self.sea, row.value)
