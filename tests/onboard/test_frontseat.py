"""The laws of the line to the STM32: R1, R6, R7, R8 and the as-built ACK."""

from __future__ import annotations

import pickle

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.model import Action, Outcome, Result, Tx
from mission.onboard.runtime.frontseat import AGAIN_S, ANSWER_S, GAP_S, HELD_S, TRIES, Frontseat
from protocol.codec import CannotEncode
from protocol.messages import Ack, Order, Setpoint

LEG = Setpoint(surge=0.5, depth=10.0)
NEXT = Setpoint(surge=0.0, depth=3.0)
GOTO = Setpoint(surge=0.5, heading=0.0)
TURNED = Setpoint(surge=0.5, heading=0.1)
FRAMES: dict[Setpoint | Order, list[bytes]] = {
    LEG: [b"@ZAF6$", b"@ZAS10$"],
    NEXT: [b"@ZAF0$", b"@ZAS3$"],
    GOTO: [b"@ZAX0$", b"@ZAF6$", b"@ZAH0$"],
    TURNED: [b"@ZAX0$", b"@ZAF6$", b"@ZAH-6$"],
    Order.STOP: [b"@ZAX0$"],
    Order.SURFACE: [b"@ZAWF$"],
}
ACCEPT, REFUSE = ord("Y"), ord("N")


def encode(command: Setpoint | Order) -> list[bytes]:
    if command not in FRAMES:
        raise CannotEncode("heave 2: the vehicle follows -1..1")
    return FRAMES[command]


def ack(code: str = "A", result: int = ACCEPT, t: float = 0.0) -> Ack:
    return Ack(t, "Z", code, result)


class Line:
    """Runs a Frontseat on its own timers and keeps what left and what became of it."""

    def __init__(self) -> None:
        self.seat = Frontseat(encode)
        self.sent: list[Tx] = []
        self.outcomes: list[Outcome] = []

    def give(
        self,
        command: Setpoint | Order,
        now: float,
        reason: str = "leg dive",
        *,
        steers: bool = False,
    ) -> None:
        outcome = self.seat.command(Action(command, reason, steers))
        self.outcomes += [outcome] if outcome else []
        self.poll(now)

    def relay(self, data: bytes, now: float, manual: bool = False) -> None:
        self.seat.relay(data, "relay", manual)
        self.poll(now)

    def answer(self, now: float, code: str = "A", result: int = ACCEPT) -> None:
        outcome = self.seat.answer(ack(code, result), now)
        self.outcomes += [outcome] if outcome else []
        self.poll(now)

    def poll(self, now: float) -> None:
        sent, outcomes = self.seat.poll(now)
        self.sent += sent
        self.outcomes += outcomes

    def until(self, end: float) -> None:
        for _ in range(1000):
            due = self.seat.next_timer()
            if due is None or due > end:
                return
            self.poll(due)
        raise AssertionError("the timer never moves on")

    @property
    def frames(self) -> list[bytes]:
        return [tx.data for tx in self.sent]


@pytest.fixture
def line() -> Line:
    return Line()


def test_second_frame_waits_for_the_answer_to_the_first(line: Line) -> None:
    line.give(LEG, 0.0)
    line.until(0.2)
    assert line.frames == [b"@ZAF6$"]
    line.answer(0.1)
    line.until(0.2)
    assert line.frames == [b"@ZAF6$", b"@ZAS10$"]
    assert line.outcomes == [Outcome(Result.ACCEPTED, b"@ZAF6$", LEG)]


def test_unanswered_frame_goes_three_times_at_300_ms_and_is_lost(line: Line) -> None:
    line.give(LEG, 0.0)
    line.until(0.899)
    assert [round(tx.t, 6) for tx in line.sent] == [0.0, ANSWER_S, 2 * ANSWER_S]
    assert line.outcomes == []
    line.until(0.9 + 1e-9)
    assert line.outcomes == [Outcome(Result.LOST, b"@ZAF6$", LEG)]
    assert len([f for f in line.frames if f == b"@ZAF6$"]) == TRIES


