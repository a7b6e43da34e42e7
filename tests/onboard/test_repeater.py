"""The laws of a line on which nobody answers: what holds is said again."""

from __future__ import annotations

import pytest

from mission.model import Action, Outcome, Result
from mission.onboard.runtime.repeater import Repeater
from protocol.codec import CannotEncode
from protocol.messages import Ack, Order, Setpoint

LEG, NEXT = Setpoint(surge=0.5), Setpoint(surge=0.2)
FRAMES: dict[Setpoint | Order, list[bytes]] = {
    LEG: [b"A", b"B"],
    NEXT: [b"C"],
    Order.STOP: [b"X"],
    Order.SURFACE: [b"W"],
}


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


def test_a_board_that_is_kept_awake_is_told_to_stop_before_anything_is_asked_of_it() -> None:
    line = Repeater(encode, 0.1, kept_awake="it sleeps without")
    told = []
    for _ in range(4):
        due = line.next_timer()
        assert due is not None
        sent, outcomes = line.poll(due)
        assert outcomes == []  # nobody asked for it: it is no stop that was acknowledged
        told += [(tx.data, tx.reason) for tx in sent]
    assert told == [(b"X", "it sleeps without (held)")] * 4
    line.command(Action(LEG, "leg"))
    sent, outcomes = line.poll(1.0)
    assert [tx.data for tx in sent] == [b"A", b"B"]
    assert len(outcomes) == 2


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


def test_nothing_of_an_operators_is_relayed_and_nothing_ends_by_it(line: Repeater) -> None:
    line.command(Action(LEG, "leg"))
    why = line.cannot_relay(b"@MMF5$")
    assert why == "this vehicle has no M, R or D"
    assert line.relay(b"@MMF5$", "stick", manual=True) == why
    assert frames(line, 1.0) == [b"A", b"B"]
    assert frames(line, 1.1) == [b"A", b"B"]


def test_a_command_that_waits_is_due_at_once(line: Repeater) -> None:
    line.command(Action(LEG, "leg"))
    assert line.next_timer() == 0.0


def test_a_slow_line_is_given_no_more_than_it_carries_and_the_newest_waits_for_no_other() -> None:
    """A thousand orders in a second on a line that carries ten of them."""
    line = Repeater(lambda command: [bytes(96)], 0.1, bits_per_s=9600)
    sent = []
    for i in range(1000):
        line.command(Action(Order.STOP if i % 2 else LEG, f"order {i}"))
        sent += line.poll(i / 1000)[0]
    assert len(sent) == 10
    due = line.next_timer()
    assert due == pytest.approx(sent[-1].t + 0.1)
    (last,), _ = line.poll(due)
    assert last.reason == "order 999"


def test_what_takes_longer_than_its_period_is_said_as_often_as_the_line_can() -> None:
    line = Repeater(lambda command: [bytes(96)], 0.05, bits_per_s=9600)
    line.command(Action(LEG, "leg"))
    times = []
    for _ in range(4):
        times.append(line.next_timer())
        assert len(line.poll(times[-1])[0]) == 1
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.3])


def test_a_frame_says_why_it_is_sent_and_whether_it_was_said_before(line: Repeater) -> None:
    line.command(Action(NEXT, "leg"))
    said = [(tx.t, tx.link, tx.reason) for now in (1.0, 2.0) for tx in line.poll(now)[0]]
    assert said == [
        (1.0, "vehicle", "leg"),
        (2.0, "vehicle", "leg (held)"),
    ]


def test_every_frame_of_a_command_counts_as_accepted_and_no_answer_changes_that(
    line: Repeater,
) -> None:
    assert line.command(Action(LEG, "leg")) is None
    _, outcomes = line.poll(1.0)
    assert [(o.result, o.frame, o.command) for o in outcomes] == [
        (Result.ACCEPTED, b"A", LEG),
        (Result.ACCEPTED, b"B", LEG),
    ]
    assert line.answer(Ack(1.05, "Z", "A", ord("N")), 1.05) is None
    assert line.poll(1.1)[1] == []


def test_an_operators_w_leaves_for_a_period_before_the_way_in_use_that_came_with_it(
    line: Repeater,
) -> None:
    for command in (Order.SURFACE, Order.STOP):
        line.command(Action(command, "W from the operator"))
    sent, outcomes = line.poll(1.0)
    assert [tx.data for tx in sent] == [b"W"]
    assert outcomes == [Outcome(Result.ACCEPTED, b"W", Order.SURFACE)]
    due = line.next_timer()
    assert due == pytest.approx(1.1)
    sent, outcomes = line.poll(due)
    assert [tx.data for tx in sent] == [b"X"]
    assert outcomes == [Outcome(Result.ACCEPTED, b"X", Order.STOP)]
    assert frames(line, 1.3) == [b"X"]


def test_another_command_waits_for_no_w(line: Repeater) -> None:
    line.command(Action(Order.SURFACE, "W from the operator"))
    line.command(Action(Order.STOP, "X from the operator"))
    assert frames(line, 1.0) == [b"X"]
    for command in (Order.SURFACE, LEG):
        line.command(Action(command, "W from the operator"))
    assert frames(line, 2.0) == [b"W"]
    line.command(Action(Order.STOP, "X from the operator"))
    assert frames(line, 2.01) == [b"X"]
    assert frames(line, 2.2) == [b"X"]


def test_a_way_that_the_board_has_no_word_for_is_refused_and_w_leaves_all_the_same(
    line: Repeater,
) -> None:
    line.command(Action(Order.SURFACE, "W from the operator"))
    refused = line.command(Action(Setpoint(depth=5.0), "W from the operator"))
    assert refused is not None
    assert refused.result is Result.REFUSED
    assert [frames(line, t) for t in (1.0, 1.2)] == [[b"W"], [b"W"]]
