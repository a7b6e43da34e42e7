"""`keep in`, `keep out`: areas in both texts, and what is no area."""

from __future__ import annotations

import jsonschema
import pytest
import yaml

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.diff.changes import changes
from mission.authoring.graph import words
from mission.authoring.language import digest, parse, script, to_lines, to_yaml
from mission.authoring.language.canonical import LONGEST_LINE
from mission.authoring.language.schema import schema
from mission.model import Chart, Mission
from mission.model.diagnostics import MissionErrors
from mission.model.shipped import load_vehicle

AUV = load_vehicle("auv")
HEAD = "mission m vehicle auv\nhome 30 120\nsafety radius 900 time 30min depth 12\n"
LEGS = "a: depth 4 heading 90 gear 4 for 30\nup: surface timeout 3min\n"
HARBOUR = "keep in harbour: north -300 east -300, north -300 east 300, north 300 east 0\n"
WRECK = "keep out wreck: north 90 east 90, 30.002 120.001, north 90 east 120 between 4 and 12\n"


def text(areas: str) -> str:
    return HEAD + areas + LEGS


def chart(mission: Mission) -> Chart:
    return compile_mission(mission, AUV, digest(mission))


def code_of(areas: str) -> tuple[str, str]:
    with pytest.raises(MissionErrors) as caught:
        parse(text(areas))
    (problem,) = caught.value.diagnostics
    return problem.code, problem.hint


def test_areas_read_back_from_both_texts() -> None:
    mission = parse(text(HARBOUR + WRECK))
    assert parse(to_lines(mission)) == parse(to_yaml(mission)) == mission
    assert [area.name for area in mission.areas] == ["harbour", "wreck"]
    assert (mission.areas[1].top, mission.areas[1].bottom) == (4.0, 12.0)


def test_their_order_changes_nothing() -> None:
    assert digest(parse(text(WRECK + HARBOUR))) == digest(parse(text(HARBOUR + WRECK)))


def test_they_are_part_of_the_digest() -> None:
    assert digest(parse(text(HARBOUR))) != digest(parse(text("")))
    assert "keep" not in to_lines(parse(text("")))


def test_a_long_one_travels_in_several_lines() -> None:
    corners = ", ".join(f"north {n}.125 east {n * n % 97}.25" for n in range(40))
    lines = script(parse(text(f"keep in large: {corners}\n")))
    assert max(map(len, lines)) <= LONGEST_LINE
    assert any(line.startswith("+ ") for line in lines)


def test_the_schema_knows_them() -> None:
    jsonschema.validate(yaml.safe_load(to_yaml(parse(text(HARBOUR + WRECK)))), schema())


def test_a_name_stands_for_one_area() -> None:
    assert code_of(HARBOUR + HARBOUR)[0] == "duplicate-name"


def test_a_range_of_depths_has_the_shallower_first() -> None:
    code, hint = code_of(WRECK.replace("4 and 12", "12 and 4"))
    assert code == "upside-down"
    assert "between 4 and 12" in hint


def test_an_area_stands_at_the_top() -> None:
    with pytest.raises(MissionErrors) as caught:
        parse(HEAD + "group g:\n" + HARBOUR + "a: depth 4 gear 4 for 30\nend\n")
    assert [p.code for p in caught.value.diagnostics] == ["inside-group"]


@pytest.mark.parametrize(
    ("area", "code"),
    [
        ("{between: [4 m, 12 m]}", "missing-word"),
        ("{corners: [home, north 9 east 0, north 9 east 9], between: [4 m]}", "missing-word"),
        ("{corners: [home, north 9 east 0, north 9 east 9], bottom: 4 m}", "unknown-word"),
        ("{corners: [here, north 9 east 0, north 9 east 9]}", "here"),
    ],
)
def test_in_yaml_an_area_has_corners_and_two_depths(area: str, code: str) -> None:
    with pytest.raises(MissionErrors) as caught:
        parse(
            f"mission: m\nsafety: {{radius: 900 m, keep_out: {{wreck: {area}}}}}\n"
            "legs:\n  - a: {depth: 4 m, gear: 4, for: 9 s}\n"
        )
    assert code in [p.code for p in caught.value.diagnostics]


def test_too_many_corners_are_refused_with_the_figure() -> None:
    corners = ", ".join(f"north {n} east {n * n}" for n in range(101))
    assert code_of(f"keep in large: {corners}\n")[0] == "too-long"


def test_a_difference_of_areas_is_told() -> None:
    one, other = (chart(parse(text(a))) for a in (HARBOUR, HARBOUR + WRECK))
    (row,) = changes(one, other, (AUV, AUV)).rows
    assert row.what == "area wreck"
    assert row.before == "not there"
    assert row.after.startswith("keep out wreck: north 90 east 90")


def test_pictures_name_them() -> None:
    told = words.safety(parse(text(HARBOUR + WRECK)))
    assert told.endswith("keep in harbour, keep out wreck (4 to 12 m)")
