"""Laws of what grows how: where a line bends, and that the page has every sweep and every size."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))

from bench_growth import (
    BENT,
    NOISE,
    PAGE,
    SWEEPS,
    Cost,
    Point,
    Sweep,
    bend,
    checked,
    marginals,
    mission,
    of_legs,
    of_lines,
    of_rounds,
    of_states,
    table,
)
from growth_picture import filled, points_of

from mission.authoring.language import load, script
from protocol.topside_frames import MOST_LINES

SIZES = (1, 3, 10, 30, 100)


def line(*times: float) -> list[Point]:
    return [Point(size, Cost(time, 50.0)) for size, time in zip(SIZES, times, strict=True)]


def time_of(cost: Cost) -> float:
    return cost.time


@pytest.mark.parametrize("each", [1.0, 7.0])
def test_a_straight_line_bends_nowhere_whatever_it_begins_with(each: float) -> None:
    points = line(*(5.0 + each * size for size in SIZES))
    assert marginals(points, 10, time_of) == pytest.approx([10.0 * each] * 4)
    assert bend(points, time_of, 0.1) is None


def test_a_line_bends_where_from_there_on_one_more_costs_half_as_much_again() -> None:
    times = [float(size) for size in SIZES[:4]]
    assert bend(line(*times, 30.0 + 70.0 * 0.99 * BENT), time_of, 0.1) is None
    assert bend(line(*times, 30.0 + 70.0 * 1.2 * BENT), time_of, 0.1) == 3
    assert bend(line(1.0, 3.0, 30.0, 30.0, 100.0), time_of, 0.1) is None  # dear, and cheap again


def test_what_grows_by_less_than_the_noise_bends_nothing() -> None:
    assert bend(line(1.0, 1.0, 1.001, 1.05, 1.09), time_of, 0.1) is None
    assert bend(line(1.0, 0.9, 1.0, 1.1, 1.2), time_of, 0.2) is None
    assert bend(line(1.0, 1.0, 1.0, 1.0, 1.3), time_of, 0.2) is None
    assert bend(line(1.0, 1.0, 1.0, 1.0, 9.0), time_of, 0.2) == 10


def test_a_row_has_its_figures_and_what_more_of_it_costs() -> None:
    sweep = Sweep("", "boats", 10, SIZES, lambda n: Cost(n, n), served=True)
    told = table(sweep, [Point(n, Cost(2.0 * n, 50.0, 4.0)) for n in SIZES])
    assert "| 30 | 60 | 50 | 20 | 0.00 | 4.0 |\n" in told
    assert told.endswith("\nTime: no bend up to 100 boats; memory: no bend up to 100 boats.\n")


def test_a_table_is_put_between_its_marks_and_nowhere_else() -> None:
    page = "a\n<!-- begin legs -->\nold\n<!-- end legs -->\nz\n"
    put = filled(page, {"legs": "new\n"})
    assert put == page.replace("old", "new")
    assert filled(put, {"legs": "new\n"}) == put
    assert filled(put, {}) == put


@pytest.mark.parametrize("name", SWEEPS)
def test_the_page_has_every_sweep_with_every_size_of_it(name: str) -> None:
    points = points_of(PAGE.read_text("utf-8"))[name]
    assert [point.size for point in points] == list(SWEEPS[name].sizes)


def test_what_a_table_tells_is_read_from_the_page_again() -> None:
    points = [Point(n, Cost(2.5 * n, 50.0 + n)) for n in (*SIZES, 9000)]
    told = table(SWEEPS["legs"], points)
    page = filled("<!-- begin legs -->\n<!-- end legs -->", {"legs": told})
    assert points_of(page) == {"legs": points}


@pytest.mark.proof
def test_a_process_tells_its_time_and_its_memory() -> None:
    cost = checked(of_legs(3))
    assert cost.time > NOISE[0]
    assert cost.memory > NOISE[1]


@pytest.mark.proof
@pytest.mark.parametrize(
    ("text", "why"),
    [
        (of_rounds(2500), r"exit 1\n(?s:.*)more than 5000 legs are flown"),
        (of_legs(5001), r"exit 1\n(?s:.*)more than 5000 legs are flown"),
        (of_lines(10_000), r"exit 2\n(?s:.*)more than 9,999 statements"),
        (of_states(7497), r"exit 2\n(?s:.*)more than 9,999 statements"),
    ],
    ids=["rounds", "legs", "lines", "states"],
)
def test_a_mission_beyond_the_last_row_is_refused(text: str, why: str) -> None:
    with pytest.raises(RuntimeError, match=why):
        checked(text)


@pytest.mark.parametrize("count", SWEEPS["lines"].sizes)
def test_a_mission_of_so_many_lines_is_uploaded_in_as_many(count: int) -> None:
    with mission(of_lines(count)) as (path, *_):
        assert len(script(load(Path(path)))) == count
    assert count <= MOST_LINES


@pytest.mark.parametrize("count", [3, 300, 7494])
def test_states_are_legs_and_groups(count: int) -> None:
    text = of_states(count)
    assert text.count("heading") + text.count("group") == count
