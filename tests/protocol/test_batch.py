"""A mission over the modem: few long frames, and only what is missing again."""

from __future__ import annotations

import math

import pytest
from modem_rig import Flight, OneLineUpload, Vehicle, acoustics_of, digest, fly

from links.acoustic import Water
from protocol.arq import Acoustics, Responder
from protocol.batch import NOT_IDLE, SILENCE, BatchUpload, Declined, Silent, Stored
from protocol.messages import FrameFault
from protocol.modem import MOST, OVERHEAD, Envelope, Sender, wrap
from protocol.sizing import Channel, Plan, Task

LINES = [
    "mission harbour-survey vehicle auv sum 01234567",
    *(f"leg{n}: heading {n} ZAF6 until travelled >= {n} timeout 4min" for n in range(59)),
]


def batch(lines: list[str], water: Water) -> BatchUpload:
    return BatchUpload(lines, digest(lines), acoustics_of(water))


def uploaded(lines: list[str], water: Water, seed: int = 1) -> tuple[Vehicle, Flight]:
    vehicle, sender = Vehicle(), batch(lines, water)
    flight = fly(sender, vehicle, water, seed)
    assert sender.outcome == Stored()
    assert sender.missing == ()
    assert vehicle.stored == tuple(lines)
    return vehicle, flight


def test_a_short_mission_is_one_burst_and_one_answer() -> None:
    vehicle, flight = uploaded(LINES[:9], Water())
    assert b"".join(vehicle.requests).count(b"@AW") == 9 + 1  # line 1 first, and with the question
    assert vehicle.requests[-1].endswith(b"@AQ$")
    assert (flight.topside.bursts, flight.vehicle.bursts) == (1, 1)


def test_what_the_vehicle_holds_already_costs_one_question() -> None:
    water, vehicle = Water(), Vehicle()
    vehicle.stored = tuple(LINES)
    assert fly(batch(LINES, water), vehicle, water, 1).topside.bursts == 1


@pytest.mark.parametrize("loss", [0.1, 0.4])
@pytest.mark.parametrize("errors", [0.0, 1e-4])
@pytest.mark.parametrize("bit_rate", [300.0, 5000.0])
def test_every_channel_brings_the_mission_over_sooner_than_line_by_line(
    loss: float, errors: float, bit_rate: float
) -> None:
    water = Water(range_m=1000.0, bit_rate=bit_rate, loss=loss, bit_error_rate=errors)
    seconds = single = 0.0
    for seed in range(6):
        seconds += uploaded(LINES, water, seed)[1].seconds
        single += fly(OneLineUpload(LINES, acoustics_of(water)), Vehicle(), water, seed).seconds
    assert seconds < single


class Noisy(Responder):
    """Its modem hears a false start twice a second, for 5 s behind everything that it hears."""

    def __init__(self) -> None:
        super().__init__()
        self._noise: list[float] = []

    def receive(self, data: bytes, now: float) -> list[Envelope | FrameFault]:
        due = [t for t in self._noise if t <= now]
        self._noise = self._noise[len(due) :]
        if data:
            self._noise = [now + 0.5 * n for n in range(1, 11)]
        elif due:
            data = b"\x23\x02\x80\x0c\x01"
        return super().receive(data, now)

    def next_timer(self) -> float | None:
        due = super().next_timer()
        return min(t for t in (due, *self._noise[:1], math.inf) if t is not None)


@pytest.mark.parametrize("bit_rate", [1000.0, 5000.0])
def test_an_upload_arrives_though_the_vehicle_hears_false_starts_behind_each_burst(
    bit_rate: float,
) -> None:
    water, vehicle = Water(bit_rate=bit_rate), Vehicle()
    vehicle.responder = Noisy()
    sender = batch(LINES, water)
    noisy = fly(sender, vehicle, water, 1).seconds
    assert sender.outcome == Stored()
    assert vehicle.stored == tuple(LINES)
    assert noisy < 2.0 * uploaded(LINES, water)[1].seconds


