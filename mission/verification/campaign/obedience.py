"""Orders must leave in time: X and W within 100 ms of being known (R7), a set within 5 s (R7).

The laws look for X and W in all bytes that came while the program ran, whatever stands around them.
In an ascent, a W leaves only once in the turn of another way, and none after the ascent has ended.
The sets are those of the Steps: a leg's, both halves of an ascent's. A set is excused that a later
order, another set, the stick or the program's death replaced in time.

What does not live here: who else asked for a byte (audit).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from mission.model import MANUAL_DRIVING, SURFACED, SURFACING, Step, Tx
from mission.onboard.runtime.runtime import VEHICLE
from mission.verification.campaign.audit import alike, command_of, commands_of
from mission.verification.rig.acts import Act
from mission.verification.rig.trace import Done, Event, Said
from protocol.messages import Order, Setpoint
from protocol.topside import EMERGENCIES
from protocol.vehicles.auv import AuvCodec

WITHIN = 0.1  # s from being known to being sent
SET = 5.1  # s: the time that a set has, and the frame that is on the line
_SAME = 1e-6  # s
_CLEAR = EMERGENCIES[Order.STOP]
_ORDER = re.compile(b"|".join(re.escape(frame) for frame in EMERGENCIES.values()))


@dataclass(frozen=True, slots=True)
class Ignored:
    t: float
    says: str


def ignored(events: Sequence[Event], dialect: str) -> list[Ignored]:
    """Return the orders and sets that did not leave in time."""
    return sorted([*orders(events), *_sets(events, dialect)], key=lambda one: one.t)


def itself(data: bytes) -> frozenset[bytes]:
    return frozenset((data,))


def orders(
    events: Sequence[Event], means: Callable[[bytes], frozenset[bytes]] = itself
) -> Iterator[Ignored]:
    """Yield ignored X and W; ``means`` returns which of them bytes to the vehicle stand for."""
    waits: tuple[Said, bytes] | None = None
    lives, leads = True, False  # a W leads the Step of another way's turn
    heard = excused = False  # W has left in that turn; had left as W came
    for event in events:
        if waits is not None and event.t > waits[0].t + WITHIN + _SAME:
            said, frame = waits
            if not ((heard or excused) and frame == EMERGENCIES[Order.SURFACE]):
                yield Ignored(said.t, f"{frame!r} of {said.address or said.link}: nothing left")
            waits = None
        match event:
            case Step():
                leads, heard = _leads(event, leads), _goes_on(event) and heard
                up = event.entered[-1:] == (SURFACED,)
                if up and waits is not None and waits[1] == EMERGENCIES[Order.SURFACE]:
                    waits = None  # the surface is proved, and everything is stopped
            case Said(data=data) if lives and (found := _ORDER.findall(data)):
                waits, excused = (event, found[-1]), heard
            case Done(act=Act.STALL):
                waits = None
            case Done(act=Act.KILL):
                waits, leads, heard, lives = None, False, False, False
            case Done(act=Act.BOOT):
                lives = True
            case Tx(link=link, data=data) if link == VEHICLE and waits is not None:
                if waits[1] in means(data):
                    heard = heard or (leads and waits[1] == EMERGENCIES[Order.SURFACE])
                    waits = None
            case _:
                pass


def _leads(step: Step, before: bool) -> bool:
    """Whether, after a Step, a W has to leave before the way in use."""
    if commands := commands_of(step):
        return commands[0] is Order.SURFACE and len(commands) > 1
    return before and _goes_on(step)


def _goes_on(step: Step) -> bool:
    """Whether the turn of the way continues after a Step."""
    is_left = step.entered and step.entered[-1] != SURFACING
    return not (is_left or commands_of(step))


def _sets(events: Sequence[Event], dialect: str) -> Iterator[Ignored]:
    """Yield the sets that did not leave in time.

    A newer set of the same leg has the remaining time of the set before. The X0 at the head of a
    set that steers does not count: it has nothing to clear.
    """
    encode = AuvCodec(dialect).encode
    since, owed = 0.0, list[bytes]()
    for event in events:
        if owed and event.t > since + SET + _SAME:
            yield Ignored(since, f"{owed[0]!r}: it did not leave within {SET:g} s")
            owed = []
        match event:
            case Step(t=t, actions=(*_, words), entered=entered):
                command = command_of(words)
                is_set = isinstance(command, Setpoint)
                since = since if owed and not entered else t
                owed = [f for f in encode(command) if f != _CLEAR] if is_set else []
            case Step(entered=(*_, state)) if state == MANUAL_DRIVING:
                owed = []
            case Done(act=Act.KILL | Act.STALL):
                owed = []
            case Tx(link=link, data=data) if link == VEHICLE:
                owed = [frame for frame in owed if not alike(frame, data)]
            case _:
                pass
