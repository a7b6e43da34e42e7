"""What happened, as text: a line for each record that matters to a person.

What does not live here: the dive as a whole (analysis.story), the log of a running serve (journal).
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from mission.engine.limits import LIMITS
from mission.model import Record, Step
from mission.model.regions import EMERGENCY
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.runtime import VEHICLE
from mission.onboard.stream.wellknown import ERROR, INFO, WARNING

HELD = " (held)"  # ends the reason of a repeated command
HELD_UP = "the surface is reached; it sank when it was let go, so it is held up by upward thrust"
_LIMIT = "limit "  # begins a limit's evaluation
_ANSWER = re.compile(rb"@ACK_([A-Z]{2})([A-Z])\$")  # a modem's envelope may hold several


@dataclass(frozen=True, slots=True)
class Event:
    t: float  # s, the engine's time
    level: int  # of a foxglove.Log
    of: str  # vehicle, engine, a link
    says: str


def events_of(record: Record) -> list[Event]:
    """The events of a record; an empty list for most records."""
    made = _EVENTS.get(record.kind)
    return [] if made is None else made(record)


def frame_text(data: bytes) -> str:
    """A frame as text: as it is if it is printable, else in hexadecimal."""
    printable = all(0x20 <= byte < 0x7F for byte in data.rstrip(b"\r\n"))
    return data.decode("ascii").rstrip() if printable else data.hex(" ")


def _start(record: Record) -> list[Event]:
    start = rec.read_start(record)
    kept = f", under way before: {start.store.under_way}" if start.store.under_way else ""
    what = f"the program begins, version {start.version}, vehicle {start.vehicle.name}{kept}"
    broken = [Event(0.0, ERROR, "store", text) for text in start.store.damage]
    return [Event(0.0, WARNING if kept else INFO, "program", what), *broken]


def limit_of(step: Step) -> str:
    """The name of the limit that acted, "" if none did; the event is only that step's input."""
    if step.trigger != "limit":
        return ""
    seen = (one.trigger for one in step.evaluations if one.result)
    return next((name.removeprefix(_LIMIT) for name in seen if name.startswith(_LIMIT)), "")


def bound_of(limit: str) -> str:
    """The meaning of a limit, as text; "" for a limit of another version."""
    return f": {LIMITS[limit].bound}" if limit in LIMITS else ""


def reason_of(step: Step) -> str:
    """Why a state was entered, if no edge of the mission tells it: the reason of its command, the
    limit that acted, or the input."""
    if step.actions:
        return step.actions[0].partition(": ")[2]
    if limit := limit_of(step):
        return f"limit {limit}{bound_of(limit)}{_passed(step, limit)}"
    if step.trigger == "surfaced":  # no stop was sent: it sank again after its ascent
        return HELD_UP
    if step.trigger == "forgotten":
        return "no M of the operator for too long"
    return step.event if step.trigger in ("", "load", "clear") else f"{step.trigger}, {step.event}"


def _passed(step: Step, limit: str) -> str:
    """The depth at which a limit of depth acted, as text."""
    seen = [value for one in step.evaluations for name, value in one.values if name == "depth"]
    return f" (depth {seen[0]:.1f} m)" if "depth" in limit and seen and seen[0] is not None else ""


def _step(record: Record) -> list[Event]:
    step = rec.step_of(record.payload)
    t, why = step.t, step.trigger or step.event
    if step.entered:
        path = step.entered[-1]
        level = WARNING if path.startswith(EMERGENCY) else INFO
        because = f" - {step.event}" if step.event != why else ""
        if level == WARNING and (step.actions or step.trigger in ("limit", "surfaced")):
            why, because = reason_of(step), ""
        found = [Event(t, level, "engine", f"now {path}: {why}{because}")]
    elif step.actions:
        found = []
    else:
        found = [Event(t, INFO, "engine", f"{why}: nothing follows")]
    return found + [Event(t, INFO, "engine", f"asks for {action}") for action in step.actions]


def answers_in(data: bytes) -> Iterator[tuple[str, bool]]:
    """Yield each command that these bytes to an operator answer, such as ``AA``, and whether they
    refuse it."""
    for word, letter in _ANSWER.findall(data):
        yield word.decode(), letter == b"N"


def _tx(record: Record) -> list[Event]:
    """A repeated command gives no event: its first send gave one."""
    tx = rec.read_tx(record)
    if tx.link == VEHICLE:
        if tx.reason.endswith(HELD):
            return []
        return [Event(tx.t, INFO, "vehicle", f"sent {frame_text(tx.data)} - {tx.reason}")]
    to = f"{tx.link} {tx.address}".rstrip()
    words = [word for word, refused in answers_in(tx.data) if refused]
    return [Event(tx.t, WARNING, to, f"refused: @ACK_{word}N$ - {tx.reason}") for word in words]


def _fault(record: Record) -> list[Event]:
    plain = json.loads(record.payload)
    says = f"no frame: {plain['kind']}, {plain['length']} bytes"
    return [Event(record.t, WARNING, plain["link"], says)]


def _link(says: str) -> Callable[[Record], list[Event]]:
    def made(record: Record) -> list[Event]:
        link, address = rec.read_texts(record)
        return [Event(record.t, INFO, f"{link} {address}".rstrip(), says)]

    return made


def _store(record: Record) -> list[Event]:
    number, failed = rec.read_texts(record)
    return [Event(record.t, ERROR, "store", f"write {number} failed: {failed}")]


def _ending(record: Record) -> list[Event]:
    at_once = rec.read_texts(record) == (rec.AT_ONCE,)
    says = "the program is to end at once" if at_once else "the program is to end"
    return [Event(record.t, WARNING, "program", says)]


def _mission(record: Record) -> list[Event]:
    plain = json.loads(record.payload)
    if not plain["digest"]:
        return [Event(record.t, INFO, "store", "no mission is stored")]
    says = f"mission {plain['digest'][:8]} is stored, {len(plain['lines'])} lines"
    return [Event(record.t, INFO, "store", says)]


def _navigation(record: Record) -> list[Event]:
    return [Event(record.t, INFO, "program", "the position filter is loaded")]


_EVENTS: Mapping[str, Callable[[Record], list[Event]]] = MappingProxyType(
    {
        rec.START: _start,
        rec.STEP: _step,
        rec.TX: _tx,
        rec.FAULT: _fault,
        rec.CONNECTED: _link("is connected"),
        rec.DISCONNECTED: _link("is gone"),
        rec.STORE: _store,
        rec.ENDING: _ending,
        rec.MISSION: _mission,
        rec.NAVIGATION: _navigation,
    }
)
