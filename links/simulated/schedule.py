"""When faults begin and end, on the clock of the vehicle that has them.

What does not live here: what they do (faults, board_faults).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import ceil
from typing import NamedTuple

from links.simulated.fault import Fault
from links.simulated.settings import FaultEvent, SettingError

_ROUNDED = 1e-6


class Edge(NamedTuple):
    tick: int
    begins: bool
    name: str
    value: float


def edges(
    events: Iterable[FaultEvent], rows: Mapping[str, Fault], tick: float, vehicle: str
) -> list[Edge]:
    """The next one last; ``tick`` in s. Raises SettingError for a fault that it cannot have."""
    found = []
    for event in events:
        row = rows.get(event.name)
        if row is None:
            raise SettingError(f"fault={event.name}: not of {vehicle}; it has {', '.join(rows)}")
        value = row.value if event.value is None else event.value
        duration = row.duration if event.duration is None else event.duration
        begin = max(ceil(event.begin / tick - _ROUNDED), 1)
        end = max(ceil((event.begin + duration) / tick - _ROUNDED), begin + 1)
        found += [Edge(begin, True, event.name, value), Edge(end, False, event.name, value)]
    return sorted(found, reverse=True)
