"""Who asked for a byte: Steps and operators, whatever the reason beside it says."""

from __future__ import annotations

import math
import struct

import pytest

from mission.engine.words import in_words
from mission.model import (
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    Evaluation,
    Step,
    Tx,
)
from mission.verification.campaign.audit import audit, command_of
from mission.verification.campaign.obedience import ignored
from mission.verification.campaign.soak import last_words
from mission.verification.rig.acts import Act
from mission.verification.rig.trace import Done, Event, Heard, Said
from protocol.messages import Order, Setpoint
from protocol.modem import wrap


def step(t: float, *actions: str, entered: str = "", trigger: str = "") -> Step:
    return Step(t, "", (), (), (entered,) if entered else (), actions, trigger)


def sent(t: float, data: bytes) -> Tx:
    return Tx(t, "vehicle", data, "because")


def said(t: float, data: bytes) -> Said:
    return Said(t, "topside", "boat", data)


def spurious(*events: Event) -> int:
    return len(audit(events, "as-built"))


STARTED: tuple[Event, ...] = (
    said(1.0, b"@AA$"),
    step(1.0, "surge 0.5 heading 90 depth 4: entry of a", entered="autonomous/a", trigger="start"),
)
STOP: tuple[Event, ...] = (
    said(5.0, b"@ZAX0$"),
    step(5.0, "everything stopped: X from the operator", entered=STOPPED, trigger="X"),
)


@pytest.mark.parametrize(
    "command",
    [Order.STOP, Order.SURFACE, Setpoint(0.5, heading=math.pi / 2, depth=4.0), Setpoint(heave=-1)],
)
def test_a_step_says_its_command_so_that_it_can_be_read_back(command: Setpoint | Order) -> None:
    assert command_of(f"{in_words(command)}: why") == command


def test_the_frames_of_a_set_are_asked_for_three_times_each_and_no_more() -> None:
    tries = [sent(1.0 + 0.3 * i, b"@ZAS4$") for i in range(3)]
    assert spurious(*STARTED, *tries, sent(2.0, b"@ZAH-90,6$")) == 0
    assert spurious(*STARTED, *tries, sent(1.9, b"@ZAS4$")) == 1
    assert spurious(*STARTED, sent(1.1, b"@ZAS5$")) == 0  # within what rounding explains
    assert spurious(*STARTED, sent(1.1, b"@ZAS9$")) == 1


def test_nothing_is_asked_for_before_a_step() -> None:
    assert spurious(sent(0.5, b"@ZAX0$")) == 1


def test_a_stop_ends_what_was_asked_for_before() -> None:
    assert spurious(*STARTED, *STOP, sent(5.0, b"@ZAX0$")) == 0
    assert spurious(*STARTED, *STOP, sent(5.3, b"@ZAS4$")) == 1


def test_a_start_a_stop_and_a_surfacing_need_somebody_who_asked() -> None:
    assert spurious(STARTED[1]) == 1
    assert spurious(STOP[1]) == 1
    up = "emergency surfacing: because"
    assert spurious(step(9.0, up, entered=SURFACING, trigger="W")) == 1
    assert spurious(said(9.0, b"@ZAWF$"), step(9.0, up, entered=SURFACING, trigger="W")) == 0
    seen = (Evaluation("limit depth", True, ()),)
    limit = Step(9.0, "", seen, (), (SURFACING,), (up,), "limit")
    assert spurious(limit) == 0


def test_a_leg_is_no_place_for_the_emergency() -> None:
    late = step(6.0, "surge 1: a steers")
    assert spurious(*STOP, late) == 1


def test_a_stop_is_repeated_until_it_is_acknowledged() -> None:
    again = [step(5.5 + 0.5 * i, "everything stopped: no acknowledgement yet") for i in range(9)]
    assert spurious(*STOP, *again) == 0
    acks = Heard(5.2, b"@ACK_ZAY$" * 4)
    assert spurious(*STOP, acks, again[0]) == 1


