"""When faults begin and end, on the clock of their vehicle, and which of them is in force.

What does not live here: what faults do (faults, board_faults).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import ceil
from typing import Any, NamedTuple

from links.simulated.fault import Fault
from links.simulated.settings import FaultEvent, SettingError

_ROUNDED = 1e-6


class Edge(NamedTuple):
    tick: int
    begins: bool
    name: str
    value: float
    number: int  # of the event that it belongs to


class InForce:
    """The faults in force. Of faults with the same slot only the newest counts. When it ends, the
    one before it begins again. The end of any other changes nothing."""

    def __init__(self, rows: Mapping[str, Fault]) -> None:
        self._rows = rows
        self._there: dict[str, list[Edge]] = {}  # by slot, the newest last

    def switch(self, edge: Edge, vehicle: Any) -> None:
        row = self._rows[edge.name]
        there = [] if row.adds else self._there.setdefault(row.slot or edge.name, [])
        if edge.begins:
            there.append(edge)
            row.begin(vehicle, edge.value)
            return
        counts = row.adds or there[-1].number == edge.number
        there[:] = [other for other in there if other.number != edge.number]
        if counts:
            row.end(vehicle, edge.value)
            if there:
                before = there[-1]
                self._rows[before.name].begin(vehicle, before.value)


def edges(
    events: Iterable[FaultEvent], rows: Mapping[str, Fault], tick: float, vehicle: str
) -> list[Edge]:
    """The edges, next one last; ``tick`` in s. Raises SettingError for a fault not in ``rows``."""
    found = []
    for number, event in enumerate(events):
        row = rows.get(event.name)
        if row is None:
            raise SettingError(f"fault={event.name}: not of {vehicle}; it has {', '.join(rows)}")
        value = row.value if event.value is None else event.value
        duration = row.duration if event.duration is None else event.duration
        begin = max(ceil(event.begin / tick - _ROUNDED), 1)
        end = max(ceil((event.begin + duration) / tick - _ROUNDED), begin + 1)
        found += [
            Edge(begin, True, event.name, value, number),
            Edge(end, False, event.name, value, number),
        ]
    return sorted(found, reverse=True)
