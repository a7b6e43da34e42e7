"""Guards on a direction: only those fly whose sector is the one that their numbers say."""

from __future__ import annotations

import math
import operator
from random import Random

import pytest

from mission.authoring.compiler.directions import direction_problems
from mission.authoring.language import draft
from mission.authoring.prepare import charted
from mission.engine.guards import Sheet
from mission.engine.readings import Scope
from mission.model import And, Comparison, Guard, Health, Or, Where
from mission.model.diagnostics import Diagnostic
from mission.model.shipped import load_vehicle

AUV = load_vehicle("auv")


def found(guard: str, name: str = "m") -> list[Diagnostic]:
    text = f"""mission m vehicle auv
home 30.2874595 120.1535765
safety radius 500 time 20min depth 12
assume current 0.5
turn: depth 3 heading 90 gear 2 until {guard} timeout 60s
up: surface until fix timeout 3min
"""
    return list(charted(draft(text, name), AUV).found)


@pytest.mark.parametrize(
    ("guard", "better"),
    [
        ("heading > 350 or heading < 10", "write and for or"),
        ("heading > 45 and heading < 315", "write or for and"),
        ("course >= 300 or course <= 20", "write and for or"),
        ("heading > 10 and heading > 300", "write a sector as heading > 350 and heading < 10"),
        ("not (heading > 350 or heading < 10)", "write and for or"),
        ("depth > 2 and (bearing < 10 or bearing > 350)", "write and for or"),
    ],
)
def test_comparisons_that_are_another_sector_than_they_say_are_refused(guard: str, better: str):
    (told,) = found(guard)
    assert told.code == "goes-round"
    assert better in told.hint


@pytest.mark.parametrize(
    "guard",
    [
        "heading > 350 and heading < 10",
        "heading > 10 or heading < 350",
        "heading > 80 and heading < 100",
        "heading < 45 or heading > 135",
        "heading > 350",
        "heading > 350 or depth > 2",
        "depth > 2 or depth < 1",
    ],
)
def test_a_sector_that_its_numbers_say_is_taken(guard: str) -> None:
    assert found(guard) == []


NOWHERE = Scope(0.0, None, None, lambda _: Health(True, "", 0.0), 0.0, 0.0, 0.0, 1, lambda: None)
PLAIN = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


def test_what_is_taken_is_for_the_engine_what_its_numbers_say() -> None:
    """Of two comparisons, by any bounds: as the scale from 0 to 360 has them, unless there they
    are true nowhere or everywhere."""
    random, taken = Random(7), 0
    for _ in range(400):
        both = tuple(
            Comparison("heading", random.choice(list(PLAIN)), math.radians(random.randrange(360)))
            for _ in range(2)
        )
        join, kind = random.choice([(all, And), (any, Or)])
        angles = [math.radians(degree + 0.5) for degree in range(360)]
        said = [join(PLAIN[c.operator](angle, c.bound) for c in both) for angle in angles]
        if any(direction_problems(kind(both), Where(1, 1))) or not any(said) or all(said):
            continue
        taken += 1
        guard = Sheet().add(Guard(kind(both)))
        assert [guard.test([angle], NOWHERE) for angle in angles] == said, both
    assert taken > 50
