"""What the boat remembers between two commands: plans that were uploaded, starts, last contacts.

    <folder>/dives.json     {"plans": {digest: Plan}, "boats": {url: Dive}}, the newest ``KEPT``

A file that cannot be read or written costs no command: then nobody knows when the vehicle is
overdue, and the words say so. What does not live here: what follows from it (overdue).
"""

from __future__ import annotations

import contextlib
import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from mission.model.plain import from_plain, to_plain
from mission.topside.overdue import Contact, Dive, Plan, heard

FILE = "dives.json"
KEPT = 50  # of plans, and of vehicles


def default_folder() -> Path:
    state = os.environ.get("XDG_STATE_HOME") or "~/.local/state"
    return Path(state).expanduser() / "auvmission" / "boat"


class Dives:
    def __init__(self, folder: Path) -> None:
        self._file = folder / FILE

    def of(self, url: str) -> Dive:
        return self._dive(self._read()["boats"].get(url))

    def uploaded(self, digest: str, plan: Plan) -> None:
        self._keep("plans", digest[:16], to_plain(plan))

    def started(self, url: str, digest: str, wall: float) -> None:
        """Notes a start. Of a dive that is under way already the time has begun before."""
        dive, plan = self.of(url), self._plan(digest)
        going_on = dive.started is not None and dive.plan == plan
        began = replace(dive, started=dive.started if going_on else wall, plan=plan)
        self._keep("boats", url, to_plain(began))

    def contact(self, url: str, contact: Contact) -> None:
        self._keep("boats", url, to_plain(heard(self.of(url), contact)))

    def _plan(self, digest: str) -> Plan | None:
        found = self._read()["plans"].get(digest[:16])
        with contextlib.suppress(ValueError, KeyError, TypeError):
            return from_plain(Plan, found) if found else None
        return None

    def _dive(self, found: Any) -> Dive:
        with contextlib.suppress(ValueError, KeyError, TypeError, AttributeError):
            return from_plain(Dive, found) if found else Dive()
        return Dive()

    def _read(self) -> dict[str, dict[str, Any]]:
        empty: dict[str, dict[str, Any]] = {"plans": {}, "boats": {}}
        try:
            found = json.loads(self._file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return empty
        tables = {name: found.get(name) for name in empty} if isinstance(found, dict) else {}
        return {name: t if isinstance(t := tables.get(name), dict) else {} for name in empty}

    def _keep(self, table: str, key: str, plain: Any) -> None:
        found = self._read()
        found[table].pop(key, None)
        found[table][key] = plain
        while len(found[table]) > KEPT:
            found[table].pop(next(iter(found[table])))
        beside = self._file.with_suffix(".new")
        with contextlib.suppress(OSError):
            self._file.parent.mkdir(parents=True, exist_ok=True)
            beside.write_text(json.dumps(found), encoding="utf-8")
            beside.replace(self._file)
