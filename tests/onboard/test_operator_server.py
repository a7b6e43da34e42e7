"""The laws of the Pi's side of the operator protocol, over its real bytes."""

from __future__ import annotations

import math

import pytest
from topside_world import BOAT, LINES, OTHER, WATER, Pi, opened

from mission.model import Outcome, Result, Tx
from mission.onboard.runtime.command_target import REFUSAL_CHARACTERS, Peer, one_line
from mission.onboard.runtime.commander import COMMANDER_SILENT_S
from mission.onboard.runtime.copies import REMEMBERED
from mission.onboard.runtime.staging import FORGOTTEN_AFTER_S
from protocol.messages import (
    Ack,
    ClearMission,
    Command,
    Emergency,
    Fix,
    Manual,
    MissionLine,
    NodeSwitch,
    Order,
    SetSafety,
    SetTime,
    StartMission,
    Status,
    StoreQuery,
    Telemetry,
)
from protocol.topside import ConsoleCodec, encode


@pytest.fixture
def pi() -> Pi:
    return Pi()


# --- R2, R3, R4 ---------------------------------------------------------------------------


def test_every_line_is_acknowledged_and_the_last_one_after_it_is_stored(pi: Pi) -> None:
    assert pi.upload() == [b"@ACK_AWW$"] * 3
    assert pi.target.accepted == [LINES]


def test_a_refused_mission_is_answered_n_and_the_earlier_one_stays(pi: Pi) -> None:
    pi.upload()
    pi.target.refuses_mission = "2:1: ZAF130: gear and seconds run together, write ZAF1 for 30s"
    bad = ("mission b vehicle auv", "ZAF130", "wait 1s")
    assert pi.upload(bad) == [b"@ACK_AWW$", b"@ACK_AWW$", b"@ACK_AWN$"]
    assert pi.target.store.content.lines == LINES
    (report,) = ConsoleCodec().receive(pi.hear(StoreQuery())[0], 0.0)
    assert "gear and seconds run together" in report.refusal  # type: ignore[union-attr]
    assert pi.hear(MissionLine(3, 3, "wait 1s")) == [b"@ACK_AWN$"]  # the retry of a lost N


@pytest.mark.parametrize("state", ["autonomous/a", "manual/driving", "emergency/stopped"])
def test_lines_are_refused_outside_idle(pi: Pi, state: str) -> None:
    pi.target.state = state
    assert pi.hear(MissionLine(3, 1, LINES[0])) == [b"@ACK_AWN$"]
    pi.target.state = "idle/empty"
    assert pi.hear(MissionLine(3, 2, LINES[1])) == [b"@ACK_AWN$"]  # nothing was staged


@pytest.mark.parametrize("state", ["autonomous/line2", "manual/driving"])
def test_a_line_that_is_refused_under_way_says_to_stop_and_to_clear(pi: Pi, state: str) -> None:
    pi.target.state = state
    pi.hear(MissionLine(3, 1, LINES[0]))
    told = pi.hear(StoreQuery())[0].decode()
    assert f"this is {state}: stop the vehicle (X) and clear it" in told


def test_a_line_that_is_refused_in_an_emergency_says_to_clear(pi: Pi) -> None:
    pi.target.state = "emergency/stopped"
    pi.hear(MissionLine(3, 1, LINES[0]))
    told = pi.hear(StoreQuery())[0].decode()
    assert "this is emergency/stopped: clear it at the surface; then upload" in told


def test_start_is_refused_while_lines_are_missing(pi: Pi) -> None:
    pi.hear(MissionLine(3, 1, LINES[0]))
    assert pi.hear(StartMission()) == [b"@ACK_AAN$"]
    assert pi.target.decided == []
    assert pi.hear(StartMission(), FORGOTTEN_AFTER_S) == [b"@ACK_AAA$"]


