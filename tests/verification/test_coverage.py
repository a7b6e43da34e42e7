"""What rows have seen: the area, the swath, truth beside estimate; and the shipped survey at sea."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

from links.simulated.settings import parse_settings
from mission.authoring.prepare import prepare
from mission.cli import main
from mission.legs import LEGS, Rows
from mission.legs.rows import corners
from mission.verification.simulation.coverage import coverage_of, seen
from mission.verification.simulation.flight import fly
from mission.verification.simulation.legtable import table

AREA = Rows(None, math.radians(30.0), 100.0, 20.0, 4, 1, 5.0, swath=20.0)
START = (50.0, -10.0)


def flown(kind: Rows, aside: float = 0.0) -> list[Any]:
    """Points a metre apart along the corners, ``aside`` m to starboard of the first row."""
    c, s = math.cos(kind.bearing), math.sin(kind.bearing)
    points = [(n - aside * s, e + aside * c) for n, e in corners(kind, START)]
    track = []
    for (a, b), (n, e) in pairwise(points):
        steps = max(1, round(math.dist((a, b), (n, e))))
        track += [(a + (n - a) * i / steps, b + (e - b) * i / steps) for i in range(steps + 1)]
    return [SimpleNamespace(north=n, east=e) for n, e in track]


def share(kind: Rows, track: list[Any]) -> float:
    pattern = LEGS[Rows].pattern(kind, (START,), START)
    return seen(pattern, [track], lambda point: (point.north, point.east))


def test_rows_flown_as_they_are_written_see_all_of_their_area() -> None:
    assert share(AREA, flown(AREA)) > 0.98


@pytest.mark.parametrize("side", [1, -1])
def test_a_swath_of_half_the_spacing_sees_half(side: int) -> None:
    narrow = replace(AREA, swath=10.0, side=side)
    whole = 3 * 20.0 + 10.0
    assert share(narrow, flown(narrow)) == pytest.approx(4 * 10.0 / whole, abs=0.02)


@pytest.mark.parametrize("aside", [5.0, -5.0, 20.0])
def test_what_lies_aside_of_the_rows_is_not_seen(aside: float) -> None:
    assert share(AREA, flown(AREA, aside)) == pytest.approx(1.0 - abs(aside) / 80.0, abs=0.02)


def test_a_row_that_is_not_flown_is_missed() -> None:
    three = replace(AREA, count=3)
    assert share(AREA, flown(three)) == pytest.approx(0.75, abs=0.02)
    rest = replace(AREA, count=1, skip=3.0)
    assert share(rest, flown(AREA)) > 0.98


@pytest.mark.parametrize("swath", [20.0, 7.0])
def test_a_track_sees_the_cells_that_lie_beside_a_step_along_the_rows(swath: float) -> None:
    """By a look at each cell alone, beside the one at strips of cells."""
    kind = replace(AREA, swath=swath)
    pattern = LEGS[Rows].pattern(kind, (START,), START)
    track = flown(kind, 3.0)[::7]
    steps = list(pairwise(pattern.framed((p.north, p.east)) for p in track))
    (bottom, top), (left, right) = pattern.along, pattern.across
    cell = max(max(top - bottom, right - left) / 200, min(swath / 20, 1.0))
    rows, columns = int((top - bottom) / cell), int((right - left) / cell)
    seen_cells = 0
    for i in range(rows):
        for j in range(columns):
            x, y = bottom + (i + 0.5) * cell, left + (j + 0.5) * cell
            seen_cells += any(
                abs(c - a) > abs(d - b)
                and min(a, c) <= x < max(a, c)
                and abs(y - b - (d - b) * (x - a) / (c - a)) <= swath / 2.0
                for (a, b), (c, d) in steps
            )
    assert share(kind, track) == pytest.approx(seen_cells / (rows * columns), abs=1e-3)


def test_turns_see_nothing() -> None:
    turn = [SimpleNamespace(north=START[0] + n, east=START[1] + 1.0 + 0.1 * n) for n in range(30)]
    across = replace(AREA, bearing=math.pi / 2)
    assert share(across, turn) == 0.0


def coverages(name: str, current: str, seed: int, parameters: dict[str, str]) -> Any:
    ready = prepare(name, None, parameters)
    flight = fly(ready.mission, ready.vehicle, seed=seed, settings=parse_settings([current]))
    assert flight.outcome == "completed"
    (found,) = coverage_of(flight, ready.mission)
    return found, table(flight, ready.chart)


@pytest.mark.proof
def test_the_lawnmower_sees_nine_tenths_of_its_area_in_the_current_that_it_assumes() -> None:
    found = []
    for seed, direction in enumerate((30.0, 120.0, 210.0, 300.0)):
        one, told = coverages("lawnmower", f"current=0.2@{direction}", seed, {})
        found.append(one.true)
        assert f"mow/rows: {one.true:.0%} of its area, {one.estimated:.0%} by the estimate" in told
    assert min(found) >= 0.9


@pytest.mark.proof
def test_without_fixes_the_estimate_believes_what_is_not_so(tmp_path: Any) -> None:
    text = prepare("lawnmower").text.replace("resurface: 1,", "")
    text = text.replace(
        "      achieve: {coverage: 90 %, position: 60 m}\n", ""
    )  # it would be refused
    file = tmp_path / "lawn.yaml"
    file.write_text(text.replace("  - learn: {surface: true, until: fix, timeout: 5 min}\n", ""))
    one, _ = coverages(str(file), "current=0.2@30", 0, {})
    assert one.estimated > 0.9
    assert one.true < 0.6


@pytest.mark.proof
def test_the_coverage_is_in_the_json_of_a_flight() -> None:
    run = CliRunner().invoke(main, ["simulate", "lawnmower", "--json"])
    (found,) = json.loads(run.stdout)["coverage"]
    assert found["leg"] == "mow/rows"
    assert 0.9 < found["true"] <= 1.0
