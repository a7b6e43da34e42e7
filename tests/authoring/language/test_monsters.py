"""Texts that are too large are refused at the figure, and what is within is read in even steps."""

from __future__ import annotations

import pytest

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.graph.outline import TooLarge, outline
from mission.authoring.language import MissionErrors, digest, parse, parse_script
from mission.model import extent
from mission.model.diagnostics import Diagnostic
from mission.model.extent import EXTENTS, Extent
from mission.model.shipped import load_vehicle
from mission.model.yaml_tree import YamlFault, tree

HEAD = "mission monster vehicle auv\nstart without fix\n"
MANY = 1_000_000
YAML = "mission: monster\nstart: without fix\nlegs:\n"


def wrapped(statement: str) -> str:
    """In lines that ``@AW`` can carry."""
    lines, rest = [], statement
    while len(rest) > 150:
        cut = rest.rindex(" ", 3, 150)
        lines.append(rest[:cut])
        rest = f"+ {rest[cut + 1 :]}"
    return "\n".join([*lines, rest]) + "\n"


def first(text: str) -> Diagnostic:
    with pytest.raises(MissionErrors) as caught:
        parse(text)
    assert len(str(caught.value)) < 100_000  # however long the text is
    return caught.value.diagnostics[0]


def handlers(count: int) -> str:
    return HEAD + "a: depth 5 for 10s\n" + "on depth > 8 held 4s -> a\n" * count


def follow(places: int) -> str:
    named = ", ".join(f"north {n % 90} east 5" for n in range(places))
    return HEAD + wrapped(f"a: depth 2 gear 5 follow {named} timeout 9min")


def guard(depth: int, word: str) -> str:
    close = ") " * depth if word == "(" else ""
    return HEAD + wrapped(f"a: depth 2 until {f'{word} ' * depth}depth > 1 {close} for 9s")


def groups(depth: int) -> str:
    opened = "".join(f"group g{n}:\n" for n in range(depth))
    return f"{HEAD}{opened}wait 5s\n" + "end\n" * depth


def nodes(count: int) -> str:
    return f"{YAML}  - a: {{follow: [{'home, ' * count}]}}\n"


# a text with so many of what is bounded, and the extent
GROWN = [
    (lambda n: HEAD + "ZAF1\n" * (n - 3) + "wait 5s\n", extent.STATEMENTS, "too-long"),
    (lambda n: f"{HEAD}a: wait 5s{' ' * (n - 11)}x\n", extent.STATEMENT, "too-long"),
    (lambda n: f"{HEAD}a: wait 5s\n" + "+\n" * (n - 10), extent.STATEMENT, "too-long"),
    (lambda n: guard(n, "not"), extent.DEEPEST_GUARD, "too-deep"),
    (lambda n: guard(n, "("), extent.DEEPEST_GUARD, "too-deep"),
    (groups, extent.DEEPEST_GROUP, "too-deep"),
    (lambda n: f"{HEAD}{'a' * n}: wait 5s\n", extent.NAME, "long-name"),
    (follow, extent.PLACES, "too-long"),
    (handlers, extent.HANDLERS, "too-long"),
    (lambda n: f"{YAML}  - a: {'[' * (n - 3)}{']' * (n - 3)}\n", extent.DEEPEST_YAML, "too-deep"),
    (lambda n: nodes(n - 7), extent.NODES, "too-long"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "bound", "rule"), GROWN, ids=lambda v: getattr(v, "what", None))
def test_one_more_than_the_figure_is_refused_and_so_is_any_number_more(
    text, bound: Extent, rule: str
) -> None:
    assert first(text(bound.most + 1)).code == rule
    if bound.most < 1000:  # the others take seconds
        assert first(text(bound.most * 30)).code == rule


@pytest.mark.parametrize(
    ("text", "bound", "rule"), GROWN[3:9], ids=lambda v: getattr(v, "what", None)
)
def test_as_many_as_the_figure_says_are_accepted(text, bound: Extent, rule: str) -> None:
    parse(text(bound.most))