def test_the_store_is_reported_by_state_and_digest(pi: Pi) -> None:
    def report(now: float = 0.0) -> bytes:
        return pi.hear(StoreQuery(), now)[0]

    assert report().startswith(b"@AR,empty,0,0,,,")
    pi.hear(MissionLine(3, 1, LINES[0]))
    assert report().startswith(b"@AR,staging,3,1,2-3,,")
    pi.upload()
    assert report().startswith(b"@AR,ready,3,3,,0123456789abcdef,")
    pi.target.state = "autonomous/line2"
    assert report().startswith(b"@AR,running,3,3,,0123456789abcdef,")


def test_a_full_disk_is_answered_n(pi: Pi) -> None:
    full = Pi(failures={0: "no space left on device"})
    assert full.upload()[-1] == b"@ACK_AWN$"
    assert b"no space left" in full.hear(StoreQuery())[0]
    full = Pi(failures={0: "no space left on device"})
    assert full.hear(SetSafety(radius=100.0)) == [b"@ACK_SPN$"]
    assert full.target.decided == []


def test_clear_drops_what_was_staged(pi: Pi) -> None:
    pi.hear(MissionLine(3, 1, LINES[0]))
    assert pi.hear(ClearMission()) == [b"@ACK_ACC$"]
    assert pi.hear(MissionLine(3, 2, LINES[1])) == [b"@ACK_AWN$"]


def test_no_is_silent_for_a_topside_that_cannot_bear_it() -> None:
    pi = Pi(answer_no=False)
    pi.target.refuses = "an emergency"
    assert pi.hear(StartMission()) == []


def test_an_old_refusal_is_told_with_its_age_and_ends_with_what_is_accepted(pi: Pi) -> None:
    pi.target.refuses = "no mission is stored"
    pi.hear(StartMission())
    assert b",AA: no mission is stored,$" in pi.hear(StoreQuery())[0]
    assert b",AA: no mission is stored; 10 min ago,$" in pi.hear(StoreQuery(), 600.0)[0]
    pi.target.refuses = ""
    pi.hear(StartMission(), 600.0)
    assert b",,$" in pi.hear(StoreQuery(), 600.0)[0]


def test_a_refusal_in_the_report_has_no_comma_and_at_most_200_characters(pi: Pi) -> None:
    pi.target.refuses = "no, never: " + "\u00e9" * 3 + "x" * 300
    pi.hear(StartMission())
    answer = pi.hear(StoreQuery())[0]
    assert answer.count(b",") == 7
    (report,) = ConsoleCodec().receive(answer, 0.0)
    assert report.refusal.startswith("AA: no; never: x")  # type: ignore[union-attr]
    assert len(report.refusal) == 200  # type: ignore[union-attr]


# --- R5, R10 ----------------------------------------------------------------------------------


def test_an_empty_item_of_the_safety_set_keeps_its_value(pi: Pi) -> None:
    assert pi.hear(SetSafety(100.0, 600.0, 20.0, 11.0)) == [b"@ACK_SPP$"]
    assert pi.hear(SetSafety(depth=5.0)) == [b"@ACK_SPP$"]
    assert pi.target.store.content.limits == SetSafety(100.0, 600.0, 5.0, 11.0)
    assert pi.target.decided[-1] == SetSafety(100.0, 600.0, 5.0, 11.0)


def test_time_is_set_in_idle_and_not_over_the_modem(pi: Pi) -> None:
    command = SetTime("2025-01-11T16:56:06")
    assert opened(pi.hear(command, 0.0, WATER)) == b"@ACK_STN$"
    pi.target.state = "autonomous/a"
    assert pi.hear(command, 1.0) == [b"@ACK_STN$"]
    assert pi.target.clock == ""
    pi.target.state = "idle/ready"
    assert pi.hear(command, 2.0) == [b"@ACK_STT$"]
    assert pi.target.clock == "2025-01-11T16:56:06"


# --- R6, R7, R14 --------------------------------------------------------------------------------


def test_manual_is_relayed_unchanged_when_the_engine_agrees(pi: Pi) -> None:
    assert pi.hear(b"@MT1,-10$") == []
    assert pi.target.relayed == [b"@MT1,-10$"]
    pi.target.refuses = "an emergency: let go of the stick for 2 s"
    pi.hear(b"@MMF3$")
    assert pi.target.relayed == [b"@MT1,-10$"]


