"""Whatever a mission says, both texts say it to the last bit, and so does the script."""

from __future__ import annotations

import pytest
from generated_missions import missions
from hypothesis import HealthCheck, given, settings

from mission.authoring.language import (
    digest,
    layout,
    parse,
    parse_script,
    script,
    to_lines,
    to_yaml,
)
from mission.model import Mission

SOME = settings(
    max_examples=15,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@pytest.mark.proof
@SOME
@given(missions())
def test_a_mission_survives_its_texts_its_script_and_its_layout(mission: Mission) -> None:
    texts = {"lines": to_lines(mission), "yaml": to_yaml(mission)}
    for form, text in texts.items():
        read = parse(text)
        assert read == mission
        assert digest(read) == digest(mission)
        assert (to_lines if form == "lines" else to_yaml)(read) == text
        tidy = layout.formatted(text)
        assert parse(tidy) == mission
        assert layout.formatted(tidy) == tidy


@pytest.mark.proof
@SOME
@given(missions())
def test_a_mission_survives_its_script(mission: Mission) -> None:
    lines = script(mission)
    assert all(len(line) <= 200 and line.isascii() and line.isprintable() for line in lines)
    assert not any(set("@$") & set(line) for line in lines)
    assert parse_script(lines) == mission