def test_a_lost_frame_does_not_keep_the_rest_of_the_set_from_going(line: Line) -> None:
    line.give(LEG, 0.0)
    line.until(1.0)
    assert line.frames[-1] == b"@ZAS10$"


def test_every_try_names_its_reason(line: Line) -> None:
    line.give(LEG, 0.0, "enter rows/out")
    line.until(0.3)
    assert line.sent[0].reason == "enter rows/out"
    assert line.sent[1].reason == "enter rows/out (try 2 of 3)"


def test_words_that_come_together_leave_as_one_and_hold_no_ascent_back(line: Line) -> None:
    """As flight 16418 of seed 11530, and as a radio gives them that was away for a minute."""
    line.give(Order.STOP, 0.0)
    for i in range(60):
        line.give(Order.SURFACE, 0.001 + i * 1e-5, "W from the operator")
    line.until(2.0)
    assert line.frames == [b"@ZAX0$", *[b"@ZAWF$"] * TRIES]
    line.give(LEG, 2.0, "the way in use")
    assert line.frames[-1] == b"@ZAF6$"


def test_a_way_in_use_leaves_behind_the_word_of_the_same_decision(line: Line) -> None:
    for _ in range(2):
        line.seat.command(Action(Order.SURFACE, "W from the operator"))
        line.seat.command(Action(Order.STOP, "W from the operator"))
    line.until(2.0)
    assert line.frames == [*[b"@ZAWF$"] * TRIES, *[b"@ZAX0$"] * TRIES]


def test_refusal_is_reported_and_not_tried_again(line: Line) -> None:
    line.give(NEXT, 0.0)
    line.answer(0.01, result=REFUSE)
    line.until(0.2)
    assert line.outcomes == [Outcome(Result.REFUSED, b"@ZAF0$", NEXT)]
    assert line.frames == [b"@ZAF0$", b"@ZAS3$"]


def test_frames_are_apart_by_the_gap_after_the_last_byte(line: Line) -> None:
    line.give(LEG, 0.0)
    line.answer(0.001)
    line.until(0.2)
    on_the_wire = len(b"@ZAF6$") * 10 / 9600
    assert line.sent[1].t == pytest.approx(on_the_wire + GAP_S)


@pytest.mark.parametrize("code", ["A", "F"])
def test_both_dialects_of_the_ack_answer(line: Line, code: str) -> None:
    line.give(LEG, 0.0)
    line.answer(0.05, code)
    assert [o.result for o in line.outcomes] == [Result.ACCEPTED]


def test_ack_of_another_code_answers_nothing(line: Line) -> None:
    line.give(LEG, 0.0)
    line.answer(0.05, "S")
    assert line.outcomes == []


def test_ack_while_nothing_is_outstanding_is_dropped(line: Line) -> None:
    line.answer(0.0)
    assert line.outcomes == []
    assert line.seat.idle


@pytest.mark.parametrize("order", list(Order))
def test_orders_overtake_and_drop_everything(line: Line, order: Order) -> None:
    line.give(LEG, 0.0)
    line.seat.relay(b"@RI$", "relay")
    line.give(order, 0.01, "operator")
    line.until(0.1)
    assert line.frames == [b"@ZAF6$", *FRAMES[order]]
    assert line.sent[1].t <= 0.01 + 0.1  # known to sent, R7
    line.answer(0.15)  # owed for F6
    line.answer(0.16)
    line.until(5.0)
    assert line.frames == [b"@ZAF6$", *FRAMES[order]]
    assert line.outcomes == [Outcome(Result.ACCEPTED, FRAMES[order][0], order)]


def test_two_orders_of_one_decision_leave_one_behind_the_other(line: Line) -> None:
    """An operator's W, and then letting go what is upside down (R7)."""
    line.give(LEG, 0.0)
    for order in (Order.SURFACE, Order.STOP):
        line.seat.command(Action(order, "W from the operator"))
    line.until(0.1)
    line.answer(0.11)  # owed for F6
    line.answer(0.12)
    line.until(0.2)
    assert line.frames == [b"@ZAF6$", b"@ZAWF$", b"@ZAX0$"]


