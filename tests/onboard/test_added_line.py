"""The line of added sensors: on record and replayed to the bit; without it nothing is different."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

from links.base import Rx
from links.simulated.link import SimulatedVehicle
from links.simulated.settings import parse_settings
from mission.analysis.lessons import section
from mission.analysis.noise import of_added
from mission.analysis.replay.replay import replay
from mission.authoring.language import parse
from mission.model.shipped import load_vehicle, missions_folder
from mission.model.vehicle import Beacon, Vehicle
from mission.model.vehicle_file import read_vehicle
from mission.onboard.configuration import Configuration, LinkUrls, parse_configuration
from mission.onboard.rates import rated
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.runtime import SENSORS
from mission.onboard.serve.heard import hear
from mission.onboard.stream import topics
from mission.onboard.stream.derived import Derivation
from mission.verification.rig.vehicle import simulated
from mission.verification.simulation.flight import fly

AUV = load_vehicle("auv")
BEACONED = replace(AUV, beacons={"3": Beacon(math.radians(30.288), math.radians(120.154), 5.0)})
TOLD = {
    "water": {"ahead_m_s"},
    "ground": {"ahead_m_s", "starboard_m_s"},
    "range": {"beacon", "travel_s"},
}
DIVE = """mission dive vehicle auv
home 30.2874595 120.1535765
safety radius 800 time 30min depth 15
down: depth 5 heading 40 gear 6 until depth >= 4 timeout 2min
a: gear 8 for 40
up: surface until fix timeout 4min
"""


def flown(*settings: str, vehicle: Vehicle = AUV, text: str = DIVE) -> list[rec.Record]:
    recorder = rec.ListRecorder()
    fly(parse(text), vehicle, "as-built", 2, parse_settings(settings), recorder)
    return recorder.records


def test_what_the_sensors_said_is_on_record_and_replayed_to_the_bit() -> None:
    records = flown("doppler=0.03", "acoustic=3")
    said = [rec.read_rx(r) for r in records if r.kind == rec.RX]
    lines = b"".join(rx.data for rx in said if rx.link == SENSORS)
    assert all(lines.count(kind) > 10 for kind in (b":WS,", b":BS,", b"$VDGLL"))
    assert replay(records).identical


@pytest.mark.proof
def test_ranges_and_ensembles_are_replayed_to_the_bit_and_decoded() -> None:
    records = flown("doppler_pd0=0.03", "ranges=2", vehicle=BEACONED)
    assert replay(records).identical
    start, *rest = records
    made = Derivation(start)
    aids = [m.value for record in rest for m in made.receive(record) if m.topic == topics.AID]
    assert {aid["kind"] for aid in aids} == {"water", "ground", "range"}
    for aid in aids:
        told = {name for name, value in aid.items() if value is not None} - {"t", "kind"}
        assert told == TOLD[aid["kind"]]


@pytest.mark.parametrize("lie", ["offset", "drift", "delay"])
def test_a_lie_that_nothing_shows_spoils_no_more_than_it_is_off_by(lie: str) -> None:
    """A place that is 30 m off, that drifts by 0.3 m/s, or that is 20 s old at 1 m/s."""
    records = flown("acoustic=3", f"added_lie={lie}@30", vehicle=BEACONED)
    estimates = [rec.estimate_of(r.payload) for r in records if r.kind == rec.ESTIMATE]
    honest = flown("acoustic=3", vehicle=BEACONED)
    others = [rec.estimate_of(r.payload) for r in honest if r.kind == rec.ESTIMATE]
    apart = [
        math.hypot(a.north - b.north, a.east - b.east)
        for a, b in zip(estimates, others, strict=False)
    ]
    assert max(apart) < 45.0 * math.sqrt(2.0)
    assert replay(records).identical


def test_calibration_finds_the_noise_of_what_was_added_and_writes_it_as_the_file_has_it() -> None:
    given = {"speed_log": 0.08, "acoustic": 4.0, "ranges": 1.5}
    records = flown(
        *(f"{name}={sigma}" for name, sigma in given.items()),
        vehicle=BEACONED,
        text=DIVE.replace("for 40", "for 150"),
    )
    log = hear("a.mcap", records)
    found = of_added([log.aids], BEACONED)
    wanted = {"water": 0.08, "place": 4.0, "range": 1.5}
    assert found == pytest.approx(wanted, rel=0.5)
    text = section(replace(BEACONED, added=found))
    line = next(row for row in text.splitlines() if row.startswith("added:"))
    plain = (missions_folder() / "vehicles" / "auv.yaml").read_text(encoding="utf-8")
    assert read_vehicle(f"{plain}{line}\n", "mine").added == pytest.approx(found, rel=0.05)
    assert "added" not in section(BEACONED)


def test_a_vehicle_file_that_has_sensors_is_simulated_with_them() -> None:
    mine = replace(BEACONED, added={"ground": 0.04, "range": 1.5, "place": 4.0})
    sea = simulated(mine, 1, parse_settings(["acoustic=9"]))
    assert isinstance(sea, SimulatedVehicle)
    fitted = sea.settings.added
    assert (fitted.doppler, fitted.ranges, fitted.acoustic) == (0.04, 1.5, 9.0)
    assert [beacon.number for beacon in fitted.beacons] == [3]
    assert fitted.speed_log is None
    plain, without = simulated(AUV, 1), replace(mine, beacons={})
    assert isinstance(plain, SimulatedVehicle)
    assert plain.added is None
    other = simulated(without, 1)
    assert isinstance(other, SimulatedVehicle)
    assert other.settings.added.ranges is None


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