def test_only_what_is_missing_is_sent_again() -> None:
    water = Water(range_m=100.0, bit_rate=5000.0)
    vehicle, sender = Vehicle(), batch(LINES, water)
    first = [f for f in sender.frames[:30] if f != sender.frames[7]]
    vehicle.read(b"".join(first), 0.0)
    fly(sender, vehicle, water, 1)
    again = b"".join(vehicle.requests)
    sent_twice = [f for f in sender.frames[1:30] if again.count(f) == 2]
    assert sender.outcome == Stored()
    assert again.count(sender.frames[59]) == 1
    assert sent_twice == []


def test_a_lost_answer_to_a_long_burst_is_asked_for_and_not_sent_again() -> None:
    acoustics, lines = Acoustics(1000.0, 300.0), LINES[:40]
    sender = BatchUpload(lines, digest(lines), acoustics)
    (content,) = sender.outgoing(0.0)
    assert content.count(b"@AW") >= 40
    due = sender.next_timer()
    assert due is not None
    sender.receive(b"", due)
    (question,) = sender.outgoing(due)
    assert len(question) < 100 < len(content)
    assert question[5:].startswith(sender.frames[0])


def test_a_short_content_is_simply_sent_again() -> None:
    sender = BatchUpload(LINES[:2], digest(LINES[:2]), Acoustics(1000.0, 5000.0))
    content = sender.outgoing(0.0)
    due = sender.next_timer()
    assert due is not None
    sender.receive(b"", due)
    assert sender.outgoing(due) == content


def test_a_mission_that_the_vehicle_refuses_is_declined_with_its_reason() -> None:
    water, sender = Water(), batch(LINES[:5], Water())
    fly(sender, Vehicle(refusal="line 3: no way to the surface"), water, 1)
    assert sender.outcome == Declined("line 3: no way to the surface")


def test_nobody_there_is_said_after_a_bounded_time_and_nothing_is_assumed() -> None:
    water = Water(loss=1.0)
    sender = batch(LINES, water)
    flight = fly(sender, Vehicle(), water, 1, most=3600.0)
    assert sender.outcome == Silent()
    assert flight.topside.bursts == SILENCE


def answered(report: bytes) -> BatchUpload:
    sender = BatchUpload(LINES, digest(LINES), Acoustics(1000.0, 1000.0))
    sender.outgoing(0.0)
    assert sender.receive(wrap(report, Sender.VEHICLE), 1.0) == []
    return sender


def test_a_vehicle_under_way_declines() -> None:
    sender = answered(b"@AR,running,9,9,,0123456789abcdef,,$")
    assert sender.outcome == Declined(NOT_IDLE)


def test_a_set_of_somebody_else_is_not_taken_for_ours() -> None:
    sender = answered(b"@AR,staging,9,3,4-9,,,$")
    assert sender.outcome is None
    assert len(sender.missing) == len(LINES)
    (again,) = sender.outgoing(2.0)
    assert again[5:].startswith(sender.frames[0])


def test_a_set_that_the_vehicle_dropped_is_begun_again() -> None:
    sender = answered(b"@AR,staging,60,30,31-60,,,$")
    assert sender.missing == tuple(range(31, 61))
    (content,) = sender.outgoing(2.0)
    assert not content[5:].startswith(sender.frames[0])
    sender.receive(wrap(b"@AR,empty,0,0,,,line 31 before its line 1,$", Sender.VEHICLE), 3.0)
    assert sender.outcome is None
    assert len(sender.missing) == 60


def test_a_report_beyond_the_total_and_a_torn_answer_do_no_harm() -> None:
    assert answered(b"@AR,staging,60,58,2.61-70,,,$").missing == (2,)
    assert len(answered(b"@AR,sta").missing) == 60  # no report: not an answer
    torn = answered(b"@AR,staging,$")
    assert torn.outcome is None
    assert len(torn.missing) == 60


def test_lines_that_were_in_no_burst_go_with_the_question_for_the_answer_that_was_lost() -> None:
    sender = BatchUpload(LINES, digest(LINES), Acoustics(1000.0, 300.0))
    (first,) = sender.outgoing(0.0)
    due = sender.next_timer()
    assert due is not None
    sender.receive(b"", due)
    (second,) = sender.outgoing(due)
    assert sum(frame in second for frame in sender.frames) > 10
    assert not any(frame in first and frame in second for frame in sender.frames[1:])
    assert second[5:].startswith(sender.frames[0])
    assert second[:-2].endswith(b"@AQ$")