def test_the_answer_owed_to_a_dropped_frame_is_never_taken_for_the_stops(line: Line) -> None:
    line.give(LEG, 0.0)
    line.give(Order.STOP, 0.01)
    line.until(0.05)
    line.answer(0.06)
    assert line.outcomes == []
    line.answer(0.07)
    assert [o.frame for o in line.outcomes] == [b"@ZAX0$"]


def test_a_named_ack_answers_the_stop_whatever_is_owed(line: Line) -> None:
    line.give(LEG, 0.0)
    line.give(Order.STOP, 0.01)
    line.until(0.05)
    line.answer(0.06, "X")
    assert [o.frame for o in line.outcomes] == [b"@ZAX0$"]


def test_late_answer_to_a_first_try_does_not_answer_the_next_frame(line: Line) -> None:
    line.give(LEG, 0.0)
    line.until(0.31)  # the second try is out
    line.answer(0.32)  # ... and the first one's answer comes
    line.until(0.35)
    assert line.frames == [b"@ZAF6$", b"@ZAF6$"]  # S10 waits for the answer still owed
    line.answer(0.36)
    line.until(0.4)
    assert line.frames[-1] == b"@ZAS10$"
    assert len(line.outcomes) == 1


def test_an_owed_answer_that_never_comes_holds_the_next_frame_300_ms_at_most(line: Line) -> None:
    line.give(LEG, 0.0)
    line.until(0.31)
    line.answer(0.32)
    line.until(0.61)
    assert line.frames[-1] == b"@ZAS10$"
    assert line.sent[-1].t == pytest.approx(0.6)


def test_a_stop_that_no_board_ever_answers_keeps_no_more_than_what_is_owed_now(
    line: Line,
) -> None:
    """A day of it kept 340,000 answers, and the first that came walked through them all."""
    sizes = []
    for i in range(200):
        line.give(Order.STOP, 0.5 * i)
        line.until(0.5 * i + 0.49)
        sizes.append(len(pickle.dumps(line.seat)))
    assert line.frames == [b"@ZAX0$"] * 400
    assert max(sizes) == max(sizes[:20])


def test_newer_set_replaces_what_is_unsent_of_the_older(line: Line) -> None:
    line.give(LEG, 0.0)
    line.give(NEXT, 0.01)
    line.answer(0.05)
    line.until(0.06)
    line.answer(0.1)
    line.until(0.12)
    assert line.frames == [b"@ZAF6$", b"@ZAF0$", b"@ZAS3$"]


def test_a_relay_waits_for_the_answer_to_a_command(line: Line) -> None:
    """A board that hears nothing for 0.5 s behind each word never heard the next try."""
    line.give(Order.SURFACE, 0.0)
    line.relay(b"@RI$", 0.01)
    line.until(0.1)
    assert line.frames == [b"@ZAWF$"]
    line.answer(0.11)
    line.until(0.2)
    assert line.frames == [b"@ZAWF$", b"@RI$"]
    assert len(line.outcomes) == 1


def test_no_command_is_repeated_after_a_manual_relay(line: Line) -> None:
    line.give(LEG, 0.0)
    line.relay(b"@MMF5$", 0.1, manual=True)
    line.until(5.0)
    assert line.frames == [b"@ZAF6$", b"@MMF5$"]
    assert line.outcomes == []


def test_stop_is_tried_again_before_a_waiting_relay(line: Line) -> None:
    line.give(Order.STOP, 0.0)
    line.seat.relay(b"@RI$", "relay")
    line.poll(ANSWER_S)
    assert line.frames == [b"@ZAX0$"] * 2


def test_of_a_flood_for_the_same_thrusters_the_newest_is_what_waits(line: Line) -> None:
    line.poll(0.0)
    for i in range(1000):
        line.seat.relay(b"@MMF%d$" % (i % 12), "relay", manual=True)
    line.until(100.0)
    assert line.frames == [b"@MMF%d$" % (999 % 12)]


