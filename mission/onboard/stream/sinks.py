"""The receivers of records: the black box, a monitor and others, one row each.

The runtime hands a record over and never waits: a sink stores it and does its work elsewhere. If a
sink raises, it loses that record, which is reported once; the others and the runtime continue.
"""

from __future__ import annotations

from collections.abc import Callable

from mission.model import Record
from mission.onboard.runtime.records import Recorder


class Sinks:
    """A Recorder that forwards to many. ``tell`` gets what an operator should know."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._rows: dict[str, Recorder] = {}
        self._failed: set[str] = set()

    def put(self, name: str, sink: Recorder | None) -> None:
        """Set the sink with that name; None removes it."""
        self._rows.pop(name, None)
        if sink is not None:
            self._rows[name] = sink

    def record(self, record: Record) -> None:
        for name, sink in self._rows.items():
            try:
                sink.record(record)
            except Exception as error:
                self._tell_of(name, error)

    def _tell_of(self, name: str, error: Exception) -> None:
        if name not in self._failed:
            self._failed.add(name)
            self._tell(f"{name} does not take every record: {type(error).__name__}: {error}")
