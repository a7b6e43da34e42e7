"""The inputs of the estimator, from a black box: reports and fixes, by the same decoders.

What does not live here: files (blackbox), the decoders (stream.senses), repeating the decisions
(replay).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mission.model import Record
from mission.model.vehicle import Vehicle
from mission.onboard.blackbox import read_parts
from mission.onboard.runtime import records as rec
from mission.onboard.stream.senses import Senses
from protocol.messages import Aid, Fix, Telemetry


class LogError(ValueError):
    """The operator must act: this black box cannot be read, and why."""


@dataclass(frozen=True, slots=True)
class Log:
    """``vehicle``: as it was configured then; ``aids``: the readings of added sensors."""

    name: str
    vehicle: Vehicle
    inputs: tuple[Telemetry | Fix, ...]
    aids: tuple[Aid, ...] = ()


def read_log(path: Path) -> Log:
    """Read a black box. Raises LogError, or BlackBoxError from the file itself."""
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
    senses = Senses(vehicle)
    sensed = [seen for record in stream for seen in senses.hear(record)]
    aids = tuple(seen for seen in sensed if isinstance(seen, Aid))
    return Log(name, vehicle, tuple(seen for seen in sensed if not isinstance(seen, Aid)), aids)
