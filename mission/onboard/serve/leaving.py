"""When serve may end: when the vehicle needs no control any more, or when the time is up.

    signal --> surface first, while operators still command --> settled               --> end
    another signal, or MARGIN_S before the service manager kills --> last commands    --> end
    (after an error of the program, the runtime that is due gives the last commands)

The Pi may be switched off next, and a vehicle in automatic mode keeps its last setpoint for ever.
The service manager does not tell how long it waits, so the unit states it twice: as TimeoutStopSec
and as AUVMISSION_STOP_S. What does not live here: the commands to the vehicle (engine: ending).
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping

from mission.onboard.runtime.restated import AGAIN_S, TIMES
from mission.onboard.runtime.runtime import Runtime

VARIABLE = "AUVMISSION_STOP_S"
USUAL_S = 300.0  # TimeoutStopSec of the unit
MARGIN_S = 10.0  # s of real time for the last commands and the black box
REBORN_S = 4.0  # s of real time for a runtime that is due after an error
# s of real time for the acknowledgements and retries of the last commands, and until each command
# that nothing acknowledges has been repeated as often as it has to be (R18).
LAST_WORDS_S = (TIMES - 1) * AGAIN_S + 1.0
LOOK_S = 0.05
UP_FIRST = (
    "serve ends when the vehicle is at the surface, and has acknowledged its stop; X, W and the "
    "stick are still heard; told once more (ctrl-C, SIGTERM) it ends at once"
)
TOO_EARLY = (
    "serve ends before the surface is proved, or the stop acknowledged: what the vehicle was told "
    "last holds; when serve runs again, it surfaces the vehicle, or stops it again"
)


def time_to_leave(environment: Mapping[str, str]) -> float:
    """Seconds of real time between the signal and the last commands."""
    try:
        given = float(environment.get(VARIABLE, ""))
    except ValueError:
        given = USUAL_S
    return max(0.0, (given if math.isfinite(given) else USUAL_S) - MARGIN_S)


class Leaving:
    """``living`` returns the runtime, None while another one is about to begin. ``end`` is called
    with whether the last commands are due. ``tell`` gets what an operator should know."""

    def __init__(
        self,
        seconds: float,
        living: Callable[[], Runtime | None],
        end: Callable[[bool], None],
        tell: Callable[[str], None],
    ) -> None:
        self._seconds, self._living, self._end, self._tell = seconds, living, end, tell
        self.ordered, self._hurry = asyncio.Event(), asyncio.Event()
        self.last = self.over = False  # ``last``: a new runtime gives the last commands at once

    def signal(self) -> None:
        """Take in a signal; the second one leads to the last commands at once."""
        if self.ordered.is_set():
            self._hurry.set()
        self.ordered.set()

    async def leave(self) -> None:
        self._end(False)
        if not self._settled():
            self._tell(UP_FIRST)
        await _until(lambda: self._settled() or self._hurry.is_set(), self._seconds)
        if not self._settled():
            self.last = True
            self._end(True)
            self._tell(TOO_EARLY)
        await _until(lambda: self._living() is not None, REBORN_S)
        await _until(self._said_all, LAST_WORDS_S)
        self.over = True

    def _settled(self) -> bool:
        runtime = self._living()
        return runtime is not None and runtime.engine.settled

    def _said_all(self) -> bool:
        runtime = self._living()
        return runtime is not None and runtime.said_all


async def _until(holds: Callable[[], bool], seconds: float) -> None:
    """Wait until ``holds``, at most ``seconds``."""
    clock = asyncio.get_running_loop().time
    end = clock() + seconds
    while not holds() and clock() < end:
        await asyncio.sleep(LOOK_S)