def test_an_acknowledgement_that_may_be_an_older_frames_ends_no_repetition() -> None:
    again = step(9.0, "everything stopped: no acknowledgement yet")
    stops = [step(t, "everything stopped: no acknowledgement yet") for t in (6.0, 7.0, 8.0)]

    def stopped(since_the_older: float) -> list[Event]:
        told: list[Event] = []
        for stop in stops:
            older = sent(stop.t - since_the_older, b"@ZAX0$")
            told += [older, stop, sent(stop.t, b"@ZAX0$"), Heard(stop.t, b"@ACK_ZAY$" * 2)]
        return told

    assert spurious(*STOP, *stopped(0.2), again) == 0
    assert spurious(*STOP, *stopped(0.4), again) > 0


def test_a_stop_is_said_again_when_a_report_shows_a_thruster_on() -> None:
    again = step(9.0, "everything stopped: a thruster turns after it was stopped")
    acks = Heard(5.2, b"@ACK_ZAY$" * 4)

    def report(pwm: int) -> Heard:
        return Heard(8.0, b"@SD" + bytes(60) + struct.pack("<7H", *(7 * (pwm,))) + bytes(9))

    assert spurious(*STOP, acks, report(1500), again) == 1
    assert spurious(*STOP, acks, report(1700), again) == 0


def test_a_relay_is_what_an_operator_said_once() -> None:
    driving = step(3.0, entered=MANUAL_DRIVING, trigger="stick")
    moved = said(3.0, b"@MMF5$")
    assert spurious(moved, driving, sent(3.0, b"@MMF5$")) == 0
    assert spurious(moved, driving, sent(3.0, b"@MMF5$"), sent(3.1, b"@MMF5$")) == 1
    assert spurious(moved, driving, sent(3.0, b"@MMF6$")) == 1
    assert spurious(moved, sent(3.0, b"@MMF5$")) == 1  # the stick has not got the vehicle
    cut = (said(3.0, b"@RI"), said(3.1, b"$"), sent(3.1, b"@RI$"))
    assert spurious(*cut) == 0


def test_relays_to_a_board_that_says_nothing_leave_2_s_apart() -> None:
    """As flight 230 of seed 5212: several that wait are late by as much."""
    words = [b"@DA%d,1$" % servo for servo in range(1, 5)]
    asked = [said(3.0, word) for word in words]
    late = [sent(13.0 + 2.0 * i, word) for i, word in enumerate(words)]
    assert spurious(*asked, *late) == 0
    answers = [Heard(12.9 + 2.0 * i, b"@ACK_DY$") for i in range(4)]
    told = [event for pair in zip(answers, late, strict=True) for event in pair]
    assert spurious(*asked, *told) == 3
    assert spurious(*asked, *late[:2], answers[2], *late[2:]) == 0  # one alone is answered
    assert spurious(asked[0], sent(16.0, words[0])) == 1


@pytest.mark.parametrize("ends", [True, False])
def test_an_m_that_is_refused_as_the_program_ends_holds_nothing(ends: bool) -> None:
    """As flight 2909 of seed 5111."""
    end = (Done(3.5, Act.END),) if ends else ()
    driving = step(3.0, entered=MANUAL_DRIVING, trigger="stick")
    waits = step(5.0, "everything stopped: no M for 2 s", entered=MANUAL_WAITING, trigger="silent")
    m = b"@MMF5$"
    events = (said(3.0, m), driving, *end, said(4.0, m), waits)
    assert spurious(*events) == (0 if ends else 1)


def test_the_stick_holds_back_every_z() -> None:
    events = (*STARTED, said(3.0, b"@MMF5$"), step(3.0, entered=MANUAL_DRIVING, trigger="stick"))
    assert spurious(*events, sent(3.0, b"@MMF5$"), sent(3.2, b"@ZAS4$")) == 2


def test_a_stick_out_of_its_range_holds_nothing() -> None:
    driving = step(3.0, entered=MANUAL_DRIVING, trigger="stick")
    waits = step(5.0, "everything stopped: no M for 2 s", entered=MANUAL_WAITING, trigger="silent")
    assert spurious(said(3.0, b"@MMF5$"), driving, said(4.0, b"@MMF90$"), waits) == 0
    assert spurious(said(3.0, b"@MMF5$"), driving, said(4.0, b"@MMF9$"), waits) == 1


