"""What goes on record: kinds, payloads, and the way back. The black box keeps these bytes.

    kind           payload                                     is
    start          JSON: version, configuration, vehicle,      what a replay begins with
                   store, wall clock at t = 0
    rx             t | first | link NUL address NUL data       input
    timer          t                                           input
    connected      t | link NUL address                        input
    disconnected   t | link NUL address                        input
    navigation     t   (the filter is there from now on)       input
    ending         t | "now" where no time is left             input (the program is to end)
    store          t | number of the write NUL what failed     input (writes that failed alone)
    step           JSON of the Step                            output
    estimate       JSON of the Estimate                        output, one per telemetry
    tx             link NUL address NUL reason NUL data        output
    fault          link NUL kind NUL offset NUL length         output

``t`` is an f64, low byte first: times come back to the last bit whatever keeps the records;
``first`` likewise, when the first of the bytes came.
The inputs in their order are all that a runtime ever sees: fed to one made from ``start`` they give
the same outputs, byte for byte.

What does not live here: files (blackbox), comparing (replay).
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Protocol

from links.base import Rx
from mission.model import Estimate, Record, Step, Tx
from mission.model.plain import from_plain, to_plain
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.store import Stored
from protocol.messages import FrameFault

START, RX, TIMER = "start", "rx", "timer"
CONNECTED, DISCONNECTED = "connected", "disconnected"
NAVIGATION, STORE, ENDING = "navigation", "store", "ending"
STEP, ESTIMATE, TX, FAULT = "step", "estimate", "tx", "fault"
INPUTS = frozenset({RX, TIMER, CONNECTED, DISCONNECTED, NAVIGATION, STORE, ENDING})
AT_ONCE = "now"  # the text of an ``ending`` that has no more time
OUTPUTS = frozenset({STEP, ESTIMATE, TX, FAULT})

_T = struct.Struct("<d")
_dumps = json.JSONEncoder(separators=(",", ":")).encode


class Recorder(Protocol):
    """Takes every record, in order; must not raise (a full disk must not stop the vehicle)."""

    def record(self, record: Record) -> None: ...


class Observer(Protocol):
    """Who wants to see what was decided as it is decided."""

    def step(self, step: Step) -> None: ...

    def estimate(self, estimate: Estimate) -> None:
        """One per telemetry."""
        ...

    def notice(self, text: str) -> None:
        """Something that was refused, and why: for people."""
        ...


class Nobody:
    """An ``Observer`` who looks away."""

    def step(self, step: Step) -> None:
        pass

    def estimate(self, estimate: Estimate) -> None:
        pass

    def notice(self, text: str) -> None:
        pass


class ListRecorder:
    """All records in memory."""

    def __init__(self) -> None:
        self.records: list[Record] = []

    def record(self, record: Record) -> None:
        self.records.append(record)

    def of(self, kind: str) -> list[Record]:
        return [record for record in self.records if record.kind == kind]


@dataclass(frozen=True, slots=True)
class Start:
    """All that a runtime is made from."""

    version: str
    configuration: Configuration
    vehicle: Vehicle
    store: Stored
    wall: float  # s since 1970 UTC at t = 0


def start_record(start: Start, t: float) -> Record:
    return Record(t, START, json.dumps(to_plain(start)).encode())


def read_start(record: Record) -> Start:
    return from_plain(Start, json.loads(record.payload))


def rx_record(rx: Rx, now: float) -> Record:
    head = f"{rx.link}\0{rx.address}\0".encode()
    return Record(now, RX, _T.pack(now) + _T.pack(rx.t) + head + rx.data)


def read_rx(record: Record) -> Rx:
    """``read_time`` tells when the last of its bytes came."""
    link, address, data = record.payload[2 * _T.size :].split(b"\0", 2)
    (first,) = _T.unpack_from(record.payload, _T.size)
    return Rx(first, link.decode(), data, address.decode())


def input_record(t: float, kind: str, *texts: str) -> Record:
    return Record(t, kind, _T.pack(t) + "\0".join(texts).encode())


def read_texts(record: Record) -> tuple[str, ...]:
    """The texts of an ``input_record``."""
    body = record.payload[_T.size :]
    return tuple(body.decode().split("\0")) if body else ()


def read_time(record: Record) -> float:
    """Of an input, exactly as it was."""
    t: float = _T.unpack_from(record.payload)[0]
    return t


def tx_record(tx: Tx) -> Record:
    head = f"{tx.link}\0{tx.address}\0{tx.reason}\0".encode()
    return Record(tx.t, TX, head + tx.data)


def read_tx(record: Record) -> Tx:
    link, address, reason, data = record.payload.split(b"\0", 3)
    return Tx(record.t, link.decode(), data, reason.decode(), address.decode())


def step_record(step: Step) -> Record:
    payload = {
        "t": step.t,
        "event": step.event,
        "evaluations": [[e.trigger, e.result, e.values] for e in step.evaluations],
        "exited": step.exited,
        "entered": step.entered,
        "actions": step.actions,
        "trigger": step.trigger,
        "by": step.by.value if step.by else None,
    }
    return Record(step.t, STEP, _dumps(payload).encode())


def step_of(payload: bytes | str) -> Step:
    """The Step of a record's payload, or of the same JSON from elsewhere."""
    plain = json.loads(payload)
    seen = [
        {"trigger": trigger, "result": result, "values": values}
        for trigger, result, values in plain["evaluations"]
    ]
    return from_plain(Step, plain | {"evaluations": seen})


def estimate_of(payload: bytes | str) -> Estimate:
    return from_plain(Estimate, json.loads(payload))


def estimate_record(estimate: Estimate) -> Record:
    payload = {
        "t": estimate.t,
        "north": estimate.north,
        "east": estimate.east,
        "depth": estimate.depth,
        "depth_rate": estimate.depth_rate,
        "altitude": estimate.altitude,
        "heading": estimate.heading,
        "speed": estimate.speed,
        "current_north": estimate.current_north,
        "current_east": estimate.current_east,
        "covariance": estimate.covariance,
        "sigmas": dict(estimate.sigmas),
        "nis": estimate.nis,
        "fix_age": estimate.fix_age,
        "mode": estimate.mode.value,
    }
    return Record(estimate.t, ESTIMATE, _dumps(payload).encode())


def fault_record(t: float, link: str, fault: FrameFault) -> Record:
    text = f"{link}\0{fault.kind}\0{fault.offset}\0{fault.length}"
    return Record(t, FAULT, text.encode())
