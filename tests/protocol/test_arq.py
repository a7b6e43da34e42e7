"""Under water one asks and the other answers; timeouts follow from range and length alone."""

from __future__ import annotations

import pytest

from protocol.arq import (
    FLOOR,
    GATHER,
    HELD,
    NOISE,
    TURNAROUND,
    Acoustics,
    Answered,
    Initiator,
    NoAnswer,
    Responder,
    Unasked,
)
from protocol.codec import CannotEncode
from protocol.messages import FrameFault
from protocol.modem import IDLE, OVERHEAD, Envelope, Sender, wrap
from protocol.topside_frames import LONG

FAR = Acoustics(range_m=1500.0, bit_rate=800.0)
ANSWER = wrap(b"@ACK_AAA$", Sender.VEHICLE)


def test_patience_is_travel_airtime_and_lines_of_both_and_the_turnaround() -> None:
    assert FAR.airtime(93) == 1.0
    lines = 2 * 10 * (100 + 200) / 115200
    assert FAR.patience(93, 193) == pytest.approx(2.0 + 1.0 + 2.0 + lines + TURNAROUND)
    slow = Acoustics(range_m=150.0, bit_rate=100.0, preamble=0.5, baud=1200)
    assert slow.patience(93, 193) == pytest.approx(0.2 + 8.5 + 16.5 + 5.0 + TURNAROUND)


@pytest.mark.parametrize("baud", [115200, 9600, 1200, 300])
def test_an_answer_that_comes_at_the_pace_of_a_slow_line_is_heard_in_time(baud: int) -> None:
    """G3, R1: the longest @AR takes 3.4 s at 1200 baud, in by the one line and out by the other."""
    water = Acoustics(range_m=500.0, bit_rate=5000.0, baud=baud)
    boat, content = Initiator(water), b"@AR," + b"x" * (LONG - 6) + b",$"
    boat.ask(b"@AQ$", LONG, tries=1)
    now = len(boat.outgoing(0.0)[0]) * 20 / baud + water.airtime(4) + 1.0  # and a second of thought
    now += len(content) * 10 / baud + water.airtime(LONG) + 2 * 500.0 / 1500.0
    heard = []
    for byte in wrap(content, Sender.VEHICLE):
        now += 10 / baud
        heard += boat.receive(bytes([byte]), now)
    assert heard == [Answered(b"@AQ$", content, pytest.approx(now, abs=len(content) * 11 / baud))]


def test_a_request_goes_out_once_and_its_answer_ends_it() -> None:
    boat = Initiator(FAR)
    assert boat.idle
    assert boat.next_timer() is None
    boat.ask(b"@AA$", 9)
    assert boat.outgoing(10.0) == [wrap(b"@AA$", Sender.TOPSIDE)]
    assert boat.outgoing(10.1) == []
    assert boat.next_timer() == pytest.approx(10.0 + FAR.patience(4, 9))
    assert boat.receive(ANSWER, 12.0) == [Answered(b"@AA$", b"@ACK_AAA$", 12.0)]
    assert boat.idle
    assert boat.next_timer() is None


def test_no_answer_is_said_after_the_last_try_and_not_before() -> None:
    boat = Initiator(FAR)
    boat.ask(b"@AA$", 9, tries=2)
    assert len(boat.outgoing(0.0)) == 1
    first = boat.next_timer()
    assert first is not None
    assert boat.receive(b"", first) == []
    assert len(boat.outgoing(first)) == 1
    second = boat.next_timer()
    assert second == pytest.approx(2 * first)
    assert boat.receive(b"", second - 0.01) == []
    assert boat.outgoing(second) == []
    assert boat.receive(b"", second) == [NoAnswer(b"@AA$", second)]
    assert boat.idle


def test_one_request_at_a_time() -> None:
    boat = Initiator(FAR)
    boat.ask(b"@AA$", 9)
    with pytest.raises(ValueError, match="one request"):
        boat.ask(b"@DU$", 163)


def test_what_no_envelope_holds_is_refused_before_anything_is_sent() -> None:
    boat = Initiator(FAR)
    with pytest.raises(CannotEncode):
        boat.ask(bytes(3201), 9)
    assert boat.idle


