"""What a serve hears and says on one of its links, read from its black box as it is written.

It disturbs nobody: serve alone has the port. What does not live here: where the black box lies
(serve.health), what the bytes mean (protocol).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from links.base import Rx
from mission.model import Record
from mission.onboard.blackbox import FLUSH_S, GrowingBox, first_part
from mission.onboard.runtime.records import RX, TX, read_rx, read_tx

IN, OUT = "in", "out"  # of the vehicle's computer
LOOK_S = 1.0  # between two looks for another black box


def follow(
    box: Callable[[], Path | None],
    link: str,
    ways: tuple[str, ...],
    wall: Callable[[], float],
    sleep: Callable[[float], None],
) -> Iterator[Rx]:
    """From now on, until ``box`` (asked once a second) tells of none; without bytes where nothing
    new has come. ``t`` is in s since 1970 UTC, the link IN or OUT; it goes on with the records, for
    what is not written yet may belong to what was. Raises BlackBoxError."""
    path, looked, newest = box(), wall(), 0.0
    opened: GrowingBox | None = None
    try:
        while path is not None:
            if opened is None or opened.path != first_part(path):
                opened = _next(opened, first_part(path))
            for record in opened.read():
                newest = opened.wall + record.t
                yield from _passed(record, link, ways, opened.wall)
            yield Rx(newest, "", b"")
            sleep(FLUSH_S)
            if abs(wall() - looked) >= LOOK_S:
                path, looked, newest = box(), wall(), 0.0
    finally:
        if opened is not None:
            opened.close()


def _next(before: GrowingBox | None, path: Path) -> GrowingBox:
    """The first one is read from where it ends now, another from its beginning."""
    opened = GrowingBox(path)
    if before is not None:
        before.close()
        return opened
    for _ in opened.read():
        pass
    return opened


def _passed(record: Record, link: str, ways: tuple[str, ...], wall: float) -> Iterator[Rx]:
    if record.kind == RX and IN in ways:
        rx = read_rx(record)
        if rx.link == link:
            yield Rx(wall + rx.t, IN, rx.data, rx.address)
    elif record.kind == TX and OUT in ways:
        tx = read_tx(record)
        if tx.link == link:
            yield Rx(wall + tx.t, OUT, tx.data, tx.address)
