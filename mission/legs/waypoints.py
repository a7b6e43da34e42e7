"""Steers along a list of points by line of sight: the pilot of goto, follow, rows and cover.

The first line starts where the leg was entered. A point is reached within the radius. Any but the
last also counts once it is passed abeam, so that a missed point does not send the vehicle back.

What does not live here: which points (the legs), the heading along a line (guidance).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Self

from mission.legs import guidance
from mission.legs.base import Point, Track, View
from mission.legs.words import Measure
from mission.model.copies import copied
from protocol.messages import Setpoint

WITHIN = Measure("within", "m", 0.5, 1000, "how near counts as there; 10 m unless said", 10.0)


class Waypoints:
    """``points``: None for one that is not known; the vehicle is not steered to it. The first line
    starts at the first known position."""

    __slots__ = ("_base", "_heading", "_index", "_points", "_start", "_within")

    def __init__(
        self, base: Setpoint, points: tuple[Point | None, ...], within: float, view: View
    ) -> None:
        self._base, self._points, self._within = base, points, within
        self._start: Point | None = None
        self._index = 0
        self._heading = view.estimate.heading if view.estimate else None

    def setpoint(self, view: View) -> Setpoint:
        track = self._advance(view)
        if track is not None and view.estimate is not None:
            course = guidance.course_on(track)
            self._heading = guidance.heading_for(course, view.estimate)
        return replace(self._base, heading=self._heading)

    def finished(self, view: View) -> bool:
        self._advance(view)
        return self._index >= len(self._points)

    def track(self, view: View) -> Track | None:
        track = self._against(view)
        return None if track is None else replace(track, distance=abs(track.distance))

    def clone(self) -> Self:
        return copied(self)

    def _against(self, view: View) -> Track | None:
        if view.estimate is None or self._index >= len(self._points):
            return None
        point = self._points[self._index]
        if point is None:
            return None
        here = (view.estimate.north, view.estimate.east)
        return guidance.along(self._start or here, point, here)

    def _advance(self, view: View) -> Track | None:
        if self._start is None and view.estimate is not None:
            self._start = (view.estimate.north, view.estimate.east)
        while (track := self._against(view)) is not None:
            last = self._index == len(self._points) - 1
            passed = track.distance < 0.0 and not last
            if abs(track.distance) > self._within and not passed:
                return track
            self._start = self._points[self._index]
            self._index += 1
        return None


def arrival_fault(within: float) -> str:
    return "" if within > 0.0 else "the arrival radius (within) must be greater than 0"
