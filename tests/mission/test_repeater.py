"""The laws of a line on which nobody answers: what holds is said again."""

from __future__ import annotations

import pytest

from mission.drive.repeater import Repeater
from mission.model import Action, Outcome, Result
from protocol.codec import CannotEncode
from protocol.messages import Order, Setpoint

LEG, NEXT = Setpoint(surge=0.5), Setpoint(surge=0.2)
FRAMES: dict[Setpoint | Order, list[bytes]] = {LEG: [b"A", b"B"], NEXT: [b"C"], Order.STOP: [b"X"]}


def encode(command: Setpoint | Order) -> list[bytes]:
    if command not in FRAMES:
        raise CannotEncode("no")
    return FRAMES[command]


@pytest.fixture
def line() -> Repeater:
    return Repeater(encode, 0.1)


def frames(line: Repeater, now: float) -> list[bytes]:
    return [tx.data for tx in line.poll(now)[0]]


def test_nothing_is_sent_that_nothing_asked_for(line: Repeater) -> None:
    assert line.next_timer() is None
    assert line.poll(5.0) == ([], [])


def test_what_holds_is_said_every_period(line: Repeater) -> None:
    line.command(Action(LEG, "leg"))
    assert frames(line, 1.0) == [b"A", b"B"]
    assert line.next_timer() == pytest.approx(1.1)
    assert frames(line, 1.05) == []
    assert frames(line, 1.1) == [b"A", b"B"]


def test_a_new_command_goes_at_once_and_counts_as_accepted_once(line: Repeater) -> None:
    line.command(Action(LEG, "leg"))
    line.poll(1.0)
    line.command(Action(Order.STOP, "operator"))
    sent, outcomes = line.poll(1.01)
    assert [tx.data for tx in sent] == [b"X"]
    assert outcomes == [Outcome(Result.ACCEPTED, b"X", Order.STOP)]
    assert line.poll(1.2)[1] == []


def test_what_the_board_has_no_word_for_leaves_the_old_set(line: Repeater) -> None:
    line.command(Action(LEG, "leg"))
    line.poll(1.0)
    refused = line.command(Action(Setpoint(depth=5.0), "deep"))
    assert refused is not None
    assert refused.result is Result.REFUSED
    assert frames(line, 1.1) == [b"A", b"B"]


def test_a_manual_frame_ends_the_repetition(line: Repeater) -> None:
    line.command(Action(LEG, "leg"))
    line.relay(b"M", "stick", manual=True)
    assert frames(line, 1.0) == [b"M"]
    assert line.next_timer() is None
