"""The manual says what the code does: generated parts, and the examples in it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mission.authoring.language import MissionErrors, digest, parse
from mission.authoring.language.manual import PARTS, refreshed

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "mission-language.md").read_text("utf-8")
BLOCKS = re.findall(r"```[a-z]*\n(.*?)```", PAGE, re.DOTALL)


def test_the_generated_parts_are_as_the_code_has_them() -> None:
    assert refreshed(PAGE) == PAGE, (
        "run python -m mission.authoring.language.manual docs/mission-language.md"
    )
    for part in PARTS.values():
        assert part() in PAGE


def test_the_first_mission_is_the_same_in_both_texts() -> None:
    lines, yaml = (b for b in BLOCKS if "hello" in b)
    assert parse(lines) == parse(yaml)
    assert digest(parse(lines)) == digest(parse(yaml))


def test_the_guards_of_the_manual_are_guards() -> None:
    guards = next(b for b in BLOCKS if b.startswith("depth >= 9.5"))
    for guard in guards.splitlines():
        parse(f"a: gear 6 until {guard} timeout 60\nhome_run: goto home timeout 60\n")


def test_the_error_of_the_manual_is_the_one_that_comes() -> None:
    shown = next(b for b in BLOCKS if b.startswith("survey.mission:7"))
    text = "\n" * 6 + shown.splitlines()[1].strip()
    with pytest.raises(MissionErrors) as caught:
        parse(text, "survey.mission")
    assert str(caught.value).startswith(shown.rstrip())
