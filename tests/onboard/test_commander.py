"""R12: one commands, while it is heard; and who is owed an answer of the vehicle's."""

from __future__ import annotations

import math

from mission.onboard.runtime.command_target import MODEM, Peer
from mission.onboard.runtime.commander import COMMANDER_SILENT_S, Commander
from mission.onboard.runtime.pending_answers import PendingAnswers

A, B = Peer("topside", "a"), Peer("topside", "b")
UNDER_WATER = Peer(MODEM, "")


def commanded_by(peer: Peer, *, reads: bool = True) -> Commander:
    one = Commander()
    one.hear(peer, 100.0)
    if reads:
        one.reads_reports(peer)
    assert one.hand_over(peer) is None
    return one


def test_where_nobody_commands_anybody_may() -> None:
    one = Commander()
    assert one.why_not(A, 0.0, 0.0) == ""
    assert one.peer is None
    assert one.heard_at == -math.inf


def test_whoever_commands_may_go_on_and_others_only_after_ten_seconds_of_silence() -> None:
    one = commanded_by(A)
    assert one.why_not(A, 1e6, 1e6) == ""
    assert COMMANDER_SILENT_S == 10.0
    why = one.why_not(B, 110.0, 110.0)
    assert "topside a" in why
    assert one.why_not(B, 110.001, 110.001) == ""
    one.hear(A, 105.0)
    assert one.why_not(B, 110.001, 110.001) != ""


def test_who_is_not_heard_keeps_nobody_from_commanding() -> None:
    one = Commander()
    one.hand_over(A)
    assert one.why_not(B, 1.0, 1.0) == ""
    one.hear(A, 1.0)
    assert one.why_not(B, 1.0, 1.0) != ""


def test_what_was_said_before_an_x_or_w_commands_nothing_behind_it() -> None:
    one = commanded_by(A)
    one.ordered_at = 100.0
    assert one.why_not(A, 103.0, 99.9) == "an X or W, said behind it, has overtaken it"
    assert one.why_not(A, 103.0, 100.0) == ""


def test_the_last_of_all_operators_is_remembered_and_who_spoke_is_known() -> None:
    one = Commander()
    assert not one.knows(A)
    one.hear(A, 3.0)
    one.hear(B, 4.0)
    assert one.heard_at == 4.0
    assert one.knows(A)
    one.forget(A)
    assert not one.knows(A)
    assert one.knows(B)


def test_a_commander_that_closes_commands_no_more_and_another_that_closes_changes_nothing() -> None:
    one = commanded_by(A)
    one.hear(B, 100.0)
    one.forget(B)
    assert one.peer == A
    one.forget(A)
    assert one.peer is None
    assert one.why_not(B, 100.0, 100.0) == ""


def test_a_loser_is_told_if_it_reads_reports_and_is_not_under_water() -> None:
    assert commanded_by(A).hand_over(B) == A
    assert commanded_by(A).hand_over(A) is None
    assert commanded_by(A, reads=False).hand_over(B) is None
    assert commanded_by(UNDER_WATER).hand_over(B) is None
    after = commanded_by(A)
    after.hand_over(B)
    assert after.peer == B


def test_a_connection_that_comes_again_has_not_asked_for_a_report_yet() -> None:
    one = commanded_by(A)
    one.forget(A)
    one.hear(A, 101.0)
    one.hand_over(A)
    assert one.hand_over(B) is None


# --- awaited ------------------------------------------------------------------------------


def test_an_answer_reaches_whoever_waits_for_it_once_and_nobody_else() -> None:
    owed = PendingAnswers()
    owed.add(A, "STOP", 10.0, 2.0)
    owed.add(B, "STOP", 10.0, 2.0)
    owed.add(B, "SURFACE", 10.0, 2.0)
    assert owed.answered("I", 10.5, final=True) == []
    assert owed.answered("STOP", 10.5, final=True) == [A, B]
    assert owed.answered("STOP", 10.5, final=True) == []
    assert owed.answered("SURFACE", 10.5, final=True) == [B]


def test_after_an_answer_that_is_not_the_last_they_go_on_waiting() -> None:
    owed = PendingAnswers()
    owed.add(A, "STOP", 10.0, 2.0)
    assert owed.answered("STOP", 10.5, final=False) == [A]
    assert owed.answered("STOP", 10.6, final=True) == [A]


def test_an_answer_that_comes_too_late_is_owed_to_nobody() -> None:
    owed = PendingAnswers()
    owed.add(A, "STOP", 10.0, 2.0)
    assert owed.answered("STOP", 11.999, final=False) == [A]
    assert owed.answered("STOP", 12.0, final=False) == []


def test_asked_twice_it_is_one_answer_and_the_time_begins_anew() -> None:
    owed = PendingAnswers()
    owed.add(A, "STOP", 10.0, 2.0)
    owed.add(A, "SURFACE", 10.0, 2.0)
    owed.add(B, "STOP", 10.0, 2.0)
    owed.add(A, "STOP", 11.5, 2.0)
    assert owed.answered("SURFACE", 11.5, final=True) == [A]
    assert owed.answered("STOP", 11.6, final=False) == [B, A]
    assert owed.answered("STOP", 13.4, final=True) == [A]


def test_whoever_has_gone_is_owed_nothing() -> None:
    owed = PendingAnswers()
    owed.add(A, "STOP", 10.0, 2.0)
    owed.add(B, "STOP", 10.0, 2.0)
    owed.forget(A)
    assert owed.answered("STOP", 10.5, final=True) == [B]
