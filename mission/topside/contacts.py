"""What the boat itself makes of a vehicle that it watches: contacts kept, and its own alarms.

What does not live here: what is kept (dives), what overdue means (overdue).
"""

from __future__ import annotations

import time
from pathlib import Path

from mission.model.alarms import Alarm, Condition, standing
from mission.topside.dives import Dives
from mission.topside.monitor import Watched
from mission.topside.overdue import Contact, Dive, contact_with, heard, overdue
from mission.topside.sources import ASK_UNDER_WATER_S
from mission.topside.underwater import PREFIX

KEEP_S = 10.0  # between two contacts that are kept
SILENT_S = 5.0  # without a frame: nothing shown is of now
SILENT_UNDER_WATER_S = 2 * ASK_UNDER_WATER_S + SILENT_S  # of the modem: two looks that failed


class Contacts:
    """``to``: where the vehicle's commands go, by which it is remembered; "": it is not."""

    def __init__(self, to: str, memory: Path) -> None:
        self.dives = Dives(memory)
        self._to, self._kept = to, -KEEP_S
        self.silent_s = SILENT_UNDER_WATER_S if to.startswith(PREFIX) else SILENT_S

    def remember(self, watched: Watched, now: float) -> None:
        """Keeps the last contact every few seconds, for whoever has to search."""
        if watched.at is None or not self._to or now < self._kept + KEEP_S:
            return
        self._kept = now
        self.dives.contact(self._to, _contact(watched, now))

    def alarms(self, watched: Watched, now: float, live: bool) -> tuple[Alarm, ...]:
        """What the boat alone knows: silence, overdue."""
        silent = watched.silence(now) if live else None
        gone = silent is not None and silent > self.silent_s
        late = overdue(self._dive(watched, now, live and not gone), time.time()) if self._to else ""
        return standing(Condition(silent=silent if gone else None, overdue=late))

    def _dive(self, watched: Watched, now: float, is_heard: bool) -> Dive:
        """The dive with the newest contact, which is not written to disk each time."""
        dive = self.dives.of(self._to)
        return heard(dive, _contact(watched, now)) if is_heard and watched.at is not None else dive


def _contact(watched: Watched, now: float) -> Contact:
    silent = watched.silence(now)
    assert silent is not None  # it was heard
    return contact_with(watched.state, time.time() - silent)
