"""Laws of a difference: it tells what changed for the vehicle, all of that and nothing else."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.authoring.diff import Difference, Kind, compare
from mission.authoring.diff.changes import changes
from mission.authoring.diff.show import as_markdown, as_text
from mission.authoring.language import digest, load, to_lines
from mission.authoring.prepare import Unreadable, prepare
from mission.cli import main
from mission.model.shipped import missions_folder

SURVEY = """mission survey vehicle auv
home 30.2874595 120.1535765
safety radius 1000 time 40min depth 30 voltage 10
assume current 0.2
dive: depth 10 heading 90 gear 6 until depth >= 9.5 timeout 2min
repeat 2 rows:
out: heading 90 gear 8 until travelled >= 200 timeout 4min
turn: heading 180 gear 4 for 15s
back: heading 270 gear 8 until travelled >= 200 timeout 4min
on depth > 14 -> up
end
bottom: altitude 3 gear 4 heading 0 until elapsed > 60s or altitude < 1.5 sure 90% -> home_run timeout 90s
home_run: goto home gear 8 depth 3 within 15 timeout 10min else surface
up: surface timeout 5min
on battery < 11 held 10s -> up
"""
SHIPPED = sorted(
    path for path in missions_folder().iterdir() if path.suffix in (".yaml", ".mission")
)


def compared(folder: Path, before: str, after: str) -> Difference:
    names = folder / "a.mission", folder / "b.mission"
    for path, text in zip(names, (before, after), strict=True):
        path.write_text(text, encoding="utf-8")
    return compare(prepare(names[0]), prepare(names[1]))


def changed(folder: Path, old: str, new: str, text: str = SURVEY) -> Difference:
    assert old in text
    return compared(folder, text, text.replace(old, new, 1))


def rows(found: Difference) -> list[tuple[str, tuple[str, ...], str, str, str]]:
    return [(r.kind.value, r.places, r.what, r.before, r.after) for r in found.changes]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_one_mission_in_two_texts_is_no_difference(path: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.mission"
    other.write_text(to_lines(load(path)), encoding="utf-8")
    found = compare(prepare(path), prepare(other))
    assert found.same
    assert not found.renamed


LEGS = ("dive", "rows/out", "rows/turn", "rows/back")


@pytest.mark.parametrize(
    ("old", "new", "row"),
    [
        ("depth 10", "depth 12", ("changed", LEGS, "vertical", "depth 10 m", "depth 12 m")),
        ("heading 180", "heading 181", ("changed", ("rows/turn",), "heading", "180°", "181°")),
        ("gear 4 for", "gear 5 for", None),
        ("for 15s", "for 16s", ("changed", ("rows/turn",), "for", "15 s", "16 s")),
        ("timeout 2min", "timeout 3min", ("changed", ("dive",), "timeout", "2 min", "3 min")),
        ("repeat 2", "repeat 3", ("changed", ("rows",), "rounds", "2", "3")),
        ("else surface", "else up", ("changed", ("home_run",), "else", "surface", "up")),
        ("within 15", "within 10", None),
        ("sure 90%", "sure 95%", None),
        ("-> home_run", "-> up", None),
        ("depth > 14", "depth > 13", None),
        ("held 10s", "held 12s", None),
        ("radius 1000", "radius 900", ("changed", ("mission",), "limit of radius", "1000 m", "900 m")),
        ("current 0.2", "current 0.3", ("changed", ("mission",), "assumed current", "0.2", "0.3")),
        ("home 30.2874595", "home 30.2874596", None),
        ("depth >= 9.5", "depth >= 9.50001", None),
    ],
)  # fmt: skip
def test_every_change_of_a_figure_is_one_row(
    old: str, new: str, row: tuple[object, ...] | None, tmp_path: Path
) -> None:
    found = changed(tmp_path, old, new)
    told = [(k, p, w, b.removeprefix("heading "), a.removeprefix("heading ")) for k, p, w, b, a in
            rows(found)]  # fmt: skip
    if row is not None:
        assert told == [row]
    assert len({(w, p) for _, p, w, _, _ in told}) == len(told) <= 2
    assert all(b != a for _, _, _, b, a in told)


@pytest.mark.proof
def test_no_figure_of_a_mission_changes_unseen(tmp_path: Path) -> None:
    source = SURVEY.splitlines(keepends=True)
    (tmp_path / "a.mission").write_text(SURVEY, encoding="utf-8")
    before, seen = prepare(tmp_path / "a.mission"), 0
    for i, line in enumerate(source):
        for number in re.finditer(r"(?<![\w.-])\d+(?:\.\d+)?", line):
            more = f"{float(number[0]) + 1:g}"
            text = "".join(
                [
                    *source[:i],
                    line[: number.start()] + more + line[number.end() :],
                    *source[i + 1 :],
                ]
            )
            (tmp_path / "b.mission").write_text(text, encoding="utf-8")
            try:
                other = prepare(tmp_path / "b.mission")
            except Unreadable:
                continue
            found = changes(before.chart, other.chart, (before.vehicle, other.vehicle))
            assert found.rows, line[: number.start()] + more
            seen += 1
    assert seen > 30


def test_names_are_no_difference_for_the_vehicle(tmp_path: Path) -> None:
    text = SURVEY.replace("turn:", "swing:").replace("home_run", "homeward").replace("rows:", "r:")
    found = compared(tmp_path, SURVEY, text)
    assert found.same
    assert dict(found.renamed) == {
        "rows/out": "r/out", "rows/turn": "r/swing", "rows/back": "r/back", "home_run": "homeward"
    }  # fmt: skip
    assert "no difference for the vehicle" in as_text(found)


def test_a_group_that_neither_repeats_nor_handles_is_no_difference(tmp_path: Path) -> None:
    lines = SURVEY.splitlines()
    i = next(i for i, line in enumerate(lines) if line.startswith("bottom"))
    grouped = [*lines[:i], "group last:", *lines[i : i + 2], "end", *lines[i + 2 :]]
    grouped_text = "\n".join(grouped).replace("on battery < 11", "on battery < 11")
    found = compared(tmp_path, SURVEY, grouped_text)
    assert found.same, rows(found)


def test_a_leg_that_comes_or_goes_is_the_only_row(tmp_path: Path) -> None:
    more = "back: heading 270", "look: heading 45 gear 3 for 9s\nback: heading 270"
    found = changed(tmp_path, *more)
    assert [(r.kind, r.places) for r in found.changes] == [(Kind.ADDED, ("rows/look",))]
    assert found.changes[0].after == "heading 045\u00b0 \u00b7 gear 3 \u00b7 depth 10 m, for 9 s"
    back = compared(tmp_path, SURVEY.replace(*more), SURVEY)
    assert [(r.kind, r.places) for r in back.changes] == [(Kind.REMOVED, ("rows/look",))]


def test_a_leg_that_moves_is_told_as_moved_alone(tmp_path: Path) -> None:
    turn = "turn: heading 180 gear 4 for 15s\n"
    back = "back: heading 270 gear 8 until travelled >= 200 timeout 4min\n"
    found = changed(tmp_path, turn + back, back + turn)
    assert [r.kind for r in found.changes] == [Kind.MOVED]
    assert found.changes[0].places[0] in ("rows/turn", "rows/back")


def test_a_leg_that_leaves_its_rounds_is_told_as_moved(tmp_path: Path) -> None:
    back = "back: heading 270 gear 8 until travelled >= 200 timeout 4min\n"
    text = SURVEY.replace(back, "").replace("end\n", "end\n" + back, 1)
    found = compared(tmp_path, SURVEY, text)
    assert ("moved", ("back",)) in [(r.kind.value, r.places) for r in found.changes]


SCRIPT = """mission script vehicle auv
home 30.2874595 120.1535765
ZAS5
ZAF4
wait 30s
ZAH90
wait 40s
ZAH180
wait 50s
"""


def test_a_line_put_in_shifts_no_generated_name(tmp_path: Path) -> None:
    found = changed(tmp_path, "ZAH180\n", "ZAH135\nwait 5s\nZAH180\n", SCRIPT)
    assert [(r.kind, r.before, r.after.split(",")[0]) for r in found.changes] == [
        (Kind.ADDED, "", "wait")
    ]
    assert not found.renamed


def test_a_handler_and_a_way_are_told_with_their_lines(tmp_path: Path) -> None:
    found = changed(tmp_path, "on battery < 11 held 10s -> up\n", "")
    assert rows(found) == [
        ("removed", ("mission",), "on", "battery < 11 V for 10 s -> up", "")
    ]  # fmt: skip
    assert found.changes[0].lines == ((15, 0),)


def test_an_onward_way_is_told_where_nothing_else_explains_it(tmp_path: Path) -> None:
    found = changed(
        tmp_path, "timeout 90s", "-> up timeout 90s", SURVEY.replace(" -> home_run", "")
    )
    assert [(r.places, r.what) for r in found.changes] == [(("bottom",), "until")]


def test_worst_cases_stand_before_and_after(tmp_path: Path) -> None:
    text = SURVEY.replace("on depth > 14 -> up\n", "").replace("radius 1000", "radius 2000")
    found = changed(tmp_path, "repeat 2", "repeat 3", text)
    figures = {f.name: f for f in found.figures}
    for name in ("time", "energy", "range"):
        figure = figures[name]
        assert figure.before is not None
        assert figure.after is not None
        assert figure.after > figure.before
    assert "refuses it; it passed before" in as_markdown(found)


def test_markdown_holds_its_tables_whatever_a_guard_says(tmp_path: Path) -> None:
    text = as_markdown(changed(tmp_path, "sure 90%", "sure 80%"))
    table = [line for line in text.splitlines() if line.startswith("|")]
    assert "home\\_run" in text
    widths = {re.sub(r"\\\|", "", line).count("|") for line in table}
    assert widths == {7, 5}


def test_the_command_exits_as_diff_does(tmp_path: Path) -> None:
    survey, other = tmp_path / "a.mission", tmp_path / "b.mission"
    survey.write_text(SURVEY)
    other.write_text(SURVEY.replace("gear 6", "gear 7"))
    run = CliRunner().invoke
    assert run(main, ["diff", str(survey), str(survey)]).exit_code == 0
    found = run(main, ["diff", "--json", str(survey), str(other)])
    assert found.exit_code == 1
    told = json.loads(found.stdout)
    assert told["same"] is False
    assert told["before"]["digest"] == digest(load(survey))
    assert told["changes"][0]["lines"] == [{"before": 5, "after": 5}]
    assert told["worst"]["worst_time_s"]["before"] > 0
    assert run(main, ["diff", str(survey), str(tmp_path / "none.mission")]).exit_code == 2
    assert run(main, ["diff", "--json", "--markdown", str(survey), str(other)]).exit_code == 2
