"""Decode reports, fixes and added sensors from recorded bytes, with the decoders used in flight.

What does not live here: files (blackbox), repeating the decisions (analysis.replay).
"""

from __future__ import annotations

from mission.model import Record
from mission.model.vehicle import Vehicle
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.receivers import RECEIVERS, Receivers
from mission.onboard.runtime.runtime import SENSORS, VEHICLE
from protocol.added import AddedDecoder
from protocol.messages import Aid, Fix, Telemetry
from protocol.vehicles import codec

Sensed = Telemetry | Fix | Aid
CLOCKS = frozenset({rec.RX, rec.TIMER})  # kinds by which the decoders know the time


class Senses:
    """The decoders of one run of the program: give them every record in order; gaps are allowed."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._board, self._gps = codec(*vehicle.speaks), Receivers()
        self._added = AddedDecoder()

    def hear(self, record: Record) -> list[Sensed]:
        if record.kind not in CLOCKS:
            return []
        now, found = rec.read_time(record), list[object]()
        due = self._board.next_timer()
        if due is not None and due <= now:
            found += self._board.flush(now)
        for _, heard in self._gps.flush(now):
            found += heard
        if record.kind == rec.RX:
            rx = rec.read_rx(record)
            if rx.link == VEHICLE:
                found += self._board.receive(rx.data, rx.t)
            elif rx.link in RECEIVERS:
                found += self._gps.receive(rx)
            elif rx.link == SENSORS:
                found += self._added.receive(rx.data, rx.t)
        return [one for one in found if isinstance(one, Telemetry | Fix | Aid)]