def test_every_stick_is_heard_of_whoever_holds_it_and_by_whatever_path(pi: Pi) -> None:
    """R6: a stick that is refused may still be held when nobody commands any more."""
    pi.hear(StartMission(), 0.0, BOAT)
    pi.hear(b"@MMF3$", 1.0, OTHER)
    pi.hear(b"@MMF3$", 2.0, WATER)
    assert pi.target.sticks == [1.0, 2.0]
    pi.target.refuses = "an emergency: let go of the stick for 2 s"
    pi.hear(b"@MMF3$", 3.0, BOAT)
    assert pi.target.sticks == [1.0, 2.0, 3.0]


BEYOND = (b"@MMD13$", b"@MT9,5$", b"@MDA2,99$", b"@MRX1$", b"@MS1.5,0$", b"xx@MMD13$", b"@MP9$")


@pytest.mark.parametrize("peer", [BOAT, OTHER, WATER])
@pytest.mark.parametrize("word", BEYOND)
def test_a_stick_beyond_its_range_is_heard_of_and_moves_nothing(
    pi: Pi, word: bytes, peer: Peer
) -> None:
    """R6, G4: its word is refused whole, by no answer, and it is held all the same."""
    assert pi.hear(word, 1.0, peer) == []
    assert pi.later(1.5) == []
    assert (pi.target.decided, pi.target.relayed) == ([], [])
    (heard,) = pi.target.sticks
    assert 1.0 <= heard <= 1.5
    assert pi.hear(StoreQuery(), 1.6)[0].startswith(b"@AR,empty,0,0,,,manual: ")


def test_a_stick_held_beyond_its_range_for_long_is_heard_of_until_it_is_eased(pi: Pi) -> None:
    """25 times a second there is no pause in which its faults would be told one by one."""
    pi.hear(b"@MMF3$", 0.0, BOAT)
    for i in range(500):
        pi.hear(b"@MMD13$", 1.0 + 0.04 * i, OTHER)
    pi.hear(b"@MMD12$", 21.0, OTHER)
    assert pi.target.sticks[0] == 21.0
    assert pi.target.decided[-1] == Manual("MM", b"@MMD12$")


def test_manual_never_goes_over_the_modem(pi: Pi) -> None:
    pi.hear(b"@MMF3$", 0.0, WATER)
    assert (pi.target.decided, pi.target.relayed) == ([], [])


def test_rudder_and_power_are_relayed_and_do_not_reach_the_engine(pi: Pi) -> None:
    for frame in (b"@DA2,-2$", b"@RSOOOOOOO$"):
        pi.hear(frame)
    assert pi.target.relayed == [b"@DA2,-2$", b"@RSOOOOOOO$"]
    assert pi.target.decided == []


def test_the_answer_to_a_relay_goes_back_to_whoever_asked(pi: Pi) -> None:
    pi.hear(b"@RI$", 0.0, BOAT)
    pi.topside.relayed_answer(Ack(0.1, "R", "I", 0x24), 0.1)  # a mask that is the tail byte
    assert pi.topside.outgoing(0.1) == [
        Tx(0.1, "topside", b"@ACK_RI\x24$", "answer of the STM32", "boat:1")
    ]
    pi.topside.relayed_answer(Ack(0.2, "R", "I", 0x24), 0.2)
    assert pi.topside.outgoing(0.2) == []


@pytest.mark.parametrize("peer", [BOAT, OTHER, WATER])
@pytest.mark.parametrize("order", list(Order))
def test_stop_and_surface_pass_from_every_connection_every_time(
    pi: Pi, peer: Peer, order: Order
) -> None:
    pi.hear(StartMission(), 0.0, BOAT)
    for i in range(3):
        pi.hear(Emergency(order), 0.1 * i, peer)
    assert pi.target.decided[1:] == [Emergency(order)] * 3


