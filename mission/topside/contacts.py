"""The boat's own knowledge of a vehicle that it watches: stored contacts, and its own alarms.

What does not live here: what is stored (dives), what overdue means (overdue).
"""

from __future__ import annotations

import threading
import time
from pathlib import Path

from mission.authoring.prepare import Unreadable, check_prepared, prepare_text
from mission.model.alarms import Alarm, Condition, standing
from mission.topside.dives import Dives, missing
from mission.topside.monitor import Watched
from mission.topside.overdue import Contact, contact_with, plan_of
from mission.topside.sources import ASK_UNDER_WATER_S
from mission.topside.underwater import PREFIX

KEEP_S = 10.0  # between two contacts that are stored
SILENT_S = 5.0  # without a frame: after that, nothing shown is current
SILENT_UNDER_WATER_S = 2 * ASK_UNDER_WATER_S + SILENT_S  # by modem: two looks that failed


class Contacts:
    """``to``: where the vehicle's commands go, the key of its entry; "": nothing is stored."""

    def __init__(self, to: str, memory: Path, vehicle: str | None = None) -> None:
        """``vehicle``: a file or the name of a shipped one; None: the one that a mission names."""
        self.dives = Dives(memory)
        self._to, self._kept, self._vehicle = to, -KEEP_S, vehicle
        self._learned: tuple[str, tuple[str, ...]] = ("", ())  # digest and lines checked last
        self.silent_s = SILENT_UNDER_WATER_S if to.startswith(PREFIX) else SILENT_S

    def remember(self, watched: Watched, now: float) -> None:
        """Store the last contact every few seconds, for a search."""
        if watched.at is None or not self._to or now < self._kept + KEEP_S:
            return
        self._kept = now
        self._learn(watched)
        self.dives.contact(self._to, _contact(watched, now))

    def started(self, digest: str) -> None:
        """Note that the mission was just started from here."""
        if self._to:
            self.dives.started(self._to, digest, time.time())

    def _learn(self, watched: Watched) -> None:
        """Check a mission that was not uploaded from here, in a separate thread."""
        told = digest, lines = str(watched.state.get("mission") or ""), watched.plan
        if not digest or not lines or told == self._learned:
            return
        self._learned = told
        if not self.dives.knows(digest):
            threading.Thread(target=self._prove, args=told, daemon=True).start()

    def _prove(self, digest: str, lines: tuple[str, ...]) -> None:
        """Store what the check proves; nothing if the mission is incomplete or its vehicle
        unknown."""
        try:
            prepared = prepare_text("\n".join(lines), "script", self._vehicle)
        except Unreadable:
            return
        proved = check_prepared(prepared).proved
        if proved is not None and prepared.chart.digest.startswith(digest):
            self.dives.uploaded(digest, plan_of(prepared, proved))

    def alarms(self, watched: Watched, now: float, live: bool) -> tuple[Alarm, ...]:
        """Return the alarms that only the boat can know: silence, overdue."""
        silent = watched.silence(now) if live else None
        gone = silent is not None and silent > self.silent_s
        is_heard = silent is not None and not gone
        late = "" if is_heard or not (live and self._to) else self._late()
        return standing(Condition(silent=silent if gone else None, overdue=late))

    def _late(self) -> str:
        wall = time.time()
        return missing(self.dives.missed(self._to, wall), self._to, wall)

    def due(self) -> float | None:
        """Return when the vehicle is at the surface at the latest, s since 1970 UTC; None: not
        known."""
        return self.dives.of(self._to).due if self._to else None


def _contact(watched: Watched, now: float) -> Contact:
    silent, begun = watched.silence(now), watched.age("mission_began", now)
    assert silent is not None  # a frame was received
    wall = time.time()
    return contact_with(watched.state, wall - silent, None if begun is None else wall - begun)
