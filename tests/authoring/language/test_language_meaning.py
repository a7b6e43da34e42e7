"""What the words mean: settings in SI, kinds, guards, names, parameters, YAML's own traps."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from mission.authoring.language import digest, is_yaml, load, parse, script, to_lines, to_yaml
from mission.legs import Follow, Goto, Hold, Loiter, Rows, Surface, Wait, Yoyo
from mission.model import (
    And,
    Comparison,
    Exit,
    Group,
    Guard,
    Handler,
    Leg,
    Local,
    Mission,
    Not,
    Or,
    Position,
    Set,
)


def only(text: str) -> Leg:
    """The one leg of a mission."""
    leg = parse(text).body[0]
    assert isinstance(leg, Leg)
    return leg


def settings(words: str) -> dict[str, float]:
    return {s.word: s.value for s in only(f"a: {words} for 5").settings}


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("ZAF8", {"surge": 8 / 12}),
        ("ZAB4", {"surge": -4 / 12}),
        ("ZAF0", {"surge": 0.0}),
        ("ZAL5", {"turn": -5 / 12}),
        ("ZAR5", {"turn": 5 / 12}),
        ("ZAU12", {"heave": -1.0}),
        ("ZAD8", {"heave": 8 / 12}),
        ("ZAS10", {"depth": 10.0}),
        ("ZAE3", {"altitude": 3.0}),
        ("ZAH-90", {"heading": math.pi / 2}),
        ("ZAH90", {"heading": 3 * math.pi / 2}),
        ("ZAH180", {"heading": math.pi}),
        ("ZAH-180", {"heading": math.pi}),
        ("ZAA5;-3", {"pitch": math.radians(5), "roll": math.radians(-3)}),
        ("gear 8", {"surge": 8 / 12}),
        ("gear -4", {"surge": -4 / 12}),
        ("stop", {"surge": 0.0}),
        ("speed 0.75", {"surge": 6 / 12}),
        ("speed 0.8 m/s", {"surge": 6 / 12}),
        ("speed 1.4 kn", {"surge": 6 / 12}),
        ("speed 1.25", {"surge": 10 / 12}),
        ("heading 360", {"heading": 0.0}),
        ("heading 1.5 rad", {"heading": math.radians(math.degrees(1.5))}),
        ("depth 2.5", {"depth": 2.5}),
        ("depth 250 cm", {"depth": 2.5}),
        ("up 6", {"heave": -0.5}),
        ("down 6 left 6", {"heave": 0.5, "turn": -0.5}),
        ("pitch -5 roll 3", {"pitch": math.radians(-5), "roll": math.radians(3)}),
    ],
)
def test_a_word_sets_its_field_in_si(words: str, expected: dict[str, float]) -> None:
    assert settings(words) == expected
    assert all(math.copysign(1, v) == 1 for v in settings(words).values() if v == 0)


@pytest.mark.proof
def test_every_heading_in_tenths_of_a_degree_comes_back_to_the_last_bit() -> None:
    said = [str(tenths / 10).removesuffix(".0") for tenths in range(3600)]
    mission = parse("\n".join(f"a{n}: heading {text} for 5" for n, text in enumerate(said)))
    again = to_lines(mission).splitlines()[1:]
    assert again == [f"a{n}: heading {text} for 5" for n, text in enumerate(said)]


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("a: hold for 5", Hold()),
        ("a: wait 30s", Wait()),
        ("a: goto home timeout 5", Goto("home", 10.0)),
        ("a: goto 30.2 120.1 within 5", Goto(Position(30.2, 120.1), 5.0)),
        ("a: goto 30.2, 120.1", Goto(Position(30.2, 120.1), 10.0)),
        ("a: goto north 10 east -20", Goto(Local(10.0, -20.0), 10.0)),
        ("a: goto north 1 km east 0", Goto(Local(1000.0, 0.0), 10.0)),
        (
            "a: follow home, north 1 east 2, 30.2 120.1",
            Follow(("home", Local(1.0, 2.0), Position(30.2, 120.1)), 10.0),
        ),
        (
            "a: rows 4 bearing 90 length 100 spacing 20 side port from home",
            Rows("home", math.pi / 2, 100.0, 20.0, 4, -1, 10.0),
        ),
        (
            "a: rows 1 length 0.1 km spacing 20 bearing 360",
            Rows(None, 0.0, 100.0, 20.0, 1, 1, 10.0),
        ),
        ("a: yoyo 3 shallow 2 deep 10", Yoyo(2.0, 10.0, 3)),
        ("a: loiter home radius 30", Loiter("home", 30.0, 1)),
        ("a: loiter radius 30 side port", Loiter(None, 30.0, -1)),
        ("a: loiter here radius 30", Loiter(None, 30.0, 1)),
        ("a: surface", Surface()),
        ("a: surface until fix timeout 60", Surface(until_fix=True)),
    ],
)
def test_a_kind_has_its_values(text: str, kind: object) -> None:
    mission = parse(text)
    assert only(text).kind == kind
    assert parse(to_lines(mission)) == mission
    assert parse(to_yaml(mission)) == mission


def compared(variable: str, operator: str, bound: float, sure: float | None = None) -> Comparison:
    return Comparison(variable, operator, bound, sure)


DEEP, LOW = compared("depth", ">", 5.0), compared("altitude", "<", 2.0)
LATE = compared("elapsed", ">=", 60.0)


@pytest.mark.parametrize(
    ("guard", "expected"),
    [
        ("depth > 5", Guard(DEEP)),
        ("depth>5 held 3s", Guard(DEEP, 3.0)),
        ("depth > 5 sure 95%", Guard(compared("depth", ">", 5.0, 0.95))),
        ("depth > 5 sure 0.95", Guard(compared("depth", ">", 5.0, 0.95))),
        ("elapsed >= 1 min", Guard(LATE)),
        ("depth > 5 or altitude < 2 and elapsed >= 60", Guard(Or((DEEP, And((LOW, LATE)))))),
        ("(depth > 5 or altitude < 2) and elapsed >= 60", Guard(And((Or((DEEP, LOW)), LATE)))),
        ("(depth > 5 or (altitude < 2)) or elapsed >= 60", Guard(Or((DEEP, LOW, LATE)))),
        ("not depth > 5 and altitude < 2", Guard(And((Not(DEEP), LOW)))),
        ("not (depth > 5 and altitude < 2)", Guard(Not(And((DEEP, LOW))))),
        ("not not depth > 5", Guard(Not(Not(DEEP)))),
        ("pitch > -5 deg", Guard(compared("pitch", ">", math.radians(-5)))),
        ("battery < 11 V", Guard(compared("battery", "<", 11.0))),
    ],
)
def test_a_guard_reads_as_logic_says(guard: str, expected: Guard) -> None:
    mission = parse(f"a: gear 6 until {guard} -> a timeout 5")
    leg = mission.body[0]
    assert isinstance(leg, Leg)
    assert leg.exits == (Exit(expected, "a"),)
    assert parse(to_lines(mission)) == mission
    assert parse(to_yaml(mission)) == mission


def test_a_seed_style_script_of_bare_lines_and_waits_is_a_mission() -> None:
    mission = parse("ZAF6\nwait 30\nZAL5 ZAS3\nwait 10s until depth > 2\nZAF0\n")
    assert (mission.name, mission.vehicle) == ("unnamed", "auv")
    kinds = [type(node).__name__ for node in mission.body]
    assert kinds == ["Set", "Leg", "Set", "Leg", "Set"]
    assert [node.name for node in mission.body] == ["line2", "line3", "line4", "line5", "line6"]
    lines = to_lines(mission).split("\n")
    for node in mission.body:  # a name is the line's number in the canonical text
        assert lines[int(node.name.removeprefix("line")) - 1]


def test_names_by_line_count_through_groups_and_long_lines() -> None:
    long = " or ".join(f"depth > {n}.5" for n in range(30))
    text = f"home 1 2\nrepeat 2 g:\nwait 5\nuntil {long}\nwait 7\non depth > 3 -> g\nend\nwait 9"
    mission = parse(text)
    lines = to_lines(mission).split("\n")
    group, last = mission.body
    assert isinstance(group, Group)
    for node, start in zip(
        (*group.body, last), ("wait 5", "hold until", "wait 7", "wait 9"), strict=True
    ):
        assert lines[int(node.name.removeprefix("line")) - 1].startswith(start)
    assert all(len(line) <= 200 for line in script(mission))
    assert parse(to_lines(mission)) == mission


def test_the_inner_handler_and_the_outer_are_both_kept_where_they_stand() -> None:
    mission = parse(
        "group g:\n a: gear 6 for 5\n on depth > 5 held 2 -> a\nend\nup: surface\n"
        "on depth > 5 -> up\non uncertain -> up\non timeout -> g\n"
    )
    group = mission.body[0]
    assert isinstance(group, Group)
    assert group.handlers == (Handler(Guard(DEEP, 2.0), "a"),)
    assert mission.handlers == (Handler(Guard(DEEP), "up"),)
    assert (mission.on_uncertain, mission.on_timeout) == ("up", "g")
    assert parse(to_lines(mission)) == mission == parse(to_yaml(mission))


def test_a_target_is_looked_up_in_the_innermost_group_first_and_then_outwards() -> None:
    text = (
        "a: gear 1 for 5\ngroup g:\n  a: gear 2 for 5 else b\n  group h:\n"
        "    c: gear 3 until depth > 1 -> a timeout 5 else g\n  end\nend\nb: gear 4 for 5\n"
    )
    assert parse(text).body


def test_parameters_have_defaults_units_and_overrides() -> None:
    text = (
        "mission m vehicle auv\na: gear g depth d until travelled >= far timeout t\n"
        "repeat n r:\n wait 5\nend\n"
        "param far 0.2 km\nparam g 6\nparam d 5\nparam t 2 min\nparam n 3\n"
    )
    default = parse(text)
    leg = default.body[0]
    assert isinstance(leg, Leg)
    assert leg.timeout == 120.0
    guard = leg.exits[0].guard.expression
    assert guard == compared("travelled", ">=", 200.0)
    other = parse(text, parameters={"far": "300 m", "t": "3", "g": "8"})
    assert "gear 8 until travelled >= 300 timeout 180" in to_lines(other)
    assert digest(other) != digest(default)


def test_the_order_of_words_and_the_way_of_writing_do_not_change_the_mission() -> None:
    one = parse("mission m\na: ZAF6 ZAS5 ZAH-90 timeout 1min until depth >= 4 else surface")
    two = parse(
        "mission m vehicle auv\n\n# x\n  a :heading 90 depth 500cm until depth>=4.0\n + else surface timeout 60 gear 6"
    )
    assert one == two
    assert digest(one) == digest(two)


def test_comments_and_blanks_and_line_ends_do_not_matter() -> None:
    plain = "mission m vehicle auv\na: gear 6 for 5\n"
    for text in (
        plain.replace("\n", "\r\n"),
        "\ufeff" + plain,
        "# c\n\n" + plain.replace(":", " : "),
        plain.strip(),
    ):
        assert parse(text) == parse(plain)


YAML = "mission: m\nlegs:\n  - a: {gear: 6, for: 5 s}\n"


@pytest.mark.parametrize(
    ("yaml", "lines"),
    [
        ("on:\n  - {when: depth > 5, do: a}\n", "on depth > 5 -> a\n"),
        ("on: [{when: uncertain, do: a}]\n", "on uncertain -> a\n"),
        ("on: [{when: timeout, do: a}]\n", "on timeout -> a\n"),
        ("on:\n  - when: depth > 5\n    held: 1e1 s\n    do: a\n", "on depth > 5 held 10 -> a\n"),
        ("start: without fix\n", "start without fix\n"),
        ("safety: {time: 40 min, depth: 1e1}\n", "safety depth 10 time 40min\n"),
        ("home: {latitude: 1, longitude: 2}\n", "home 1 2\n"),
        ("home: 1 2\n", "home 1 2\n"),
        ("assume: {current: 1 kn}\n", "assume current 1kn\n"),
        ("  - {b: {surface}}\n", "b: surface\n"),
        ("  - b: {surface: true, until: fix}\n", "b: surface until fix\n"),
        ("  - on: {wait: 5}\n  - yes: {wait: 5}\n", "on: wait 5\nyes: wait 5\n"),
        ("  - ZAF6 ZAS3\n  - wait 30 s until depth > 2 -> a\n", "ZAF6 ZAS3\nwait 30 until depth > 2 -> a\n"),
        ("  - b: {goto: {north: 1 m, east: 2 m}}\n", "b: goto north 1 east 2\n"),
        ("  - b: {goto: north 1 east 2}\n", "b: goto north 1 east 2\n"),
        ("  - b:\n      follow:\n        - home\n        - 1 2\n", "b: follow home, 1 2\n"),
        ("  - b: {until: [depth > 1, depth > 2 -> a], stop: yes}\n", "b: stop until depth > 1 until depth > 2 -> a\n"),
        ("  - b: {<<: {gear: 3, depth: 2}, depth: 4, for: 1}\n", "b: gear 3 depth 4 for 1\n"),
        ("  - b: &x {gear: 3, for: 1}\n  - c: *x\n", "b: gear 3 for 1\nc: gear 3 for 1\n"),
        ("  - b: {until: 'depth > 1', for: \"2 s\"}\n", "b: until depth > 1 for 2\n"),
    ],
)  # fmt: skip
def test_yaml_and_lines_say_the_same(yaml: str, lines: str) -> None:
    plain = "mission m vehicle auv\na: gear 6 for 5\n"
    assert parse(YAML + yaml) == parse(plain + lines)


def test_missions_are_told_apart_by_their_content(tmp_path: Path) -> None:
    assert is_yaml(YAML)
    assert is_yaml('{"mission": "m", "legs": []}')
    for text in ("ZAF6\nwait 5\n", "mission m\n", "home: goto home timeout 5\n", "a: ZAF6 for 5\n"):
        assert not is_yaml(text)
    wrong = tmp_path / "named.mission"
    wrong.write_text(YAML, encoding="utf-8")
    assert load(wrong) == parse(YAML)


def test_the_canonical_text_is_ascii_with_single_blanks_and_no_indentation() -> None:
    mission: Mission = parse("mission m vehicle auv\n\tgroup  g :\n  a :  gear 6   for 5 # ä\nend")
    text = to_lines(mission)
    assert text == "mission m vehicle auv\ngroup g:\na: gear 6 for 5\nend\n"
    assert isinstance(mission.body[0], Group)
    assert not isinstance(mission.body[0], Set)