def test_what_the_vehicle_has_no_word_for_is_an_outcome_not_an_exception(line: Line) -> None:
    command = Setpoint(heave=2.0)
    line.give(command, 0.0)
    assert line.sent == []
    assert [(o.result, o.command) for o in line.outcomes] == [(Result.REFUSED, command)]


def test_idle_line_has_no_timer(line: Line) -> None:
    assert line.seat.next_timer() is None
    line.give(Order.STOP, 0.0)
    line.answer(0.01)
    assert line.seat.next_timer() is None


# --- a leg that steers ----------------------------------------------------------------------


def held() -> Line:
    line = Line()
    line.give(GOTO, 0.0)
    for now in (0.1, 0.2, 0.3):
        line.until(now)
        line.answer(now)
    line.sent.clear()
    return line


def said(line: Line, now: float) -> list[bytes]:
    """What leaves from now on, everything being answered."""
    for i in range(6):
        line.until(now + 0.1 * (i + 1))
        line.answer(now + 0.1 * (i + 1))
    return [tx.data for tx in line.sent]


def test_a_leg_that_steers_stops_no_thruster_on_its_way():
    line = held()
    line.give(TURNED, 1.0, steers=True)
    assert said(line, 1.0) == FRAMES[TURNED][1:]
    line.sent.clear()
    line.give(GOTO, 2.0, steers=True)
    assert said(line, 2.0) == FRAMES[GOTO][1:]


def test_an_entry_sends_its_whole_set_whatever_is_held():
    line = held()
    line.give(TURNED, 1.0)
    assert said(line, 1.0) == FRAMES[TURNED]


@pytest.mark.parametrize("spoil", ["refused", "lost", "stop", "stick", "cut short"])
def test_what_may_not_be_held_any_more_is_said_whole(spoil: str):
    line = held()
    if spoil in ("refused", "lost", "cut short"):
        line.give(GOTO, 1.0)
    if spoil == "refused":
        line.answer(1.1, result=REFUSE)
        said(line, 1.1)
    elif spoil == "lost":
        line.until(1.95)
        said(line, 2.0)
    elif spoil == "stop":
        line.give(Order.STOP, 1.0)
        said(line, 1.0)
    elif spoil == "stick":
        line.relay(b"@MMF5$", 1.0, manual=True)
        line.until(2.0)
    line.sent.clear()
    line.give(TURNED, 3.0, steers=True)
    assert [d for d in said(line, 3.0) if d in FRAMES[TURNED]][-3:] == FRAMES[TURNED]


# --- ranks ----------------------------------------------------------------------------------


def test_a_set_that_is_due_leaves_before_any_relay(line: Line) -> None:
    line.give(LEG, 0.0)
    line.seat.relay(b"@DS1,5$", "relay")
    line.seat.relay(b"@RI$", "relay")
    line.answer(0.01)
    line.until(0.03)
    assert line.frames == [b"@ZAF6$", b"@ZAS10$"]
    line.answer(0.1)
    line.until(0.2)
    assert line.frames[2:] == [b"@DS1,5$", b"@RI$"]


def test_a_further_try_leaves_before_any_relay(line: Line) -> None:
    line.give(Order.SURFACE, 0.0)
    line.relay(b"@DS1,5$", ANSWER_S - 0.001)
    line.until(TRIES * ANSWER_S - 0.01)
    assert line.frames == [b"@ZAWF$"] * TRIES
    line.until(TRIES * ANSWER_S + 0.03)
    assert line.frames == [b"@ZAWF$"] * TRIES + [b"@DS1,5$"]


def test_a_board_that_answers_nothing_is_passed_a_word_every_two_seconds(line: Line) -> None:
    """An operator may switch its power off while X is said again and again."""
    line.give(Order.STOP, 0.0)
    for i in range(1, 80):
        line.until(0.1 * i)
        if i % 5 == 0:
            line.give(Order.STOP, 0.1 * i, "no acknowledgement yet")
        line.relay(b"@DS1,%d$" % (i % 20), 0.1 * i)
    passed = [tx.t for tx in line.sent if tx.data.startswith(b"@DS")]
    assert len(passed) == 3
    assert all(b - a >= HELD_S for a, b in zip([0.0, *passed], passed, strict=False))
    assert line.sent[0].data == b"@ZAX0$"