def test_who_stopped_hears_what_became_of_it(pi: Pi) -> None:
    pi.hear(Emergency(Order.STOP), 0.0, OTHER)
    for result in (Result.LOST, Result.ACCEPTED, Result.ACCEPTED):
        pi.topside.order_outcome(Outcome(result, b"@ZAX0$", Order.STOP), 1.0)
    sent = pi.topside.outgoing(1.0)
    assert [tx.data for tx in sent] == [b"@ACK_ZXN$", b"@ACK_ZXY$"]
    assert {tx.address for tx in sent} == {OTHER.address}


# --- R12 ------------------------------------------------------------------------------------------


def test_others_read_while_somebody_commands(pi: Pi) -> None:
    assert pi.hear(StartMission(), 0.0, BOAT) == [b"@ACK_AAA$"]
    assert pi.hear(ClearMission(), 1.0, OTHER) == [b"@ACK_ACN$"]
    pi.hear(b"@MMF3$", 1.0, OTHER)
    assert pi.target.decided == [StartMission()]
    assert pi.target.relayed == []
    assert pi.hear(StoreQuery(), 1.0, OTHER)[0].startswith(b"@AR,")
    assert pi.hear(b"@DU$", 1.0, OTHER)[0].startswith(b"@VS")
    assert pi.hear(b"@NI$", 1.0, OTHER) == [b"@ACK_NI\x2f$"]


def test_a_closed_or_silent_connection_commands_no_more(pi: Pi) -> None:
    pi.hear(StartMission(), 0.0, BOAT)
    pi.hear(b"@DU$", 5.0, BOAT)  # reading is not silence
    assert pi.hear(ClearMission(), 5.0 + COMMANDER_SILENT_S, OTHER) == [b"@ACK_ACN$"]
    assert pi.hear(ClearMission(), 5.1 + COMMANDER_SILENT_S, OTHER) == [b"@ACK_ACC$"]
    assert pi.hear(ClearMission(), 15.2, BOAT) == [b"@ACK_ACN$"]
    pi.topside.disconnected(OTHER, 0.0)
    assert pi.hear(ClearMission(), 15.3, BOAT) == [b"@ACK_ACC$"]


def test_who_stops_the_vehicle_commands_it(pi: Pi) -> None:
    pi.hear(StartMission(), 0.0, BOAT)
    pi.hear(Emergency(Order.STOP), 1.0, OTHER)
    assert pi.hear(ClearMission(), 2.0, OTHER) == [b"@ACK_ACC$"]
    assert pi.hear(ClearMission(), 2.0, BOAT) == [b"@ACK_ACN$"]


def test_what_was_said_before_an_order_is_refused_behind_it(pi: Pi) -> None:
    pi.hear(Emergency(Order.STOP), 0.6, OTHER)
    pi.topside.disconnected(OTHER, 0.0)
    pi.target.decided.clear()
    assert pi.hear(ClearMission(), 4.0, BOAT, said=0.5) == [b"@ACK_ACN$"]
    assert pi.hear(b"@MMF5$", 4.0, BOAT, said=0.5) == []
    assert (pi.target.decided, pi.target.relayed, pi.target.sticks) == ([], [], [4.0])
    assert pi.hear(Emergency(Order.SURFACE), 4.0, BOAT, said=0.5) == []
    assert pi.target.decided == [Emergency(Order.SURFACE)]
    assert pi.hear(ClearMission(), 4.0, BOAT, said=0.55) == [b"@ACK_ACN$"]
    assert pi.hear(ClearMission(), 4.0, BOAT, said=0.6) == [b"@ACK_ACC$"]


def test_who_loses_the_command_and_reads_reports_is_told_by_one(pi: Pi) -> None:
    pi.hear(StoreQuery(), 0.0, BOAT)
    pi.hear(StartMission(), 0.0, BOAT)
    pi.topside.receive(OTHER, encode(Emergency(Order.STOP)), 1.0, 1.0)
    out = [tx for tx in pi.topside.outgoing(1.0) if tx.address == BOAT.address]
    assert [tx.data.rpartition(b",")[0].rpartition(b",")[2] for tx in out] == [
        b"topside other:2 has taken the command"
    ]
    pi.topside.receive(OTHER, encode(Emergency(Order.SURFACE)), 1.1, 1.1)
    assert pi.topside.outgoing(1.1) == [], "once"


