"""The path to a board that acknowledges nothing: commands are sent periodically (R16, R17).

    newest command --> its frames, once the line is free --> the same every ``period`` --> board

The frames of the newest command leave as soon as the line is free, and then every ``period``. A
board that receives nothing for its silence time goes neutral by itself. A board that has to be kept
awake is sent a stop before there is any command. A frame that was sent counts as accepted: only
telemetry shows whether the board follows it.

An M becomes frames of the board, if it has any; after 600 ms without an M the board is sent a stop,
as the STM32 does by itself (R6). Nothing is passed on unchanged: a command for which the board has
no frames is refused, and the command in force continues (R14). An operator's W, and the ascent's
way in use that comes with it for the same reason, are sent in turn: W for one period (R7).

What does not live here: boards that acknowledge (frontseat), frames (protocol.vehicles).
"""

from __future__ import annotations

import math
from collections.abc import Callable

from mission.model import Action, Outcome, Result, Tx
from mission.onboard.runtime.outer_loop import LoopCloser
from mission.onboard.runtime.restated import Restated, TakeOutputs, no_outputs
from protocol.codec import CannotEncode
from protocol.messages import Ack, Order, Outputs, Setpoint, Telemetry

BITS_PER_BYTE = 10  # 8N1
BITS_PER_S = 115200
STICK_S = 0.6  # R6
_LET_GO = Action(Order.STOP, f"no M for {1000 * STICK_S:.0f} ms: neutral")


def _no_stick(held: Setpoint, word: bytes) -> Setpoint:
    raise CannotEncode("this vehicle has no M, R or D")


