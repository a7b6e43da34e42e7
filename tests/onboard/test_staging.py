"""The laws of R3: no line lost, doubled or mixed."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.onboard.runtime.staging import FORGOTTEN_AFTER_S, Held, OutOfPlace, Staging, Whole
from protocol.messages import MissionLine

LINES = ("mission a vehicle auv sum 0123456789abcdef", "ZAF6", "wait 10s", "ZAF0")


def line(number: int, lines: tuple[str, ...] = LINES) -> MissionLine:
    return MissionLine(len(lines), number, lines[number - 1])


def offer_all(staging: Staging, numbers: list[int], now: float = 0.0) -> list[object]:
    return [staging.offer(line(n), (), now) for n in numbers]


def test_the_set_is_whole_with_its_last_missing_line() -> None:
    assert offer_all(Staging(), [1, 4, 2, 3]) == [Held(), Held(), Held(), Whole(LINES)]


def test_a_set_begins_with_line_1() -> None:
    answers = offer_all(Staging(), [2, 1, 2])
    assert isinstance(answers[0], OutOfPlace)
    assert "line 1 first" in answers[0].why
    assert answers[1:] == [Held(), Held()]


@given(st.randoms(use_true_random=False), st.integers(1, 30))
@settings(max_examples=40)
def test_any_order_and_any_repetition_gives_the_lines_once_and_in_order(
    rnd: random.Random, count: int
) -> None:
    lines = tuple(f"line {i} sum 1" for i in range(count))
    numbers = [*range(1, count + 1), *(rnd.randint(1, count) for _ in range(5))]
    rnd.shuffle(numbers)
    staging = Staging()
    answers = [staging.offer(line(n, lines), (), 0.0) for n in [1, *numbers]]
    assert answers[-1] == Whole(lines)
    assert all(isinstance(answer, Held | Whole) for answer in answers)


def test_a_different_line_1_drops_what_was_staged() -> None:
    staging = Staging()
    offer_all(staging, [1, 2, 3])
    other = ("mission b vehicle auv", "ZAF6", "wait 10s", "ZAF0")
    assert staging.offer(line(1, other), (), 0.0) == Held()
    assert (staging.have, staging.missing) == (1, "2-4")


def test_a_line_1_without_a_sum_begins_anew_however_it_reads() -> None:
    """An edited script that begins like the one before, which was refused or not finished: none of
    its lines may stand in for one of the new script that was lost, or is still to come."""
    plain = ("mission a vehicle auv", *LINES[1:])
    staging = Staging()
    for number in (1, 2, 3, 4, 1):
        staging.offer(line(number, plain), (), 0.0)
    assert (staging.have, staging.missing) == (1, "2-4")
    assert staging.offer(MissionLine(4, 3, "wait 20s"), (), 1.0) == Held()
    assert staging.offer(line(4, plain), (), 2.0) == Held()
    assert staging.missing == "2"


def test_a_line_1_with_its_sum_goes_on_with_its_set() -> None:
    staging = Staging()
    assert offer_all(staging, [1, 2, 1, 4, 3])[-1] == Whole(LINES)


def test_another_total_drops_what_was_staged() -> None:
    staging = Staging()
    offer_all(staging, [1, 2, 3])
    assert isinstance(staging.offer(MissionLine(5, 4, "ZAF0"), (), 0.0), OutOfPlace)
    assert staging.total == 0


def test_ten_minutes_without_a_line_drop_the_set() -> None:
    staging = Staging()
    offer_all(staging, [1, 2])
    assert staging.incomplete((), FORGOTTEN_AFTER_S - 1)
    assert not staging.incomplete((), FORGOTTEN_AFTER_S)
    assert isinstance(staging.offer(line(3), (), FORGOTTEN_AFTER_S), OutOfPlace)


def test_a_whole_set_stays_whole_and_takes_a_mended_line() -> None:
    staging = Staging()
    offer_all(staging, [1, 2, 3, 4])
    assert staging.offer(line(4), (), 1.0) == Whole(LINES)
    mended = staging.offer(MissionLine(4, 2, "ZAF5"), (), 2.0)
    assert mended == Whole((LINES[0], "ZAF5", *LINES[2:]))
    assert not staging.incomplete((), 2.0)


def test_a_late_duplicate_of_a_finished_upload_has_no_effect() -> None:
    staging = Staging()
    assert staging.offer(line(4), LINES, 0.0) == Held()
    assert staging.total == 0
    assert staging.offer(line(1), LINES, 0.0) == Held()
    assert not staging.incomplete(LINES, 0.0)


def test_an_upload_that_repeats_the_stored_mission_but_for_a_lost_line_is_incomplete() -> None:
    """The line that was edited may be the lost one, which only a sum could tell."""
    plain = ("mission a vehicle auv", *LINES[1:])
    staging = Staging()
    for number in (1, 2, 4):
        assert staging.offer(line(number, plain), plain, 0.0) == Held()
    assert staging.incomplete(plain, 0.0)


def test_what_differs_from_the_stored_mission_is_a_new_upload() -> None:
    staging = Staging()
    staging.offer(line(1), LINES, 0.0)
    staging.offer(MissionLine(4, 2, "ZAF9"), LINES, 0.0)
    assert staging.incomplete(LINES, 0.0)


@pytest.mark.parametrize(("total", "current"), [(10000, 1), (4, 0), (4, 5), (0, 0)])
def test_counters_that_count_nothing_are_out_of_place(total: int, current: int) -> None:
    staging = Staging()
    offer_all(staging, [1, 2])
    assert isinstance(staging.offer(MissionLine(total, current, "ZAF6"), (), 0.0), OutOfPlace)
    assert staging.have == 2


@pytest.mark.parametrize(
    ("held", "missing"),
    [
        ([1], "2-9"),
        ([1, 2, 6, 7, 8], "3-5.9"),
        (list(range(1, 10)), ""),
        ([1, 3, 5, 7, 9], "2.4.6.8"),
    ],
)
def test_missing_lines_are_written_as_ranges(held: list[int], missing: str) -> None:
    staging = Staging()
    for number in held:
        staging.offer(MissionLine(9, number, "ZAF6"), (), 0.0)
    assert staging.missing == missing


def test_a_long_list_of_missing_lines_fits_its_frame() -> None:
    staging = Staging()
    for number in range(1, 9999, 2):
        staging.offer(MissionLine(9999, number, "ZAF6"), (), 0.0)
    assert 100 < len(staging.missing) <= 120
    assert staging.missing.startswith("2.4.6.")
