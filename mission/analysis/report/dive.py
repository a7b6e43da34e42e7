"""The data of one recording on a page: series of values, legs by time, the plan, the fixes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mission.analysis.chapters import Chapter
from mission.analysis.doubts import Spell
from mission.analysis.extremes import TRACKED_BY
from mission.analysis.journal import began, goes_on, recordings, start_of
from mission.analysis.smoothing import Track, smooth
from mission.analysis.story import Teller
from mission.model import AUTONOMOUS, Position, Record, Step
from mission.model.vehicle import Vehicle
from mission.navigation.filter import Array
from mission.navigation.geodesy import LocalFrame
from mission.onboard.blackbox import Gap, first_part, notes_of
from mission.onboard.runtime import records as rec
from mission.onboard.stream.derived import Derivation, Message
from mission.onboard.stream.senses import Sensed, Senses
from mission.onboard.stream.topics import FIX, PLAN, POSITION, STATE, TELEMETRY

_BLINK_S = 0.05  # shorter legs get no colour
Point = tuple[float, float]  # east, north of the origin, m


@dataclass(frozen=True, slots=True)
class Stay:
    """Time in a leg, s."""

    leg: str
    begin: float
    end: float


@dataclass(slots=True)
class Dive:
    """One recording. Values are as in their topics. ``smoothed`` is None if there is no fix to
    place the track. ``notes``: a simulation's own notes, including seed and sea."""

    vehicle: Vehicle
    wall: float  # s since 1970 UTC at time 0
    name: str = ""  # name of its file
    items: Sequence[Record | Gap] = ()
    notes: Mapping[str, str] = field(default_factory=dict)
    missions: dict[str, None] = field(default_factory=dict)  # missions that were started, in order
    origin: Position | None = None
    home: Position | None = None  # distances count from here: home of the first of its recordings
    states: list[Mapping[str, Any]] = field(default_factory=list)
    telemetry: list[Mapping[str, Any]] = field(default_factory=list)
    fixes: list[Mapping[str, Any]] = field(default_factory=list)
    places: list[tuple[float, float, float]] = field(default_factory=list)  # t, degrees
    covariances: list[tuple[float, Array]] = field(default_factory=list)  # of north and east, m^2
    standing: list[rec.Standing] = field(default_factory=list)
    plan: list[dict[str, Any]] = field(default_factory=list)
    moves: list[tuple[float, str]] = field(default_factory=list)  # begin of each leg; "" for none
    spells: Sequence[Spell] = ()  # of sensors that could not be believed
    story: Sequence[Chapter] = ()  # the events first, then the tables
    smoothed: Track | None = None
    goes_on: bool = False  # continues the dive before: the program restarted, no mission started

    @property
    def is_tracked(self) -> bool:
        """Whether the vehicle reports position or heading; else the estimate stays at home."""
        known = any(state["north_m"] is not None for state in self.states)
        return known and bool(self.vehicle.reports & TRACKED_BY)

    def series(self, values: Sequence[Mapping[str, Any]], name: str) -> tuple[Array, Array]:
        """Return times and values; NaN if not known."""
        told = [np.nan if one[name] is None else one[name] for one in values]
        return np.array([one["t"] for one in values]), np.array(told, dtype=float)

    def stays(self) -> list[Stay]:
        """Return the legs from step to step; if no step is recorded, from report to report."""
        if not self.moves:
            return self._reported_stays()
        end = max(self.states[-1]["t"] if self.states else 0.0, self.moves[-1][0])
        ends = [*(t for t, _ in self.moves[1:]), end]
        stays = [Stay(leg, t, over) for (t, leg), over in zip(self.moves, ends, strict=True)]
        return [stay for stay in stays if stay.leg and stay.end - stay.begin > _BLINK_S]

    def _reported_stays(self) -> list[Stay]:
        found: list[Stay] = []
        for one in self.states:
            if found and found[-1].leg == one["leg"]:
                found[-1] = Stay(one["leg"], found[-1].begin, one["t"])
            else:
                if found:
                    found[-1] = Stay(found[-1].leg, found[-1].begin, one["t"])
                found.append(Stay(one["leg"], one["t"], one["t"]))
        return [stay for stay in found if stay.leg]

    def local(self, latitude_deg: float, longitude_deg: float) -> Point:
        assert self.origin is not None
        angles = np.radians(latitude_deg), np.radians(longitude_deg)
        north, east = LocalFrame(self.origin).to_local(float(angles[0]), float(angles[1]))
        return east, north

    def _take(self, message: Message, derivation: Derivation) -> None:
        kept = {STATE: self.states, TELEMETRY: self.telemetry, FIX: self.fixes}
        if message.topic in kept:
            kept[message.topic].append(message.value)
        elif message.topic == POSITION:
            where = message.value["latitude"], message.value["longitude"]
            self.places.append((message.t, *where))
            ee, ne, _, _, nn = message.value["position_covariance"][:5]
            self.covariances.append((message.t, np.array([[nn, ne], [ne, ee]])))
        elif message.topic == PLAN:
            self.plan = json.loads(message.value["geojson"])["features"]
        standing, chart = derivation.standing, derivation.chart
        if standing is not None and standing.origin is not None:
            self.origin = standing.origin
        if chart is not None and message.topic == STATE and message.value["leg"]:
            self.missions[chart.mission.name] = None

    def _step(self, step: Step) -> None:
        if not step.entered:
            return
        region, _, leg = step.entered[-1].partition("/")
        leg = leg if region == AUTONOMOUS else ""
        if leg != (self.moves[-1][1] if self.moves else ""):
            self.moves.append((step.t, leg))

    @classmethod
    def of(
        cls,
        items: Sequence[Record | Gap],
        vehicle: Vehicle | None,
        home: Position | None = None,
    ) -> Dive:
        """Make a dive. ``vehicle``: used for smoothing instead of the recorded one. ``home``: that
        of the recording before, if the program only restarted. Raises ValueError, KeyError or
        TypeError for a start record of a version that cannot be read."""
        start = start_of(items)
        if start is None:
            raise ValueError("there is no whole start record, so nothing says what vehicle it is")
        begun = rec.read_start(start)
        dive = cls(begun.vehicle, begun.wall, items=items)
        senses, sensed = Senses(begun.vehicle), list[Sensed]()

        def seen(record: Record, messages: Sequence[Message], derivation: Derivation) -> None:
            sensed.extend(senses.hear(record))
            for message in messages:
                dive._take(message, derivation)
            if record.kind == rec.STEP:
                dive._step(rec.step_of(record.payload))
            if record.kind == rec.STANDING:
                dive.standing.append(rec.read_standing(record))

        teller = Teller(items, seen, home)
        dive.story, dive.spells = list(teller.chapters()), teller.spells()
        dive.home = teller.home
        if dive.fixes:
            dive.smoothed = smooth(sensed, vehicle or dive.vehicle, dive.origin)
        return dive


def dives_of(
    files: Sequence[Path], vehicle: Vehicle | None = None, notes: Mapping[str, str] | None = None
) -> list[Dive]:
    """Read each recording once, sorted by their starts. ``notes`` are added to those of the files.
    Raises BlackBoxError, and ValueError, KeyError or TypeError as Dive.of does."""
    read = [(path, recordings([path])[0]) for path in dict.fromkeys(map(first_part, files))]
    found: list[Dive] = []
    for path, items in sorted(read, key=lambda one: began(one[1])):
        goes = bool(found) and goes_on(found[-1].items, items)
        dive = Dive.of(items, vehicle, found[-1].home if goes else None)
        dive.name, dive.notes = path.name, {**notes_of(path), **(notes or {})}
        dive.goes_on = goes and not dive.missions
        found.append(dive)
    return found
