"""Alarms of a running serve: logged when they begin and end, and passed to the runtime.

    Condition of the runtime --+
    Condition of serve --------+--> alarms in force ---> journal, health
                 its names -------------------------------> runtime (for @AE)

What does not live here: what an alarm is (model.alarms).
"""

from __future__ import annotations

import calendar
import math
import time
from collections.abc import Callable, Mapping

from mission.model.alarms import Alarm, Condition, standing
from mission.onboard.blackbox import BlackBox
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.journal import Journal
from mission.onboard.serve.ports import Port
from mission.onboard.serve.recording import Recording
from protocol.messages import Fix

FRESH_S = 5.0  # s: age of a fix that the clock is compared with


class AlarmWatch:
    """``tell_runtime`` gets the names of the alarms that serve alone sees, when they change.
    ``broken``: faults of configuration, vehicle file and store, as text. ``in_real_time``: the
    engine's time is as fast as the wall's."""

    def __init__(
        self,
        journal: Journal,
        tell_runtime: Callable[[tuple[str, ...]], None],
        broken: tuple[str, ...],
        in_real_time: bool,
    ) -> None:
        self._journal, self._tell_runtime = journal, tell_runtime
        self.broken, self._in_real_time = broken, in_real_time
        self._unsent = -math.inf  # monotonic
        self._of_serve: tuple[str, ...] = ()
        self._standing: Mapping[str, Alarm] = {}

    def unsent(self) -> None:
        """Note that a command could not be sent."""
        self._unsent = time.monotonic()

    @property
    def standing(self) -> tuple[Alarm, ...]:
        """The alarms in force at the last look."""
        return tuple(self._standing.values())

    def begin(self) -> None:
        """Another runtime has started, which knows of no alarm yet."""
        self._of_serve = ()

    def look(
        self, runtime: Runtime, ports: Mapping[str, Port], recording: Recording, now: float
    ) -> tuple[Alarm, ...]:
        """Return the alarms in force at the engine's time ``now``; pass changes on."""
        of_runtime = standing(runtime.condition(now))
        own = standing(
            Condition(
                closed=away(ports),
                unsent_age=time.monotonic() - self._unsent,
                disk_free=recording.free,
                recording=recording_fault(recording.box),
                clock_off=self._clock_off(runtime.situation.fix, now),
                broken=self.broken,
            )
        )
        self._follow({alarm.name: alarm for alarm in (*of_runtime, *own)})
        names = tuple(alarm.name for alarm in own)
        if names != self._of_serve:
            self._of_serve = names
            self._tell_runtime(names)
        return self.standing

    def _clock_off(self, fix: Fix | None, now: float) -> float | None:
        return clock_off(fix, now, time.time()) if self._in_real_time else None

    def _follow(self, found: Mapping[str, Alarm]) -> None:
        """Log the alarms that have begun, and those that are over."""
        for name in found.keys() - self._standing.keys():
            self._journal.warning(f"ALARM {found[name]}", f"ALARM {name}")
        for name in self._standing.keys() - found.keys():
            self._journal.info(f"alarm over: {name}", kind="alarms over")
        self._standing = found


def away(ports: Mapping[str, Port]) -> tuple[str, ...]:
    return tuple(name for name, port in ports.items() if port.is_away)


def recording_fault(box: BlackBox | None) -> str:
    """Why not everything is recorded, "" if it is."""
    if box is None:
        return "nothing is recorded"
    return box.failure or (f"{box.lost} records are lost" if box.lost else "")


def clock_off(fix: Fix | None, now: float, wall: float) -> float | None:
    """Seconds that ``wall`` (since 1970 UTC) is ahead of a fresh fix's own time, both at the
    engine's time ``now``; None without a fresh fix."""
    if fix is None or fix.utc is None or now - fix.t > FRESH_S:
        return None
    told = calendar.timegm(time.strptime(fix.utc, "%Y-%m-%dT%H:%M:%S"))
    return wall - (now - fix.t) - told
