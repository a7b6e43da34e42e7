"""Whatever a mission says, both texts say it to the last bit, and so does the script."""

from __future__ import annotations

import re
from importlib import resources

import pytest
from generated_missions import missions
from hypothesis import HealthCheck, given, settings

from mission.authoring.language import (
    digest,
    elsewhere,
    layout,
    parse,
    parse_script,
    script,
    to_lines,
    to_yaml,
)
from mission.authoring.language.vocabulary import vocabulary
from mission.model import Mission
from mission.model.diagnostics import MissionErrors

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


# --- names ----------------------------------------------------------------------------------------

GRAMMAR = resources.files("mission.authoring.language").joinpath("grammar.lark").read_text()
WORDS = sorted(
    {row["word"] for row in vocabulary()}
    | elsewhere.CONTROL
    | set(re.findall(r"/(?:\(\?:)?([a-z]+)(?=\\b)", GRAMMAR))
    | {"ZAF6", "true", "null", "no", "e5", "nan", "deadbeef", "line3"}
)
LEG = "depth: 4 m, heading: 0, gear: 4, for: 10 s"
TEXTS = {  # YAML, lines
    "leg": (
        '  - "{0}": {{{1}}}\n  - a_1: {{for: 5, until: depth > 5 -> {0}}}\n',
        "{0}: {2}\na_1: for 5 until depth > 5 -> {0}\n",
    ),
    "group": ('  - "{0}": {{legs: [a_1: {{{1}}}]}}\n', "group {0}:\na_1: {2}\nend\n"),
    "rounds": (
        '  - "{0}": {{repeat: 3, legs: [a_1: {{{1}}}]}}\n',
        "repeat 3 {0}:\na_1: {2}\nend\n",
    ),
}


def read_or_refused(text: str) -> Mission | str:
    """The code of what is wrong first."""
    try:
        return parse(text)
    except MissionErrors as errors:
        return errors.diagnostics[0].code


@pytest.mark.parametrize("what", TEXTS)
@pytest.mark.parametrize("word", WORDS)
def test_a_word_of_the_language_is_a_name_in_both_texts_or_in_none(word: str, what: str) -> None:
    yaml, lines = TEXTS[what]
    leg = LEG.replace(":", "").replace(",", "")
    one = read_or_refused(f"mission: {word}\nlegs:\n{yaml.format(word, LEG, leg)}")
    other = read_or_refused(f"mission {word} vehicle auv\n{lines.format(word, LEG, leg)}")
    if not isinstance(one, Mission):
        assert one in ("control-word", "reserved-name")
        assert other == one
        return
    assert one == other
    assert parse(to_lines(one)) == parse(to_yaml(one)) == one
    assert parse_script(script(one)) == one


@pytest.mark.parametrize("head", ["", "# mission\n\n  "])
def test_a_text_that_begins_with_a_missions_head_is_a_line_script(head: str) -> None:
    legs = "legs: depth 4 heading 0 gear 4 for 10\nmission: gear 3 for 10\n"
    text = f"{head}mission m vehicle auv\n{legs}"
    assert [node.name for node in parse(text).body] == ["legs", "mission"]
    assert parse(layout.formatted(text)) == parse(text)


@pytest.mark.proof
@SOME
@given(missions())
def test_a_mission_survives_its_script(mission: Mission) -> None:
    lines = script(mission)
    assert all(len(line) <= 200 and line.isascii() and line.isprintable() for line in lines)
    assert not any(set("@$") & set(line) for line in lines)
    assert parse_script(lines) == mission
