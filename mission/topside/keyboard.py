"""Keys of a terminal as a hand on a stick: held as long as the key repeats. Sans-IO.

    arrows        ahead, back, to port, to starboard        PgUp or r, PgDn or f    up, down
    + -  1 .. 9   how strong, in gears of 12                space                   let go
    x             stop everything (X)                       q                       let go and end

A terminal tells of no key that is let go: it repeats the key while it is held, the first time after
half a second or so. So one stroke counts for ``FIRST_S``, and each further one for ``NEXT_S``.
"""

from __future__ import annotations

import enum
import re

from mission.topside.helm import GEARS, Push

FIRST_S, NEXT_S = 0.75, 0.3
USUAL = 3
_KEY = re.compile(rb"\x1b(?:\[|O)[0-9;]*[A-Za-z~]|.", re.DOTALL)
_PUSHES = {
    b"\x1b[A": (1, 0, 0), b"\x1b[B": (-1, 0, 0), b"\x1b[C": (0, 1, 0), b"\x1b[D": (0, -1, 0),
    b"\x1bOA": (1, 0, 0), b"\x1bOB": (-1, 0, 0), b"\x1bOC": (0, 1, 0), b"\x1bOD": (0, -1, 0),
    b"\x1b[5~": (0, 0, 1), b"\x1b[6~": (0, 0, -1), b"r": (0, 0, 1), b"f": (0, 0, -1),
}  # fmt: skip


class Wish(enum.Enum):
    STOP = "stop"
    QUIT = "quit"


class Keyboard:
    """``gear`` is how strong a push is."""

    def __init__(self, gear: int = USUAL) -> None:
        self.gear = gear
        self._key, self._until = b"", 0.0

    def press(self, data: bytes, now: float) -> list[Wish]:
        """What was typed, beyond pushes and gears."""
        wishes: list[Wish] = []
        for key in _KEY.findall(data):
            if key in _PUSHES:
                repeats = key == self._key and now < self._until
                self._key, self._until = key, now + (NEXT_S if repeats else FIRST_S)
                continue
            self._key = b""
            if key in (b"x", b"X"):
                wishes.append(Wish.STOP)
            elif key in (b"q", b"Q"):
                wishes.append(Wish.QUIT)
            else:
                self._shift(key)
        return wishes

    def push(self, now: float) -> Push | None:
        if not self._key or now >= self._until:
            self._key = b""
            return None
        surge, turn, heave = (sign * self.gear / GEARS for sign in _PUSHES[self._key])
        return Push(surge, turn, heave)

    def _shift(self, key: bytes) -> None:
        if key in (b"+", b"-"):
            self.gear = max(1, min(GEARS, self.gear + (1 if key == b"+" else -1)))
        elif key.isdigit() and key != b"0":
            self.gear = int(key)