def test_a_wrong_bit_costs_its_block_alone() -> None:
    sender, vehicle = BatchUpload(LINES, digest(LINES), Acoustics(100.0, 1000.0)), Vehicle()
    (burst,) = sender.outgoing(0.0)
    at = burst.index(sender.frames[20])
    vehicle.receive(burst[:at] + b"\x00" + burst[at + 1 :], 1.0)
    (answer,) = vehicle.responder.outgoing(2.0)
    sent = [n for n, frame in enumerate(sender.frames, 1) if frame in burst]
    sender.receive(answer, 3.0)
    lacking = set(sender.missing) & set(sent)
    assert 21 in lacking
    assert len(lacking) <= 5


def test_a_damaged_line_1_is_noticed_and_no_refusal_of_the_mission() -> None:
    sender, vehicle = BatchUpload(LINES, digest(LINES), Acoustics(100.0, 1000.0)), Vehicle()
    (burst,) = sender.outgoing(0.0)
    vehicle.receive(burst[:6] + b"x" + burst[7:], 1.0)
    (answer,) = vehicle.responder.outgoing(2.0)
    sender.receive(answer, 3.0)
    assert sender.outcome is None
    assert sender.missing == tuple(range(2, len(LINES) + 1))


def test_every_burst_fits_what_a_modem_sends_at_once() -> None:
    for errors in (0.0, 1e-4, 1e-3):
        water = Water(range_m=1000.0, bit_rate=5000.0, loss=0.2, bit_error_rate=errors)
        uploaded(LINES * 5, water, 3)  # the link refuses what is longer


FULL = 100_000


def blocks_of(channel: Channel) -> Plan:
    return channel.best(Task(left=FULL, line=70, head=0, answer=60, longest=60))


def test_a_clean_channel_earns_the_longest_block_and_one_with_errors_a_line_a_block() -> None:
    water = Acoustics(1000.0, 1000.0)
    clean, noisy = Channel(water), Channel(water)
    for n in range(40):
        clean.learn_block(700, came=True)
        noisy.learn_block(100, came=n % 10 > 0)
    assert blocks_of(clean).size == blocks_of(noisy).size == MOST
    assert blocks_of(clean).block >= 900
    assert blocks_of(noisy).block <= 140


def test_bursts_lost_whatever_their_length_do_not_shorten_them_for_ever() -> None:
    channel = Channel(Acoustics(1000.0, 1000.0))
    for _ in range(10):
        for size in (100, 2300):
            channel.learn(size, 60, came=False)
            channel.learn(size, 60, came=True)
    assert blocks_of(channel).size >= 2300


def test_a_long_burst_without_an_answer_is_asked_for_and_a_short_one_said_again() -> None:
    channel = Channel(Acoustics(1000.0, 300.0))
    task = Task(left=3000, line=70, head=0, answer=60, longest=60)
    assert channel.asking_pays(3000, 1, task)
    assert not channel.asking_pays(60, 1, task)
    assert channel.asking_pays(60, 12, task)  # by now one of them will have come


@pytest.mark.parametrize("bit_rate", [300.0, 1000.0])
@pytest.mark.parametrize("errors", [1e-4, 3e-4])
def test_wrong_bits_cost_little_more_than_the_blocks_they_spoil(
    errors: float, bit_rate: float
) -> None:
    water = Water(range_m=1000.0, bit_rate=bit_rate, bit_error_rate=errors)
    block = max(map(len, BatchUpload(LINES, "", acoustics_of(water)).frames)) + OVERHEAD
    spoilt = 1.0 - (1.0 - errors) ** (8 * block)
    clean = uploaded(LINES, Water(range_m=1000.0, bit_rate=bit_rate))[1].seconds
    seconds = [uploaded(LINES, water, seed)[1].seconds for seed in range(8)]
    assert sum(seconds) / len(seconds) < 1.35 * clean / (1.0 - spoilt)


def test_other_words_beside_or_before_the_report_are_passed_over() -> None:
    assert answered(b"@ACK_STT$@AR,running,9,9,,,,$").outcome == Declined(NOT_IDLE)
    assert answered(b"@ACK_STT$").outcome is None