def test_a_leg_watches_as_many_comparisons_as_the_figure_says_and_not_one_more() -> None:
    vehicle = load_vehicle("auv")
    for more in (0, 1):
        own = " or ".join(["depth > 8"] * (extent.WATCHED.most - 10 + more))
        around = "on depth > 8 -> surface\n" * 10
        mission = parse(HEAD + wrapped(f"a: depth 5 until {own} for 9s") + around)
        if not more:
            assert compile_mission(mission, vehicle, digest(mission))
            continue
        with pytest.raises(MissionErrors, match=extent.WATCHED.exceeded):
            compile_mission(mission, vehicle, digest(mission))


def test_the_hundredth_error_ends_the_reading() -> None:
    with pytest.raises(MissionErrors) as caught:
        parse(HEAD + "dpeth 5\n" * 5000)
    assert len(caught.value.diagnostics) == extent.PROBLEMS.most
    assert "there may be more" in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        HEAD + "foo\n" * 100_000,
        HEAD + "x" * MANY,
        HEAD + "a: depth " + "9" * MANY,
        HEAD + "ZAF" + "9" * 5000,
        HEAD + "ZAA" + "9" * 5000 + ";1",
        HEAD + "repeat " + "9" * 10_000 + " g:\nwait 5s\nend\n",
        HEAD + "a: depth 1e400 for 5s",
        HEAD + "repeat" + " " * 19_000 + "\n",
        "\0" * MANY,
        "mission " + "a" * MANY,
        YAML + "  - " + "a" * MANY,
        YAML + "  - " + "- " * 100_000,
        YAML + "  - a: " + "{a: " * 100_000,
        "? " * 100_000,
        "mission: m\nlegs: &a\n  - g: {legs: *a}\n",
        "mission: m\nlegs:\n  - g: &g {<<: *g, depth: 5}\n",
        "mission: m\nlegs:\n  - a0: &a0 {legs: [wait 1 s]}\n" + "".join(f"  - a{i}: &a{i} {{legs: [b: *a{i - 1}, c: *a{i - 1}]}}\n" for i in range(1, 40)),
    ],
    ids=range(17),
)  # fmt: skip
def test_a_monster_is_refused_in_few_words(text: str) -> None:
    first(text)


@pytest.mark.proof
def test_targets_by_the_thousand_are_each_looked_up_once() -> None:
    text = HEAD + "".join(f"a{n}: depth 5 for 1s else b{n}\n" for n in range(3_000))
    assert first(text).code == "unknown-target"


def test_aliases_are_counted_as_if_they_were_written_out() -> None:
    rows = ["a0: &a0 [x, x]"]
    rows += [f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]" for i in range(1, 15)]
    assert tree("\n".join(rows[:10])) is not None
    with pytest.raises(YamlFault, match="aliases written out"):
        tree("\n".join([*rows, *(f"b{i}: *a14" for i in range(10))]))


def test_a_line_script_that_fits_the_wire_is_judged_however_it_is_nested() -> None:
    for word in ("not", "("):
        with pytest.raises(MissionErrors) as caught:
            parse_script(guard(4_000, word).splitlines())
        assert caught.value.diagnostics[0].code == "too-deep"


@pytest.mark.proof
def test_a_graph_that_nobody_could_look_at_is_not_drawn() -> None:
    vehicle = load_vehicle("auv")
    for count in (extent.PICTURE.most - 1, extent.PICTURE.most + 1):
        mission = parse(HEAD + "".join(f"a{n}: depth 5 for 1s\n" for n in range(count)))
        chart = compile_mission(mission, vehicle, digest(mission))
        if count < extent.PICTURE.most:
            assert len(outline(chart).leaves()) == count + 1
        else:
            with pytest.raises(TooLarge, match="--depth"):
                outline(chart)


def test_every_extent_says_its_figure() -> None:
    assert all(f"{row.most:,}" in row.exceeded and row.what in row.exceeded for row in EXTENTS)
