"""Make the same runtime again from the records, and feed it the recorded inputs.

    start record --> runtime_from --> Runtime;  every input record, in order --> feed

What does not live here: files (blackbox), the comparison with the recorded outputs (replay).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from mission.model import Record, Tx
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore


def failed_writes(records: Iterable[Record]) -> dict[int, str]:
    """Return the store's failed writes by number: the new runtime must meet them as well."""
    texts = (rec.read_texts(record) for record in records if record.kind == rec.STORE)
    return {int(number): why for number, why in texts}


def runtime_from(
    start: rec.Start,
    failures: Mapping[int, str],
    recorder: rec.Recorder | None = None,
    observer: rec.Observer | None = None,
) -> Runtime:
    """Make a runtime. Raises ValueError if this version lacks the vehicle's codec or dialect."""
    store = MemoryStore(start.store, failures)
    kept = start.configuration, start.vehicle, store, recorder
    return Runtime(*kept, wall=start.wall, observer=observer)


def feed(runtime: Runtime, record: Record) -> list[Tx]:
    """Feed one input; a record of another kind changes nothing."""
    now = rec.read_time(record) if record.kind in rec.INPUTS else record.t
    if record.kind == rec.RX:
        return runtime.receive(rec.read_rx(record), now)
    if record.kind == rec.TIMER:
        return runtime.handle_timer(now)
    if record.kind == rec.CONNECTED:
        link, address = rec.read_texts(record)
        return runtime.connected(link, address, now)
    if record.kind == rec.DISCONNECTED:
        link, address = rec.read_texts(record)
        return runtime.disconnected(link, address, now)
    if record.kind == rec.NAVIGATION:
        return runtime.set_navigation(runtime.make_navigation(), now)
    if record.kind == rec.ALARMS:
        (names,) = rec.read_texts(record)
        return runtime.take_alarms(names.split(",") if names else (), now)
    if record.kind == rec.ENDING:
        return runtime.end(now, at_once=rec.read_texts(record) == (rec.AT_ONCE,))
    return []
