"""Both texts say one Mission: they read alike, write alike, and have the same digest."""

from __future__ import annotations

from pathlib import Path

import pytest

from mission.authoring.language import (
    MissionErrors,
    digest,
    load,
    parse,
    parse_script,
    script,
    to_lines,
    to_yaml,
)

MISSIONS = Path(__file__).resolve().parents[3] / "missions"
SHIPPED = sorted(p for p in MISSIONS.iterdir() if p.suffix in (".yaml", ".mission"))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.name)
def test_a_shipped_mission_reads_back_from_every_text_made_of_it(path: Path) -> None:
    mission = load(path)
    for text in (to_lines(mission), to_yaml(mission), "\n".join(script(mission))):
        assert parse(text) == mission
    assert digest(parse(to_yaml(mission))) == digest(mission)
    assert to_lines(parse(to_lines(mission))) == to_lines(mission)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.name)
def test_a_shipped_mission_says_on_top_what_it_is_for(path: Path) -> None:
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("# ")


def test_the_two_texts_of_the_harbour_survey_are_one_mission() -> None:
    lines, yaml = (load(MISSIONS / f"harbour-survey.{kind}") for kind in ("mission", "yaml"))
    assert lines == yaml
    assert digest(lines) == digest(yaml)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.name)
def test_every_line_of_a_script_can_travel(path: Path) -> None:
    for line in script(load(path)):
        assert 1 <= len(line.encode("ascii")) <= 200
        assert line.isprintable()
        assert not set("@$") & set(line)


def test_a_script_is_believed_only_with_the_sum_of_its_lines() -> None:
    lines = script(load(MISSIONS / "harbour-survey.yaml"))
    assert parse_script(lines) == load(MISSIONS / "harbour-survey.yaml")
    changed = [line.replace("depth 10", "depth 90") for line in lines]
    assert changed != lines
    with pytest.raises(MissionErrors, match="the sum does not fit"):
        parse_script(changed)