def test_a_plain_topside_never_sees_a_report_it_did_not_ask_for(pi: Pi) -> None:
    pi.hear(StartMission(), 0.0, BOAT)
    pi.topside.receive(OTHER, encode(Emergency(Order.STOP)), 1.0, 1.0)
    assert pi.topside.outgoing(1.0) == []


def test_under_water_nobody_is_told_unasked_that_he_lost_the_command(pi: Pi) -> None:
    pi.hear(StoreQuery(), 0.0, WATER)
    pi.hear(StartMission(), 20.0, WATER)
    pi.topside.receive(BOAT, encode(Emergency(Order.STOP)), 40.0, 40.0)
    assert pi.topside.outgoing(40.0) == []
    assert pi.later(60.0) == []


def test_the_same_command_over_both_paths_is_executed_once(pi: Pi) -> None:
    assert pi.hear(StartMission(), 0.0, BOAT) == [b"@ACK_AAA$"]
    assert opened(pi.hear(StartMission(), 4.5, WATER)) == b"@ACK_AAA$"
    assert pi.target.decided == [StartMission()]


def test_an_answer_leaves_on_the_path_of_its_request(pi: Pi) -> None:
    assert opened(pi.hear(b"@DU$@NI$", 0.0, WATER)).startswith(b"@VS2025")
    assert pi.topside.outgoing(0.3) == []


def test_a_status_nobody_asked_for_goes_out_on_every_path(pi: Pi) -> None:
    pi.topside.report_unasked(0.0, "surfaced")
    sent = pi.topside.outgoing(0.0) + pi.later(10.0)
    assert sorted((tx.link, tx.address) for tx in sent) == [
        ("modem", ""),
        ("topside", "boat:1"),
        ("topside", "other:2"),
    ]


# --- R13 ------------------------------------------------------------------------------------------


def test_a_switch_is_answered_when_all_nodes_have_changed(pi: Pi) -> None:
    assert pi.hear(NodeSwitch("OOCOOO")) == []
    pi.topside.changed(b"BDGPS C\n", 0.5)
    assert pi.topside.outgoing(0.5) == []
    pi.topside.changed(b"CAMERA O\n", 1.0)
    assert [tx.data for tx in pi.topside.outgoing(1.0)] == [b"@ACK_NSS$"]
    assert pi.hear(b"@NI$", 2.0) == [b"@ACK_NI\x3b$"]


def test_what_the_processes_are_asked_for_goes_to_them(pi: Pi) -> None:
    pi.topside.receive(BOAT, b"@NSOOCOOO$", 0.0, 0.0)
    sent = [(tx.link, tx.data) for tx in pi.topside.outgoing(0.0)]
    assert sent == [("nodes", b"BDGPS C"), ("nodes", b"CAMERA O")]


def test_a_switch_that_does_not_come_about_is_answered_n_after_5_s(pi: Pi) -> None:
    pi.hear(NodeSwitch("OOCOCO"))
    assert pi.topside.next_timer() == 5.0
    (refusal,) = pi.later(5.0)
    assert refusal.data == b"@ACK_NSN$"
    assert pi.topside.next_timer() is None
    (why,) = pi.hear(b"@AQ$", 6.0)
    assert b"not changed within 5 s: BDGPS;" in why


def test_a_retry_of_a_switch_is_answered_once(pi: Pi) -> None:
    pi.hear(NodeSwitch("OOCOCO"))
    assert pi.hear(NodeSwitch("OOCOCO"), 1.0) == []
    pi.topside.changed(b"BDGPS C\n", 1.5)
    assert [tx.data for tx in pi.topside.outgoing(1.5)] == [b"@ACK_NSS$"]


def test_a_connection_that_closes_before_its_switch_is_done_does_not_command(pi: Pi) -> None:
    pi.hear(NodeSwitch("OOOOOO"))
    pi.topside.disconnected(BOAT, 0.0)
    pi.topside.changed(b"CAMERA O\n", 3.5)
    assert pi.topside.commander.peer is None
    assert pi.hear(SetSafety(radius=50.0), 3.6, OTHER) == [b"@ACK_SPP$"]


