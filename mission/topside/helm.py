"""An operator's hand as M commands (document 000, table 1.2.2). Sans-IO.

    silent --dead man held, and pushed--> driving --let go, or lost--> ending --> silent
           every 200 ms a command for each axis that is pushed (R1); @MMF0$ twice at the end

Only a push begins. A neutral command would prevent taking over an emergency, and so would one that
comes within 2 s of any other (R6). Mains and verticals have separate commands. When an axis is let
go, a neutral command for it is sent. Surge and turn move the same thrusters: the stronger counts.
What does not live here: where the hand is (keyboard, joystick), the vehicle's dead man.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

PERIOD_S = 0.2  # R1
ENDS = 2  # neutral commands at the end (R1)
GEARS, TURNS = 12, 5  # the greatest values of MM and MR
NEUTRAL, LEVEL = b"@MMF0$", b"@MMU0$"


@dataclass(frozen=True, slots=True)
class Push:
    """Shares of full, -1 to 1: ahead, to starboard, up. ``aside``: another output needs the
    stick."""

    surge: float = 0.0
    turn: float = 0.0
    heave: float = 0.0
    aside: bool = False

    @property
    def moves(self) -> bool:
        return bool(self.surge or self.turn or self.heave or self.aside)


def mains(push: Push) -> bytes:
    if abs(push.turn) > abs(push.surge):
        return b"@MR%c%d$" % (b"R" if push.turn > 0 else b"L", _level(push.turn, TURNS))
    if push.surge:
        return b"@MM%c%d$" % (b"F" if push.surge > 0 else b"B", _level(push.surge, GEARS))
    return NEUTRAL


def verticals(push: Push) -> bytes:
    if push.heave:
        return b"@MM%c%d$" % (b"U" if push.heave > 0 else b"D", _level(push.heave, GEARS))
    return LEVEL


def _level(share: float, full: int) -> int:
    return max(1, min(full, math.floor(abs(share) * full + 0.5)))


class Helm:
    """``hold`` takes the position of the hand, ``words`` returns the commands to send now."""

    def __init__(self) -> None:
        self._push: Push | None = None
        self._driving, self._ends = False, 0
        self._lifted = False  # a vertical command was sent since all was neutral
        self._due = -math.inf
        self._locked = False

    @property
    def is_silent(self) -> bool:
        return not self._driving and not self._ends

    @property
    def is_locked(self) -> bool:
        """Whether it was dropped, and the dead man has not been let go since."""
        return self._locked

    def hold(self, push: Push | None) -> None:
        """None: the dead man is let go, or its state is not known."""
        self._locked = self._locked and push is not None
        if self._locked:
            return
        self._push = push
        if push is not None and push.moves:
            self._driving, self._ends = True, 0
        elif push is None and self._driving:
            self._driving, self._ends = False, ENDS
            self._due = -math.inf  # at once

    def drop(self) -> None:
        """After a stop: be silent at once, until the dead man is let go."""
        self._push, self._driving, self._ends = None, False, 0
        self._lifted, self._locked = False, True

    def next_timer(self) -> float | None:
        return None if self.is_silent else self._due

    def words(self, now: float) -> list[bytes]:
        if self.is_silent or now < self._due:
            return []
        late = now - self._due > PERIOD_S
        self._due = now + PERIOD_S if late else self._due + PERIOD_S
        if self._ends:
            self._ends -= 1
            return [*self._lower(), NEUTRAL]
        push = self._push or Push()
        up, along = verticals(push), mains(push)
        moving = [word for word in (along, up) if word not in (NEUTRAL, LEVEL)]
        still = [] if up != LEVEL else self._lower()
        self._lifted = self._lifted or up != LEVEL
        if along == NEUTRAL:
            still.append(NEUTRAL)
        return moving + still  # motion first: only that may take over an emergency

    def _lower(self) -> list[bytes]:
        """Stop the verticals while they may still be on, and once more with the last command."""
        told = [LEVEL] if self._lifted else []
        if not self._driving and not self._ends:
            self._lifted = False
        return told
