"""The audit of every byte that went to the STM32: who asked for it?

A frame is asked for by a recorded Step, or by an operator's own bytes. The audit ignores the
reasons in the Tx. It applies these rules in the order of the events:

    @ZA...   It belongs to the command of the newest Step that has one. Each frame of that command
             leaves at most three times (R1). A newer set leaves an older frame only its remaining
             tries; a newer order or the stick leaves it none (R6, R7). No @ZA leaves while the
             stick is held.
    @M @D @R An operator sent it within the last ``RELAYED`` s, plus ``UNHEARD`` s for each relay
             that waited before it and may stay unanswered. It leaves once, byte for byte. An @M
             leaves only while the stick has the vehicle.
    a Step   Its state must allow its command: a set only in a leg. ``stopped`` needs an X;
             surfacing a W, a limit, a restart, an ordered end or a forgotten stick; manual an M;
             a start an @AA that is no copy by modem (R12). Only an M of the stick's holder keeps
             the stick alive, not one of others or by modem (R6, R12). A stop is repeated only
             until the STM32 acknowledges it, after a report shows that a thruster still turns,
             or after the line was disconnected. While two or more frames may still be answered,
             an acknowledgement need not be believed: it may answer the older frame.

What does not live here: whether a limit was right to act (the engine's tests), outcomes that a
flight must not have (laws).
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mission.engine.ascent import DOWNWARD
from mission.model import (
    AUTONOMOUS,
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    Step,
    Tx,
)
from mission.onboard.runtime.command_target import MODEM, Peer
from mission.onboard.runtime.runtime import VEHICLE
from mission.verification.campaign.permits import STALE, Permit
from mission.verification.campaign.reports import decoded
from mission.verification.rig.acts import Act
from mission.verification.rig.trace import Done, Event, Heard, Said
from protocol.messages import UPWARD, Manual, Order, Setpoint
from protocol.modem import Sender, wrap
from protocol.topside import TopsideCodec
from protocol.vehicles.auv import ACTUATORS, SD, AuvCodec

_STOPS = (
    STOPPED,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    IDLE_READY,
    SURFACED,
)  # each needs an acknowledged stop of its own
TRIES = 3  # R1
ANSWER = 0.3  # s within which a frame is answered (R1)
UNHEARD, MOST = 2.0, 32  # s between relays without an answer (R7); relays that may wait
RELAYED = 10.0  # s: 32 relays of 60 ms, after 0.9 s of tries, and a modem's idle time
HEARD = 2.0  # s from bytes to their Step: an unfinished frame before them (G3), the modem
STICK = 2.0  # s (R6)
UNBELIEVED = 3  # acknowledgements that may belong to earlier frames (as built, code A)
COPY = 120.0  # s that a copy may be late (R12)
_SAME = 1e-3  # s

_FRAME = re.compile(rb"@ZA([A-Z])(-?\d*)[,;]?(-?\d*)\$")
_RELAYED = re.compile(rb"@[MRD][^@$]{0,60}\$")
_X, _W, _AA = re.compile(rb"@ZAX0\$"), re.compile(rb"@ZAWF\$"), re.compile(rb"@AA\$")
_ENVELOPES = frozenset({wrap(b"@AA$", Sender.TOPSIDE)})
_STOPPED_ACK = re.compile(rb"@ACK_Z[XA]Y\$")
_LONGEST = 64
_THRUSTERS = tuple(f"pwm_{name}" for name in ACTUATORS[:5])
_NEUTRAL = 10  # us
_ORDERS = {"everything stopped": Order.STOP, "emergency surfacing": Order.SURFACE}
_ANGLES = ("heading", "pitch", "roll")


@dataclass(frozen=True, slots=True)
class Spurious:
    t: float
    says: str


def command_of(words: str) -> Setpoint | Order:
    """Return the command in a Step's action text, without its reason.

    Raises TypeError or ValueError for a text that is no command.
    """
    text = words.partition(":")[0]
    if text in _ORDERS:
        return _ORDERS[text]
    parts = text.split()
    values = {name: float(value) for name, value in zip(parts[::2], parts[1::2], strict=True)}
    turned = {n: math.radians(v) if n in _ANGLES else v for n, v in values.items()}
    return Setpoint(**turned)


def commands_of(step: Step) -> list[Setpoint | Order]:
    """Return the commands of a Step, without its outputs. Raises what ``command_of`` raises."""
    return [command_of(words) for words in step.actions if not words.startswith("output ")]


def audit(events: Sequence[Event], dialect: str) -> list[Spurious]:
    """Return everything that was sent without a cause, in order."""
    return list(_Auditor(dialect).walk(events))


def moves_asked(events: Sequence[Event]) -> list[Spurious]:
    """Return the moves that nothing asked for, of a vehicle with other commands than the AUV."""
    return list(_MoveAuditor("documented").walk(events))


_Said = tuple[float, Peer, int]  # when, from whom, and how many earlier ones waited then


class _Auditor:
    def __init__(self, dialect: str) -> None:
        self._encode = AuvCodec(dialect).encode
        self._state = ""
        self._permits: list[Permit] = []
        self._relays: dict[bytes, deque[_Said]] = {}  # what operators sent, oldest first
        self._sticks: dict[Peer, float] = {}  # the last M of each
        self._holder: Peer | None = None  # whose M the vehicle follows
        self._tails: dict[Peer, bytes] = {}
        self._last: dict[re.Pattern[bytes], float] = {}
        self._starts: deque[tuple[float, bool]] = deque(maxlen=64)  # each @AA; whether a copy
        self._booted = -math.inf
        self._acks = 0  # of a stop, since the newest reason to stop
        self._sent_at: deque[float] = deque(maxlen=2)  # the newest frames to the vehicle
        self._stalled: float | None = None
        self._answered_at = self._mute_at = -math.inf  # last answer; relay after an unanswered one
        self._ends = False  # the program was told to end
        self._holds = False  # in surfaced, after an ascent that ended without a stop

    def walk(self, events: Sequence[Event]) -> Iterator[Spurious]:
        for event in events:
            match event:
                case Said():
                    self._said(event)
                case Heard():
                    if not event.data.startswith(b"@SD"):
                        self._answered_at = event.t
                    if not self._may_be_of_two(event.t):
                        self._acks += len(_STOPPED_ACK.findall(event.data))
                    if _turns(event.data):
                        self._acks = 0
                case Done(t=t, act=Act.STALL):
                    self._stalled = t if self._stalled is None else self._stalled
                case Done(t=t, act=Act.RUN):
                    self._run_again(t)
                case Done(t=t, act=Act.KILL | Act.BOOT):
                    self._stalled = None
                    self._permits, self._relays, self._tails = [], {}, {}
                    self._state, self._booted, self._acks, self._ends = "", t, 0, False
                    self._starts.clear()
                case Done(act=Act.END):
                    self._ends = True
                case Done(act=Act.PLUG):
                    self._acks = 0  # nobody knows which frames they answered
                case Step():
                    yield from self._step(event)
                case Tx(link=link) if link == VEHICLE:
                    self._sent_at.append(event.t)
                    yield from self._sent(event)
                case _:
                    pass

    def _may_be_of_two(self, t: float) -> bool:
        return len(self._sent_at) == 2 and t - self._sent_at[0] <= ANSWER

    def _run_again(self, t: float) -> None:
        """Shift by the length of the stall everything that was due during it."""
        late, self._stalled = t - (t if self._stalled is None else self._stalled), None
        for permit in self._permits:
            permit.ends += late
        for frame, said in self._relays.items():
            self._relays[frame] = deque((t + late, peer, ahead) for t, peer, ahead in said)
        for pattern in (_X, _W, _AA):
            if pattern in self._last:
                self._last[pattern] += late

    # --- asked for -----------------------------------------------------------------------------

    def _said(self, said: Said) -> None:
        peer = Peer(said.link, said.address)
        stream = self._tails.get(peer, b"") + said.data
        fresh = len(stream) - len(said.data)
        for found in _RELAYED.finditer(stream):
            if found.end() > fresh:
                ahead = sum(map(len, self._relays.values()))
                self._relays.setdefault(found[0], deque()).append((said.t, peer, ahead))
                if said.link != MODEM and found[0].startswith(b"@M") and moves(found[0]):
                    self._sticks[peer] = said.t
        for pattern in (_X, _W, _AA):
            if any(found.end() > fresh for found in pattern.finditer(stream)):
                self._last[pattern] = said.t
        if _AA.search(said.data) and (said.link != MODEM or said.data in _ENVELOPES):
            meant = [at for at, copy in self._starts if not copy and COPY > said.t - at > 0.0]
            self._starts.append((said.t, said.link == MODEM and bool(meant)))
        self._tails[peer] = stream[-_LONGEST:]

    def _was_said(self, pattern: re.Pattern[bytes], t: float, within: float = HEARD) -> bool:
        return t - self._last.get(pattern, -math.inf) <= within

    def _is_copy(self, t: float) -> bool:
        """Whether every recent @AA came by modem, after one that was no copy (R12)."""
        recent = [copy for at, copy in self._starts if t - at <= HEARD]
        return bool(recent) and all(recent)

    def _is_held(self, t: float, within: float) -> bool:
        """Whether an M came in the last ``within`` s from the holder of the stick."""
        return self._holder is not None and t - self._sticks[self._holder] <= within

    def _step(self, step: Step) -> Iterator[Spurious]:
        before, moved = self._state, bool(step.entered)
        if moved:
            self._state = step.entered[-1]
        if moved and self._state == MANUAL_DRIVING:
            self._holder = max(self._sticks, key=self._sticks.__getitem__, default=None)
        try:
            commands = commands_of(step)
        except (TypeError, ValueError):
            yield Spurious(step.t, f"a step that says what is no command: {step.actions}")
            return
        self._holds = Order.STOP not in commands if moved else self._holds
        yield from self._unjustified(step, before, moved, commands)
        for command in commands:
            self._permit(command, step.t)
        if moved and self._state in _STOPS:
            self._acks = 0

    def _unjustified(
        self, step: Step, before: str, moved: bool, commands: list[Setpoint | Order]
    ) -> Iterator[Spurious]:
        state, t = self._state, step.t
        if moved and (why := self._unasked(step, before)):
            yield Spurious(t, f"{before or 'a start'} -> {state}: {why}")
        for command in commands:
            if not self._fits(command, state):
                yield Spurious(t, f"{step.actions} in {state}")
        repeats = commands == [Order.STOP] and not moved and state != SURFACING  # there X0 lets go
        if repeats and not state.startswith(AUTONOMOUS) and self._acks > UNBELIEVED:
            yield Spurious(t, f"a stop repeated in {state} after {self._acks} acknowledgements")

    def _unasked(self, step: Step, before: str) -> str:
        """Return why nobody asked for a change of state; "" if somebody did."""
        state, t = self._state, step.t
        inside = before.startswith(AUTONOMOUS)
        if state.startswith(AUTONOMOUS) and not inside and not self._was_said(_AA, t):
            return "without an @AA"
        if state.startswith(AUTONOMOUS) and not inside and self._is_copy(t):
            return "by a copy of an @AA"
        restarted = step.trigger == "restart" and t - self._booted <= _SAME
        if state == STOPPED and not (restarted or self._was_said(_X, t)):
            return "without an X"
        if state == MANUAL_DRIVING and not self._is_held(t, HEARD):
            return "without an M"
        if state == MANUAL_WAITING and not self._ends and self._is_held(t, STICK - _SAME):
            return "with an M less than 2 s ago"
        if state == SURFACING:
            limit = any(e.trigger.startswith("limit ") and e.result for e in step.evaluations)
            forgotten = step.trigger == "forgotten" and not self._is_held(t, 59.0)
            runaway = step.trigger == "limit"
            ends = step.trigger == "end" and self._ends
            if not (limit or ends or restarted or forgotten or runaway or self._was_said(_W, t)):
                return "without a W, a limit, a restart or a forgotten stick"
        return ""

    def _fits(self, command: Setpoint | Order, state: str) -> bool:
        if state.startswith(AUTONOMOUS):
            return True
        if state == SURFACING:
            return isinstance(command, Order) or command in (UPWARD, DOWNWARD)
        if state == SURFACED and self._holds and command in (UPWARD, Order.SURFACE):
            return True
        return (state != MANUAL_DRIVING or self._ends) and command is Order.STOP

    def _permit(self, command: Setpoint | Order, t: float) -> None:
        order = isinstance(command, Order)
        for permit in self._permits:
            together = permit.since == t  # of the same Step: one leaves after the other
            ended = t + _SAME if order or not permit.begun else t + STALE
            if together:
                ended = t + STALE
            if order or not permit.order:
                permit.ends = min(permit.ends, ended)
        self._permits = [p for p in self._permits if p.ends > t]
        for frame in self._encode(command):
            self._permits.append(Permit(frame, order, t, command == UPWARD and b"U" in frame))

    # --- sent ----------------------------------------------------------------------------------

    def _sent(self, tx: Tx) -> Iterator[Spurious]:
        if tx.data.startswith(b"@ZA"):
            yield from self._commanded(tx)
        else:
            yield from self._relayed(tx)

    def _commanded(self, tx: Tx) -> Iterator[Spurious]:
        live = [
            permit
            for permit in self._permits
            if tx.t <= permit.ends
            and (permit.lifts or permit.tries < TRIES)
            and alike(permit.frame, tx.data)
        ]
        for permit in live[:1]:  # the oldest that is left is on the line
            permit.sent(tx.t)
        for permit in live:
            permit.begun = True
        if not live:
            yield Spurious(
                tx.t, f"{tx.data!r} in {self._state}: no step asked for it ({tx.reason})"
            )
        if self._state == MANUAL_DRIVING and not self._ends:
            yield Spurious(tx.t, f"{tx.data!r} while the stick is held ({tx.reason})")

    def _waits(self, since: float, _: Peer, ahead: int) -> float:
        return UNHEARD * min(ahead, MOST) if self._mute_at >= since else 0.0

    def _relayed(self, tx: Tx) -> Iterator[Spurious]:
        said = self._relays.get(tx.data, deque())
        if tx.t - self._answered_at > UNHEARD - 0.1:
            self._mute_at = tx.t
        while said and tx.t - said[0][0] > RELAYED + self._waits(*said[0]):
            said.popleft()
        if not said:
            yield Spurious(tx.t, f"{tx.data!r} in {self._state}: no operator said it ({tx.reason})")
            return
        _, peer, _ = said[-1]
        said.popleft()
        if not tx.data.startswith(b"@M"):
            return
        if peer in self._sticks:
            self._holder = peer
        if self._state != MANUAL_DRIVING:
            yield Spurious(tx.t, f"{tx.data!r} relayed in {self._state}")
        for permit in self._permits:
            permit.ends = min(permit.ends, tx.t)


class _MoveAuditor(_Auditor):
    """Audits only the changes of state, for a vehicle with other commands.

    Such a vehicle ignores an M that it has no frames for, so the end of the stick is not judged.
    """

    def _unjustified(
        self, step: Step, before: str, moved: bool, commands: list[Setpoint | Order]
    ) -> Iterator[Spurious]:
        let_go = self._state == MANUAL_WAITING or step.trigger == "forgotten"
        if moved and not let_go and (why := self._unasked(step, before)):
            yield Spurious(step.t, f"{before or 'a start'} -> {self._state}: {why}")

    def _permit(self, command: Setpoint | Order, t: float) -> None:
        pass

    def _sent(self, tx: Tx) -> Iterator[Spurious]:
        yield from ()


def _turns(data: bytes) -> bool:
    """Whether the report shows one of the five thrusters on."""
    at = data.find(SD.lead)
    if at < 0 or len(data) < at + SD.length:
        return False
    values = decoded(data[at : at + SD.length])
    return any(abs(values[name] - 1500) > _NEUTRAL for name in _THRUSTERS)


def moves(frame: bytes) -> bool:
    """Whether the frame is an M with values in range: others move nothing (G4)."""
    return any(isinstance(heard, Manual) for heard in TopsideCodec().receive(frame, 0.0))


def alike(asked: bytes, sent: bytes) -> bool:
    """Whether two frames are the same. Numbers may differ by one, since a Step rounds them."""
    a, b = _FRAME.fullmatch(asked), _FRAME.fullmatch(sent)
    if asked == sent or a is None or b is None:
        return asked == sent
    near = [_near(x, y) for x, y in zip(a.groups()[1:], b.groups()[1:], strict=True)]
    return a[1] == b[1] and all(near)


def _near(a: bytes, b: bytes) -> bool:
    if not a or not b:
        return a == b
    return (int(a) - int(b)) % 360 in (0, 1, 359)