def test_a_new_order_drops_what_was_passed_on_before_it(line: Line) -> None:
    line.give(Order.STOP, 0.0)
    line.relay(b"@RI$", 0.01)
    line.give(Order.SURFACE, 0.1)
    line.until(10.0)
    assert b"@RI$" not in line.frames


def test_what_is_passed_on_behind_a_stop_outlives_its_repetition(line: Line) -> None:
    line.give(Order.STOP, 0.0)
    line.relay(b"@RI$", 0.01)
    line.give(Order.STOP, 0.5, "no acknowledgement yet")
    line.until(10.0)
    assert b"@RI$" in line.frames


FRAME_S = 17 * 10 / 9600 + GAP_S  # the longest that operators have


@pytest.mark.parametrize("rate", [5, 20, 60, 200])
def test_both_frames_of_an_ascent_leave_under_any_slider(line: Line, rate: int) -> None:
    ascent = Setpoint(heave=-1.0)
    FRAMES[ascent] = [b"@ZAX0$", b"@ZAU12$"]
    for i in range(rate * 2):
        now = i / rate
        line.until(now)
        line.relay(b"@DS%d,%d$" % (i % 3 + 1, i % 20), now)
        if i == rate:
            line.give(ascent, now)
    line.until(10.0)
    left = {tx.data: tx.t for tx in reversed(line.sent)}
    assert left[b"@ZAX0$"] - 1.0 <= FRAME_S
    assert left[b"@ZAU12$"] - left[b"@ZAX0$"] <= TRIES * ANSWER_S + 2 * FRAME_S


def test_a_set_that_has_not_left_within_5_s_is_told_once(line: Line) -> None:
    """Each newer set of a leg that steers begins anew, and nobody answers the first try."""
    t, late = 0.0, []
    while t < 20.0:
        line.give(GOTO if round(t) % 2 else TURNED, t, steers=t > 0.0)
        line.until(t + 0.8)
        line.answer(t + 0.8)
        line.until(t + 0.99)
        late += [(t, o) for o in line.outcomes if o.result is Result.LATE]
        line.outcomes.clear()
        t += 1.0
    assert [(t, o.command) for t, o in late] == [(5.0, GOTO)]


def test_the_next_leg_has_its_own_5_s(line: Line) -> None:
    for t in range(12):
        if t % 4 == 0:
            line.give(LEG if t % 8 else GOTO, float(t))
        else:
            line.give(LEG if t % 8 > 4 else GOTO, float(t), steers=True)
        line.until(t + 0.8)
    assert not [o for o in line.outcomes if o.result is Result.LATE]


def test_a_set_that_has_left_is_not_late_though_nobody_answers(line: Line) -> None:
    line.give(LEG, 0.0)
    line.until(60.0)
    assert {o.result for o in line.outcomes} == {Result.LOST}


def test_an_idle_line_behind_a_set_is_not_late_for_the_next(line: Line) -> None:
    line.give(LEG, 0.0)
    for now in (0.1, 0.2):
        line.answer(now)
        line.until(now)
    line.give(GOTO, 30.0)
    line.until(30.9)
    assert line.outcomes[-1].result is not Result.LATE


_RELAYED = [b"@DS%d,%d$" % (n, a) for n in (1, 2, 3) for a in (-15, 0, 22)]
_RELAYED += [b"@DA1,1$", b"@RI$", b"@RSOOOOOOO$"]


