"""`depth 8 never below altitude 3`: one setting in both texts, what it needs, and what it is told."""

from __future__ import annotations

import json

import jsonschema
import pytest
import yaml

from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.graph.dot import dot
from mission.authoring.graph.outline import outline
from mission.authoring.language import digest, parse, to_lines, to_yaml
from mission.authoring.language.schema import schema
from mission.model import Chart, Mission
from mission.model.diagnostics import MissionErrors
from mission.model.shipped import load_vehicle
from protocol.messages import Setpoint

HEAD = "mission m vehicle {vehicle}\nhome 30 120\nsafety radius 400 time 30min depth {deep}\n"
KEPT = "depth 8 never below altitude 3"


def text(body: str, vehicle: str = "auv", deep: float = 12) -> str:
    return HEAD.format(vehicle=vehicle, deep=deep) + body + "\nup: surface timeout 3min\n"


def chart(mission: Mission) -> Chart:
    return compile_mission(mission, load_vehicle(mission.vehicle), digest(mission))


def sets(body: str, **more: object) -> list[Setpoint | None]:
    return [s.setpoint for s in chart(parse(text(body, **more))).states if s.leg]  # type: ignore[arg-type]


def codes(body: str, **more: object) -> list[str]:
    with pytest.raises(MissionErrors) as caught:
        chart(parse(text(body, **more)))  # type: ignore[arg-type]
    return [problem.code for problem in caught.value.diagnostics]


def judged(body: str, **more: object):
    mission = parse(text(body, **more))  # type: ignore[arg-type]
    return check_mission(chart(mission), load_vehicle(mission.vehicle))


def test_a_leg_holds_both_in_one_set() -> None:
    found = sets(f"a: {KEPT} heading 90 gear 4 for 60")[0]
    assert found is not None
    assert (found.depth, found.altitude) == (8.0, 3.0)


def test_the_reverse_is_the_same_mission() -> None:
    one = parse(text(f"a: {KEPT} gear 4 for 60"))
    other = parse(text("a: altitude 3 never below depth 8 gear 4 for 60"))
    assert digest(one) == digest(other)


def test_it_reads_back_from_both_texts() -> None:
    mission = parse(text(f"a: {KEPT} heading 90 gear 4 for 60\nb: gear 5 for 60"))
    assert parse(to_lines(mission)) == parse(to_yaml(mission)) == mission
    assert KEPT in to_lines(mission)
    assert "depth: 8 m never below altitude 3 m," in to_yaml(mission)


def test_it_reads_back_where_a_leg_has_no_name() -> None:
    mission = parse(text(f"{KEPT} gear 4\na: for 60"))
    assert parse(to_yaml(mission)) == mission
    assert sets(f"{KEPT} gear 4\na: for 60")[0].altitude == 3.0  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "written",
    ["depth 8 m, never below altitude 3 m", "depth 800 cm never below altitude 3"],
)
def test_units_and_the_comma_of_speech_are_understood(written: str) -> None:
    assert digest(parse(text(f"a: {written} gear 4 for 60"))) == digest(
        parse(text(f"a: {KEPT} gear 4 for 60"))
    )


def test_parameters_stand_for_either() -> None:
    body = "param d 8 m\nparam up_by 3 m\na: depth d never below altitude up_by gear 4 for 60"
    assert sets(body)[0].altitude == 3.0  # type: ignore[union-attr]


def test_the_setting_is_kept_by_the_legs_behind_it_as_a_whole() -> None:
    _, second, third = sets(f"a: {KEPT} gear 4 for 60\nb: gear 5 for 9\nc: depth 4 for 9")[:3]
    assert second is not None
    assert third is not None
    assert (second.depth, second.altitude) == (8.0, 3.0)
    assert (third.depth, third.altitude) == (4.0, None)


def test_a_leg_that_can_be_entered_with_either_is_asked_which() -> None:
    body = (
        f"a: {KEPT} gear 4 until range > 9 -> c timeout 60\n"
        "b: depth 8 gear 4 for 9\nc: gear 5 for 9"
    )
    assert codes(body) == ["axis-conflict"]


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("a: depth 8 altitude 3 gear 4 for 60", "axis-twice"),
        ("a: depth 8 never below altitude 3 down 4 for 60", "axis-twice"),
        ("a: depth 8 never below depth 3 gear 4 for 60", "never-below"),
        ("a: depth 8 never below heading 3 gear 4 for 60", "never-below"),
        ("a: gear 8 never below altitude 3 for 60", "never-below"),
    ],
)
def test_what_is_no_pair_is_refused(body: str, code: str) -> None:
    assert set(codes(body)) == {code}


