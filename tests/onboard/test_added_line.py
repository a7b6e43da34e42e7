"""The line of added sensors: on record and replayed to the bit; without it nothing is different."""

from __future__ import annotations

import json
from dataclasses import replace

from links.base import Rx
from links.simulated.settings import parse_settings
from mission.analysis.replay.replay import replay
from mission.authoring.language import parse
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration, LinkUrls, parse_configuration
from mission.onboard.rates import rated
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.runtime import SENSORS
from mission.verification.simulation.flight import fly

AUV = load_vehicle("auv")
DIVE = """mission dive vehicle auv
home 30.2874595 120.1535765
safety radius 800 time 30min depth 15
down: depth 5 heading 40 gear 6 until depth >= 4 timeout 2min
a: gear 8 for 40
up: surface until fix timeout 4min
"""


def flown(*settings: str) -> list[rec.Record]:
    recorder = rec.ListRecorder()
    fly(parse(DIVE), AUV, "as-built", 2, parse_settings(settings), recorder)
    return recorder.records


def test_what_the_sensors_said_is_on_record_and_replayed_to_the_bit() -> None:
    records = flown("doppler=0.03", "acoustic=3")
    said = [rec.read_rx(r) for r in records if r.kind == rec.RX]
    lines = b"".join(rx.data for rx in said if rx.link == SENSORS)
    assert all(lines.count(kind) > 10 for kind in (b":WS,", b":BS,", b"$VDGLL"))
    assert replay(records).identical


def test_the_replay_needs_what_the_sensors_said() -> None:
    records = flown("acoustic=3")
    without = [r for r in records if r.kind != rec.RX or rec.read_rx(r).link != SENSORS]
    assert not replay(without).identical


def test_noise_on_the_line_is_told_as_a_fault_of_it() -> None:
    records = flown("acoustic=3")
    n, first = next((n, r) for n, r in enumerate(records) if r.kind == rec.RX and r.t > 20.0)
    noise = Rx(first.t, SENSORS, b"\xff\xfenoise\r\n")
    spoilt = [*records[:n], rec.rx_record(noise, first.t), *records[n:]]
    found = replay(spoilt).divergence
    assert found is not None
    assert found.actual is not None
    assert (found.actual.kind, found.t) == (rec.FAULT, first.t)
    assert json.loads(found.actual.payload)["link"] == SENSORS


def test_without_such_a_line_the_start_record_is_as_it_was() -> None:
    (start,) = [r for r in flown() if r.kind == rec.START]
    plain = json.loads(start.payload)
    assert "sensors" not in plain["configuration"]["links"]
    assert "added" not in plain["vehicle"]
    assert rec.read_start(start).configuration.links.sensors is None


def test_the_start_record_has_the_line_and_the_noise() -> None:
    links = replace(LinkUrls(), sensors="tcp://127.0.0.1:9")
    vehicle = replace(AUV, added={"ground": 0.02})
    start = rec.Start("1", Configuration(links=links), vehicle, rec.Stored(), 0.0)
    again = rec.read_start(rec.start_record(start, 0.0))
    assert again.configuration.links.sensors == "tcp://127.0.0.1:9"
    assert again.vehicle.added == {"ground": 0.02}


def test_the_line_is_a_link_like_the_others_at_9600_baud() -> None:
    given = parse_configuration("links: {sensors: serial:///dev/ttyUSB1}")
    assert rated(given, AUV).links.sensors == "serial:///dev/ttyUSB1?baud=9600"
    assert parse_configuration("").links.sensors is None
