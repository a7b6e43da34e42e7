"""The boat's memory between two commands: plans, starts, last contacts, and addresses.

    <folder>/dives.json     {"plans": {digest: Plan}, "boats": {address: Dive},
                             "ways": {address: address}}, the newest ``KEPT`` of each

A vehicle is stored under the address at which it was first heard or started: a URL without the part
after ``?``. Other addresses can lead to the same vehicle. If a vehicle answers at an address, under
way with a mission that only one known vehicle is under way with, the address is another way to that
vehicle, until another mission is reported there. So a start by TCP is known by modem, too. If
nothing says which vehicle a silent address leads to, it may be any that is under way.

A file that cannot be read or written fails no command. Then nobody knows when the vehicle is
overdue, and the texts say so. What does not live here: what follows from it (overdue).
"""

from __future__ import annotations

import contextlib
import json
import os
import threading
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mission.model.plain import from_plain, to_plain
from mission.topside.overdue import Contact, Dive, Plan, heard, overdue

FILE = "dives.json"
KEPT = 50  # plans, vehicles and ways, each
DIGITS = 16  # digits of a digest
ONE_START_S = 60.0  # two reports of one start differ by less
SEARCHED_S = 3 * 86400.0  # after its due time: so long it is reported for silent addresses

Tables = dict[str, dict[str, Any]]


def default_folder() -> Path:
    state = os.environ.get("XDG_STATE_HOME") or "~/.local/state"
    return Path(state).expanduser() / "auvmission" / "boat"


class Dives:
    def __init__(self, folder: Path) -> None:
        self._file, self._held = folder / FILE, threading.Lock()

    def of(self, url: str) -> Dive:
        found = self._read()
        return _dive(found, _known_by(found, _address(url)))

    def missed(self, url: str, now: float) -> Mapping[str, Dive]:
        """Return the dives that a silence at ``url`` may concern, by address: the dive known to be
        under way there, else any other."""
        found = self._read()
        name = _known_by(found, _address(url))
        own = _dive(found, name)
        if own.started is not None:
            return {name: own}
        others = {one: _dive(found, one) for one in found["boats"]}
        return {
            one: dive
            for one, dive in others.items()
            if dive.due is not None and dive.due <= now <= dive.due + SEARCHED_S
        }

    def knows(self, digest: str) -> bool:
        return digest[:DIGITS] in self._read()["plans"]

    def uploaded(self, digest: str, plan: Plan) -> None:
        with self._held:
            found = self._read()
            _put(found["plans"], digest[:DIGITS], to_plain(plan))
            self._write(found)

    def started(self, url: str, digest: str, wall: float) -> None:
        """Note a start. A dive that continues keeps its start time."""
        with self._held:
            found = self._read()
            name, plan = _known_by(found, _address(url)), _plan(found, digest)
            dive = _dive(found, name)
            began = dive.started if dive.goes_on(plan, wall) else wall
            dive = replace(dive, started=began, plan=plan, mission=digest[:DIGITS])
            _put(found["boats"], name, to_plain(dive))
            self._write(found)

    def contact(self, url: str, contact: Contact) -> None:
        with self._held:
            found = self._read()
            name = _answering(found, _address(url), contact)
            dive = _begun(found, _dive(found, name), contact)
            _put(found["boats"], name, to_plain(dive))
            self._write(found)

    def _read(self) -> Tables:
        empty: Tables = {"plans": {}, "boats": {}, "ways": {}}
        try:
            found = json.loads(self._file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return empty
        tables = {name: found.get(name) for name in empty} if isinstance(found, dict) else {}
        return {name: t if isinstance(t := tables.get(name), dict) else {} for name in empty}

    def _write(self, found: Tables) -> None:
        beside = self._file.with_suffix(".new")
        with contextlib.suppress(OSError):
            self._file.parent.mkdir(parents=True, exist_ok=True)
            beside.write_text(json.dumps(found), encoding="utf-8")
            beside.replace(self._file)


def missing(found: Mapping[str, Dive], own: str, now: float) -> str:
    """Describe what is overdue in ``found``, "" for nothing. ``own``: the URL that is asked."""
    told = {name: overdue(dive, now) for name, dive in found.items()}
    return "; ".join(
        words if name == _address(own) else f"{_called(name, found[name])}: {words}"
        for name, words in told.items()
        if words
    )


def _called(name: str, dive: Dive) -> str:
    return name if dive.plan is None else f"{dive.plan.name}, known by {name}"


# --- one read of the file ------------------------------------------------------------------------


def _address(url: str) -> str:
    return url.partition("?")[0]


def _put(table: dict[str, Any], key: str, plain: Any) -> None:
    table.pop(key, None)
    table[key] = plain
    while len(table) > KEPT:
        table.pop(next(iter(table)))


def _known_by(found: Tables, way: str) -> str:
    """Return the address under which a vehicle that answers there is stored."""
    name = found["ways"].get(way)
    return name if isinstance(name, str) and name in found["boats"] else way


def _dive(found: Tables, name: str) -> Dive:
    plain = found["boats"].get(name)
    with contextlib.suppress(ValueError, KeyError, TypeError, AttributeError):
        return from_plain(Dive, plain) if plain else Dive()
    return Dive()


def _plan(found: Tables, digest: str) -> Plan | None:
    plain = found["plans"].get(digest[:DIGITS])
    with contextlib.suppress(ValueError, KeyError, TypeError):
        return from_plain(Plan, plain) if plain else None
    return None


def _answering(found: Tables, way: str, contact: Contact) -> str:
    """Return the address under which the vehicle that answered there is stored; update the ways."""
    name = _known_by(found, way)
    if name != way and contact.mission and contact.mission != _dive(found, name).mission:
        del found["ways"][way]  # another vehicle is there
        name = way
    if name == way and _dive(found, way).started is None:
        same = [one for one in found["boats"] if one != way and _is_of(_dive(found, one), contact)]
        if len(same) == 1:
            (name,) = same
            _put(found["ways"], way, name)
    return name


def _is_of(dive: Dive, contact: Contact) -> bool:
    """Whether the contact belongs to the dive. An idle vehicle may be any that holds the mission,
    so it never does."""
    if dive.started is None or contact.is_over or not contact.mission:
        return False
    at_once = contact.began is None or abs(contact.began - dive.started) < ONE_START_S
    return dive.mission == contact.mission and at_once


def _begun(found: Tables, before: Dive, contact: Contact) -> Dive:
    """Update a dive, also one that somebody else started. It begins at once if the vehicle reports
    when it began. Else it begins when the vehicle was under way in two contacts, so that a start
    from here is noted first."""
    dive, seen = heard(before, contact), before.contact
    if dive.started is not None or not contact.is_under_way:
        return dive
    plan = _plan(found, contact.mission)
    began = contact.began
    if began is None and seen is not None and seen.mission == contact.mission:
        began = seen.wall if seen.is_under_way else None
    return dive if plan is None or began is None else Dive(began, plan, contact, contact.mission)