def test_what_goes_ahead_is_in_the_same_burst_in_an_envelope_of_its_own() -> None:
    boat = Initiator(FAR)
    boat.ask(b"@AQ$", 100, ahead=(b"@DU$", b"@NI$"))
    (burst,) = boat.outgoing(0.0)
    assert burst == b"".join(wrap(each, Sender.TOPSIDE) for each in (b"@DU$", b"@NI$", b"@AQ$"))
    due = boat.next_timer()
    assert due == pytest.approx(FAR.patience(len(burst) - OVERHEAD, 100))


def test_the_vehicle_does_not_speak_while_the_next_content_comes_in() -> None:
    diver = Responder()
    first, second = (wrap(each, Sender.TOPSIDE) for each in (b"@DU$", b"@AQ$"))
    diver.receive(first + second[:4], 10.0)
    diver.answer(b"@ACK_AAA$", 10.0)
    assert diver.outgoing(10.0 + 2 * GATHER) == []
    diver.receive(second[4:], 10.5)
    due = diver.next_timer()
    assert due == pytest.approx(10.5 + GATHER)
    assert diver.outgoing(due) == [wrap(b"@ACK_AAA$", Sender.VEHICLE)]


def test_a_content_that_never_ends_keeps_no_answer_back_for_longer_than_it_is_waited_for() -> None:
    diver = Responder()
    diver.receive(wrap(b"@DU$", Sender.TOPSIDE) + b"\x23\x02\x00\x0c", 10.0)
    diver.answer(b"@ACK_AAA$", 10.0)
    due = diver.next_timer()
    assert due == pytest.approx(10.0 + IDLE)
    diver.receive(b"", due)
    assert diver.outgoing(due) == [wrap(b"@ACK_AAA$", Sender.VEHICLE)]


FALSE_START = b"\x23\x02\x80\x0c\x01"  # of a content of 3200 bytes


def test_noise_that_never_ends_keeps_no_answer_back_for_longer_than_it_is_waited_for() -> None:
    diver = asked(now=10.0)
    diver.answer(b"@ACK_AAA$", 10.0)
    spoken = []
    for n in range(1, 200):
        now = 10.0 + 0.1 * n
        diver.receive(FALSE_START, now)
        assert diver.next_timer() is not None
        spoken += [(now, word) for word in diver.outgoing(now)]
    assert spoken == [(pytest.approx(10.0 + HELD), wrap(b"@ACK_AAA$", Sender.VEHICLE))]


def test_no_timer_of_an_answer_in_noise_is_behind_what_it_waits_for() -> None:
    diver = asked(now=10.0)
    diver.answer(b"@ACK_AAA$", 10.0)
    diver.receive(FALSE_START, 10.9)
    due = diver.next_timer()
    assert due == pytest.approx(10.0 + HELD)
    assert diver.outgoing(due - 0.01) == []
    assert diver.outgoing(due) == [wrap(b"@ACK_AAA$", Sender.VEHICLE)]


def test_what_was_not_asked_for_answers_nothing() -> None:
    boat = Initiator(FAR)
    assert boat.receive(ANSWER, 0.0) == [Unasked(b"@ACK_AAA$", 0.0)]
    boat.ask(b"@AQ$", 400, matches=lambda content: b"@AR," in content)
    assert boat.receive(ANSWER, 1.0) == [Unasked(b"@ACK_AAA$", 1.0)]  # not yet sent
    boat.outgoing(2.0)
    assert boat.receive(ANSWER, 3.0) == [Unasked(b"@ACK_AAA$", 3.0)]  # of another request
    assert not boat.idle


def test_the_own_echo_is_no_answer() -> None:
    boat = Initiator(FAR)
    boat.ask(b"@AA$", 9)
    (sent,) = boat.outgoing(0.0)
    assert boat.receive(sent, 0.1) == []


def test_a_damaged_answer_is_a_fault_and_the_request_is_repeated() -> None:
    boat = Initiator(FAR)
    boat.ask(b"@AA$", 9)
    boat.outgoing(0.0)
    boat.receive(ANSWER[:-1] + b"\x00", 1.0)
    due = boat.next_timer()
    assert due is not None
    assert [type(x) for x in boat.receive(b"", due)] == [FrameFault]
    again = boat.next_timer()
    assert again is not None
    boat.receive(b"", again)
    assert len(boat.outgoing(again)) == 1


def asked(content: bytes = b"@AA$", now: float = 10.0) -> Responder:
    diver = Responder()
    assert diver.receive(wrap(content, Sender.TOPSIDE), now) == [Envelope(now, 1, content)]
    return diver


