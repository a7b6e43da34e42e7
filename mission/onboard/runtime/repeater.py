"""The way to a board that answers nothing: what holds is said again and again (R16, R17).

    newest command --> its frames, once the line is free --> every ``period`` the same --> board

The frames of the newest command go out as soon as the line has carried those before, and then every
``period``; a board that hears nothing for its own time of silence goes neutral by itself. Whatever
was sent counts as accepted: that it is followed is seen by telemetry alone. Nothing of the
operators' is relayed: these boards have no M, R or D (R14).

What does not live here: boards that acknowledge (frontseat), frames (protocol.vehicles).
"""

from __future__ import annotations

from collections.abc import Callable

from mission.model import Action, Outcome, Result, Tx
from protocol.codec import CannotEncode
from protocol.messages import Ack, Order, Setpoint

BITS_PER_BYTE = 10  # 8N1
BITS_PER_S = 115200


class Repeater:
    """To the runtime the same as a ``Frontseat``."""

    gap = 0.0  # s: frames are delimited by their bytes
    cannot_relay = "this vehicle has no M, R or D"

    def __init__(
        self,
        encode: Callable[[Setpoint | Order], list[bytes]],
        period: float,
        link: str = "vehicle",
        bits_per_s: float = BITS_PER_S,
    ) -> None:
        self._encode, self._period, self._link = encode, period, link
        self._seconds_per_byte = BITS_PER_BYTE / bits_per_s
        self._frames: list[bytes] = []
        self._action: Action | None = None
        self._is_new = False
        self._due = self._free = 0.0  # when it is said again; from when on the line may be used

    def command(self, action: Action) -> Outcome | None:
        try:
            self._frames = self._encode(action.command)
        except CannotEncode as error:
            return Outcome(Result.REFUSED, str(error).encode(), action.command)
        self._action, self._is_new = action, True
        return None

    def relay(self, data: bytes, reason: str, manual: bool = False) -> str:
        return self.cannot_relay

    def answer(self, ack: Ack, now: float) -> Outcome | None:
        return None

    def poll(self, now: float) -> tuple[list[Tx], list[Outcome]]:
        action = self._action
        if action is None or now < self._free or not (self._is_new or now >= self._due):
            return [], []
        outcomes = []
        if self._is_new:
            outcomes = [Outcome(Result.ACCEPTED, d, action.command) for d in self._frames]
        reason = action.reason if self._is_new else f"{action.reason} (held)"
        self._is_new, self._due = False, now + self._period
        self._free = now + sum(map(len, self._frames)) * self._seconds_per_byte
        return [Tx(now, self._link, data, reason) for data in self._frames], outcomes

    def next_timer(self) -> float | None:
        if self._action is None:
            return None
        return self._free if self._is_new else max(self._due, self._free)