def test_of_those_who_ask_for_one_switch_the_first_who_is_still_there_commands(pi: Pi) -> None:
    pi.hear(NodeSwitch("OOOOOO"))
    pi.hear(NodeSwitch("OOOOOO"), 1.0, OTHER)
    pi.topside.disconnected(BOAT, 0.0)
    pi.topside.changed(b"CAMERA O\n", 3.5)
    assert [tx.data for tx in pi.topside.outgoing(3.5)] == [b"@ACK_NSS$"]
    assert pi.topside.commander.peer == OTHER


def test_the_pi_does_not_close_itself(pi: Pi) -> None:
    assert pi.hear(NodeSwitch("COOOCO")) == [b"@ACK_NSS$"]
    assert pi.hear(b"@NI$") == [b"@ACK_NI\x2f$"]


def test_auto_reaches_the_engine_when_it_changes(pi: Pi) -> None:
    pi.hear(NodeSwitch("OOOOCO"))
    pi.hear(NodeSwitch("OOOOCC"), 1.0)
    pi.hear(NodeSwitch("OOOOCC"), 2.0)
    assert pi.target.auto == [False]


def test_the_stm32_stays_open_until_the_vehicle_is_idle(pi: Pi) -> None:
    pi.target.state = "autonomous/a"
    assert pi.hear(NodeSwitch("OCOOCO")) == [b"@ACK_NSN$"]


def requests(pi: Pi, now: float) -> list[bytes]:
    """What processes are asked for."""
    return [tx.data for tx in pi.topside.outgoing(now) if tx.link == "nodes"]


BOARD_CLOSED = NodeSwitch("OCOOCO")


@pytest.mark.parametrize("word", [StartMission(), Manual("MMF", b"@MMF5$")])
@pytest.mark.parametrize("is_done", [False, True])
def test_nothing_that_moves_is_taken_while_the_stm32_is_closed_or_about_to_be(
    pi: Pi, word: Command, is_done: bool
) -> None:
    pi.hear(b"@AQ$")
    pi.hear(BOARD_CLOSED)
    if is_done:
        pi.topside.changed(b"STM32 C\n", 0.5)
        pi.topside.outgoing(0.5)
    (told,) = pi.hear(word, 1.0)
    assert told == b"@ACK_AAN$" or b"node STM32 is closed" in told
    assert (pi.target.decided, pi.target.relayed) == ([], [])
    if isinstance(word, Manual):
        assert pi.target.sticks == [1.0]
    pi.topside.changed(b"STM32 C\n", 2.0)
    pi.hear(NodeSwitch("OOOOCO"), 3.0)
    pi.topside.changed(b"STM32 O\n", 4.0)
    pi.hear(word, 5.0)
    assert len(pi.target.decided) == 1


def test_a_stm32_that_is_needed_for_what_is_under_way_stays_open_in_idle_too(pi: Pi) -> None:
    pi.target.under_way = "a stop without its acknowledgement"
    assert pi.hear(BOARD_CLOSED) == [b"@ACK_NSN$"]
    (why,) = pi.hear(b"@AQ$", 1.0)
    assert b"the STM32 is needed: a stop without its acknowledgement" in why


@pytest.mark.parametrize("order", [b"@ZAX0$", b"@ZAWF$"])
def test_an_x_or_w_opens_the_stm32(pi: Pi, order: bytes) -> None:
    pi.hear(BOARD_CLOSED)
    pi.topside.changed(b"STM32 C\n", 0.5)
    pi.topside.outgoing(0.5)
    pi.topside.receive(OTHER, order, 1.0, 1.0)
    assert requests(pi, 1.0) == [b"STM32 O"]
    pi.topside.changed(b"STM32 O\n", 1.5)
    pi.topside.receive(OTHER, order, 2.0, 2.0)
    assert requests(pi, 2.0) == []


