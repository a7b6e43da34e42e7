"""Two frames never become one burst on the line, however late the first one left."""

from __future__ import annotations

import itertools

import pytest

from links import baud_of
from mission.onboard.serve.pace import Pace

GAP, BAUD = 0.02, 9600.0
LENGTH_S = 6 * 10 / BAUD  # of @ZAX0$ on the line


def test_a_frame_that_follows_at_once_waits_for_the_end_of_the_one_before_and_the_gap() -> None:
    pace = Pace(GAP, BAUD)
    assert pace.leaving(b"@ZAF5$", 10.0) == [b"@ZAF5$"]
    assert pace.leaving(b"@MMF5$", 10.001) == []
    due = pace.next_event()
    assert due == pytest.approx(10.0 + LENGTH_S + GAP)
    assert pace.due(10.02) == []
    assert pace.due(due) == [b"@MMF5$"]
    assert pace.next_event() is None


def test_each_that_waits_has_its_own_gap_and_all_keep_their_order() -> None:
    pace = Pace(GAP, BAUD)
    left = [(0.0, frame) for frame in pace.leaving(b"@ZAF1$", 0.0)]
    for number in (b"@ZAF2$", b"@ZAF3$", b"@ZAF4$"):
        assert pace.leaving(number, 0.0) == []
    while (due := pace.next_event()) is not None:
        left += [(due, frame) for frame in pace.due(due)]
    assert [frame for _, frame in left] == [b"@ZAF1$", b"@ZAF2$", b"@ZAF3$", b"@ZAF4$"]
    for (before, _), (after, _) in itertools.pairwise(left):
        assert after - before == pytest.approx(LENGTH_S + GAP)


@pytest.mark.parametrize("order", [b"@ZAX0$", b"@ZAWF$"])
def test_an_order_drops_what_waits(order: bytes) -> None:
    pace = Pace(GAP, BAUD)
    pace.leaving(b"@ZAF5$", 0.0)
    pace.leaving(b"@ZAS9$", 0.001)
    assert pace.leaving(order, 0.002) == []
    assert pace.due(1.0) == [order]


def test_a_line_that_is_gone_keeps_nothing_for_its_return() -> None:
    pace = Pace(GAP, BAUD)
    pace.leaving(b"@ZAF5$", 0.0)
    pace.leaving(b"@ZAS9$", 0.001)
    pace.clear()
    assert pace.due(100.0) == []


def test_where_no_gap_is_needed_everything_leaves_at_once() -> None:
    pace = Pace(0.0, BAUD)
    assert pace.leaving(b"one", 0.0) == [b"one"]
    assert pace.leaving(b"two", 0.0) == [b"two"]


def test_the_line_is_as_fast_as_its_link_is_opened() -> None:
    assert baud_of("serial:///dev/ttyUSB0?baud=4800", 1.0) == 4800.0
    assert baud_of("serial:///dev/ttyUSB0", 1.0) == 9600.0
    assert baud_of("tcp://127.0.0.1:9", 9600.0) == 9600.0
    assert baud_of("no link", 9600.0) == 9600.0
