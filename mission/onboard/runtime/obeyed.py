"""Finds X and W in the modem's bytes at once, even in the middle of a damaged envelope (R7, G3).

    bytes --+--> envelopes --> commands --+--> heard
            +--> X and W, wherever -------+    (those of no envelope that is whole by now go first)

A content takes its time, and a false one keeps what comes behind it. So a second reader looks for
the six bytes alone. When the envelope around an X or W that was obeyed is whole at last, that X or
W is not obeyed once more, nor is what stood before it: it was overtaken.

What does not live here: envelopes (protocol.modem), frames (protocol.topside).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TypeVar

from protocol.messages import Emergency, Order
from protocol.tolerances import Tolerances
from protocol.topside import EMERGENCIES

HELD_UP_S = 10.0  # a program may be, behind the time in which a content is given up

_ORDERS = {frame: order for order, frame in EMERGENCIES.items()}
_PLAIN = b"|".join(map(re.escape, _ORDERS))
_NESTED = b"(?<!@AW....)(?:" + _PLAIN + b")"  # as payload of a mission line (E-F7) it is none
LONGEST = max(map(len, _ORDERS)) + len(b"@AW....")
_Item = TypeVar("_Item")


def orders(tolerances: Tolerances) -> re.Pattern[bytes]:
    """Finds X and W among bytes."""
    return re.compile(_NESTED if tolerances.on("aw_nested") else _PLAIN, re.DOTALL)


class Obeyed:
    """Of one modem. ``patience``: s within which a content is whole, or given up (G3)."""

    def __init__(self, tolerances: Tolerances, patience: float) -> None:
        self._late = patience + HELD_UP_S
        self._order = orders(tolerances)
        self._tail = b""
        self._early: list[tuple[Order, float]] = []  # obeyed, their envelope not seen yet

    def found(self, data: bytes) -> list[Order]:
        """Those whose last byte is among these bytes."""
        stream, before = self._tail + data, len(self._tail)
        self._tail = stream[1 - LONGEST :]
        return [_ORDERS[m[0]] for m in self._order.finditer(stream) if m.end() > before]

    def left_of(self, content: Sequence[_Item], now: float) -> list[_Item]:
        """What is still to be done of the commands of one content."""
        self._early = [(order, t) for order, t in self._early if now - t < self._late]
        begin = 0
        for at, item in enumerate(content, 1):
            early = (e for e in self._early if item == Emergency(e[0]))
            if (known := next(early, None)) is not None:
                self._early.remove(known)
                begin = at
        return list(content[begin:])

    def at_once(
        self, found: Sequence[Order], heard: Sequence[object], now: float
    ) -> list[Emergency]:
        """Of those found, what is not among the commands that are heard now."""
        known = [item.order for item in heard if isinstance(item, Emergency)]
        missing = []
        for order in found:
            if order in known:
                known.remove(order)
            else:
                missing.append(order)
        self._early += [(order, now) for order in missing]
        return [Emergency(order) for order in missing]
