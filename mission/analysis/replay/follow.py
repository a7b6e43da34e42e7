"""Bytes that ``serve`` receives and sends on one link, read from its black box as it is written.

This disturbs nothing, because serve alone has the port open. What does not live here: where the
black box is (serve.health), what the bytes mean (protocol).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from links.base import Rx
from mission.model import Record
from mission.onboard.blackbox import FLUSH_S, GrowingBox, first_part
from mission.onboard.runtime.records import RX, TX, read_rx, read_tx

IN, OUT = "in", "out"  # directions, seen from the vehicle's computer
LOOK_S = 1.0  # between two checks for another black box


def follow(
    box: Callable[[], Path | None],
    link: str,
    ways: tuple[str, ...],
    wall: Callable[[], float],
    sleep: Callable[[float], None],
) -> Iterator[Rx]:
    """Yield the bytes from now on, until ``box`` (called once a second) returns None. After each
    read comes an Rx without bytes. ``t`` is in s since 1970 UTC, the link is IN or OUT. The time
    advances only with the records, because bytes not written yet may continue the last ones. Raises
    BlackBoxError."""
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
    """Open a box. The first one is read from its present end, later ones from their beginning."""
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
