"""A vehicle that lies on its side or upside down, by two or more successive reports.

reports --Turned--> sentences
"""

from __future__ import annotations

from collections.abc import Iterator

from mission.model.shown import clock, duration

_OVER_DEG = 90.0
_REPORTS = 2


class Turned:
    """Pitch and roll in degrees, None if not known."""

    def __init__(self) -> None:
        self._since, self._count, self._roll = 0.0, 0, 0.0

    def report(self, t: float, pitch: float | None, roll: float | None) -> Iterator[str]:
        if pitch is None or roll is None:
            return
        if max(abs(pitch), abs(roll)) <= _OVER_DEG:
            lasted, turned = t - self._since, self._is_told
            self._count = 0
            if turned:
                yield f"{clock(t)}: its reports say that it is upright again, after {_s(lasted)}."
            return
        self._since = self._since if self._count else t
        self._count, self._roll = self._count + 1, roll
        if self._count == _REPORTS:
            tilt = f"roll {roll:.0f} deg, pitch {pitch:.0f} deg"
            yield f"{clock(self._since)}: it turned over, by its own reports: {tilt}."

    def at_last(self, end: float) -> Iterator[str]:
        if self._is_told:
            lasted = f"(roll {self._roll:.0f} deg), for {_s(end - self._since)} by then"
            yield f"By its last report it still lies turned over {lasted}."

    @property
    def _is_told(self) -> bool:
        return self._count >= _REPORTS


def _s(seconds: float) -> str:
    return duration(round(seconds))
