"""The laws of commands that come twice (R1, R12): what is answered as done is in force."""

from __future__ import annotations

import pytest
from topside_world import BOAT, LINES, OTHER, WATER, Pi, opened

from mission.model import STOPPED
from mission.onboard.runtime.copies import AGAIN_S, LATE_S, REMEMBERED, Copies
from protocol.messages import (
    ClearMission,
    Emergency,
    MissionLine,
    NodeSwitch,
    Order,
    SetSafety,
    SetTime,
    StartMission,
)

WIDE, NARROW = SetSafety(depth=20.0), SetSafety(depth=5.0)
OPEN, CLOSED = NodeSwitch("OOOOCO"), NodeSwitch("OOOOCC")


@pytest.fixture
def pi() -> Pi:
    return Pi()


def by_modem(pi: Pi, command: object, now: float) -> bytes:
    return opened(pi.hear(command, now, WATER))  # type: ignore[arg-type]


@pytest.mark.parametrize("late", [1.0, 4.9, 22.0, LATE_S - 1.0])
@pytest.mark.parametrize("first", [BOAT, WATER])
def test_a_late_start_by_modem_starts_no_mission_that_is_over(pi: Pi, first, late: float) -> None:
    pi.hear(StartMission(), 0.0, first)
    pi.target.state = "idle/ready"  # it is over
    assert by_modem(pi, StartMission(), late) == b"@ACK_AAN$"
    assert pi.target.decided == [StartMission()]


@pytest.mark.parametrize("late", [1.0, 22.0, LATE_S - 1.0])
def test_a_late_start_is_answered_as_done_while_the_mission_runs(pi: Pi, late: float) -> None:
    pi.hear(StartMission(), 0.0, BOAT)
    assert by_modem(pi, StartMission(), late) == b"@ACK_AAA$"
    assert pi.target.decided == [StartMission()]


def test_a_late_start_that_was_refused_starts_nothing_either(pi: Pi) -> None:
    pi.target.refuses = "no fix for 5 s"
    assert by_modem(pi, StartMission(), 0.0) == b"@ACK_AAN$"
    pi.target.refuses = ""
    assert by_modem(pi, StartMission(), 22.0) == b"@ACK_AAN$"
    assert pi.hear(StartMission(), 30.0, BOAT) == [b"@ACK_AAA$"]  # by the network it is meant


def test_a_late_start_gives_a_vehicle_under_the_stick_no_mission_back(pi: Pi) -> None:
    pi.hear(StartMission(), 0.0, BOAT)
    pi.hear(b"@MMF5$", 5.0, BOAT)
    pi.target.state = "manual/waiting"
    assert by_modem(pi, StartMission(), 22.0) == b"@ACK_AAN$"


def test_a_late_limit_loosens_none_that_was_tightened_since(pi: Pi) -> None:
    pi.hear(WIDE, 0.0, BOAT)
    pi.hear(NARROW, 10.0, BOAT)
    assert by_modem(pi, WIDE, 22.0) == b"@ACK_SPN$"
    assert pi.target.store.content.limits.depth == 5.0
    assert pi.target.decided == [WIDE, NARROW]
    assert by_modem(pi, NARROW, 24.0) == b"@ACK_SPP$"  # this one is in force


def test_what_came_between_two_paths_counts_and_not_the_first_answer(pi: Pi) -> None:
    """AUTO closed, opened and closed again within 5 s: the dive that goes on is not called over."""
    for node in (b"STM32 O\n", b"BDGPS O\n", b"UACM O\n"):
        pi.topside.changed(node, 0.0)
    assert pi.hear(CLOSED, 0.0, BOAT) == [b"@ACK_NSS$"]
    assert pi.hear(OPEN, 1.0, BOAT) == [b"@ACK_NSS$"]
    assert by_modem(pi, CLOSED, 2.0) == b"@ACK_NSN$"
    assert pi.target.auto == [False, True]
    assert by_modem(pi, OPEN, 3.0) == b"@ACK_NSS$"
    assert pi.hear(CLOSED, 4.0, BOAT) == [b"@ACK_NSS$"]  # by the network it is meant


