"""Laws of the frames that leave for a board of documents 002 to 004 (R6, R14, R16, R17).

    asked     every frame is what the newest Step asks for, or under the stick what an M asks for
    stick     after 600 ms without an M, no frame pushes any more
    moves     a mission begins by an @AA that is no copy, stick control by an M, a stop by an X
    pace      while the program lives, it repeats the command in force within the period of the
              document
    orders    X and W, whoever sends them, leave within 100 ms

An output's own command moves nothing and is not judged here. Where the Pi closes the loops of
depth and heading (`outer_loop`), only the depth laws judge its efforts.

What does not live here: the audit of the AUV's commands (audit, obedience).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

from links.simulated.settings import Settings
from mission.model import MANUAL_DRIVING, Step, Tx
from mission.model.vehicle import Vehicle
from mission.onboard.runtime.runtime import VEHICLE
from mission.verification.campaign.audit import Spurious, commands_of, moves, moves_asked
from mission.verification.campaign.obedience import WITHIN, Ignored, orders
from mission.verification.campaign.trial import fault_ends
from mission.verification.rig.acts import TOPSIDE, Act
from mission.verification.rig.speech import Motion, Speech, same
from mission.verification.rig.trace import Done, Event, Said
from protocol.codec import CannotEncode
from protocol.messages import Order, Setpoint

STICK_S = 0.6  # s (R14)
G3_S = 1.1  # s that an unfinished frame may hold back the next one
RIGHTED_S = 10.0  # s until the program knows that the vehicle is upright again
SLACK_S = 0.03  # s: the frames that are still on the line
_SAME = 1e-3  # s
_M = re.compile(rb"@M[^@$]{2,10}\$")
_LONGEST = 64
_HINDERS = (Act.KILL, Act.STALL, Act.UNPLUG, Act.RUN, Act.BOOT, Act.PLUG, Act.END, Act.LEAVE)


def audit(events: Sequence[Event], vehicle: Vehicle) -> list[Spurious]:
    """Return the frames that nothing asked for, and the frames that were not repeated in time."""
    speech = Speech(vehicle)
    found = [*_Auditor(speech, vehicle).walk(events), *_pace(events, speech)]
    found += moves_asked(events)
    return sorted(found, key=lambda one: one.t)


def ignored(events: Sequence[Event], vehicle: Vehicle, settings: Settings) -> list[Ignored]:
    """Return the X and W that did not leave in time.

    W leaves as upward thrust, on the robot as a stop. Orders to a vehicle that lies upside down are
    left out: its ascent begins by letting go, and has no other bytes for W (R7).
    """
    speech = Speech(vehicle)
    w = b"@ZAU12$" if speech.lifts else b"@ZAX0$"

    def means(data: bytes) -> frozenset[bytes]:
        word = speech.word(data)
        return frozenset((word, b"@ZAWF$") if word == w else (word,))

    turned = [(f.begin, fault_ends(f)) for f in settings.faults if f.name == "capsized"]
    return [
        one
        for one in orders(events, means)
        if not any(begin <= one.t <= end + RIGHTED_S for begin, end in turned)
    ]


class _Auditor:
    def __init__(self, speech: Speech, vehicle: Vehicle) -> None:
        self._speech, self._loop = speech, vehicle.outer_loop is not None
        self._state = ""
        self._asked = self._before = speech.motions(Order.STOP)
        self._since = -math.inf
        self._first: list[Motion] = []  # all commands of the newest Step but its last (R7)
        self._free = False  # the Pi holds the depth or heading that is asked for
        self._held: list[Setpoint] = [Setpoint()]  # setpoints that the stick may hold
        self._last_m = -math.inf
        self._tails: dict[str, bytes] = {}

    def walk(self, events: Sequence[Event]) -> Iterator[Spurious]:
        for event in events:
            match event:
                case Said(link=link) if link == TOPSIDE:
                    self._said(event)
                case Done(act=Act.BOOT | Act.KILL):
                    self._state, self._free = "", False
                    self._ask(self._speech.motions(Order.STOP), event.t)
                case Step():
                    self._step(event)
                case Tx(link=link) if link == VEHICLE:
                    yield from self._sent(event)
                case _:
                    pass

    def _said(self, said: Said) -> None:
        stream = self._tails.get(said.address, b"") + said.data
        fresh = len(stream) - len(said.data)
        for found in _M.finditer(stream):
            if found.end() > fresh and moves(found[0]):
                self._steered(found[0], said.t)
        self._tails[said.address] = stream[-_LONGEST:]

    def _steered(self, word: bytes, t: float) -> None:
        if self._state != MANUAL_DRIVING and t - self._last_m > G3_S:
            self._held = [Setpoint()]
        try:
            news = [self._speech.board.stick(held, word) for held in self._held]
        except CannotEncode:
            return
        self._last_m = t
        self._held = list(dict.fromkeys([Setpoint(), *self._held, *news]))[-400:]

    def _ask(self, motions: list[Motion], t: float) -> None:
        self._before, self._asked, self._since = self._asked, motions, t

    def _step(self, step: Step) -> None:
        if step.entered:
            self._state = step.entered[-1]
        commands = commands_of(step)
        if commands:
            self._first = [m for word in commands[:-1] for m in self._speech.motions(word)]
        for command in commands:
            held, holds = self._free, isinstance(command, Setpoint)
            self._free = self._loop and holds and _is_held(command)
            self._ask(self._speech.motions(command), step.t)
            if held:  # a loop that gives up sends neutral first (R17)
                self._before = [*self._before, *self._speech.motions(Setpoint())]

    def _sent(self, tx: Tx) -> Iterator[Spurious]:
        said = self._speech.motion(tx.data)
        if not said:
            return
        if self._state == MANUAL_DRIVING:
            yield from self._under_the_stick(tx, said)
            return
        late = tx.t <= self._since + _SAME and same(self._before, said)
        late = late or (tx.t <= self._since + WITHIN and same(self._first, said))
        if not (self._free or late or same(self._asked, said)):
            yield Spurious(tx.t, f"{_shown(said)} in {self._state}: not asked for ({tx.reason})")

    def _under_the_stick(self, tx: Tx, said: Motion) -> Iterator[Spurious]:
        if same(self._speech.motions(Order.STOP), said):
            return
        allowed = (self._speech.motions(held) for held in self._held)
        if not any(same(motions, said) for motions in allowed):
            yield Spurious(tx.t, f"{_shown(said)} under the stick: no M asked for it")
        elif tx.t - self._last_m > STICK_S + G3_S:
            yield Spurious(tx.t, f"{_shown(said)} {tx.t - self._last_m:.1f} s behind the last M")


def _is_held(command: Setpoint | Order) -> bool:
    return isinstance(command, Setpoint) and not (command.depth is command.heading is None)


def _shown(said: Motion) -> str:
    return " ".join(f"{name} {value:g}" for name, value in said.items() if value)


def _pace(events: Sequence[Event], speech: Speech) -> Iterator[Spurious]:
    """Check the pace from the first motion of each run of the program on. A program that has asked
    for none yet repeats outputs only, as often as R6 says."""
    last: float | None = None
    period = speech.board.period
    for event in events:
        if isinstance(event, Done) and event.act in _HINDERS:
            last = None
        elif isinstance(event, Tx) and event.link == VEHICLE:
            if last is not None and event.t - last > period + SLACK_S:
                yield Spurious(event.t, f"nothing was said for {event.t - last:.2f} s")
            if last is not None or speech.motion(event.data):
                last = event.t