@pytest.mark.proof
@settings(max_examples=200, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.floats(0.005, 0.2),
            st.sampled_from([*_RELAYED, *_RELAYED, LEG, NEXT, GOTO, Order.STOP, Order.SURFACE]),
        ),
        max_size=150,
    ),
    st.sampled_from([0.0, 0.01, 0.29, 0.31]),
)
def test_no_mix_of_relays_keeps_an_order_or_a_set_back(script, latency: float) -> None:
    """An order leaves with the frame that is on the line; each frame of a set within the tries of
    those before it. ``latency``: of the board's answers; 0.0: it gives none."""
    line, now = Line(), 0.0
    due: list[tuple[bytes, float]] = []
    answers: list[float] = []
    for pause, what in script:
        now += pause
        for at in [a for a in answers if a <= now]:
            line.until(at)
            line.answer(at)
        answers = [a for a in answers if a > now]
        line.until(now)
        if isinstance(what, bytes):
            line.relay(what, now)
        else:
            due = [] if not isinstance(what, Order) else due
            line.give(what, now)
            spent = 0.0 if isinstance(what, Order) else 2 * TRIES * ANSWER_S
            due = [
                (frame, now + spent + FRAME_S + i * (TRIES * ANSWER_S + FRAME_S))
                for i, frame in enumerate(FRAMES[what])
            ]
        fresh = line.sent
        if latency:
            known = len(answers)
            answers += [tx.t + latency for tx in fresh if tx.data.startswith(b"@ZA")][known:]
        for tx in fresh:
            due = [(f, by) for f, by in due if f != tx.data]
        line.sent = []
        assert all(now <= by for _, by in due), due


UPWARDS = Setpoint(heave=-1.0)
FRAMES[UPWARDS] = [b"@ZAX0$", b"@ZAU12$"]


def test_the_lift_of_an_ascent_is_said_once_more_behind_its_answer(line: Line) -> None:
    """An X0 that is answered twice answers for both."""
    line.give(UPWARDS, 0.0)
    line.answer(0.05)
    line.until(0.06)
    line.answer(0.2)
    line.until(AGAIN_S + 0.1)
    assert line.frames == [b"@ZAX0$", b"@ZAU12$"]
    line.until(AGAIN_S + 0.2)
    line.answer(AGAIN_S + 0.25)
    line.until(60.0)
    assert line.frames == [b"@ZAX0$", b"@ZAU12$", b"@ZAU12$"]
    assert line.seat.next_timer() is None


def test_a_lift_that_nobody_answers_is_said_again_until_something_else_is(line: Line) -> None:
    """A board that hears nothing for 0.8 s behind each word never heard one of the three tries."""
    line.give(UPWARDS, 0.0)
    line.answer(0.05)
    line.until(10.0)
    assert line.frames.count(b"@ZAU12$") == TRIES * 4
    assert line.seat.said_all
    assert [o.result for o in line.outcomes] == [Result.ACCEPTED, *[Result.LOST] * 4]
    line.give(Order.STOP, 10.0)
    line.answer(10.05)
    line.until(60.0)
    assert line.frames[-1] == b"@ZAX0$"


def test_between_the_rows_of_a_lift_relays_leave_and_a_busy_board_hears_the_last_try(
    line: Line,
) -> None:
    line.give(UPWARDS, 0.0)
    line.answer(0.05)
    for i in range(1000):
        line.relay(b"@DS1,%d$" % (i % 20), 0.01 * i)
        line.until(0.01 * i)
    lifts = [tx.t for tx in line.sent if tx.data == b"@ZAU12$"]
    others = [tx.t for tx in line.sent if tx.data.startswith(b"@DS")]
    assert len(others) > 100
    for first, last in zip(lifts[TRIES::TRIES], lifts[2 * TRIES - 1 :: TRIES], strict=False):
        assert last - first > 0.9
        assert not any(first < t < last for t in others)


@pytest.mark.parametrize("answered", [True, False])
def test_no_lift_is_said_again_once_somebody_steers(line: Line, answered: bool) -> None:
    line.give(UPWARDS, 0.0)
    line.answer(0.05)
    line.until(0.5)
    if answered:
        line.answer(0.5, "U")
    line.relay(b"@MMD5$", 0.6, manual=True)
    line.until(60.0)
    assert line.frames[-1] == b"@MMD5$"
