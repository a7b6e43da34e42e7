"""Keys of a terminal as a hand on a stick: held as long as the key repeats. Sans-IO.

    arrows        ahead, back, to port, to starboard        PgUp or r, PgDn or f    up, down
    + -  1 .. 9   how strong, in gears of 12                space                   let go
    x             stop everything (X)                       q                       let go and end
    others        outputs of the vehicle file, as they are named: set, or set while held

A terminal does not report when a key is let go. It repeats the key while it is held, the first time
after about half a second. So the first stroke counts for ``FIRST_S``, each further one for
``NEXT_S``.
"""

from __future__ import annotations

import enum
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from mission.topside.helm import GEARS, Push
from protocol.messages import SetOutput

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


@dataclass(frozen=True, slots=True)
class Switch:
    """What a key does to an output. ``otherwise``: its value once the key is let go; None: it
    stays."""

    name: str
    value: float
    otherwise: float | None = None


Switches = Mapping[bytes, tuple[Switch, ...]]  # by key
_WISHES = {b"x": Wish.STOP, b"X": Wish.STOP, b"q": Wish.QUIT, b"Q": Wish.QUIT}
_ASIDE = Push(aside=True)
_NONE: Switches = MappingProxyType({})


def is_free(key: bytes) -> bool:
    """Whether the key may be assigned to an output."""
    taken = {*_PUSHES, *_WISHES, b"+", b"-", b" "}
    return len(key) == 1 and key.isascii() and key not in taken and key.isalpha()


class Keyboard:
    """``gear``: the strength of a push."""

    def __init__(self, gear: int = USUAL, switches: Switches = _NONE) -> None:
        self.gear, self._switches = gear, switches
        self._key, self._until = b"", 0.0
        self._held = b""  # the key whose outputs are set until it is let go

    def press(self, data: bytes, now: float) -> list[Wish | SetOutput]:
        """Take typed keys; return the wishes beyond pushes and gears."""
        wishes: list[Wish | SetOutput] = []
        for key in _KEY.findall(data):
            repeats = key == self._key and now < self._until
            if key in _PUSHES or self._is_held(key):
                self._key, self._until = key, now + (NEXT_S if repeats else FIRST_S)
            else:
                self._key = b""
            wishes += self.let_go(now)
            if key in _WISHES:
                wishes.append(_WISHES[key])
            elif key not in self._switches:
                self._shift(key)
            elif not repeats:
                wishes += [SetOutput(one.name, one.value) for one in self._switches[key]]
                self._held = key if self._is_held(key) else b""
        return wishes

    def let_go(self, now: float) -> list[SetOutput]:
        """Reset the outputs whose key is no longer held."""
        if not self._held or (self._held == self._key and now < self._until):
            return []
        held, self._held = self._switches[self._held], b""
        return [SetOutput(o.name, o.otherwise) for o in held if o.otherwise is not None]

    def _is_held(self, key: bytes) -> bool:
        return any(one.otherwise is not None for one in self._switches.get(key, ()))

    def push(self, now: float) -> Push | None:
        if not self._key or now >= self._until:
            self._key = b""
            return None
        if self._key not in _PUSHES:
            return _ASIDE
        surge, turn, heave = (sign * self.gear / GEARS for sign in _PUSHES[self._key])
        return Push(surge, turn, heave)

    def _shift(self, key: bytes) -> None:
        if key in (b"+", b"-"):
            self.gear = max(1, min(GEARS, self.gear + (1 if key == b"+" else -1)))
        elif key.isdigit() and key != b"0":
            self.gear = int(key)