def test_the_vehicle_speaks_when_asked_and_only_then() -> None:
    diver = Responder()
    diver.answer(b"@ACK_AAA$", 0.0)
    assert diver.outgoing(1e6) == []
    diver = asked()
    assert diver.outgoing(11.0) == []  # nothing to say
    diver.answer(b"@ACK_AAA$", 11.0)
    assert diver.next_timer() == pytest.approx(11.0 + GATHER)
    assert diver.outgoing(11.0) == []  # there may be more
    assert diver.outgoing(11.0 + GATHER) == [ANSWER]
    diver.answer(b"@ACK_STT$", 11.3)
    assert diver.next_timer() is None
    assert diver.outgoing(11.3 + GATHER) == []  # one answer a request


def test_what_is_late_waits_for_the_next_request() -> None:
    diver = asked(now=10.0)
    diver.answer(b"@ACK_AAA$", 10.0 + FLOOR)
    assert diver.next_timer() is None
    assert diver.outgoing(10.0 + FLOOR + GATHER) == []
    diver.receive(wrap(b"@DU$", Sender.TOPSIDE), 20.0)
    assert diver.outgoing(20.0 + GATHER) == [ANSWER]


def test_an_owner_who_comes_too_late_does_not_talk_over_the_next_request() -> None:
    diver = asked(now=10.0)
    diver.answer(b"@ACK_AAA$", 10.0)
    assert diver.outgoing(10.0 + FLOOR + 0.1) == []
    assert diver.next_timer() is None


def test_an_answer_holds_whole_frames_and_the_rest_waits() -> None:
    diver = asked()
    frame = b"@VS" + b"1" * 996 + b"$"
    for _ in range(4):
        diver.answer(frame, 10.0)
    assert diver.outgoing(10.0 + GATHER) == [wrap(frame * 3, Sender.VEHICLE)]
    diver.receive(wrap(b"@DU$", Sender.TOPSIDE), 20.0)
    assert diver.outgoing(20.0 + GATHER) == [wrap(frame, Sender.VEHICLE)]


def test_a_store_report_replaces_the_acknowledgements_of_lines() -> None:
    diver = asked()
    report = b"@AR,ready,1,1,,0123456789abcdef,,$"
    for frame in (b"@ACK_AWW$", b"@ACK_AWN$", b"@ACK_STT$", report):
        diver.answer(frame, 10.0)
    assert diver.outgoing(10.0 + GATHER) == [wrap(b"@ACK_STT$" + report, Sender.VEHICLE)]


def test_the_status_on_surfacing_waits_for_a_quiet_moment() -> None:
    diver = asked(now=10.0)
    diver.unasked(b"@VS1$", 10.1)
    diver.unasked(b"@VS2$", 10.2)
    assert diver.next_timer() == pytest.approx(10.0 + FLOOR)
    assert diver.outgoing(10.3) == []
    assert diver.outgoing(10.0 + FLOOR) == [wrap(b"@VS2$", Sender.VEHICLE)]
    assert diver.outgoing(100.0) == []


@pytest.mark.parametrize("noise", [b"\x55", FALSE_START])
def test_in_noise_an_unasked_word_waits_for_a_minute_without_a_request(noise: bytes) -> None:
    diver, requested, spoken = asked(now=0.0), [], []
    diver.unasked(b"@VS1$", 0.0)
    for n in range(1, 200):
        now = 0.5 * n
        heard = diver.receive(wrap(b"@DU$", Sender.TOPSIDE) if n == 20 else noise, now)
        requested += [now for item in heard if isinstance(item, Envelope)]
        if n == 40:
            diver.unasked(b"@VS2$", now)  # newer, and waits no longer
        spoken += [(now, word) for word in diver.outgoing(now)]
    assert len(requested) == 1
    assert spoken == [(requested[0] + NOISE, wrap(b"@VS2$", Sender.VEHICLE))]


def test_the_vehicle_does_not_hear_itself_and_tells_damage() -> None:
    diver = Responder()
    assert diver.receive(ANSWER, 0.0) == []
    assert diver.receive(b"noise", 1.0) == []
    due = diver.next_timer()
    assert due is not None
    assert diver.receive(b"", due) == [FrameFault(len(ANSWER), "bad_header", 5)]
