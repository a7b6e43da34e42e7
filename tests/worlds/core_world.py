"""The core of serve between two boats with faulty links and a simulated vehicle, in lock step.

    boats (upload.Conversation) --link that loses, doubles, garbles, cuts--> OnBoard <--> vehicle

What does not live here: what is asked of it (test_serve_core).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from random import Random

from links.base import Rx
from links.simulated.faults import FAULTS
from links.simulated.link import START, SimulatedVehicle
from links.simulated.sea import Sea
from links.simulated.settings import Settings
from mission.authoring.language import digest, parse, script
from mission.model import Step, Tx
from mission.model.shipped import load_vehicle
from mission.onboard.runtime.runtime import VEHICLE
from mission.topside.upload import Conversation, Script
from mission.verification.campaign.disturbances import TOPSIDE, Act
from mission.verification.campaign.onboard import FillableStore, OnBoard
from mission.verification.campaign.trial import Done, Event, Heard, Said

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
        self.connected = False
        self.talk: Conversation | None = None
        self.sends: Known | None = None  # what ``talk`` uploads, if it does


class CoreWorld:
    def __init__(self, profile: str, seed: int) -> None:
        self.profile, self.rng = profile, Random(seed)
        self.vehicle = replace(load_vehicle("auv"), dialect=profile)
        self.sea = SimulatedVehicle(profile, seed, Settings(Sea((0.1, 1.0), floor=20.0)))
        self.store = FillableStore()
        self.board = OnBoard(
            self.vehicle, self.store, START.timestamp(), self.steps_on, lambda estimate: None
        )
        self.faults = Faults()
        self.boats = (Boat("boat"), Boat("other boat"))
        self.events: list[Event] = []
        self.delivered = b""  # to the program, by the boats, in the current call
        self.now = 0.0
        self.finished: list[Boat] = []
        self.board.boot(0.0, 0.0)
        self.connect(self.boats[0])

    def steps_on(self, step: Step) -> None:
        self.events.append(step)

    @property
    def runtime(self):
        return self.board.runtime

    # --- boats -----------------------------------------------------------------------------------

    def connect(self, boat: Boat) -> None:
        if self.board.lives:
            boat.connected = True
            self.out(self.board.connected(TOPSIDE, boat.name, self.now))

    def part(self, boat: Boat) -> None:
        boat.connected, boat.talk = False, None
        self.out(self.board.disconnected(TOPSIDE, boat.name, self.now))

    def hold(self, boat: Boat, talk: Script, sends: Known | None = None) -> Conversation:
        boat.talk, boat.sends = Conversation(talk), sends
        self.say(boat, boat.talk.begin(self.now))
        return boat.talk

    def say(self, boat: Boat, frames: list[bytes]) -> None:
        for frame in frames:
            for data in self.faults.of(frame, self.rng):
                self.deliver(boat, data)

    def deliver(self, boat: Boat, data: bytes) -> None:
        if not boat.connected or not data:
            return
        self.delivered += data
        self.events.append(Said(self.now, TOPSIDE, boat.name, data))
        self.out(self.board.receive(Rx(self.now, TOPSIDE, data, boat.name), self.now))

    # --- the loop --------------------------------------------------------------------------------

    def out(self, sent: list[Tx]) -> None:
        for tx in sent:
            self.events.append(tx)
            if tx.link == VEHICLE:
                self.sea.vehicle_link.send(tx.data, self.now)
            for boat in self.boats:
                if (tx.link, tx.address) == (TOPSIDE, boat.name) and boat.connected:
                    self.heard_by(boat, tx.data)
        self.look_for_death()

    def heard_by(self, boat: Boat, data: bytes) -> None:
        for piece in self.faults.of(data, self.rng):
            if boat.talk is not None and not boat.talk.over:
                self.say(boat, boat.talk.receive(piece, self.now))

    def next_event(self) -> float:
        dues = [self.sea.vehicle_link.next_event(), self.sea.gps_link.next_event()]
        dues.append(self.board.next_timer())
        dues += [b.talk.next_timer() for b in self.boats if b.talk is not None]
        return max(self.now, min((t for t in dues if t is not None), default=math.inf))

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while (event := self.next_event()) <= end:
            self.now = event
            for rx in self.sea.vehicle_link.receive(event):
                self.events.append(Heard(event, rx.data))
                self.out(self.board.receive(rx, event))
            for rx in self.sea.gps_link.receive(event):
                self.out(self.board.receive(rx, event))
            due = self.board.next_timer()
            if due is not None and due <= event:
                self.out(self.board.handle_timer(event))
            for boat in self.boats:
                due = boat.talk.next_timer() if boat.talk else None
                if boat.talk is not None and due is not None and due <= event:
                    self.say(boat, boat.talk.handle_timer(event))
        self.now = end

    # --- the program -----------------------------------------------------------------------------

    def look_for_death(self) -> None:
        """Whoever died inside a write loses its connections."""
        if not self.board.lives and any(boat.connected for boat in self.boats):
            self.die()

    def die(self) -> None:
        self.board.kill()
        self.events.append(Done(self.now, Act.KILL))
        for boat in self.boats:
            boat.connected = False

    def boot(self) -> None:
        if not self.board.lives:
            self.events.append(Done(self.now, Act.BOOT))
            self.board.boot(self.now, 0.5)

    # --- the vehicle -----------------------------------------------------------------------------

    def fail(self, name: str) -> None:
        row = FAULTS[name]
        row.begin(self.sea, row.value)

    def mend(self, name: str) -> None:
        row = FAULTS[name]
        row.end(self.sea, row.value)
