"""Black boxes as lines: the journal, or any topic, sorted by wall time.

    paths --recordings, sorted by their start--> Lines, with a line for each gap and restart

What does not live here: topics (stream), the dive as a whole (story).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from mission.analysis.replay.rerun import failed_writes, feed, runtime_from
from mission.model import Record
from mission.onboard.blackbox import FLUSH_S, Gap, GrowingBox, first_part, recording, told_start
from mission.onboard.runtime import records as rec
from mission.onboard.stream import wellknown
from mission.onboard.stream.derived import Derivation
from mission.onboard.stream.events import events_of
from mission.onboard.stream.topics import DERIVED, JOURNAL, TOPICS
from mission.onboard.stream.wellknown import ERROR, WARNING

LEVELS = {WARNING: "warning", ERROR: "fault"}
_DERIVED = frozenset(topic.name for topic in DERIVED)
_ALL: frozenset[str] = frozenset({JOURNAL})


UNTIMED = "time not known"


class UnknownTopic(ValueError):
    """The topic does not exist; the message lists those that do."""


@dataclass(frozen=True, slots=True)
class Line:
    """One line. ``wall``: s since 1970 UTC; the same as ``t`` if no start record gives the date.
    ``value``: by the topic's schema."""

    t: float
    wall: float
    topic: str
    value: Mapping[str, Any]

    def __str__(self) -> str:
        clock = datetime.fromtimestamp(self.wall, UTC).strftime("%Y-%m-%d %H:%M:%S.%f")[:-3]
        head = f"{clock if self.wall > self.t else UNTIMED:23} {self.t:10.3f}"
        if self.topic != JOURNAL:
            return f"{head}  {self.topic}  {json.dumps(self.value)}"
        level = LEVELS.get(self.value["level"], "")
        return f"{head}  {level:7} {self.value['name']}: {self.value['message']}"


@dataclass(frozen=True, slots=True)
class Wanted:
    """Filter of lines: of ``topics``, from ``since`` to ``until`` (the engine's time, s), with
    ``text`` anywhere in the line, ignoring case. Raises UnknownTopic."""

    topics: frozenset[str] = _ALL
    since: float = 0.0
    until: float = float("inf")
    text: str = ""

    def __post_init__(self) -> None:
        for name in self.topics - TOPICS.keys():
            raise UnknownTopic(f"no topic {name!r}; there are {', '.join(TOPICS)}")

    def takes(self, line: Line) -> bool:
        if line.topic not in self.topics or not self.since <= line.t <= self.until:
            return False
        return not self.text or self.text.lower() in str(line).lower()


def recordings(paths: Sequence[Path]) -> list[list[Record | Gap]]:
    """Read each recording once, sorted by the wall time of its start. To a recording of the first
    form add the records that this form lacks. Raises BlackBoxError."""
    read = [_begun(path) for path in dict.fromkeys(map(first_part, paths))]
    return sorted((_with_standing(items) for items in read), key=began)


def _begun(path: Path) -> list[Record | Gap]:
    """Read a recording. If its start record is lost, rebuild it from the file's attachments."""
    items = list(recording(path))
    start = None if start_of(items) is not None else told_start(path)
    return items if start is None else [start, *items]


def _with_standing(items: list[Record | Gap]) -> list[Record | Gap]:
    """Add what the first form lacks by running the inputs again; unchanged if inputs are
    missing."""
    start, records = start_of(items), [item for item in items if isinstance(item, Record)]
    damaged = any(isinstance(item, Gap) and not item.cut for item in items)
    if start is None or damaged or rec.read_start(start).form >= rec.FORM:
        return items
    again = rec.ListRecorder()
    runtime = runtime_from(rec.read_start(start), failed_writes(records), again)
    for record in records:
        feed(runtime, record)
    return [*again.records, *(item for item in items if isinstance(item, Gap))]


