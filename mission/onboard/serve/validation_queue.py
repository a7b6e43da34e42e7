"""Validate an uploaded mission off the event loop, before its last line is acknowledged; X and W
overtake it.

    bytes --would they complete a set of lines?--no--> runtime
                      |yes
                      +--> held, with further bytes of that connection; a thread judges the set;
                           then all of it goes to the runtime, which finds the verdict ready (R3)

Judging a long mission takes seconds, more on a Pi. Without this queue the event loop would block:
no X would leave, and the service manager would find the program hung. An X or W of the same
connection overtakes the held bytes, marked by bytes that end a frame that had begun; bytes before
it in the same read are dropped. Outside idle no line is accepted: the held bytes go on at once, and
the runtime refuses commands that were sent before an X or W (R7).

What does not live here: the verdict, and the answers (runtime).
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Coroutine, Mapping
from typing import Any

from links.base import Rx
from mission.model.regions import IDLE
from mission.onboard.runtime.obeyed import LONGEST, orders
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.rate_limiter import BREAK
from mission.onboard.uncollected import uncollected
from protocol.tolerances import Tolerances

_TAIL = 1 - LONGEST  # an incomplete X or W begins here at the earliest
MISSED = 16  # X and W that wait for a runtime
_Whose = tuple[str, str]  # link and address


class ValidationQueue:
    def __init__(
        self,
        pass_on: Callable[[Rx], None],
        spawn: Callable[[Coroutine[Any, Any, None]], None],
        tolerances: Mapping[str, str],
    ) -> None:
        self._order = orders(Tolerances.parse(tolerances))  # not in a mission's line
        self._pass_on, self._spawn = pass_on, spawn
        self.held: dict[_Whose, list[Rx]] = {}
        self.gone: dict[_Whose, Callable[[], None]] = {}
        self._missed: list[Rx] = []
        self._begun: dict[_Whose, Rx] = {}  # what may be the beginning of one

    def hear(self, rx: Rx, runtime: Runtime) -> None:
        whose = rx.link, rx.address
        if (held := self.held.get(whose)) is not None:
            tail = _end_of(held)
            heard, behind = tail + rx.data, rx.data
            for found in self._order.finditer(heard):
                if found.end() <= len(tail):  # already passed on
                    continue
                self._pass_on(rx._replace(data=BREAK + found[0]))
                behind = BREAK + heard[found.end() :]
            held.append(rx._replace(data=behind))
        elif (lines := runtime.foresee(rx)) and (order := self._order.search(rx.data)):
            self._pass_on(rx._replace(data=BREAK + rx.data[order.start() :]))
        elif lines:
            self.held[whose] = held = [rx]
            self._spawn(self._judge(whose, held, lines, runtime))
        else:
            self._pass_on(rx)
        if runtime.engine.region != IDLE:
            for each in tuple(self.held):
                self._let_go(each)

    def miss(self, rx: Rx) -> None:
        """Without a runtime: keep the newest X and W for the next one (R7)."""
        begun = self._begun.get((rx.link, rx.address))
        heard = (begun.data if begun else b"") + rx.data
        orders, end = [], 0
        for found in self._order.finditer(heard):
            orders.append(rx._replace(data=BREAK + found[0]))
            end = found.end()
        self._missed = [*self._missed, *orders][-MISSED:]
        last = heard[max(end, len(heard) + _TAIL, heard.rfind(b"$") + 1) :]
        self._begun[rx.link, rx.address] = rx._replace(data=last if b"@" in last else b"")
        self._begun = dict(list(self._begun.items())[-MISSED:])

    def take_missed(self, now: float) -> list[Rx]:
        """Return the X and W that were kept, and bytes that may continue as one."""
        missed, self._missed = [*self._missed, *self._begun.values()], []
        self._begun.clear()
        return [rx._replace(t=now) for rx in missed if rx.data]

    def part(self, link: str, address: str, told: Callable[[], None]) -> None:
        """A connection has closed: call ``told`` once all its bytes have been passed on."""
        if (link, address) in self.held:
            self.gone[link, address] = told
        else:
            told()

    async def _judge(
        self, whose: _Whose, held: list[Rx], lines: tuple[str, ...], runtime: Runtime
    ) -> None:
        loop = asyncio.get_running_loop()
        with contextlib.suppress(Exception):  # the runtime meets it again, and reports it
            await loop.run_in_executor(None, _judged, runtime, lines)
        if self.held.get(whose) is held:
            self._let_go(whose)

    def _let_go(self, whose: _Whose) -> None:
        for rx in self.held.pop(whose):
            self._pass_on(rx)
        if told := self.gone.pop(whose, None):
            told()


def _end_of(held: list[Rx]) -> bytes:
    return b"".join(rx.data for rx in held[_TAIL:])[_TAIL:]


def _judged(runtime: Runtime, lines: tuple[str, ...]) -> None:
    """Judge without the collector: ten thousand lines make so many objects that it would block."""
    with uncollected():
        runtime.judge(lines)
