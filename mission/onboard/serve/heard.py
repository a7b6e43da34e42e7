"""What the estimator heard, out of a black box: reports and fixes through the same decoders.

What does not live here: files (blackbox), deciding anything again (replay).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mission.model import Record
from mission.model.vehicle import Vehicle
from mission.onboard.blackbox import read_parts
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.runtime import GPS, VEHICLE
from protocol.messages import Fix, Telemetry
from protocol.nmea import NmeaDecoder
from protocol.vehicles import codec

Heard = Telemetry | Fix


class LogError(ValueError):
    """The operator must act: this is no black box that can be read, and why."""


@dataclass(frozen=True, slots=True)
class Log:
    """``vehicle`` as it was configured then."""

    name: str
    vehicle: Vehicle
    inputs: tuple[Heard, ...]


def read_log(path: Path) -> Log:
    """Raises LogError, or BlackBoxError from the file itself."""
    return hear(path.name, read_parts(path))


def hear(name: str, records: Iterable[Record]) -> Log:
    stream = iter(records)
    first = next(stream, None)
    if first is None or first.kind != rec.START:
        raise LogError(
            f"{name}: there is no whole start record, so nothing says what vehicle it is"
        )
    try:
        vehicle = rec.read_start(first).vehicle
    except (ValueError, KeyError, TypeError) as error:
        raise LogError(f"{name}: the start record is not one of this version: {error}") from error
    board = codec(*vehicle.speaks)
    gps = NmeaDecoder()
    inputs: list[Heard] = []
    for record in stream:
        if record.kind not in (rec.RX, rec.TIMER):
            continue
        now = rec.read_time(record)
        for decoder in (board, gps):
            due = decoder.next_timer()
            if due is not None and due <= now:
                inputs += [m for m in decoder.flush(now) if isinstance(m, Telemetry | Fix)]
        if record.kind == rec.RX:
            rx = rec.read_rx(record)
            if rx.link == VEHICLE:
                inputs += [m for m in board.receive(rx.data, rx.t) if isinstance(m, Telemetry)]
            elif rx.link == GPS:
                inputs += [m for m in gps.receive(rx.data, rx.t) if isinstance(m, Fix)]
    return Log(name, vehicle, tuple(inputs))
