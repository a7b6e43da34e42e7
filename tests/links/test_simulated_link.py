"""The simulated vehicle as a link: real bytes, foretold times, same seed same bytes."""

from __future__ import annotations

import math
import random
from itertools import pairwise

import pytest

from links.base import LinkClosed, Rx
from links.simulated.link import PROFILES, SimulatedVehicle
from links.simulated.settings import Settings, parse_settings
from protocol.checksum import crc32_stm32

FLIGHT = [
    (4.0, {"as-built": [b"@ZAH-90,6$"], "documented": [b"@ZAF6$", b"@ZAH-90$"]}),
    (6.19, {"as-built": [b"@ZAS8$"], "documented": [b"@ZAS8$"]}),
    (70.0, {"as-built": [b"@ZAX0$"], "documented": [b"@ZAX0$"]}),
]


def fly(vehicle: SimulatedVehicle, until: float, cut: random.Random | None = None) -> list[Rx]:
    """Lock step: from foretold event to foretold event, or at the random times of ``cut``."""
    sends = [(t + 0.1 * i, c) for t, by in FLIGHT for i, c in enumerate(by[vehicle.profile])]
    out: list[Rx] = []
    now = 0.0
    while now < until:
        if cut:
            step = cut.choice((0.001, 0.01, 0.3, 1.0, 7.0))
            upcoming = now + step
        else:
            events = vehicle.vehicle_link.next_event(), vehicle.gps_link.next_event()
            upcoming = min(event for event in events if event is not None)
        if sends:
            upcoming = min(upcoming, sends[0][0])
        now = min(upcoming, until)
        out += vehicle.vehicle_link.receive(now) + vehicle.gps_link.receive(now)
        while sends and sends[0][0] <= now:
            vehicle.vehicle_link.send(sends.pop(0)[1], now)
    return out


def ordered(received: list[Rx]) -> list[tuple[str, float, bytes]]:
    return sorted((rx.link, rx.t, rx.data) for rx in received)


@pytest.mark.parametrize("profile", PROFILES)
def test_same_seed_same_bytes_however_time_is_cut(profile: str) -> None:
    settings = parse_settings(
        [
            *("current=0.2@45", "deep_current=0.1@90", "uneven=0.6"),
            *("fault=heavy@30+10", "fault=line_noise@50+9"),
        ]
    )
    first = SimulatedVehicle(profile, 7, settings)
    flown = ordered(fly(first, 90.0))
    for cut in range(4):
        again = SimulatedVehicle(profile, 7, settings)
        assert flown == ordered(fly(again, 90.0, random.Random(cut)))
        assert first.truth() == again.truth()
        assert first.track == again.track
    assert flown != ordered(fly(SimulatedVehicle(profile, 8, settings), 90.0))


def test_reports_come_early_and_late_where_they_are_uneven() -> None:
    most = 0.6
    means = set()
    for seed in range(20):
        vehicle = SimulatedVehicle("documented", seed, parse_settings([f"uneven={most}"]))
        times = [rx.t for rx in vehicle.vehicle_link.receive(200.0)]
        apart = [round(b - a, 3) for a, b in pairwise(times)]
        assert all(2.0 - most <= a <= 2.0 + most for a in apart)
        means.add(round(sum(apart) / len(apart), 1))
    assert min(means) < 1.9  # some boards are fast
    assert max(means) > 2.1  # and some are slow


@pytest.mark.parametrize("profile", PROFILES)
def test_bytes_are_there_at_the_foretold_time_and_not_before(profile: str) -> None:
    vehicle = SimulatedVehicle(profile, 1)
    link = vehicle.vehicle_link
    event = link.next_event()
    assert event is not None
    assert link.receive(math.nextafter(event, 0.0)) == []
    (report,) = link.receive(event)
    assert report.data[:3] == b"@SD"
    assert event - report.t == pytest.approx(86 * 10 / 9600)


@pytest.mark.parametrize("profile", PROFILES)
def test_telemetry_every_two_seconds_with_the_right_checksum(profile: str) -> None:
    vehicle = SimulatedVehicle(profile, 1, Settings(splice=0.0))
    reports = [rx for rx in fly(vehicle, 60.0) if rx.data[:3] == b"@SD"]
    assert [rx.t for rx in reports] == pytest.approx([1.0 + 2.0 * i for i in range(30)])
    for rx in reports:
        assert len(rx.data) == 86
        assert rx.data[-1:] == b"$"
        assert crc32_stm32(rx.data[3:81]) == int.from_bytes(rx.data[81:85], "little")


@pytest.mark.parametrize("profile", PROFILES)
def test_a_closed_link_says_so(profile: str) -> None:
    vehicle = SimulatedVehicle(profile)
    vehicle.vehicle_link.close()
    with pytest.raises(LinkClosed, match="vehicle"):
        vehicle.vehicle_link.receive(1.0)
    with pytest.raises(LinkClosed):
        vehicle.vehicle_link.send(b"@ZAX0$", 1.0)
    assert vehicle.gps_link.receive(2.0)


def test_an_unknown_profile_is_named_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match="as-built"):
        SimulatedVehicle("as-buildt")


@pytest.mark.parametrize("most", [0.0, 0.2])
def test_answers_are_late_by_up_to_what_is_set_each_by_its_own(most: float) -> None:
    vehicle = SimulatedVehicle("as-built", 2, parse_settings([f"answers_late={most}"]))
    took = []
    for i in range(60):
        said = 0.5 + 2.0 * i  # between two reports
        vehicle.advance(said)
        vehicle.vehicle_link.send(b"@ZAS5$", said)
        vehicle.advance(said + 0.4)
        (answer,) = (
            rx for rx in vehicle.vehicle_link.receive(said + 0.4) if rx.data.startswith(b"@ACK")
        )
        took.append(answer.t - said)
    assert min(took) < 0.03
    assert max(took) - min(took) <= most + 1e-6
    assert max(took) - min(took) >= 0.8 * most