def test_the_same_switch_by_both_paths_at_once_is_done_once_and_answered_twice(pi: Pi) -> None:
    pi.topside.receive(BOAT, b"@NSOOCOCO$", 0.0, 0.0)
    before = pi.topside.outgoing(0.0)
    assert pi.hear(NodeSwitch("OOCOCO"), 0.5, WATER) == []
    assert pi.topside.outgoing(0.5) == []
    pi.topside.changed(b"BDGPS C\n", 0.6)
    sent = pi.topside.outgoing(0.6) + pi.later(0.9)
    assert [tx.data for tx in before] == [b"BDGPS C"]
    assert [tx.address for tx in sent if b"@ACK_NSS$" in tx.data] == [BOAT.address, ""]


def test_a_late_clear_drops_no_mission_that_was_sent_since(pi: Pi) -> None:
    assert pi.hear(ClearMission(), 0.0, BOAT) == [b"@ACK_ACC$"]
    pi.upload(now=10.0)
    assert by_modem(pi, ClearMission(), 22.0) == b"@ACK_ACN$"
    assert pi.target.store.content.lines == LINES


def test_a_refused_clear_may_be_said_again_by_modem(pi: Pi) -> None:
    pi.target.refuses = "an emergency, and 5 m deep"
    assert by_modem(pi, ClearMission(), 0.0) == b"@ACK_ACN$"
    pi.target.refuses = ""
    assert by_modem(pi, ClearMission(), 10.0) == b"@ACK_ACC$"


@pytest.mark.parametrize("late", [0.5, 10.0, LATE_S - 1.0])
def test_one_press_of_clear_that_comes_by_both_ways_is_no_second_wish(pi: Pi, late: float) -> None:
    """R7: said twice it is obeyed under water; whoever says it twice by the network means it."""
    pi.target.refuses, pi.target.state = "clear it at the surface", STOPPED
    assert pi.hear(ClearMission(), 0.0, BOAT) == [b"@ACK_ACN$"]
    pi.target.refuses = ""
    assert by_modem(pi, ClearMission(), late) == b"@ACK_ACN$"
    assert pi.target.decided == [ClearMission()]
    assert pi.hear(ClearMission(), late + 0.5, BOAT) == [b"@ACK_ACC$"]


def test_a_late_line_neither_drops_nor_changes_another_mission(pi: Pi) -> None:
    old = ("mission old vehicle auv", "ZAF9", "wait 90s")
    for number, line in enumerate(old[:2], 1):
        pi.hear(MissionLine(3, number, line), 0.0, WATER)
    pi.hear(MissionLine(3, 1, LINES[0]), 11.0, BOAT)
    for number, line in enumerate(old[:2], 1):
        assert by_modem(pi, MissionLine(3, number, line), 22.0 + number) == b"@ACK_AWN$"
    for number in (2, 3):
        pi.hear(MissionLine(3, number, LINES[number - 1]), 30.0, BOAT)
    assert pi.target.accepted == [LINES]
    assert by_modem(pi, MissionLine(3, 1, old[0]), 40.0) == b"@ACK_AWN$"
    assert pi.hear(StartMission(), 41.0, BOAT) == [b"@ACK_AAA$"]  # nothing is staged


def test_lines_that_are_held_are_acknowledged_however_often_they_come(pi: Pi) -> None:
    for now in (0.0, 6.0, 60.0):
        assert by_modem(pi, MissionLine(3, 1, LINES[0]), now) == b"@ACK_AWW$"
    assert by_modem(pi, MissionLine(3, 3, LINES[2]), 61.0) == b"@ACK_AWW$"
    assert by_modem(pi, MissionLine(3, 2, LINES[1]), 62.0) == b"@ACK_AWW$"
    assert by_modem(pi, MissionLine(3, 2, LINES[1]), 66.0) == b"@ACK_AWW$"
    assert pi.target.accepted == [LINES]


