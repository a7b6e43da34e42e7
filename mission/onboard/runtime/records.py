"""The records: their kinds and payloads, written and read. The black box stores these bytes.

Every payload is a JSON object; ``docs/reference/black-box.md`` lists the fields of each.

    start          version, form, configuration, vehicle,      what a replay begins with
                   store, wall clock at t = 0
    rx             link, address, bytes, when the first came   input
    timer                                                      input
    connected      link, address                               input
    disconnected   link, address                               input
    navigation     (the filter is loaded from now on)          input
    ending         "now" if no time is left                    input (the program has to end)
    alarms         names                                       input (that serve alone sees)
    store          number of the write, what failed            input (failed writes alone)
    step           the Step                                    output
    estimate       the Estimate                                output, one per telemetry
    tx             link, address, reason, bytes                output
    fault          link, kind, offset, length                  output
    standing       values until the next one: origin,          output, when it changes
                   limits in force and breached, commander
    mission        the lines that the store holds              output, when they change

Numbers are written so that they read back to the last bit. ``data`` has a character for each byte
(ISO 8859-1). The inputs, in order, are all that a runtime ever sees: a runtime made from ``start``
and fed with them gives the same outputs, byte for byte. ``form`` is the version of the records:
form 1 had neither standing nor mission.

What does not live here: files (blackbox), schemas (stream), comparing (replay).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from links.base import Rx
from mission.model import Estimate, Position, Record, Step, Tx
from mission.model.plain import from_plain, to_plain
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.store import Stored
from protocol.messages import FrameFault

START, RX, TIMER = "start", "rx", "timer"
CONNECTED, DISCONNECTED = "connected", "disconnected"
NAVIGATION, STORE, ENDING, ALARMS = "navigation", "store", "ending", "alarms"
STEP, ESTIMATE, TX, FAULT = "step", "estimate", "tx", "fault"
STANDING, MISSION = "standing", "mission"
INPUTS = frozenset({RX, TIMER, CONNECTED, DISCONNECTED, NAVIGATION, STORE, ENDING, ALARMS})
AT_ONCE = "now"  # the text of an ``ending`` with no time left
OUTPUTS = frozenset({STEP, ESTIMATE, TX, FAULT, STANDING, MISSION})
FORM = 2
SINCE_FORM_2 = frozenset({STANDING, MISSION})
# the texts of an ``input_record``, by kind
_TEXTS: Mapping[str, tuple[str, ...]] = {
    CONNECTED: ("link", "address"),
    DISCONNECTED: ("link", "address"),
    STORE: ("number", "failed"),
    ENDING: ("time_left",),
    ALARMS: ("names",),
}
_BYTES = "latin-1"
_quoted = json.encoder.encode_basestring_ascii
_dumps = json.JSONEncoder(separators=(",", ":")).encode


class Recorder(Protocol):
    """Takes every record, in order; must not raise (a full disk must not stop the vehicle)."""

    def record(self, record: Record) -> None: ...


class Observer(Protocol):
    """Receives the decisions as they are made."""

    def step(self, step: Step) -> None: ...

    def estimate(self, estimate: Estimate) -> None:
        """One per telemetry."""
        ...

    def notice(self, text: str) -> None:
        """A refusal and its reason, for people."""
        ...


class Nobody:
    """An ``Observer`` that does nothing."""

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
    form: int = 1


@dataclass(frozen=True, slots=True)
class Standing:
    """Values that stay in force until the next one. ``origin``: of the estimate's north and east
    (degrees), None before it is known. The four bounds: limits in force (m, s, m, V). ``digest``:
    of the mission that could be started, or is under way, "" if none."""

    origin: Position | None
    radius: float
    time: float
    depth: float
    voltage: float
    breached: tuple[str, ...]
    commander: str
    digest: str


def start_record(start: Start, t: float) -> Record:
    return Record(t, START, json.dumps(to_plain(start)).encode())


def read_start(record: Record) -> Start:
    return from_plain(Start, json.loads(record.payload))


def rx_record(rx: Rx, now: float) -> Record:
    """Most records are of this kind: building the JSON text directly takes half the time."""
    way = f'"link":{_quoted(rx.link)},"address":{_quoted(rx.address)}'
    data = _quoted(rx.data.decode(_BYTES))
    return Record(now, RX, f'{{"t":{now!r},"first":{rx.t!r},{way},"data":{data}}}'.encode())


def read_rx(record: Record) -> Rx:
    """Return the Rx; ``read_time`` tells when the last of its bytes came."""
    plain = json.loads(record.payload)
    return Rx(plain["first"], plain["link"], plain["data"].encode(_BYTES), plain["address"])


def input_record(t: float, kind: str, *texts: str) -> Record:
    payload = {"t": t} | dict(zip(_TEXTS.get(kind, ()), texts, strict=False))
    return Record(t, kind, _dumps(payload).encode())


def read_texts(record: Record) -> tuple[str, ...]:
    """The texts of an ``input_record``."""
    plain = json.loads(record.payload)
    return tuple(plain[name] for name in _TEXTS.get(record.kind, ()) if name in plain)


def read_time(record: Record) -> float:
    """Return the time of an input, to the last bit."""
    t: float = json.loads(record.payload)["t"]
    return t


def tx_record(tx: Tx) -> Record:
    payload = {
        "link": tx.link,
        "address": tx.address,
        "reason": tx.reason,
        "data": tx.data.decode(_BYTES),
    }
    return Record(tx.t, TX, _dumps(payload).encode())


def read_tx(record: Record) -> Tx:
    plain = json.loads(record.payload)
    data = plain["data"].encode(_BYTES)
    return Tx(record.t, plain["link"], data, plain["reason"], plain["address"])


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
    payload = {"link": link, "kind": fault.kind, "offset": fault.offset, "length": fault.length}
    return Record(t, FAULT, _dumps(payload).encode())


def standing_record(t: float, standing: Standing) -> Record:
    return Record(t, STANDING, _dumps({"t": t} | to_plain(standing)).encode())


def read_standing(record: Record) -> Standing:
    plain = json.loads(record.payload)
    del plain["t"]
    return from_plain(Standing, plain)


def mission_record(t: float, digest: str, lines: tuple[str, ...]) -> Record:
    return Record(t, MISSION, _dumps({"t": t, "digest": digest, "lines": lines}).encode())
