"""Events at the surface or at rest that no decision records: no fix came, or the vehicle sank.

    reports, fixes and states --Unfixed, Sunk--> sentences

The module unsaid combines these with its own.
"""

from __future__ import annotations

from collections.abc import Iterator

from mission.model.regions import EMERGENCY, IDLE
from mission.model.shown import clock, duration

WAITED_S = 30.0  # at the surface without a fix: a longer time is reported
GAP_S = 10.0  # the same if fixes came steadily before
_STEADY_S, _STEADY = 5.0, 5  # s between two fixes, and so many in a row: steady
SILENT_S = 5.0  # between two reports
_TOP_M = 1.0  # a receiver works down to this depth
_SANK_M = 2.0
_AT_REST = (f"{IDLE}/", f"{EMERGENCY}/stopped", f"{EMERGENCY}/surfaced")


class Unfixed:
    """Times at the surface, by believed reports, without a fix."""

    def __init__(self) -> None:
        self._since: float | None = None  # since when at the surface, or the last fix there
        self._reported = 0.0
        self._steady = 0  # fixes in a row

    def report(self, t: float, depth: float | None, believed: bool) -> Iterator[str]:
        silent, self._reported = t - self._reported > SILENT_S, t
        if silent:
            self._since = None
        if believed and depth is not None and depth < _TOP_M:
            self._since = t if self._since is None else self._since
        else:
            yield from self._over(t)
            self._steady = 0

    def fix(self, t: float) -> Iterator[str]:
        since = self._since
        if since is not None:
            yield from self._over(t)
            self._since = t
            self._steady = self._steady + 1 if t - since <= _STEADY_S else 0

    def at_last(self, end: float) -> Iterator[str]:
        yield from self._over(end)

    def _over(self, t: float) -> Iterator[str]:
        since, self._since = self._since, None
        if since is None:
            return
        waited = duration(round(t - since))
        if self._steady >= _STEADY and GAP_S <= t - since < WAITED_S:
            when = f"{clock(since)} to {clock(t)}"
            yield f"{when}: no fix for {waited}, though it was at the surface."
        elif t - since >= WAITED_S:
            yield f"{clock(t)}: until then it had been at the surface without a fix for {waited}."


class Sunk:
    """A vehicle that is deeper at the end of the recording than when it came to rest, by its
    reports, believed or not: an offset is in both depths."""

    def __init__(self) -> None:
        self._state, self._since = "", 0.0
        self._first: float | None = None
        self._last = 0.0

    def state(self, t: float, state: str) -> None:
        if state != self._state:
            self._state, self._since, self._first = state, t, None

    def report(self, depth: float | None) -> None:
        if depth is not None:
            self._first = depth if self._first is None else self._first
            self._last = depth

    def at_last(self) -> Iterator[str]:
        first = self._first
        if first is not None and self._state.startswith(_AT_REST) and self._last - first > _SANK_M:
            yield (
                f"It seems to have sunk in {self._state}: its reports said {first:.1f} m when that "
                f"began at {clock(self._since)}, and {self._last:.1f} m at last."
            )
