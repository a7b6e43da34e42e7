"""X and W from the console: repeated until the vehicle acknowledges them, whatever the obstacle.

    given --> sent --> acknowledged --> confirmed | unconfirmed | contradicted  (what reports show)
               ^ |
    unanswered + <-- no answer, or no connection        a newer order takes the place of an older

A page that reconnects sends its last order again: its ``key`` shows that it is the same one, and it
replaces no other.

An order gives its sender the vehicle's command (R12). So once it is acknowledged, the connection is
replaced by a new one: the stick need not wait for it.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mission.console.line import Line
from mission.topside.orders import Contradicted, Unconfirmed, order
from mission.topside.upload import OperatorError
from protocol.messages import Order

ORDERS = {"stop": Order.STOP, "surface": Order.SURFACE}
KEPT = 5
AGAIN_S = 0.2
Told = Callable[[str, str], None]
"""Gets what became of it (``is``), and words."""


@dataclass(slots=True)
class Given:
    name: str
    told: Told
    at: float  # monotonic
    key: object = None
    is_now: str = "sent"
    says: str = ""

    def become(self, is_now: str, says: str = "") -> None:
        if (is_now, says) != (self.is_now, self.says) or is_now == "sent":
            self.is_now, self.says = is_now, says
            self.told(is_now, says)


class Orders:
    def __init__(self, line: Line) -> None:
        self._line = line
        self._given: deque[Given] = deque(maxlen=KEPT)
        self._tasks: set[asyncio.Task[None]] = set()

    def as_objects(self, now: float) -> list[dict[str, Any]]:
        return [
            {"order": g.name, "is": g.is_now, "says": g.says, "age": round(now - g.at)}
            for g in self._given
        ]

    def give(self, name: str, told: Told, key: object = None) -> None:
        """``key``: of the press; None: a new order."""
        for known in self._given:
            if key is not None and (known.name, known.key) == (name, key):
                known.told = told
                told(known.is_now, known.says)
                return
        given = Given(name, told, time.monotonic(), key)
        self._given.append(given)
        given.become("sent")
        task = asyncio.get_running_loop().create_task(self._pursue(given))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def end(self) -> None:
        for task in self._tasks:
            task.cancel()

    async def _pursue(self, given: Given) -> None:
        while self._given[-1] is given:
            try:
                given.become("confirmed", await self._say(given))
            except Unconfirmed as why:
                given.become("unconfirmed", str(why))
            except Contradicted as why:
                given.become("contradicted", str(why))
            except OperatorError as why:
                unheard = given.is_now in ("sent", "unanswered")
                if unheard and self._line.acoustics is None:
                    given.become("unanswered", f"{why}; it is said again")
                    await asyncio.sleep(AGAIN_S)
                    continue
                says = f"{why}; press again if you still mean it"
                given.become("unconfirmed", says if unheard else f"acknowledged; then {why}")
            return
        if given.is_now in ("sent", "unanswered"):
            given.become("refused", "a newer order has taken its place")

    async def _say(self, given: Given) -> str:
        def acknowledged(says: str) -> None:
            given.become("acknowledged", says)
            renewing = asyncio.get_running_loop().create_task(self._line.renew())
            self._tasks.add(renewing)
            renewing.add_done_callback(self._tasks.discard)

        under_water = self._line.acoustics is not None
        script = order(ORDERS[given.name], acknowledged, under_water=under_water)
        return await self._line.say(script, urgent=True)