def test_a_refused_line_may_be_sent_again_at_once(pi: Pi) -> None:
    assert by_modem(pi, MissionLine(3, 2, LINES[1]), 0.0) == b"@ACK_AWN$"  # line 1 was lost
    assert by_modem(pi, MissionLine(3, 1, LINES[0]), 3.0) == b"@ACK_AWW$"
    assert by_modem(pi, MissionLine(3, 2, LINES[1]), 6.0) == b"@ACK_AWW$"


def test_a_late_time_sets_no_clock_back(pi: Pi) -> None:
    pi.hear(SetTime("2025-01-11T16:56:06"), 0.0, BOAT)
    pi.hear(SetTime("2025-01-11T16:57:06"), 60.0, BOAT)
    assert by_modem(pi, SetTime("2025-01-11T16:56:06"), 61.0) == b"@ACK_STN$"
    assert pi.target.clock == "2025-01-11T16:57:06"


def test_a_late_power_switch_undoes_no_newer_one(pi: Pi) -> None:
    old, new = b"@RSOOOOOOO$", b"@RSOOOOOOC$"
    pi.hear(old, 0.0, BOAT)
    pi.hear(new, 10.0, BOAT)
    pi.hear(old, 22.0, WATER)
    assert pi.target.relayed == [old, new]
    pi.hear(new, 24.0, WATER)
    assert pi.target.relayed == [old, new, new]  # asked for its answer again, which changes nothing


@pytest.mark.parametrize("late", [0.5, 22.0])
def test_an_increment_by_both_paths_is_passed_on_once(pi: Pi, late: float) -> None:
    pi.hear(b"@DA1,-2$", 0.0, BOAT)
    pi.hear(b"@DA1,-2$", late, WATER)
    assert pi.target.relayed == [b"@DA1,-2$"]
    pi.hear(b"@DA1,-2$", late + 0.1, BOAT)  # a connection says it as often as it is meant
    assert pi.target.relayed == [b"@DA1,-2$"] * 2


def test_by_the_network_alone_everything_is_meant(pi: Pi) -> None:
    """A mission that was over at once, a limit to and fro: one connection keeps its order."""
    for now in (0.0, 1.0, 2.0):
        pi.target.state = "idle/ready"
        assert pi.hear(StartMission(), now, BOAT) == [b"@ACK_AAA$"]
    for now in (3.0, 3.1):
        assert pi.hear(WIDE, now, BOAT) == [b"@ACK_SPP$"]
        assert pi.hear(NARROW, now, BOAT) == [b"@ACK_SPP$"]
    assert pi.target.store.content.limits.depth == 5.0
    assert len(pi.target.decided) == 7


def test_by_the_network_a_copy_of_the_modems_is_refused_and_obeyed_when_said_again(pi: Pi) -> None:
    pi.hear(StartMission(), 0.0, WATER)
    pi.target.state = "idle/ready"
    for now in (22.0, 23.0, 24.0):  # the three tries of one that was late
        assert pi.hear(StartMission(), now, BOAT) == [b"@ACK_AAN$"]
    assert pi.hear(StartMission(), 22.0 + AGAIN_S, BOAT) == [b"@ACK_AAA$"]


def test_after_two_minutes_it_is_a_new_wish(pi: Pi) -> None:
    pi.hear(StartMission(), 0.0, WATER)
    pi.target.state = "idle/ready"
    assert by_modem(pi, StartMission(), LATE_S - 0.1) == b"@ACK_AAN$"
    assert by_modem(pi, StartMission(), LATE_S) == b"@ACK_AAA$"


def test_a_copy_that_is_refused_says_how_to_mean_it(pi: Pi) -> None:
    pi.hear(StartMission(), 0.0, BOAT)
    pi.target.state = "idle/ready"
    by_modem(pi, StartMission(), 22.0)
    assert b"say it by the network; or in 98 s" in pi.hear(b"@AQ$", 23.0)[0]


def test_a_copy_takes_the_command_from_nobody(pi: Pi) -> None:
    pi.hear(StartMission(), 0.0, BOAT)
    by_modem(pi, StartMission(), 1.0)
    assert pi.topside.commander.peer == BOAT


