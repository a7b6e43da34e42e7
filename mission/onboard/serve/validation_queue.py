"""Validates an uploaded mission off the event loop, before its last line is acknowledged; X and W
overtake it.

    bytes --would they complete a set of lines?--no--> runtime
                      |yes
                      +--> held, with whatever that connection says next; a thread judges the set;
                           then all of it goes on to the runtime, which finds the verdict ready (R3)

A long mission takes seconds to be judged, more on a Pi. Without this the loop would stand still:
no X would leave, and the service manager would find it hung. An X or W of the same connection
overtakes what is held, marked by bytes that end a frame that had begun; what stood before it in
its read is dropped. Out of idle no line is taken: all that is held goes on at once, and the runtime
refuses what was said before an X or W (R7).

What does not live here: the verdict, and what is answered (runtime).
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

_TAIL = 1 - LONGEST  # where an X or W may begin that is not whole yet
MISSED = 16  # X and W that wait for a runtime
_Whose = tuple[str, str]  # link and address


class ValidationQueue:
    def __init__(
        self,
        pass_on: Callable[[Rx], None],
        spawn: Callable[[Coroutine[Any, Any, None]], None],
        tolerances: Mapping[str, str],
    ) -> None:
        self._order = orders(Tolerances.parse(tolerances))  # a mission's line may be one: not that
        self._pass_on, self._spawn = pass_on, spawn
        self.held: dict[_Whose, list[Rx]] = {}
        self.gone: dict[_Whose, Callable[[], None]] = {}
        self._missed: list[Rx] = []
        self._begun: dict[_Whose, Rx] = {}  # what may be the begin of one

    def hear(self, rx: Rx, runtime: Runtime) -> None:
        whose = rx.link, rx.address
        if (held := self.held.get(whose)) is not None:
            tail = _end_of(held)
            heard, behind = tail + rx.data, rx.data
            for found in self._order.finditer(heard):
                if found.end() <= len(tail):  # it has been passed on
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
        """Where there is no runtime: its X and W wait for the next one, the newest of them (R7)."""
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
        """And what may go on as one."""
        missed, self._missed = [*self._missed, *self._begun.values()], []
        self._begun.clear()
        return [rx._replace(t=now) for rx in missed if rx.data]

    def part(self, link: str, address: str, told: Callable[[], None]) -> None:
        """A connection is gone: ``told`` once all that it said has been heard."""
        if (link, address) in self.held:
            self.gone[link, address] = told
        else:
            told()

    async def _judge(
        self, whose: _Whose, held: list[Rx], lines: tuple[str, ...], runtime: Runtime
    ) -> None:
        loop = asyncio.get_running_loop()
        with contextlib.suppress(Exception):  # the runtime meets it again, and says so
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
    """Ten thousand lines become so many objects that the collector would hold everything up."""
    with uncollected():
        runtime.judge(lines)
