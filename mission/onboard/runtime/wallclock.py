"""Wall time from the engine's time: only for people to read, never for a decision (R10).

What does not live here: the system's clock; the caller of a runtime gives its time.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class WallClock:
    """``wall``: s since 1970 UTC at the engine's time 0; ``utc_offset``: s, of local time."""

    def __init__(self, wall: float, utc_offset: float) -> None:
        self._wall, self._utc_offset = wall, utc_offset

    def local(self, t: float) -> str:
        """``YYYY-MM-DDThh:mm:ss`` at the engine's time ``t``, in the topside's local time."""
        there = _EPOCH + timedelta(seconds=self._wall + self._utc_offset + t)
        return there.strftime("%Y-%m-%dT%H:%M:%S")

    def utc_date(self, t: float) -> str:
        """``YYYY-MM-DD``."""
        return (_EPOCH + timedelta(seconds=self._wall + t)).strftime("%Y-%m-%d")

    def set(self, local: str, now: float) -> None:
        """Set the clock: ``now`` is that local time. Raises ValueError if it is no time."""
        told = datetime.fromisoformat(local).replace(tzinfo=UTC) - _EPOCH
        self._wall = told.total_seconds() - self._utc_offset - now