def test_an_x_gives_up_a_switch_that_would_close_the_stm32(pi: Pi) -> None:
    pi.topside.receive(BOAT, encode(BOARD_CLOSED), 0.0, 0.0)
    assert requests(pi, 0.0) == [b"STM32 C"]
    pi.topside.receive(OTHER, b"@ZAX0$", 0.1, 0.1)
    sent = [(tx.link, tx.data) for tx in pi.topside.outgoing(0.1)]
    assert sent == [("nodes", b"STM32 O"), ("topside", b"@ACK_NSN$")]
    for letter in (b"C", b"O"):
        pi.topside.changed(b"STM32 %b\n" % letter, 0.2)
    assert pi.later(6.0) == []
    assert pi.hear(b"@NI$", 6.0) == [b"@ACK_NI\x2f$"]


def test_an_x_opens_the_stm32_behind_an_ns_that_took_its_closing_back(pi: Pi) -> None:
    """What was asked of its process still comes, in turn: closed, and open."""
    pi.topside.receive(BOAT, encode(BOARD_CLOSED), 0.0, 0.0)
    pi.topside.receive(BOAT, encode(NodeSwitch("OOOOCO")), 0.0, 0.0)
    assert requests(pi, 0.0) == [b"STM32 C", b"STM32 O"]
    pi.topside.receive(BOAT, encode(BOARD_CLOSED), 0.1, 0.1)
    pi.topside.changed(b"STM32 C\nSTM32 O\n", 0.1)
    pi.topside.receive(OTHER, b"@ZAX0$", 0.2, 0.2)
    assert requests(pi, 0.2) == [b"STM32 C", b"STM32 O"]


def test_nobody_commands_by_a_switch_that_was_asked_for_before_an_x(pi: Pi) -> None:
    pi.hear(NodeSwitch("OOOOOO"))
    pi.hear(b"@ZAX0$", 0.0, OTHER)
    pi.topside.changed(b"CAMERA O\n", 1.0)
    assert [tx.data for tx in pi.topside.outgoing(1.0)] == [b"@ACK_NSS$"]
    assert pi.topside.commander.peer == OTHER


def test_auto_opens_when_all_that_was_asked_for_has_changed_and_not_by_a_refused_switch(
    pi: Pi,
) -> None:
    pi.hear(NodeSwitch("OOOOCC"))
    assert pi.target.auto == [False]
    pi.hear(NodeSwitch("OOOOOO"), 1.0)
    assert [tx.data for tx in pi.later(6.0)] == [b"@ACK_NSN$"]
    assert pi.target.auto == [False]
    pi.hear(NodeSwitch("OOOOOO"), 7.0)
    pi.topside.changed(b"CAMERA O\n", 8.0)
    assert pi.target.auto == [False, True]


@pytest.mark.parametrize(("state", "asked"), [("autonomous/a", [b"UACM O"]), ("idle/ready", [])])
def test_out_of_idle_the_modem_is_opened_again_when_the_last_boat_goes(
    pi: Pi, state: str, asked: list[bytes]
) -> None:
    pi.topside.disconnected(OTHER, 0.0)
    pi.hear(NodeSwitch("OOOCCO"))
    pi.topside.changed(b"UACM C\n", 0.5)
    pi.topside.disconnected(WATER, 0.5)
    pi.target.state = state
    assert requests(pi, 0.5) == []
    pi.topside.disconnected(BOAT, 1.0)
    assert requests(pi, 1.0) == asked


def test_the_modem_stays_open_while_it_is_the_only_live_path(pi: Pi) -> None:
    for peer in (BOAT, OTHER):
        pi.topside.disconnected(peer, 0.0)
    assert opened(pi.hear(NodeSwitch("OOOCCO"), 0.0, WATER)) == b"@ACK_NSN$"


# --- bad input --------------------------------------------------------------------------------------


def test_garbage_is_told_and_costs_no_good_frame(pi: Pi) -> None:
    assert pi.hear(b"\x00@@AQ\xff@NI$@SP,1,2$") == [b"@ACK_NI\x2f$"]
    pi.topside.handle_timer(1.0)
    faults = pi.topside.faults()
    assert faults
    assert {peer for peer, _ in faults} == {BOAT}


