"""The way to a board that answers nothing: what holds is said again and again (R16, R17).

The frames of the newest command go out at once and then every ``period``; a board that hears
nothing for its own time of silence goes neutral by itself. Whatever was sent counts as accepted:
that it is followed is seen by telemetry alone.

What does not live here: boards that acknowledge (frontseat), frames (protocol.vehicles).
"""

from __future__ import annotations

from collections.abc import Callable

from mission.model import Action, Outcome, Result, Tx
from protocol.codec import CannotEncode
from protocol.messages import Ack, Order, Setpoint


class Repeater:
    """To the drive the same as a ``Frontseat``."""

    def __init__(
        self,
        encode: Callable[[Setpoint | Order], list[bytes]],
        period: float,
        link: str = "vehicle",
    ) -> None:
        self._encode, self._period, self._link = encode, period, link
        self._frames: list[bytes] = []
        self._action: Action | None = None
        self._is_new = False
        self._due = 0.0
        self._relays: list[tuple[bytes, str]] = []

    def command(self, action: Action) -> Outcome | None:
        try:
            self._frames = self._encode(action.command)
        except CannotEncode as error:
            return Outcome(Result.REFUSED, str(error).encode(), action.command)
        self._action, self._is_new = action, True
        return None

    def relay(self, data: bytes, reason: str, manual: bool = False) -> None:
        """A manual frame ends the repetition: two masters on one line are one too many."""
        if manual:
            self._action, self._is_new = None, False
        self._relays.append((data, reason))

    def answer(self, ack: Ack, now: float) -> Outcome | None:
        return None

    def poll(self, now: float) -> tuple[list[Tx], list[Outcome]]:
        sent = [Tx(now, self._link, data, reason) for data, reason in self._relays]
        self._relays = []
        action = self._action
        if action is None or not (self._is_new or now >= self._due):
            return sent, []
        outcomes = []
        if self._is_new:
            outcomes = [Outcome(Result.ACCEPTED, d, action.command) for d in self._frames]
        reason = action.reason if self._is_new else f"{action.reason} (held)"
        self._is_new, self._due = False, now + self._period
        return sent + [Tx(now, self._link, data, reason) for data in self._frames], outcomes

    def next_timer(self) -> float | None:
        if self._relays or self._is_new:
            return 0.0
        return None if self._action is None else self._due
