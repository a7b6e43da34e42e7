"""Two frames never become one burst on the line, however late the first one left."""

from __future__ import annotations

import itertools

import pytest

from links import baud_of
from mission.onboard.serve.tx_spacer import TxSpacer

GAP, BAUD = 0.02, 9600.0
LENGTH_S = 6 * 10 / BAUD  # of @ZAX0$ on the line


def test_a_frame_that_follows_at_once_waits_for_the_end_of_the_one_before_and_the_gap() -> None:
    spacer = TxSpacer(GAP, BAUD)
    assert spacer.leaving(b"@ZAF5$", 10.0) == [b"@ZAF5$"]
    assert spacer.leaving(b"@MMF5$", 10.001) == []
    due = spacer.next_event()
    assert due == pytest.approx(10.0 + LENGTH_S + GAP)
    assert spacer.due(10.02) == []
    assert spacer.due(due) == [b"@MMF5$"]
    assert spacer.next_event() is None


def test_each_that_waits_has_its_own_gap_and_all_keep_their_order() -> None:
    spacer = TxSpacer(GAP, BAUD)
    left = [(0.0, frame) for frame in spacer.leaving(b"@ZAF1$", 0.0)]
    for number in (b"@ZAF2$", b"@ZAF3$", b"@ZAF4$"):
        assert spacer.leaving(number, 0.0) == []
    while (due := spacer.next_event()) is not None:
        left += [(due, frame) for frame in spacer.due(due)]
    assert [frame for _, frame in left] == [b"@ZAF1$", b"@ZAF2$", b"@ZAF3$", b"@ZAF4$"]
    for (before, _), (after, _) in itertools.pairwise(left):
        assert after - before == pytest.approx(LENGTH_S + GAP)


@pytest.mark.parametrize("order", [b"@ZAX0$", b"@ZAWF$"])
def test_an_order_drops_what_waits(order: bytes) -> None:
    spacer = TxSpacer(GAP, BAUD)
    spacer.leaving(b"@ZAF5$", 0.0)
    spacer.leaving(b"@ZAS9$", 0.001)
    assert spacer.leaving(order, 0.002) == []
    assert spacer.due(1.0) == [order]


def test_a_line_that_is_gone_keeps_nothing_for_its_return() -> None:
    spacer = TxSpacer(GAP, BAUD)
    spacer.leaving(b"@ZAF5$", 0.0)
    spacer.leaving(b"@ZAS9$", 0.001)
    spacer.clear()
    assert spacer.due(100.0) == []


def test_where_no_gap_is_needed_everything_leaves_at_once() -> None:
    spacer = TxSpacer(0.0, BAUD)
    assert spacer.leaving(b"one", 0.0) == [b"one"]
    assert spacer.leaving(b"two", 0.0) == [b"two"]


def test_the_line_is_as_fast_as_its_link_is_opened() -> None:
    assert baud_of("serial:///dev/ttyUSB0?baud=4800", 1.0) == 4800.0
    assert baud_of("serial:///dev/ttyUSB0", 115200.0) == 115200.0  # that of its role
    assert baud_of("tcp://127.0.0.1:9", 9600.0) == 9600.0
    assert baud_of("no link", 9600.0) == 9600.0
