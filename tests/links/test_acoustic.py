"""The simulated water: delay, airtime, half duplex, loss and wrong bits, the same every time."""

from __future__ import annotations

import pytest

from links import LinkAddressError, open_link
from links.acoustic import MTU, AcousticLink, Water, acoustic_pair
from links.base import LinkBusy, LinkClosed, LinkError


def heard(link: AcousticLink, until: float = 1e6) -> list[bytes]:
    return [rx.data for rx in link.receive(until)]


def test_a_burst_arrives_whole_after_airtime_and_sound() -> None:
    a, b = acoustic_pair(Water(range_m=1500.0, bit_rate=800.0), 1)
    a.send(b"x" * 100, 10.0)
    assert b.next_event() == pytest.approx(12.0)
    assert b.receive(11.99) == []
    (rx,) = b.receive(12.0)
    assert (rx.t, rx.link, rx.data) == (pytest.approx(12.0), "modem", b"x" * 100)
    assert b.next_event() is None
    assert a.receive(12.0) == []


def test_what_is_sent_while_transmitting_waits_its_turn() -> None:
    a, b = acoustic_pair(Water(range_m=0.0, bit_rate=80.0, preamble=0.5), 1)
    a.send(b"1" * 10, 0.0)
    a.send(b"2" * 10, 0.1)
    assert [rx.t for rx in b.receive(9.0)] == [1.5, 3.0]
    assert a.tally.airtime == 3.0


def test_half_duplex_loses_what_arrives_while_talking() -> None:
    a, b = acoustic_pair(Water(range_m=1500.0, bit_rate=80.0), 1)
    a.send(b"a" * 10, 0.0)  # heard by b from 1 to 2 s
    b.send(b"b" * 10, 1.5)  # b talks from 1.5 to 2.5 s, heard by a from 2.5 s
    assert heard(b) == []
    assert heard(a) == [b"b" * 10]
    assert a.tally.collided == 1


def test_loss_takes_its_share_of_bursts_and_nothing_else() -> None:
    a, b = acoustic_pair(Water(loss=0.3), 7)
    for n in range(2000):
        a.send(bytes([n & 255]), 10.0 * n)
    got = heard(b)
    assert len(got) == 2000 - a.tally.lost
    assert a.tally.lost / 2000 == pytest.approx(0.3, abs=0.04)


def test_wrong_bits_come_at_their_rate_and_change_no_length() -> None:
    a, b = acoustic_pair(Water(bit_error_rate=1e-3), 7)
    for n in range(100):
        a.send(bytes(1000), 100.0 * n)
    got = heard(b)
    assert {len(data) for data in got} == {1000}
    wrong = sum(byte.bit_count() for data in got for byte in data)
    assert wrong / 800_000 == pytest.approx(1e-3, rel=0.15)
    assert a.tally.damaged == sum(1 for data in got if any(data))


def test_at_the_worst_rate_every_bit_is_wrong_and_an_empty_burst_stays_empty() -> None:
    a, b = acoustic_pair(Water(bit_error_rate=1.0), 1)
    a.send(b"\x00\x0f", 0.0)
    a.send(b"", 100.0)
    assert heard(b) == [b"\xff\xf0", b""]


def test_the_same_seed_gives_the_same_bytes() -> None:
    def run(seed: int) -> list[bytes]:
        a, b = acoustic_pair(Water(loss=0.2, bit_error_rate=1e-3), seed)
        for n in range(50):
            a.send(bytes(200), 10.0 * n)
        return heard(b)

    assert run(3) == run(3)
    assert run(3) != run(4)


def test_a_burst_beyond_one_frame_is_an_error_of_the_sender() -> None:
    a, _ = acoustic_pair(Water(), 1)
    with pytest.raises(LinkError, match="3208 bytes"):
        a.send(bytes(MTU + 1), 0.0)


def test_a_closed_end_says_so_and_the_other_talks_into_empty_water() -> None:
    a, b = acoustic_pair(Water(), 1)
    assert a.fileno() == -1
    b.close()
    for use in (lambda: b.receive(0.0), lambda: b.send(b"x", 0.0)):
        with pytest.raises(LinkClosed):
            use()
    a.send(b"x", 0.0)
    assert a.receive(1e6) == []


def test_two_modems_meet_in_the_water_they_name() -> None:
    url = "acoustic://bay-one?range=1500&rate=800&loss=0&errors=0&seed=3"
    alone = open_link("boat", url)
    alone.send(b"anybody?", 0.0)
    diver = open_link("diver", "acoustic://bay-one")
    alone.send(b"x" * 92, 10.0)
    assert [(rx.t, rx.link) for rx in diver.receive(20.0)] == [(pytest.approx(11.92), "diver")]
    with pytest.raises(LinkBusy, match="two modems"):
        open_link("third", "acoustic://bay-one")
    diver.close()
    again = open_link("diver", "acoustic://bay-one")
    alone.send(b"y", 30.0)
    assert [rx.data for rx in again.receive(40.0)] == [b"y"]
    with pytest.raises(LinkAddressError, match="acoustic://bay"):
        open_link("x", "acoustic://")


@pytest.mark.parametrize(
    "water", [{"bit_rate": 0.0}, {"range_m": -1.0}, {"loss": 1.1}, {"bit_error_rate": -0.1}]
)
def test_an_impossible_channel_is_refused(water: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="not"):
        Water(**water)
