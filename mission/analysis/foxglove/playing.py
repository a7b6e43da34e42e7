"""A black box as messages at their times: the records of a dive, and what is derived from them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mission.model import Record
from mission.onboard.blackbox import BlackBoxError, Gap
from mission.onboard.runtime import records as rec
from mission.onboard.stream.derived import Derivation, Message
from mission.onboard.stream.topics import DERIVED

TOPICS = tuple(topic.name for topic in DERIVED)


def begun(items: Iterable[Record | Gap]) -> float:
    """Return the wall time at time 0, s since 1970 UTC. Raises BlackBoxError without a whole
    start."""
    for item in items:
        if isinstance(item, Record) and item.kind == rec.START:
            return rec.read_start(item).wall
    raise BlackBoxError("there is no whole start record: nothing can be shown of it")


def messages(items: Iterable[Record | Gap]) -> Iterator[Message]:
    """Yield the messages of one recording, in order. Raises ValueError, KeyError or TypeError for a
    start record of a version that cannot be read."""
    derivation: Derivation | None = None
    for item in items:
        if isinstance(item, Gap):
            continue
        if derivation is None and item.kind == rec.START:
            derivation = Derivation(item)
        if derivation is not None:
            yield from derivation.receive(item)