def began(items: Sequence[Record | Gap]) -> float:
    """Return the wall time of the start, s since 1970 UTC; 0 without a start record."""
    start = start_of(items)
    return rec.read_start(start).wall if start else 0.0


def start_of(items: Sequence[Record | Gap]) -> Record | None:
    first = next((item for item in items if isinstance(item, Record)), None)
    return first if first is not None and first.kind == rec.START else None


def lines(items: Iterable[Record | Gap], wanted: Wanted) -> Iterator[Line]:
    """Yield the lines of one recording."""
    reading = Lines(wanted)
    for item in items:
        yield from reading.receive(item)


class Lines:
    """The lines of one recording, item by item."""

    def __init__(self, wanted: Wanted) -> None:
        self._wanted = wanted
        self._derivation: Derivation | None = None
        self._t = 0.0

    def receive(self, item: Record | Gap) -> list[Line]:
        made = self._of_gap(item) if isinstance(item, Gap) else list(self._of_record(item))
        return [line for line in made if self._wanted.takes(line)]

    def _of_gap(self, gap: Gap) -> list[Line]:
        level = WARNING if gap.whole else ERROR
        value = {"level": level, "name": "black box", "message": str(gap)}
        return [Line(self._t, self._wall(self._t), JOURNAL, value)]

    def _of_record(self, record: Record) -> Iterator[Line]:
        self._t = record.t
        if record.kind == rec.START and self._derivation is None:
            self._derivation = Derivation(record)
        if record.kind in self._wanted.topics:
            yield Line(record.t, self._wall(record.t), record.kind, json.loads(record.payload))
        if self._derivation is None and JOURNAL in self._wanted.topics:
            for event in events_of(record):  # events that need no start record
                said = wellknown.log(event.t, event.level, event.of, event.says)
                yield Line(event.t, event.t, JOURNAL, said)
        if self._derivation is not None and self._wanted.topics & _DERIVED:
            for message in self._derivation.receive(record):
                yield Line(message.t, self._wall(message.t), message.topic, message.value)

    def _wall(self, t: float) -> float:
        return self._derivation.wall(t) if self._derivation else t


def restart(before: Sequence[Record | Gap], after: Sequence[Record | Gap]) -> str:
    """Describe the break between two recordings in words. If the later one began before the earlier
    one ended, the program did not restart: it is another vehicle or simulation, or a clock was set
    back."""
    start, earlier = start_of(after), start_of(before)
    if start is None or earlier is None:
        return "another recording, without its start"
    last = max((item.t for item in before if isinstance(item, Record)), default=0.0)
    begun = rec.read_start(start)
    away = begun.wall - rec.read_start(earlier).wall - last
    kept = begun.store.under_way
    what = f"under way was {kept}" if kept else "nothing was under way"
    if away < 0.0:
        return f"--- another recording, begun {-away:.1f} s before the one above ended ---"
    return f"--- the program began again {away:.1f} s later: {what} ---"


def goes_on(before: Sequence[Record | Gap], after: Sequence[Record | Gap]) -> bool:
    """Whether the same vehicle's program restarted after the other recording ended."""
    start, earlier = start_of(after), start_of(before)
    if start is None or earlier is None:
        return False
    again, first = rec.read_start(start), rec.read_start(earlier)
    last = max((item.t for item in before if isinstance(item, Record)), default=0.0)
    return again.vehicle.name == first.vehicle.name and again.wall >= first.wall + last


def follow(path: Path, wanted: Wanted, sleep: Callable[[float], None]) -> Iterator[Line]:
    """Yield the lines that are appended to a file from now on, without end; the existing content is
    read silently. Raises BlackBoxError."""
    box, reading = GrowingBox(first_part(path)), Lines(wanted)
    try:
        for record in box.read():
            reading.receive(record)
        while True:
            for record in box.read():
                yield from reading.receive(record)
            sleep(FLUSH_S)
    finally:
        box.close()