def test_the_stick_is_as_silent_as_who_holds_it() -> None:
    """Others may say M as often as they like, and nobody drives over a modem."""
    driving = step(3.0, entered=MANUAL_DRIVING, trigger="stick")
    waits = step(5.0, "everything stopped: no M for 2 s", entered=MANUAL_WAITING, trigger="silent")
    held = (said(3.0, b"@MMF5$"), driving, sent(3.0, b"@MMF5$"))
    other = Said(4.0, "topside", "other boat", b"@MMF6$")
    assert spurious(*held, other, waits) == 0
    assert spurious(*held, Said(4.0, "modem", "", b"#\x02\x06\x00\x01@MMD9$_6"), waits) == 0
    assert spurious(Said(3.0, "modem", "", b"@MMF5$"), driving) == 1
    # the first boat has gone, and what the other one says is passed on: now it has the stick
    assert spurious(*held, other, sent(4.0, b"@MMF6$"), waits) == 1


def test_a_late_copy_of_a_start_by_modem_asks_for_nothing() -> None:
    """R12: the mission is over, and what its start was said with comes once more."""

    def again(t: float, link: str = "modem") -> tuple[Event, ...]:
        heard = Said(t, link, "", wrap(b"@AA$", 1) if link == "modem" else b"@AA$")
        return heard, step(t, "surge 0: entry of a", entered="autonomous/a", trigger="start")

    over = (*STARTED, step(9.0, "everything stopped: it is over", entered=IDLE_READY))
    assert spurious(*over, *again(23.0)) == 1
    assert spurious(*over, *again(23.0, "topside")) == 0
    assert spurious(*over, *again(122.0)) == 0
    assert spurious(*over, again(100.0)[0], *again(122.0)) == 0  # a copy renews nothing
    assert spurious(*over, Done(20.0, Act.KILL), Done(22.0, Act.BOOT), *again(23.0)) == 0


def test_a_mission_in_a_row_knows_the_ascent_that_the_one_before_was_in() -> None:
    """As mission 3929 of soak 42: nothing answers, so U12 is said again for as long as its turn."""
    ascent = (
        step(80.0, "everything stopped: a limit", entered=SURFACING),
        step(90.0, "everything stopped: after 10 s", "surge 0 heave -1: after 10 s"),
        step(91.0, trigger="silent"),
    )
    later = [sent(0.1 + 1.5 * i, b"@ZAU12$") for i in range(5)]
    known = audit([*last_words(ascent, 100.0), *later], "as-built")
    assert [one for one in known if one.t >= 0.0] == []
    state = [event for event in last_words(ascent, 100.0) if event.t == -20.0]
    assert len([one for one in audit([*state, *later], "as-built") if one.t >= 0.0]) == 5


# --- what was ordered leaves ------------------------------------------------------------------------


def held_back(*events: Event) -> int:
    return len(ignored([*events, said(99.0, b"")], "as-built"))


@pytest.mark.parametrize(
    "data", [b"@ZAX0$", b"#\x02\x80\x0c\x01@ZAX0$\xff", wrap(b"@ZAX0$", 1), b"@ZAWF$@ZAX0$"]
)
@pytest.mark.parametrize("link", ["topside", "modem"])
def test_an_order_in_whatever_came_is_on_its_way_within_100_ms(data: bytes, link: str) -> None:
    assert held_back(Said(5.0, link, "", data), sent(5.09, b"@ZAX0$")) == 0
    assert held_back(Said(5.0, link, "", data), sent(5.11, b"@ZAX0$")) == 1
    assert held_back(Said(5.0, link, "", data), Done(5.05, Act.KILL)) == 0


def test_no_w_leaves_behind_an_ascent_that_has_ended() -> None:
    """As flight 9558 of seed 4404: the surface was proved 3 ms behind it, in the gap of the line."""
    up = step(5.003, "everything stopped: the surface is reached", entered=SURFACED)
    assert held_back(said(5.0, b"@ZAWF$"), up, sent(5.02, b"@ZAX0$")) == 0
    assert held_back(up, said(5.01, b"@ZAWF$"), sent(5.02, b"@ZAX0$")) == 1
    assert held_back(said(5.0, b"@ZAX0$"), up) == 1