class Repeater:
    """Has the same interface as ``Frontseat``."""

    halfway = False
    gap = 0.0  # s: none is needed, bytes delimit the frames

    def __init__(
        self,
        encode: Callable[[Setpoint | Order], list[bytes]],
        period: float,
        link: str = "vehicle",
        bits_per_s: float = BITS_PER_S,
        kept_awake: str = "",
        stick: Callable[[Setpoint, bytes], Setpoint] = _no_stick,
        take_outputs: TakeOutputs = no_outputs,
        closer: LoopCloser | None = None,
    ) -> None:
        """``kept_awake``: why the board is sent a stop, repeatedly, before there is any command;
        "": it is not. ``stick``: the setpoint of an M, given what the stick held.
        ``take_outputs``: outputs without a frame of their own are in every later frame of
        ``encode``. ``closer``: holds the axes that the board does not."""
        self._closer, self._given_up = closer, False
        self._encode, self._period, self._link = encode, period, link
        self._steer = stick
        self._take_outputs, self._outputs = take_outputs, Restated()
        self._seconds_per_byte = BITS_PER_BYTE / bits_per_s
        self._frames: list[bytes] = []
        self._action: Action | None = None
        self._behind: Action | None = None  # the way in use, after the period of a W
        self._is_new = False
        self._news = ""  # the reason of outputs that leave with the command in force
        self._stick: Setpoint | None = None  # what the stick holds
        self._lets_go = math.inf  # when the stick counts as released
        self._due = self._free = 0.0  # when the command is repeated; when the line is free
        if kept_awake:
            self._action, self._frames = Action(Order.STOP, kept_awake), encode(Order.STOP)

    def command(self, action: Action) -> Outcome | None:
        try:
            if isinstance(action.command, Outputs):
                self._set_outputs(action.command, action.reason)
            elif self._follows_w(action):
                self._said(action.command)  # raises if there are no frames
                self._behind = action
            else:
                self._take(action, None)
        except CannotEncode as error:
            return Outcome(Result.REFUSED, str(error).encode(), action.command)
        return None

    def _follows_w(self, action: Action) -> bool:
        """Whether the action came with an operator's W that has not been sent yet."""
        held, is_w = self._action, action.command is Order.SURFACE
        if held is None or held.command is not Order.SURFACE or is_w:
            return False
        return self._is_new and held.reason == action.reason

    def _set_outputs(self, outputs: Outputs, reason: str) -> None:
        """Send the command in force with the outputs at once; neutral, if there is none yet.
        Raises CannotEncode; then the command in force continues."""
        held = self._action or Action(Order.STOP, f"neutral, with {reason}")
        assert not isinstance(held.command, Outputs)
        before = self._frames or self._said(held.command)
        self._outputs.add(self._take_outputs(outputs), reason)
        frames = self._said(held.command)
        if frames != before:
            self._action, self._frames, self._due = held, frames, 0.0
            self._news = "" if self._is_new else reason

    def _said(self, command: Setpoint | Order) -> list[bytes]:
        """The frames of a command without the axes that the Pi holds."""
        return self._encode(command if self._closer is None else self._closer.open(command))

    def cannot_relay(self, frame: bytes) -> str:
        """Why the board has no frames for it, "" if it has."""
        try:
            self._encode(self._steer(self._stick or Setpoint(), frame))
        except CannotEncode as error:
            return str(error)
        return ""

    def relay(self, data: bytes, reason: str, manual: bool = False) -> str:
        if why := self.cannot_relay(data):
            return why
        setpoint = self._steer(self._stick or Setpoint(), data)
        self._take(Action(setpoint, reason), setpoint)
        return ""

    def report(self, report: Telemetry) -> None:
        if self._closer is not None:
            self._closer.report(report)

    def answer(self, ack: Ack, now: float) -> Outcome | None:
        return None

    def poll(self, now: float) -> tuple[list[Tx], list[Outcome]]:
        if now >= self._lets_go:
            self._take(_LET_GO, Setpoint())
        elif self._behind is not None and not self._is_new and now >= self._due:
            self._take(self._behind, None)
        action = self._action
        if action is None or now < self._free or not (self._is_new or now >= self._due):
            return self._own_word(now), []
        outcomes = self._closed(action, now)
        if self._is_new and self._stick is None:
            assert not isinstance(action.command, Outputs)
            outcomes += [Outcome(Result.ACCEPTED, d, action.command) for d in self._frames]
        if self._is_new and self._stick is not None and action is not _LET_GO:
            self._lets_go = now + STICK_S
        reason = action.reason if self._is_new else f"{action.reason} (held)"
        reason, self._news = self._news or reason, ""
        self._is_new, self._due = False, now + self._period
        self._free = now + sum(map(len, self._frames)) * self._seconds_per_byte
        return [Tx(now, self._link, data, reason) for data in self._frames], outcomes

    def _closed(self, action: Action, now: float) -> list[Outcome]:
        """Encode the efforts of this instant if the Pi holds an axis; refused once it gives up."""
        closer = self._closer
        if closer is None or self._stick is not None or not isinstance(action.command, Setpoint):
            return []
        self._frames = self._encode(closer.closed(action.command, now))
        if not closer.fault or self._given_up:
            return []
        self._given_up = True
        return [Outcome(Result.REFUSED, closer.fault.encode(), action.command)]

    def _own_word(self, now: float) -> list[Tx]:
        """The next frame of an output, between the repeated frames."""
        word = self._outputs.take(now) if now >= self._free else None
        if word is None:
            return []
        self._free = now + len(word[0]) * self._seconds_per_byte
        return [Tx(now, self._link, *word)]

    @property
    def said_all(self) -> bool:
        """Whether nothing waits to be sent, and nothing is repeated."""
        return self.next_timer() is None

    def next_timer(self) -> float | None:
        said = self._outputs.next_timer()
        first = math.inf if said is None else max(said, self._free)
        if self._action is not None:
            due = self._free if self._is_new else max(self._due, self._free)
            first = min(first, due, self._lets_go)
        return first if first < math.inf else None

    def _take(self, action: Action, stick: Setpoint | None) -> None:
        """Put an action in force. Raises CannotEncode; then the previous one continues."""
        assert not isinstance(action.command, Outputs)
        self._frames = self._said(action.command)
        if self._closer is not None:
            self._closer.hold(action.command)
        self._given_up = False
        self._action, self._is_new, self._news, self._behind = action, True, "", None
        self._stick, self._lets_go = stick, math.inf
