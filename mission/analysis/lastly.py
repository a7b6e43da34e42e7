"""The end of a recording: where the vehicle was, how it drifts, what somebody has to do.

    steps, states, fixes and reports --Lastly--> sentences

The position is the last estimate. The drift is the least-squares slope of the fixes of the last
``DRIFT_S`` during which everything was stopped. What does not live here: the greatest distance
(extremes), sinking at rest (resting).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from mission.analysis.extremes import TRACKED_BY
from mission.engine.thrust import THRUSTERS
from mission.engine.words import in_words
from mission.model import STOPPED, SURFACED, SURFACING, Position, Step
from mission.model.regions import EMERGENCY, IDLE
from mission.model.shown import clock
from mission.navigation.geodesy import LocalFrame
from mission.onboard.stream.derived import Message
from mission.onboard.stream.events import HELD_UP, reason_of
from mission.onboard.stream.topics import FIX, STATE, TELEMETRY
from protocol.messages import Order

DRIFT_S = 60.0
_LEAST_S, _LEAST_FIXES = 8.0, 5  # with less, no drift is reported
_TURNS = 0.02  # share of full thrust above which a thruster turns, as in the engine
_WINDS = ("north", "northeast", "east", "southeast", "south", "southwest", "west", "northwest")

Drift = tuple[float, float, float]  # m/s to the north and to the east, one sigma of each


class Lastly:
    """The end of one run of the program. ``reports``: what the vehicle can report. ``home``: that
    of the recording before; distances are measured from it until a mission starts in this
    recording."""

    def __init__(self, reports: frozenset[str] = frozenset(), home: Position | None = None) -> None:
        self._tracked = bool(reports & TRACKED_BY)
        self._before = home
        self._path, self._since, self._held = "", 0.0, False
        self._place: tuple[float, float, float, float] | None = None  # t, degrees, 95 % radius
        self._fixes: list[tuple[float, float, float]] = []  # t, degrees
        self._thrusters: Mapping[str, float] | None = None
        self._reported = 0.0  # s, when the thrusters were reported

    def step(self, step: Step) -> None:
        if step.trigger == "start":
            self._before = None
        if step.entered:
            self._path, self._since = step.entered[-1], step.t
            self._held = self._path == SURFACED and reason_of(step) == HELD_UP
        elif self._held and any(words.startswith(in_words(Order.STOP)) for words in step.actions):
            self._held, self._since = False, step.t

    def receive(self, message: Message) -> None:
        said = message.value
        if message.topic == STATE and said["latitude_deg"] is not None:
            place = said["latitude_deg"], said["longitude_deg"], said["radius_95_m"] or 0.0
            self._place = message.t, *place
        elif message.topic == FIX:
            fixes = [fix for fix in self._fixes if fix[0] >= message.t - DRIFT_S]
            self._fixes = [*fixes, (message.t, said["latitude_deg"], said["longitude_deg"])]
        elif message.topic == TELEMETRY:
            self._thrusters = dict(list(said["actuators"].items())[:THRUSTERS])
            self._reported = message.t

    def home(self, origin: Position | None) -> Position | None:
        """Return the point that distances are measured from; ``origin``: of this recording's
        estimate."""
        return self._before or origin

    def away(self, state: Mapping[str, Any]) -> float | None:
        """Return the distance of a state from home, m."""
        if not self._tracked or state["north_m"] is None:
            return None
        if self._before is None or state["latitude_deg"] is None:
            return math.hypot(state["north_m"], state["east_m"])
        return math.hypot(*_apart(self._before, state["latitude_deg"], state["longitude_deg"]))

    def says(self, end: float, origin: Position | None, deep_known: bool) -> Iterator[str]:
        """``deep_known``: the depth can be believed at the end."""
        if self._tracked:
            yield from self._where(end, self.home(origin))
        drift = self._drift(end) if self._rests else None
        if drift is not None:
            yield _drifting(*drift)
        yield from self._turning()
        yield from self._to_do(deep_known)

    @property
    def _rests(self) -> bool:
        return self._path.startswith(f"{IDLE}/") or self._path in (STOPPED, SURFACED)

    def _where(self, end: float, home: Position | None) -> Iterator[str]:
        if self._place is None:
            yield "Where it was at the end is not known: there is no estimate of its place."
            return
        t, latitude, longitude, radius = self._place
        at = "At the end" if end - t < DRIFT_S else f"At {clock(t)}, when it last knew,"
        sure = f"95 % sure within {radius:.0f} m"
        said = f"{at} it was at {degrees(latitude, longitude)} ({sure})"
        if home is not None:
            north, east = _apart(home, latitude, longitude)
            first = "the home of the first recording" if self._before else "home"
            said += f", {math.hypot(north, east):.0f} m {_wind(north, east)} of {first}"
        yield f"{said}."
        if self._fixes and self._fixes[-1][0] > t:
            yield self._after(Position(latitude, longitude))

    def _after(self, estimate: Position) -> str:
        """Describe a fix that the estimate does not include yet."""
        t, *fix = self._fixes[-1]
        away = math.hypot(*_apart(estimate, *fix))
        return f"A fix came after that, at {clock(t)}: {degrees(*fix)}, {away:.0f} m from there."

    def _drift(self, end: float) -> tuple[Drift, float] | None:
        """Return the drift and the time that it was measured over, s."""
        since = max(self._since, end - DRIFT_S)
        fixes = [fix for fix in self._fixes if fix[0] >= since]
        if len(fixes) < _LEAST_FIXES or fixes[-1][0] - fixes[0][0] < _LEAST_S:
            return None
        zero = Position(*fixes[0][1:])
        drift = slope([(t, *_apart(zero, *place)) for t, *place in fixes])
        return drift, fixes[-1][0] - fixes[0][0]

    def _turning(self) -> Iterator[str]:
        if self._thrusters is None or not self._thrusters:
            return
        on = {name: share for name, share in self._thrusters.items() if abs(share) > _TURNS}
        if not on:
            yield "By its last report no thruster turns."
            return
        said = ", ".join(f"{name} {100 * share:.0f} %" for name, share in on.items())
        if self._rests and not self._held and self._reported <= self._since:
            before = f"By its last report, at {clock(self._reported)}, thrusters turned: {said}."
            yield f"{before} It was stopped after that, and has told nothing of them since."
            return
        yield f"By its last report thrusters still turn: {said}."

    def _to_do(self, deep_known: bool) -> Iterator[str]:
        if self._held:
            yield (
                "Only upward thrust holds it up, for it sank when it was let go: take hold of it "
                "before anybody says stop or clear, and before its battery is empty."
            )
        if self._path == SURFACING:
            yield "Its ascent was not over: somebody has to see to it that it comes up."
        if self._path.startswith(EMERGENCY):
            again = "" if deep_known else ", twice, for its depth is not known"
            yield f"The emergency is latched: no mission starts before somebody clears it{again}."
        if self._rests:
            yield "Nothing holds it in its place or brings it home: it has to be fetched."


def degrees(latitude: float, longitude: float) -> str:
    north, east = "N" if latitude >= 0.0 else "S", "E" if longitude >= 0.0 else "W"
    return f"{abs(latitude):.5f} {north} {abs(longitude):.5f} {east}"


def slope(places: Sequence[tuple[float, float, float]]) -> Drift:
    """Fit a straight line to three or more (t, north, east)."""
    count = len(places)
    t0, n0, e0 = (sum(column) / count for column in zip(*places, strict=True))
    along = sum((t - t0) ** 2 for t, _, _ in places)
    north = sum((t - t0) * (n - n0) for t, n, _ in places) / along
    east = sum((t - t0) * (e - e0) for t, _, e in places) / along
    off = ((n - n0 - north * (t - t0), e - e0 - east * (t - t0)) for t, n, e in places)
    left = sum(a * a + b * b for a, b in off)
    return north, east, math.sqrt(left / (2 * count - 4) / along)


def _drifting(drift: Drift, seconds: float) -> str:
    north, east, sure = *drift[:2], 2.0 * drift[2]
    speed, by = math.hypot(north, east), f"by its fixes of the last {seconds:.0f} s"
    if speed < sure:
        return f"Whether it drifts cannot be told: less than {speed + sure:.1f} m/s, {by}."
    give = f"give or take {sure:.2f} m/s"
    return f"It drifts {speed:.2f} m/s to the {_wind(north, east)}, {give}, {by}."


def _wind(north: float, east: float) -> str:
    bearing = round(math.degrees(math.atan2(east, north))) % 360
    return f"{_WINDS[round(bearing / 45) % 8]} ({bearing:03} deg)"


def _apart(home: Position, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
    """Return north and east of home, m."""
    angles = math.radians(latitude_deg), math.radians(longitude_deg)
    return LocalFrame(home).to_local(*angles)