def test_a_w_said_again_as_the_turn_of_its_way_ends_leaves_no_more() -> None:
    """As flight 9128 of seed 4808: the next way was due 20 ms later."""
    heard = Step(
        5.0, "", (), (), (SURFACING,), ("emergency surfacing: W", "surge 0 heave -1: W"), "W"
    )
    said_twice = (said(5.0, b"@ZAWF$"), heard, sent(5.0, b"@ZAWF$"), said(15.0, b"@ZAWF$"))
    ended = (step(15.02, "everything stopped: no less"), sent(15.02, b"@ZAX0$"))
    first = (sent(5.9, b"@ZAX0$"), sent(6.0, b"@ZAU12$"))
    events = sorted((*said_twice, *first, *ended), key=lambda event: event.t)
    assert held_back(*events) == 0
    assert held_back(*events, said(16.0, b"@ZAWF$")) == 1


def test_a_w_that_has_left_in_its_turn_leaves_no_more_though_the_program_stood_still() -> None:
    """As flight 19655 of seed 10621; one that was killed has forgotten it."""
    heard = Step(
        5.0, "", (), (), (SURFACING,), ("emergency surfacing: W", "surge 0 heave -1: W"), "W"
    )
    before = (said(5.0, b"@ZAWF$"), heard, sent(5.0, b"@ZAWF$"), sent(6.0, b"@ZAU12$"))
    still = (Done(7.0, Act.STALL), Done(8.0, Act.RUN))
    dead = (Done(7.0, Act.KILL), Done(8.0, Act.BOOT))
    assert held_back(*before, *still, said(9.0, b"@ZAWF$")) == 0
    assert held_back(*before, *dead, said(9.0, b"@ZAWF$")) == 1


def test_that_a_w_was_to_leave_before_another_way_is_no_proof_that_it_did() -> None:
    heard = step(5.0, "emergency surfacing: W", "everything stopped: W", trigger="W")
    let_go = (said(5.0, b"@ZAWF$"), heard, sent(5.05, b"@ZAX0$"))
    assert held_back(*let_go) == 1
    assert held_back(*let_go[:2], sent(5.0, b"@ZAWF$"), let_go[2], said(6.0, b"@ZAWF$")) == 0


def test_every_frame_of_a_set_leaves_within_5_s() -> None:
    both = (sent(1.1, b"@ZAS4$"), sent(5.9, b"@ZAH-90,6$"))
    assert held_back(*STARTED, *both) == 0
    assert held_back(*STARTED, both[0], sent(6.2, b"@ZAH-90,6$")) == 1
    assert held_back(*STARTED, both[0], step(3.0, entered=MANUAL_DRIVING)) == 0
    assert held_back(*STARTED, both[0], *STOP, sent(5.0, b"@ZAX0$")) == 0


def test_a_set_that_steers_has_what_is_left_of_the_time_of_the_one_before() -> None:
    steers = [step(2.0 * i, "surge 0.5 heading 90 depth 4: a steers") for i in range(1, 9)]
    depths = [sent(2.0 * i + 0.1, b"@ZAS4$") for i in range(1, 9)]
    each = [event for pair in zip(steers, depths, strict=True) for event in pair]
    assert held_back(*STARTED, *each) > 0
    assert held_back(*STARTED, sent(1.1, b"@ZAS4$"), sent(1.2, b"@ZAH-90,6$"), *each[:2]) == 1
    other = step(4.0, "surge 0.5 heading 90 depth 4: entry of b", entered="autonomous/b")
    done = (sent(8.0, b"@ZAS4$"), sent(8.1, b"@ZAH-90,6$"))
    assert held_back(*STARTED, *each[:2], other, *done) == 0


def test_both_halves_of_an_ascent_leave() -> None:
    ascent = step(5.0, "surge 0 heave -1: the depth is 3 m, no less")
    assert held_back(ascent, sent(5.0, b"@ZAX0$"), sent(5.1, b"@ZAU12$")) == 0
    assert held_back(ascent, sent(5.0, b"@ZAX0$")) == 1
