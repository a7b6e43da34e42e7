"""Every broken mission is refused at its place, with what is wrong and what to write instead."""

from __future__ import annotations

import pytest
from broken_missions import BROKEN, Broken

from mission.authoring.language import MissionErrors, parse


def errors(text: str, parameters: dict[str, str] | None = None) -> MissionErrors:
    with pytest.raises(MissionErrors) as caught:
        parse(text, "m", parameters or {})
    return caught.value


@pytest.mark.parametrize("row", BROKEN, ids=lambda row: row.text[:40])
def test_a_broken_mission_is_refused_at_its_place(row: Broken) -> None:
    found = errors(row.text).diagnostics
    assert len(found) == 1, [p.message for p in found]
    problem = found[0]
    assert (problem.code, problem.where.line, problem.where.column) == (
        row.rule,
        row.line,
        row.column,
    )
    assert row.message in problem.message
    assert problem.hint.startswith(row.hint)
    assert row.hint
    assert problem.text == row.text.split("\n")[row.line - 1]
    assert problem.where.length >= 1


def test_there_are_eighty_broken_missions_and_more() -> None:
    assert len({row.text for row in BROKEN}) >= 80
    assert len({row.rule for row in BROKEN}) >= 60


@pytest.mark.parametrize(
    ("text", "places"),
    [
        (
            "mission m vehicle axv\na: dpeth 5\nb: depth 5 until dephts > 3 -> nowhere\n"
            "ZAF130\nrepeat 0 r:\n  for 1:30\nend\nend\non batery < 3 -> c\n",
            [(1, 19), (2, 4), (3, 18), (3, 32), (4, 1), (5, 8), (6, 7), (8, 1), (9, 4), (9, 18)],
        ),
        (
            "mission: m\nvehicle: axv\nlegs:\n  - a: {dpeth: 5 m, for: 1 s}\n"
            "  - b: {depth: 5 m, depth: 6 m, until: dephts > 3 -> nowhere}\n  - ZAF130\n"
            "  - r: {repeat: 0, legs: [wait 1:30]}\non:\n  - {when: batery < 3, do: c}\n",
            [
                (2, 10),
                (4, 9),
                (5, 21),
                (5, 40),
                (5, 54),
                (6, 5),
                (7, 17),
                (7, 32),
                (9, 12),
                (9, 28),
            ],
        ),
    ],
    ids=["lines", "yaml"],
)
def test_all_errors_of_a_file_are_told_at_once(text: str, places: list[tuple[int, int]]) -> None:
    problems = errors(text).diagnostics
    assert [(p.where.line, p.where.column) for p in problems] == places


def test_an_error_shows_the_line_underlined_and_what_to_write() -> None:
    text = "mission m vehicle auv\n\tdive: depth 5 until dephts > 3 timeout 30   # down\n"
    assert str(errors(text)).split("\n") == [
        "m:2:22: unknown variable 'dephts' [unknown-variable]",
        "    \tdive: depth 5 until dephts > 3 timeout 30   # down",
        "    \t                    ^^^^^^",
        "    did you mean depth?",
        "m: 1 error",
    ]


def test_places_are_right_in_continued_lines() -> None:
    text = "a: depth 5\n  + until depth > 3 # x\n\n  +  or altitued < 2 timeout 30\n"
    problem = errors(text).diagnostics[0]
    assert (problem.where.line, problem.where.column, problem.offending) == (4, 9, "altitued")


def test_places_are_right_behind_quotes_and_in_other_scripts() -> None:
    text = 'mission: m\n# 下潜\nlegs:\n  - a: {until: "dephts > 3", timeout: 5 s}\n'
    problem = errors(text).diagnostics[0]
    assert (problem.where.line, problem.where.column, problem.offending) == (4, 17, "dephts")


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"lenght": "5"}, "there is no parameter 'lenght'"),
        ({"length_1": "five"}, "'five' is no value for it"),
        ({"length_1": "5 fathom"}, "'5 fathom' is no value for it"),
        ({"length_1": "5 s"}, "the unit does not fit"),
    ],
)
def test_a_parameter_from_outside_is_checked(parameters: dict[str, str], message: str) -> None:
    text = "param length_1 20 m\na: gear 6 until travelled > length_1 timeout 60\n"
    assert message in str(errors(text, parameters))


@pytest.mark.proof
def test_a_mission_is_at_most_as_long_as_the_wire_can_count() -> None:
    text = "mission m vehicle auv\n" + "wait 5\n" * 9999
    assert [p.code for p in errors(text).diagnostics] == ["too-long"]


def test_groups_are_nested_at_most_sixteen_deep() -> None:
    text = "".join(f"group g{n}:\n" for n in range(17)) + "wait 5\n" + "end\n" * 17
    assert [p.code for p in errors(text).diagnostics] == ["too-deep"]


def test_thousands_of_groups_in_each_other_are_refused_and_no_trap() -> None:
    text = "repeat 2 g:\n" * 3000 + "wait 5\n" + "end\n" * 3000
    assert "too-deep" in {p.code for p in errors(text).diagnostics}


def test_aliases_that_repeat_themselves_are_no_trap() -> None:
    bomb = "mission: m\nx: &a [wait 5]\n"
    endless = "mission: m\nlegs: &a\n  - g: {legs: *a}\n"
    many = "".join(
        f"  - g{n}: &g{n} {{legs: [g: *g{n - 1}, h: *g{n - 1}]}}\n" for n in range(1, 30)
    )
    wide = f"mission: m\nlegs:\n  - g0: &g0 {{legs: [wait 5]}}\n{many}"
    deep = "mission: m\nlegs: " + "[" * 100_000
    dashes = "mission: m\nlegs:\n" + "- " * 100_000
    for text in (bomb, endless, wide, deep, dashes):
        assert errors(text).diagnostics


@pytest.mark.parametrize("text", ["", "\n\n# only a comment\n", "\ufeff", "\x00", "---\n", "- a\n"])
def test_no_text_at_all_is_an_error_with_a_place(text: str) -> None:
    assert errors(text).diagnostics[0].where.line >= 1
