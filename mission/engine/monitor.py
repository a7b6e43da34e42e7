"""The monitor of the limits: which rows are breached now, and for how long they have been.

What does not live here: the rows (limits), what they look at (watch), responses (engine).
"""

from __future__ import annotations

import math

from mission.engine.bounds import Bounds
from mission.engine.lasting import Lasting
from mission.engine.limits import LIMITS, Limit, On, never
from mission.engine.vehicle_state import VehicleState
from mission.engine.watch import Watch
from mission.model.vehicle import SAMPLED, STALE_AFTER, Vehicle


class LimitMonitor(Watch):
    """``breaches``: the rows that were found breached when they were last looked at."""

    def __init__(self, vehicle: Vehicle, vehicle_state: VehicleState, bounds: Bounds) -> None:
        super().__init__(vehicle, vehicle_state, bounds)
        self.rows = tuple(row for row in LIMITS.values() if not row.disarmed(vehicle))
        self._looked = {
            (reported, fixed): tuple(
                (row.breached, row)
                for row in self.rows
                if {On.CLOCK: True, On.REPORT: reported, On.FIX: fixed}[row.on]
            )
            for reported in (False, True)
            for fixed in (False, True)
        }
        self._timed = tuple(row for row in self.rows if row.due is not never)
        self.breaches: tuple[Limit, ...] = ()
        self.samples: dict[str, int] = {}  # beyond the bound, less those within it
        self._sampled: dict[str, float] = {}  # when one was last counted
        self._lasting = Lasting()
        self._seen: dict[str, float] = {}  # for rows that must last for seconds: when last known

    def begin(self, now: float) -> None:
        super().begin(now)
        self.samples, self._lasting, self.breaches = {}, Lasting(), ()
        self._seen, self._sampled = {}, {}

    def forgive(self, row: Limit) -> None:
        """Reset the counts of a limit, after a response that may end the breach."""
        self.samples.pop(row.name, None)
        self._sampled.pop(row.name, None)
        self._lasting.forget(row.name)

    def look(self, reported: bool, fixed: bool) -> list[Limit]:
        """Return the rows that are breached now and have been for long enough. Rows that are not
        looked at now stay in ``breaches``."""
        self.look_for_depth()
        rows = self._looked[reported, fixed]
        found = []
        counts = bool(self.samples or self._lasting)  # False: there is nothing to take back
        for is_breached, row in rows:
            breached = is_breached(self)
            if breached:
                if self._lasts(row):
                    found.append(row)
            elif counts and breached is not None:
                self._fade(row)
        if found or self.breaches:
            looked = [row for _, row in rows]
            kept = [row for row in self.breaches if row not in looked]
            self.breaches = (*kept, *found)
        return found

    def next_timer(self) -> float | None:
        first = None
        for row in self._timed:
            due = row.due(self)
            if due is not None and (first is None or due < first):
                first = due
        return first

    def _lasts(self, row: Limit) -> bool:
        """Count a breach; return whether it has lasted for as long as its row requires."""
        if row.seconds:
            now = self._known(row)
            return now - self._lasting.holds(row.name, now) >= row.seconds
        count = self.samples.get(row.name, 0)
        if self._is_next(row):
            count = self.samples[row.name] = min(count + 1, row.samples)
        return count >= row.samples

    def _fade(self, row: Limit) -> None:
        """Count a sample within the bound. It takes one sample (or twice its time) from the
        breach's count, since noise may produce it."""
        if row.seconds:
            self._lasting.breaks(row.name, self._known(row))
        elif row.name in self.samples and self._is_next(row):
            self.samples[row.name] -= 1
            if not self.samples[row.name]:
                del self.samples[row.name]

    def _is_next(self, row: Limit) -> bool:
        """Note a sample; return whether it counts. If the row needs several, they count at least
        ``SAMPLED`` s apart: a fast board repeats the error of one reading many times."""
        now = self.vehicle_state.now
        is_next = row.samples == 1 or now >= self._sampled.get(row.name, -math.inf) + SAMPLED
        if is_next:
            self._sampled[row.name] = now
        return is_next

    def _known(self, row: Limit) -> float:
        """Note that it is known now whether the row is breached; return the time, s. What was known
        before stands for ``STALE_AFTER`` at most; time beyond that counts neither way."""
        now, name = self.vehicle_state.now, row.name
        unseen = now - self._seen.get(name, now) - STALE_AFTER
        if unseen > 0.0:
            self._lasting.unseen(name, unseen)
        self._seen[name] = now
        return now
