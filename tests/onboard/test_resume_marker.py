"""The resume marker: what a restart would interrupt is durable before it happens, or as soon as may be."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from mission.engine.restart import STICK, UNANSWERED, UNSEEN
from mission.onboard.runtime.resume_marker import AGAIN_S, EVERY_S, UNNAMED, ResumeMarker
from mission.onboard.store import MemoryStore, Stored

LEG, OTHER = "autonomous/a", "autonomous/b"


class Counting(MemoryStore):
    """``full``: the disk takes nothing."""

    def __init__(self, under_way: str = "") -> None:
        super().__init__(Stored(under_way=under_way))
        self.asked: list[str] = []
        self.full = False

    def keep_under_way(self, what: str) -> None:
        self.asked.append(what)
        self._failures = {self._writes: "no space left"} if self.full else {}
        super().keep_under_way(what)


def test_another_region_is_written_at_once() -> None:
    store = Counting()
    marker = ResumeMarker(store)
    marker.follow(LEG, 1.0)
    assert store.asked == [LEG]
    assert marker.next_timer() is None
    marker.follow("", 3.0)
    marker.follow("", 4.0)
    assert store.asked == [LEG, ""]
    assert store.content.under_way == ""


def test_another_leg_is_written_by_the_timer_that_follows_at_once() -> None:
    """Its set leaves first."""
    store = Counting()
    marker = ResumeMarker(store)
    marker.follow(LEG, 1.0)
    marker.follow(OTHER, 2.0)
    assert store.asked == [LEG]
    assert marker.next_timer() == 2.0
    marker.handle_timer(2.0)
    assert store.asked == [LEG, OTHER]
    assert marker.next_timer() is None
    marker.follow(OTHER, 3.0)
    assert marker.next_timer() is None


def fly(marker: ResumeMarker, legs: int, seconds: float) -> Iterator[str]:
    """So many legs of so many seconds, each of them another, with every timer; at the end of each
    its name."""
    for i in range(legs):
        marker.follow(f"autonomous/{i}", i * seconds)
        while (due := marker.next_timer()) is not None and due < (i + 1) * seconds:
            marker.handle_timer(due)
            assert marker.next_timer() != due
        yield f"autonomous/{i}"


@pytest.mark.parametrize("seconds", [0.1, 1.0, 7.0, 29.0, 31.0, 600.0])
def test_the_writes_of_legs_are_few_however_short_the_legs_are(seconds: float) -> None:
    store = Counting()
    legs = list(fly(ResumeMarker(store), 3000, seconds))
    assert len(store.asked) <= min(len(legs), 32 + len(legs) * seconds / EVERY_S)


@pytest.mark.parametrize("seconds", [0.1, 1.0, 7.0, 29.0, 31.0, 600.0])
def test_what_is_kept_is_the_leg_that_is_active_or_no_leg_at_all(seconds: float) -> None:
    store = Counting()
    unnamed = 0
    for i, leg in enumerate(fly(ResumeMarker(store), 1200, seconds)):
        named = store.content.under_way == leg
        assert named or store.content.under_way == f"autonomous/{UNNAMED}"
        assert named or i >= 30
        unnamed += not named
    assert (unnamed > 0) is (seconds < EVERY_S)


def test_a_quiet_day_before_allows_no_more_writes() -> None:
    store = Counting()
    marker = ResumeMarker(store)
    for i in range(100):
        marker.follow(f"autonomous/{i}", 86400.0 + i)
        marker.handle_timer(86400.0 + i)
    assert len(store.asked) <= 33 + 100.0 / EVERY_S


def test_a_leg_that_follows_many_short_ones_and_lasts_is_named() -> None:
    store = Counting()
    marker = ResumeMarker(store)
    list(fly(marker, 100, 1.0))
    assert store.content.under_way == f"autonomous/{UNNAMED}"
    marker.follow(LEG, 100.0)
    due = marker.next_timer()
    assert due is not None
    assert 100.0 < due <= 100.0 + 2 * EVERY_S
    marker.handle_timer(due)
    assert store.content.under_way == LEG
    assert marker.next_timer() is None


@pytest.mark.parametrize("before", ["", LEG])
@pytest.mark.parametrize(
    "under_way", [STICK, "manual/driving", UNANSWERED, "emergency/stopped", "emergency/surfacing"]
)
def test_no_disk_stands_before_a_stop_or_the_stick(before: str, under_way: str) -> None:
    store = Counting(before)
    marker = ResumeMarker(store)
    marker.follow(under_way, 7.0)
    due = 7.0 + AGAIN_S * (before == LEG and under_way == "emergency/surfacing")  # it would surface
    assert store.asked == []
    assert marker.next_timer() == due
    marker.handle_timer(due - 0.001)
    assert store.asked == []
    marker.handle_timer(due, due - 0.2)  # the line has a word
    marker.handle_timer(due, due)
    assert store.asked == []
    marker.handle_timer(due, due + 0.5)
    assert store.asked == [under_way]
    assert marker.next_timer() is None
    marker.handle_timer(due + 1.0)
    assert store.asked == [under_way]


def test_each_state_of_an_emergency_is_written_however_often_it_changes() -> None:
    """A heavy vehicle that sinks out of each surface: a restart comes back to where it was."""
    store = Counting()
    marker = ResumeMarker(store)
    for i in range(80):
        state = "emergency/surfacing" if i % 2 else "emergency/surfaced"
        marker.follow(state, 2.0 * i)
        marker.handle_timer(2.0 * i)
        assert store.content.under_way == state


def test_that_it_may_have_sunk_is_written_at_once_and_that_it_was_seen_again_seldom() -> None:
    """A depth may come and go each second, for days: an SD card does not bear that."""
    store = Counting()
    marker = ResumeMarker(store)
    for i in range(1000):
        marker.follow("" if i % 2 else UNSEEN, float(i))
        marker.handle_timer(float(i))
        assert i % 2 or store.content.under_way == UNSEEN
    assert len(store.asked) <= 3 * (32 + 1000.0 / EVERY_S)
    assert set(store.asked) == {UNSEEN, ""}
    while (due := marker.next_timer()) is not None:
        marker.handle_timer(due)
    assert store.content.under_way == ""
    marker.follow(UNSEEN, due := 1e6)
    marker.follow(LEG, due + 1.0)
    assert store.content.under_way == LEG


def test_a_later_change_takes_the_place_of_one_that_waits() -> None:
    store = Counting()
    marker = ResumeMarker(store)
    marker.follow("emergency/stopped", 7.0)
    marker.follow("", 7.0)
    assert store.asked == [""]
    assert marker.next_timer() is None


def test_what_the_disk_did_not_take_is_tried_again_after_five_seconds_until_it_does() -> None:
    store = Counting()
    store.full = True
    marker = ResumeMarker(store)
    marker.follow(LEG, 1.0)
    for due in (6.0, 11.0):
        assert marker.next_timer() == due
        marker.handle_timer(due)
    store.full = False
    marker.handle_timer(16.0)
    assert AGAIN_S == 5.0
    assert store.asked == [LEG] * 4
    assert store.content.under_way == LEG
    assert marker.next_timer() is None


def test_a_start_that_is_not_durable_does_not_happen() -> None:
    store = Counting()
    store.full = True
    marker = ResumeMarker(store)
    assert "no space left" in marker.foresee(LEG)
    assert store.content.under_way == ""
    marker.follow("", 1.0)
    assert store.asked == [LEG]  # nothing was taken, nothing is to be taken back
    store.full = False
    assert marker.foresee(LEG) == ""
    marker.follow(LEG, 2.0)
    assert store.asked == [LEG, LEG]


def test_a_start_that_is_refused_is_taken_back() -> None:
    store = Counting()
    marker = ResumeMarker(store)
    assert marker.foresee(LEG) == ""
    marker.follow("", 1.0)
    assert store.content.under_way == ""


@pytest.mark.parametrize("kept", ["", STICK, UNANSWERED])
def test_a_start_over_what_would_only_be_stopped_is_written_anew(kept: str) -> None:
    store = Counting(kept)
    assert ResumeMarker(store).foresee(LEG) == ""
    assert store.content.under_way == LEG


@pytest.mark.parametrize("kept", [LEG, "manual/driving", "emergency/surfaced"])
def test_a_start_over_what_would_surface_anyway_needs_no_write(kept: str) -> None:
    store = Counting(kept)
    store.full = True
    assert ResumeMarker(store).foresee(OTHER) == ""
    assert store.asked == []


def test_what_an_earlier_program_left_is_lifted_when_nothing_is_under_way() -> None:
    store = Counting(LEG)
    marker = ResumeMarker(store)
    marker.follow("emergency/surfacing", 1.0)
    marker.handle_timer(1.0 + AGAIN_S)
    marker.follow("", 2.0 + AGAIN_S)
    assert store.asked == ["emergency/surfacing", ""]


def test_an_ascent_waits_for_no_write_that_is_due_already() -> None:
    """The disk was full as an interrupted mission went on: it still says stopped."""
    store = Counting("emergency/stopped")
    marker = ResumeMarker(store)
    store.full = True
    marker.follow(LEG, 11.0)
    store.full = False
    marker.follow("emergency/surfacing", 15.9)
    assert marker.next_timer() == 15.9
    marker.handle_timer(15.9)
    assert store.content.under_way == "emergency/surfacing"


@pytest.mark.parametrize("under_way", ["emergency/surfacing", OTHER])
def test_a_write_waits_while_an_ascent_or_a_set_is_halfway_out_and_comes_when_it_is_whole(
    under_way: str,
) -> None:
    store = Counting("manual/driving" if under_way != OTHER else LEG)
    marker = ResumeMarker(store)
    marker.follow(under_way, 7.0)
    for now, line_due in ((7.0, 7.3), (7.3, 7.3), (7.3, 7.6)):
        assert marker.next_timer() == now
        marker.handle_timer(now, line_due, halfway=True)
    assert store.asked == []
    assert marker.next_timer() == 7.6
    marker.handle_timer(7.6, 7.9, halfway=False)
    assert store.asked == [under_way]
    assert marker.next_timer() is None