@pytest.mark.parametrize("order", list(Order))
def test_x_and_w_are_obeyed_however_late_and_often_they_come(pi: Pi, order: Order) -> None:
    for now in (0.0, 0.1, 22.0, 60.0):
        pi.hear(Emergency(order), now, WATER)
        pi.hear(Emergency(order), now + 0.01, BOAT)
    assert pi.target.decided == [Emergency(order)] * 8


def test_an_increment_by_the_network_behind_the_modems_is_doubted_once(pi: Pi) -> None:
    step = b"@DA1,-2$"
    pi.hear(step, 100.0, WATER)
    pi.hear(step, 104.9, BOAT)  # by both paths
    assert pi.target.relayed == [step]
    pi.hear(b"@AQ$", 105.0, BOAT)
    assert b"say it again in 5 s" not in pi.hear(b"@AQ$", 105.0, BOAT)[0]
    pi.hear(step, 105.0, BOAT)
    assert pi.target.relayed == [step]
    assert b"say it again in 5 s" in pi.hear(b"@AQ$", 106.0, BOAT)[0]
    for now in (111.0, 111.1, 111.2):
        pi.hear(step, now, BOAT)
    assert pi.target.relayed == [step] * 4


def test_only_another_switch_of_power_undoes_one(pi: Pi) -> None:
    switch = b"@RSOOOOOOO$"
    for now, other in ((0.0, switch), (1.0, b"@RI$"), (2.0, b"@DS1,5$"), (3.0, b"@NI$")):
        pi.hear(other, now, BOAT)
    pi.hear(switch, 22.0, WATER)
    assert pi.target.relayed == [switch, b"@RI$", b"@DS1,5$", switch]


def test_a_refused_switch_of_power_undoes_none(pi: Pi) -> None:
    old, new = b"@RSOOOOOOO$", b"@RSOOOOOOC$"
    pi.hear(old, 0.0, BOAT)
    pi.hear(new, 1.0, OTHER)  # who does not command
    pi.hear(old, 22.0, WATER)
    assert pi.target.relayed == [old, old]


def test_a_mission_may_be_sent_by_the_network_that_was_sent_by_modem_before(pi: Pi) -> None:
    other = ("mission other vehicle auv", "ZAF1", "wait 1s")
    for number, line in enumerate(LINES, 1):
        assert by_modem(pi, MissionLine(3, number, line), 100.0 + number) == b"@ACK_AWW$"
    assert pi.upload(other, 120.0) == [b"@ACK_AWW$"] * 3
    assert pi.upload(LINES, 121.0) == [b"@ACK_AWW$"] * 3
    assert pi.target.accepted == [LINES, other, LINES]


@pytest.mark.parametrize("begin", [100.0, 1e6])
def test_two_minutes_are_counted_from_when_it_was_said(pi: Pi, begin: float) -> None:
    pi.hear(WIDE, begin, BOAT)
    pi.hear(NARROW, begin + 1.0, BOAT)
    pi.hear(b"@DU$", begin + 119.0, BOAT)
    assert by_modem(pi, WIDE, begin + 119.0) == b"@ACK_SPN$"
    pi.topside.disconnected(BOAT, 0.0)
    assert by_modem(pi, WIDE, begin + LATE_S) == b"@ACK_SPP$"


def test_what_was_said_anew_is_remembered_anew(pi: Pi) -> None:
    for now in (0.0, 100.0):
        pi.hear(WIDE, now, BOAT)
        pi.hear(NARROW, now + 1.0, BOAT)
    assert by_modem(pi, WIDE, 150.0) == b"@ACK_SPN$"


def test_more_than_is_remembered_drops_the_oldest_alone() -> None:
    copies = Copies(lambda command: False)
    for depth in range(REMEMBERED + 1):
        copies.note(BOAT, SetSafety(depth=float(depth)), True, 0.0)
    assert copies.judge(WATER, SetSafety(depth=0.0), 1.0) is None
    assert copies.judge(WATER, SetSafety(depth=1.0), 1.0) is not None
