"""`achieve`: both texts, who may say it, which of several counts, and what it leaves as it was."""

from __future__ import annotations

import pytest

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.diff.changes import changes
from mission.authoring.graph.dot import dot
from mission.authoring.graph.mermaid import mermaid
from mission.authoring.graph.outline import outline
from mission.authoring.graph.svg import svg
from mission.authoring.graph.tables import tables
from mission.authoring.language import digest, parse, to_lines, to_yaml
from mission.model import Chart, Mission, aims_of
from mission.model.diagnostics import MissionErrors
from mission.model.shipped import load_vehicle

AUV = load_vehicle("auv")
ROWS = "rows 2 bearing 90 length 60 spacing 20 from north 30 east 0 swath 20 gear 6 depth 4"
TEXT = f"""mission m vehicle auv
home 30 120
achieve coverage 50% position 40
group g:
achieve position 30
a: {ROWS} timeout 10min
b: {ROWS} timeout 10min achieve coverage 0.7
end
up: surface timeout 3min
"""


def without(text: str) -> str:
    lines = (line.partition(" achieve")[0] for line in text.splitlines())
    return "\n".join(line for line in lines if not line.startswith("achieve")) + "\n"


def chart(mission: Mission) -> Chart:
    return compile_mission(mission, AUV, digest(mission))


def test_a_purpose_reads_back_from_both_texts() -> None:
    mission = parse(TEXT)
    assert parse(to_lines(mission)) == parse(to_yaml(mission)) == mission
    assert "achieve: {coverage: 50%, position: 40 m}" in to_yaml(mission)


def test_of_each_aim_the_innermost_counts() -> None:
    mission = parse(TEXT)
    found = {path: aims for path, _, aims in aims_of(mission.body, mission.achieve)}
    assert found["g/a"] == {"coverage": 0.5, "position": 30.0}
    assert found["g/b"] == {"coverage": 0.7, "position": 30.0}


def test_a_purpose_is_part_of_the_digest_and_a_mission_without_one_says_nothing_of_it() -> None:
    plain = parse(without(TEXT))
    assert "achieve" not in to_lines(plain)
    assert "achieve" not in to_yaml(plain)
    assert digest(plain) != digest(parse(TEXT))


@pytest.mark.parametrize(
    ("written", "code"),
    [
        ("achieve coverage 90", "range"),
        ("achieve position 0", "range"),
        ("achieve coverage 5 m", "unit"),
        ("achieve position 5 position 6", "twice"),
        ("achieve depth 5", "syntax"),
    ],
)
def test_an_aim_that_cannot_be_is_refused(written: str, code: str) -> None:
    with pytest.raises(MissionErrors) as refused:
        parse(TEXT.replace("achieve position 30", written))
    assert {d.code for d in refused.value.diagnostics} == {code}


def test_a_purpose_is_stated_once_in_each_place() -> None:
    with pytest.raises(MissionErrors) as refused:
        parse(TEXT.replace("achieve position 30", "achieve position 30\nachieve coverage 40%"))
    assert [d.code for d in refused.value.diagnostics] == ["twice"]


def test_legs_that_see_nothing_have_nothing_to_achieve() -> None:
    with pytest.raises(MissionErrors) as refused:
        parse(TEXT.replace("up: surface", "up: surface achieve position 5"))
    (found,) = refused.value.diagnostics
    assert found.code == "foreign-word"
    assert "rows" in found.hint


def test_a_leg_without_rows_may_be_flown_for_its_position_alone() -> None:
    plain = "out: heading 0 gear 6 for 60 achieve "
    mission = parse(TEXT.replace("up: ", plain + "position 30\nup: "))
    assert parse(to_lines(mission)) == parse(to_yaml(mission)) == mission
    with pytest.raises(MissionErrors) as refused:
        parse(TEXT.replace("up: ", plain + "coverage 50%\nup: "))
    (found,) = refused.value.diagnostics
    assert found.code == "foreign-word"
    assert "coverage" in found.message


def test_pictures_tell_the_purpose() -> None:
    drawn = svg(outline(chart(parse(TEXT))), False).replace("\u00a0", " ")
    assert "to achieve coverage 50 %, position 40 m" in drawn
    assert "to achieve coverage 70 %" in drawn
    assert "to achieve position 30 m" in drawn
    for text in (dot, mermaid):
        assert "to achieve position 30 m" in text(outline(chart(parse(TEXT))), False)
    assert '"coverage": 0.7' in tables(chart(parse(TEXT)))


def test_a_difference_tells_a_purpose_that_changed() -> None:
    before, after = chart(parse(without(TEXT))), chart(parse(TEXT))
    rows = changes(before, after, (AUV, AUV)).rows
    told = {(row.places, row.before, row.after) for row in rows if row.what == "to achieve"}
    assert told == {
        (("mission",), "not stated", "coverage 50 %, position 40 m"),
        (("g",), "not stated", "position 30 m"),
        (("g/b",), "not stated", "coverage 70 %"),
    }
    assert not changes(after, after, (AUV, AUV)).rows


def test_a_group_that_went_with_its_purpose_is_told() -> None:
    flat = "".join(
        line + "\n"
        for line in TEXT.splitlines()
        if line not in ("group g:", "achieve position 30", "end")
    )
    rows = changes(chart(parse(TEXT)), chart(parse(flat)), (AUV, AUV)).rows
    assert [row.before for row in rows] == ["to achieve position 30 m"]


def test_a_leg_that_is_parted_keeps_its_purpose() -> None:
    parted = chart(parse(TEXT.replace("swath 20 gear", "swath 20 resurface 1 gear")))
    assert parted.state("autonomous/g/b").group.achieve == (("coverage", 0.7),)  # type: ignore[union-attr]