def test_a_comma_in_a_table_of_yaml_is_answered_with_the_way_to_write_it() -> None:
    wrong = to_yaml(parse(text(f"a: {KEPT} gear 4 for 60"))).replace("m never", "m, never")
    with pytest.raises(MissionErrors) as caught:
        parse(wrong)
    assert "write depth: 8 m never below altitude 3 m" in caught.value.diagnostics[0].hint


def test_more_behind_it_in_yaml_is_no_part_of_it() -> None:
    wrong = to_yaml(parse(text(f"a: {KEPT} gear 4 for 60"))).replace("3 m,", "3 m gear 2,")
    with pytest.raises(MissionErrors) as caught:
        parse(wrong)
    assert [p.code for p in caught.value.diagnostics] == ["yaml-type"]


@pytest.mark.parametrize("held", ["8 m never below altitude 3 m", "d never below altitude h", 8])
def test_the_schema_knows_it(held: object) -> None:
    legs = [{"a": {"depth": held, "gear": 4, "for": "1 min"}}]
    jsonschema.validate({"mission": "m", "legs": legs}, schema())


def test_the_schema_knows_what_it_is_not() -> None:
    legs = [{"a": {"depth": "8 m never below depth 3 m", "gear": 4, "for": "1 min"}}]
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"mission": "m", "legs": legs}, schema())


def test_a_vehicle_that_measures_no_altitude_cannot_be_kept_above_one() -> None:
    assert "vehicle-cannot-know" in codes(f"a: {KEPT} for 60", vehicle="robot")


def test_a_vehicle_that_holds_a_depth_and_measures_an_altitude_needs_no_word_for_both() -> None:
    found = sets(f"a: {KEPT} heading 90 speed 0.5 for 60", vehicle="coreboard")[0]
    assert found is not None
    assert found.altitude == 3.0


def test_the_height_may_lie_between_the_steps_of_the_vehicle_and_the_depth_may_not() -> None:
    assert sets("a: depth 8 never below altitude 2.5 gear 4 for 60")
    assert codes("a: depth 8.5 never below altitude 3 gear 4 for 60") == ["between-steps"]


def test_the_check_tells_what_is_held_without_an_altitude() -> None:
    report = judged(f"assume floor 10\na: {KEPT} heading 90 gear 4 for 60")
    assert report.ok
    assert any(line.startswith("a holds 7 m while its altitude") for line in report.assumed)


def test_the_check_bounds_it_by_the_depth_that_is_asked_for() -> None:
    """An altimeter that reads too much must not lead deeper than is proved."""
    kept = judged(f"assume floor 10\na: {KEPT} heading 90 gear 4 for 60").proved
    plain = judged("assume floor 10\na: depth 8 heading 90 gear 4 for 60").proved
    assert kept is not None
    assert plain is not None
    assert kept.max_depth == plain.max_depth


def test_a_floor_without_room_is_refused_with_the_leg() -> None:
    report = judged("assume floor 4\na: depth 3 never below altitude 4 heading 90 gear 4 for 60")
    assert [r.code for r in report.refusals] == ["never-below"]
    assert report.refusals[0].where.line == 5
    assert report.refusals[0].message.startswith("a is kept 4 m above")


def test_a_floor_that_nobody_states_is_the_depth_allowed() -> None:
    report = judged("a: depth 8 never below altitude 12 heading 90 gear 4 for 60")
    assert [r.code for r in report.refusals] == ["never-below"]


def test_pictures_say_it() -> None:
    drawn = dot(outline(chart(parse(text(f"a: {KEPT} gear 4 for 60")))))
    assert "depth 8 m, never below altitude 3 m" in drawn


def test_yaml_of_others_reads_it_as_one_text() -> None:
    read = yaml.safe_load(to_yaml(parse(text(f"a: {KEPT} gear 4 for 60"))))
    assert json.dumps(read["legs"][0]["a"]["depth"]) == '"8 m never below altitude 3 m"'
