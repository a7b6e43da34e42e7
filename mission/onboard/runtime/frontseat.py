"""The path to the STM32: one line, one command outstanding, safety first. Sans-IO, no clock.

    1  STOP, SURFACE  --> urgent --+
    2  setpoints --> queue --------+--> line (20 ms after the end of the frame before) --> STM32
    3  relays (M, R, @DA/@DS) -----+        one Z outstanding; 300 ms, 3 tries (R1)

The smaller number has the line first: an order, retries of an unacknowledged frame, both frames of
an ascent (X0 and U12), a leg's set. Relays get the time that is left. They wait while an
acknowledgement is pending, because a board that is busy with a relay may miss the retries. Without
acknowledgements one relay leaves every 2 s. Under the stick there are no sets; M has their rank.

Rules of docs/rules.md that live here: R1 (stop and wait), R7's overtaking (the queue is dropped, an
unacknowledged Z is given up), the as-built ACK code ``A`` for any Z, and the gap without which two
frames arrive as one burst and are misread. A set that has not left completely after 5 s, even if
newer sets of the same leg have replaced it, is reported as LATE, once.

An ACK of code A does not say which Z it answers. After a Z was given up or sent twice, another ACK
may still come. Until it has come, or can no longer come (300 ms), an ACK of code A does not count
for the next frame, and the next setpoint waits. STOP and SURFACE do not wait: at worst they are
sent once more.

The U12 of an ascent is repeated automatically: once after its ACK, and as long as there is no ACK,
until something else is commanded. A board that is busy with the X0 before it misses all three
tries, and an X0 that is acknowledged twice answers for both. Relays leave between these repeats and
may keep the board busy, so the timeout of these tries is longer.

What does not live here: what the commands mean and the R8 consequence of three lost Z (engine),
which relay is next (relays), frames (protocol.vehicles), bytes on the port (links).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

from mission.model import Action, Outcome, Result, Tx
from mission.onboard.runtime.relays import Relays, channels_of
from mission.onboard.runtime.restated import Restated, TakeOutputs, no_outputs
from protocol.codec import CannotEncode
from protocol.messages import UPWARD, Ack, Order, Outputs, Setpoint, Telemetry
from protocol.vehicles.auv import change

ANSWER_S = 0.3
TRIES = 3
AGAIN_S = 1.5  # s after the tries of an ascent's U12, until it is repeated
LONGER_S = 0.5  # s, the timeout then: three tries outlast a board that is busy for 0.9 s
HELD_S = 2.0  # s that unacknowledged frames hold relays back: three tries of two frames, and some
GAP_S = 0.02
BITS_PER_BYTE = 10  # 8N1
BITS_PER_S = 9600
LEAVES_S = 5.0  # s within which a set must have left
ANY = "A"  # as-built firmware acknowledges every Z with this code


@dataclass(frozen=True, slots=True)
class _Frame:
    data: bytes
    command: Setpoint | Order
    reason: str
    again: bool = False  # it was sent before, and acknowledged or lost

    @property
    def lifts(self) -> bool:
        return self.command == UPWARD and self.code == "U"

    @property
    def code(self) -> str:
        return chr(self.data[3]) if len(self.data) > 3 else ""


@dataclass(frozen=True, slots=True)
class _Outstanding:
    frame: _Frame
    tries: int
    deadline: float


@dataclass(frozen=True, slots=True)
class _Owed:
    """An ACK that may still come for a transmission that nobody waits for any more."""

    code: str
    until: float


class Frontseat:
    """Turns Actions and relays into bytes at the right time, and ACKs into Outcomes.

    A frame that a newer set or a safety command replaced before its ACK has no Outcome.
    """

    gap = GAP_S  # s that the line needs between two frames

    def __init__(
        self,
        encode: Callable[[Setpoint | Order], list[bytes]],
        link: str = "vehicle",
        bits_per_s: float = BITS_PER_S,
        take_outputs: TakeOutputs = no_outputs,
    ) -> None:
        self._encode, self._link = encode, link
        self._take_outputs, self._outputs = take_outputs, Restated()
        self._seconds_per_byte = BITS_PER_BYTE / bits_per_s
        self._urgent: deque[_Frame] = deque()
        self._relays = Relays()
        self._queue: deque[_Frame] = deque()
        self._outstanding: _Outstanding | None = None
        self._owed: list[_Owed] = []
        self._becoming: Setpoint | None = None  # nothing of it was refused or lost so far
        self._held: Setpoint | None = None  # all of it was accepted, and nothing sent since
        self._set: Setpoint | None = None  # the newest
        self._late_at: float | None = None  # when a set is late, unless all of it has left
        self._order: Order | None = None  # the newest command, if it is an order
        self._again: tuple[float, _Frame] | None = None  # what is repeated, and when
        self._sent_at = self._row_from = -math.inf  # a frame that is acknowledged; a row of them
        self._free = 0.0  # when the line is free

    @property
    def halfway(self) -> bool:
        """Whether frames of a set, or the second of an ascent, wait behind those that have left."""
        return bool(self._urgent or self._queue)

    @property
    def idle(self) -> bool:
        """Whether nothing waits to be sent or acknowledged."""
        return self.said_all and self._outstanding is None and self._again is None

    @property
    def said_all(self) -> bool:
        """Like ``idle``, but without the automatic repeats."""
        waiting = self._outstanding
        waits = self._urgent or self._queue or self._relays.waiting or self._outputs.words
        return not waits and (waiting is None or waiting.frame.again)

    def command(self, action: Action) -> Outcome | None:
        """Queue an action; return an Outcome only if the vehicle has no command for it."""
        try:
            if isinstance(action.command, Outputs):
                self._outputs.add(self._take_outputs(action.command), action.reason)
                return None
            data = self._encode(action.command)
        except CannotEncode as error:
            return Outcome(Result.REFUSED, str(error).encode(), action.command)
        if action.steers and self._held is not None:
            data = change(data, self._encode(self._held))
        frames = [_Frame(d, action.command, action.reason) for d in data]
        self._held = self._again = None
        before, self._set = self._set, None
        if isinstance(action.command, Setpoint):
            self._set = action.command
        self._becoming = self._set
        if not action.steers and self._set != before:
            self._late_at = None  # another leg, or none
        self._queue.clear()  # a set is complete: the rest of the one before is obsolete
        before_it, self._order = self._order, None
        if isinstance(action.command, Order):
            self._order = action.command
            if self._order != before_it:  # relays behind it may leave while it is repeated
                self._relays.clear()
            self._give_up()
            same = (f for f in self._urgent if f.reason == action.reason)  # of the same decision
            self._urgent = deque([*(f for f in same if f.command != action.command), *frames])
        else:
            self._queue.extend(frames)
        return None

    def cannot_relay(self, frame: bytes) -> str:
        """Always "": R, M and D are this board's own commands."""
        return ""

    def relay(self, data: bytes, reason: str, manual: bool = False) -> str:
        """Pass a frame on unchanged; why not, "" if it will leave. A manual one cancels every Z,
        also the stop of a silent stick: a retry of it would end the STM32's manual mode (R6)."""
        if manual:
            self._queue.clear()
            self._urgent.clear()
            self._give_up()
            self._held = self._becoming = self._set = self._late_at = self._order = None
            self._again = None
        if why := self._relays.add(data, reason, manual):
            return why
        self._outputs.give_way(channels_of(data))
        return ""

    def report(self, report: Telemetry) -> None:
        """Nothing to do: this board closes its loops itself."""

    def answer(self, ack: Ack, now: float) -> Outcome | None:
        """The Outcome by an ACK of group Z; None if it answers no outstanding frame."""
        self._owed = [owed for owed in self._owed if owed.until > now]
        owed = next((o for o in self._owed if ack.function in (ANY, o.code)), None)
        if owed is not None:
            self._owed.remove(owed)
            return None
        waiting = self._outstanding
        if waiting is None or ack.function not in (ANY, waiting.frame.code):
            return None
        self._outstanding = None
        self._owed += [_Owed(waiting.frame.code, waiting.deadline)] * (waiting.tries - 1)
        result = Result.ACCEPTED if ack.ok else Result.REFUSED
        self._becoming = self._becoming if ack.ok else None
        if not self._queue:
            self._held = self._becoming
        if not waiting.frame.again:
            self._say_again(waiting.frame, now)
        return Outcome(result, waiting.frame.data, waiting.frame.command)

    def poll(self, now: float) -> tuple[list[Tx], list[Outcome]]:
        """Send what is due (at most one frame: the gap follows it), and give up lost frames. A loss
        is reported before anything else leaves, because it may lead to an order."""
        waiting = self._outstanding
        if waiting is None and self.idle:
            return [], []
        if self._queue and self._late_at is None:
            self._late_at = now + LEAVES_S
        if self._queue and self._late_at is not None and now >= self._late_at:
            self._late_at = math.inf
            return [], [Outcome(Result.LATE, self._queue[0].data, self._queue[0].command)]
        if waiting and now >= waiting.deadline and waiting.tries >= TRIES:
            self._outstanding = self._becoming = None
            self._say_again(waiting.frame, now)
            return [], [Outcome(Result.LOST, waiting.frame.data, waiting.frame.command)]
        return (self.next_out(now) if now >= self._free else []), []

    def next_out(self, now: float) -> list[Tx]:
        waiting, again = self._outstanding, self._again
        if waiting and now >= waiting.deadline:
            return [self._send(waiting.frame, waiting.tries + 1, now)]
        if waiting is None and self._urgent:
            return [self._send(self._urgent.popleft(), 1, now)]
        if waiting is None and self._queue and not any(o.until > now for o in self._owed):
            frame = self._queue.popleft()
            self._late_at = self._late_at if self._queue else None
            return [self._send(frame, 1, now)]
        if waiting is None and again and now >= again[0]:
            self._again = None
            return [self._send(again[1], 1, now)]
        return self._pass_on(now) if now >= self._passes_on_at else []

    @property
    def _passes_on_at(self) -> float:
        """When relays may leave, if the line is free."""
        return -math.inf if self._outstanding is None else self._row_from + HELD_S

    def _pass_on(self, now: float) -> list[Tx]:
        word = self._outputs.take(now) or (self._relays.take() if self._relays else None)
        if word is None:
            return []
        self._row_from = now
        return [self._transmit(*word, now)]

    def next_timer(self) -> float | None:
        """When ``poll`` has something to do."""
        waiting, first = self._outstanding, math.inf
        others = max(self._free, self._passes_on_at)
        if self._relays.waiting or (waiting is None and self._urgent):
            first = others
        if (said := self._outputs.next_timer()) is not None:
            first = min(first, max(others, said))
        if self._queue and self._late_at is not None:
            first = min(first, self._late_at)
        if waiting:
            # The last wait ends by the clock alone; another try needs the line.
            last = waiting.tries >= TRIES
            first = min(first, waiting.deadline if last else max(self._free, waiting.deadline))
        elif self._again is not None:
            first = min(first, max(self._free, self._again[0]))
        elif self._queue:
            first = min(first, max([self._free, *(owed.until for owed in self._owed)]))
        return first if first < math.inf else None

    def _send(self, frame: _Frame, tries: int, now: float) -> Tx:
        if now - self._sent_at > 2 * ANSWER_S:
            self._row_from = now
        self._sent_at = now
        self._owed = [owed for owed in self._owed if owed.until > now]  # no board may ever answer
        answer = LONGER_S if frame.again else ANSWER_S
        self._outstanding = _Outstanding(frame, tries, now + answer)
        again = f" (try {tries} of {TRIES})" if tries > 1 else ""
        return self._transmit(frame.data, frame.reason + again, now)

    def _transmit(self, data: bytes, reason: str, now: float) -> Tx:
        self._free = now + len(data) * self._seconds_per_byte + GAP_S
        return Tx(now, self._link, data, reason)

    def _say_again(self, frame: _Frame, now: float) -> None:
        if frame.lifts:
            reason = frame.reason if frame.again else f"{frame.reason} (held)"
            self._again = now + AGAIN_S, replace(frame, reason=reason, again=True)

    def _give_up(self) -> None:
        if self._outstanding:
            owed = _Owed(self._outstanding.frame.code, self._outstanding.deadline)
            self._owed += [owed] * self._outstanding.tries
            self._outstanding = None
