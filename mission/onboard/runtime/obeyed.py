"""Find X and W in the modem's bytes at once, even in the middle of a damaged envelope (R7, G3).

    bytes --+--> envelopes --> commands --+--> heard
            +--> X and W, anywhere -------+    (first those that are in no whole envelope yet)

A content takes time to arrive, and a false one swallows the bytes after it. So a second reader
searches for the six bytes alone. When the envelope around an obeyed X or W is whole, this X or W is
not obeyed again, nor are the commands before it: they were overtaken.

What does not live here: envelopes (protocol.modem), frames (protocol.topside).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TypeVar

from protocol.messages import Emergency, Order
from protocol.tolerances import Tolerances
from protocol.topside import EMERGENCIES

HELD_UP_S = 10.0  # s that the program may stall, beyond the timeout of a content

_ORDERS = {frame: order for order, frame in EMERGENCIES.items()}
_PLAIN = b"|".join(map(re.escape, _ORDERS))
_NESTED = b"(?<!@AW....)(?:" + _PLAIN + b")"  # in a mission line (E-F7) it is no order
LONGEST = max(map(len, _ORDERS)) + len(b"@AW....")
_Item = TypeVar("_Item")


def orders(tolerances: Tolerances) -> re.Pattern[bytes]:
    """The pattern that finds X and W among bytes."""
    return re.compile(_NESTED if tolerances.on("aw_nested") else _PLAIN, re.DOTALL)


class Obeyed:
    """The orders of one modem. ``patience``: s until a content is whole, or given up (G3)."""

    def __init__(self, tolerances: Tolerances, patience: float) -> None:
        self._late = patience + HELD_UP_S
        self._order = orders(tolerances)
        self._tail = b""
        self._early: list[tuple[Order, float]] = []  # obeyed before their envelope was whole

    def found(self, data: bytes) -> list[Order]:
        """The orders whose last byte is among these bytes."""
        stream, before = self._tail + data, len(self._tail)
        self._tail = stream[1 - LONGEST :]
        return [_ORDERS[m[0]] for m in self._order.finditer(stream) if m.end() > before]

    def left_of(self, content: Sequence[_Item], now: float) -> list[_Item]:
        """The commands of one content that are still to be executed."""
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
        """The orders found that are not among the commands of whole envelopes."""
        known = [item.order for item in heard if isinstance(item, Emergency)]
        missing = []
        for order in found:
            if order in known:
                known.remove(order)
            else:
                missing.append(order)
        self._early += [(order, now) for order in missing]
        return [Emergency(order) for order in missing]