@pytest.mark.parametrize(
    ("frame", "refusal"),
    [
        (b"@ST,2025/13/01 00:00:00,$", b"@ACK_STN$"),
        (b"@ST,0001/01/01 00:00:00,$", b"@ACK_STN$"),
        (b"@ST,9999/12/31 23:59:59,$", b"@ACK_STN$"),
        (b"@NSXOOOOO$", b"@ACK_NSN$"),
        (b"@AW\x02\x00\x03\x00ZAF6$", b"@ACK_AWN$"),
        (b"@AO,lamp,x,$", b"@ACK_AON$"),
        (b"@AO,lamp,1e1,$", b"@ACK_AON$"),
        (b"@AO,4,4,$", b"@ACK_AON$"),
        (b"@AO,lamp,,$", b"@ACK_AON$"),
        (b"@ST,,$", b"@ACK_STN$"),
        (b"@NS$", b"@ACK_NSN$"),
    ],
)
@pytest.mark.parametrize("peer", [BOAT, WATER])
def test_a_command_with_a_value_out_of_range_is_refused_whole(
    pi: Pi, frame: bytes, refusal: bytes, peer: Peer
) -> None:
    answers = pi.hear(b"@DA1,2$" * 100 + frame + b"@NI$", 0.0, peer)
    assert (opened(answers) if peer is WATER else b"".join(answers)) == refusal + b"@ACK_NI\x2f$"
    assert pi.topside.faults()
    assert pi.target.decided == []


def test_a_refused_command_that_is_alone_in_its_content_is_answered_too(pi: Pi) -> None:
    """G3: with the content it is at its end, however soon that came behind its begin."""
    assert opened(pi.hear(b"@NSXOOOOO$", 0.0, WATER)) == b"@ACK_NSN$"


def test_an_empty_item_of_a_safety_set_is_legal(pi: Pi) -> None:
    assert pi.hear(b"@SP,,5,,10,$") == [b"@ACK_SPP$"]


def test_a_safety_set_with_the_wrong_count_is_not_answered(pi: Pi) -> None:
    assert pi.hear(b"@SP,1,2$@NI$") == [b"@ACK_NI\x2f$"]


@pytest.mark.proof
def test_a_flood_of_commands_is_remembered_in_bounds(pi: Pi) -> None:
    for i in range(REMEMBERED + 2000):
        pi.hear(SetSafety(radius=float(i + 1)), i * 1e-4)
    assert len(pi.topside.copies.said) <= REMEMBERED


def test_the_store_given_to_topside_is_read_not_copied(pi: Pi) -> None:
    pi.target.store.keep_lines(LINES)
    assert pi.hear(MissionLine(3, 2, LINES[1])) == [b"@ACK_AWW$"]
    assert pi.hear(Manual("MMF", b"@MMF0$")) == []


@pytest.mark.parametrize("value", [1e30, -1e30, 3.4e38, math.inf, math.nan, 1e9, -0.05])
def test_an_absurd_reading_never_keeps_the_status_from_leaving(value: float) -> None:
    angle = value if math.isfinite(value) else None
    telemetry = Telemetry(
        1.0, value, value, angle, angle, angle, value, (value,) * 9, (value,) * 7, (value, value)
    )
    fix = Fix(1.0, 0.5, 2.0, 1.0, speed=value, course=angle, elevation=value)
    frame = encode(Status("2025-01-19T23:26:25", fix, telemetry))
    assert frame.startswith(b"@VS2025-01-19-23:26:25,114.5915590,28.6478898,")
    assert len(frame) <= 400


def test_a_reason_reads_well_although_its_signs_cannot_travel() -> None:
    assert one_line("AA: an emergency: clear it (@AC), or take\nthe stick \u00e9") == (
        "AA: an emergency: clear it (AC); or take the stick"
    )
    assert not set(one_line("".join(map(chr, range(300))))) & set(",@$")
    assert len(one_line("x" * 999)) == REFUSAL_CHARACTERS
