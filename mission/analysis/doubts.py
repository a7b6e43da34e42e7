"""Which sensors could not be believed, and when: the health checks as on board, on recorded inputs.

    records --Doubts--> spells of disbelief, sensor by sensor

The thrust that the engine applied is not used here. If only the thrust contradicts a depth, the
limit "depth contradicted" reports it. What does not live here: what health is (navigation.health).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from mission.analysis.resting import SILENT_S
from mission.model import Health, Record
from mission.model.shown import clock, duration
from mission.model.vehicle import Vehicle
from mission.navigation.health import CHANNELS, SENSORS, SensorHealth
from mission.onboard.runtime import records as rec
from mission.onboard.stream.senses import CLOCKS, Senses
from protocol.messages import Fix, Telemetry

DOUBTED = tuple(name for name in SENSORS if name != "position")  # no fix under water
CONTRADICTED = "depth contradicted"  # the name of the limit
_ABOARD = "contradicted on board"
_BLINK_S = 1.0
_MEANS = {
    ("attitude", "absurd"): "absurd, or on its side or back",  # beyond 90 deg
    ("altitude", "absurd"): "absurd, or without an echo",  # the altimeter then reports 0
}


@dataclass(frozen=True, slots=True)
class Spell:
    """A period in which a sensor could not be believed, noticed at ``begin`` and over at ``end``.
    ``since``: when the fault began: the last report before a silence, the first of a frozen value;
    None if that is when it was noticed."""

    sensor: str
    begin: float
    end: float
    reason: str
    since: float | None = None

    @property
    def first(self) -> float:
        return self.begin if self.since is None else self.since


class Timeline:
    """Collects spells, sensor by sensor."""

    def __init__(self, sensors: Iterable[str]) -> None:
        self._sensors = [name for name in DOUBTED if name in sensors]
        self._open: dict[str, tuple[float, str, float | None]] = {}  # noticed, what, since when
        self._closed: list[Spell] = []

    def look(
        self,
        health: Callable[[str, float], Health],
        t: float,
        stands: Callable[[str], float | None] = lambda _: None,
    ) -> None:
        """Record each sensor's health at ``t``. ``stands``: since when a frozen sensor repeats its
        value."""
        for sensor in self._sensors:
            seen = health(sensor, t)
            begin, was, since = self._open.get(sensor, (t, "", None))
            if seen.reason == was:
                continue
            if was:
                self._closed.append(Spell(sensor, begin, t, was, since))
            self._open[sensor] = (t, seen.reason, _since(seen, t, stands(sensor)))

    def spells(self, end: float) -> tuple[Spell, ...]:
        last = [Spell(s, at, end, why, since) for s, (at, why, since) in self._open.items() if why]
        return tuple(sorted([*self._closed, *last], key=lambda s: (s.sensor, s.begin)))


def _since(health: Health, t: float, stands: float | None) -> float | None:
    """Return when the fault that was noticed at ``t`` began."""
    if health.reason == "stale":
        return t - health.age
    return stands if health.reason == "frozen" else None


class Doubts:
    """The doubts in one run of the program, from its first report on."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._senses = Senses(vehicle)
        self._health = SensorHealth(vehicle.reports, vehicle.stale_after)
        self._timeline = Timeline(vehicle.reports)
        self._stood: dict[str, tuple[float, float]] = {}  # channel: its value, and since when
        self._heard = False
        self._contradicted = False  # the engine contradicts the depth

    def receive(self, record: Record) -> None:
        """Update the health with one record. A sensor that stops reporting becomes stale. Nothing
        is in doubt before the first report."""
        if record.kind == rec.STANDING:
            self._contradicted = CONTRADICTED in rec.read_standing(record).breached
        for sensed in self._senses.hear(record):
            if isinstance(sensed, Telemetry):
                self._health.telemetry(sensed)
                self._note_values(sensed.t)
                self._heard = True
            elif isinstance(sensed, Fix):
                self._health.fix(sensed)
        if self._heard and record.kind in CLOCKS:
            self._timeline.look(self._of, record.t, self._stands)

    def _note_values(self, t: float) -> None:
        for name, monitor in self._health.monitors.items():
            if monitor.t == t and self._stood.get(name, (math.nan, t))[0] != monitor.value:
                self._stood[name] = monitor.value, t

    def _stands(self, sensor: str) -> float | None:
        """Return since when the sensor's frozen channels repeat their value; None if none is."""
        frozen = (n for n, m in self._health.monitors.items() if m.reason == "frozen")
        since = [self._stood[n][1] for n in frozen if CHANNELS[n].sensor == sensor]
        return min(since, default=None)

    def reason(self, sensor: str, t: float) -> str:
        """Return why the sensor cannot be believed; "" if it can."""
        return self._of(sensor, t).reason

    def believes(self, sensor: str, t: float) -> bool:
        return self._of(sensor, t).valid

    def _of(self, sensor: str, t: float) -> Health:
        health = self._health.of(sensor, t)
        if sensor == "depth" and self._contradicted and health.valid:
            return Health(False, _ABOARD, health.age)
        return health

    def spells(self, end: float) -> Sequence[Spell]:
        return self._timeline.spells(end)


def summed(spells: Iterable[Spell]) -> list[tuple[str, ...]]:
    """Return table rows: sensor, reason, when the first fault began, when it was noticed, when the
    last one ended, how often, total time. Totals shorter than ``_BLINK_S`` are left out."""
    found: dict[tuple[str, str], list[Spell]] = {}
    for spell in spells:
        found.setdefault((spell.sensor, spell.reason), []).append(spell)
    rows: list[tuple[str, ...]] = []
    for (sensor, reason), some in found.items():
        if (total := lasting(some)) >= _BLINK_S:
            when = tuple(map(clock, (some[0].first, some[0].begin, some[-1].end)))
            reason = _MEANS.get((sensor, reason), reason)
            rows.append((sensor, reason, *when, str(len(some)), duration(round(total))))
    return rows


def lasting(spells: Iterable[Spell]) -> float:
    """Return the total length of the spells, s."""
    return sum(spell.end - spell.first for spell in spells)


def doubted_depth(spells: Iterable[Spell], fixes: Iterable[float]) -> Iterator[str]:
    """Say that the depth could not be believed for ``SILENT_S`` or more in total. ``fixes``: times
    of the fixes, s."""
    deep = [spell for spell in spells if spell.sensor == "depth"]
    if (lasted := lasting(deep)) < SILENT_S:
        return
    reasons = ", ".join(dict.fromkeys(spell.reason for spell in deep))
    when = f"between {clock(deep[0].first)} and {clock(deep[-1].end)}"
    found = [t for t in fixes if any(one.first <= t <= one.end for one in deep)]
    known = "how deep it truly was then is not known"
    if found:
        came = f"{len(found)} fixes came between {clock(found[0])} and {clock(found[-1])}"
        known = f"{known}, but {came}, and those come at the surface alone"
    lasts = duration(round(lasted))
    yield f"Its depth was not to be believed ({reasons}) for {lasts} {when}: {known}."
