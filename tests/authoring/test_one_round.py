"""All errors of all stages that can be known are told in one round, and none that is not known."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.authoring.language import draft
from mission.authoring.prepare import Unreadable, charted, prepare
from mission.commands.check import check
from mission.model.diagnostics import Stage
from mission.model.shipped import load_vehicle, missions_folder

AUV = load_vehicle("auv")

LINES = (
    "mission m vehicle auv\n"
    "a: dpeth 5 heading 0 gear 4 timeout 60\n"  # text
    "b: depth 5 heading 0 gear 4\n"  # compile: no clock
    "c: depth 9000 until leak > 0 timeout 60\n"  # compile: too deep; the AUV reports no leak
    "d: goto 30.28 120.15 gear 4 timeout 60\n"  # check: no home
)
YAML = (
    "mission: m\nlegs:\n"
    "  - a: {dpeth: 5 m, heading: 0, gear: 4, timeout: 60 s}\n"
    "  - b: {depth: 5 m, heading: 0, gear: 4}\n"
    "  - c: {depth: 9000 m, until: leak > 0, timeout: 60 s}\n"
    "  - d: {goto: {latitude: 30.28, longitude: 120.15}, gear: 4, timeout: 60 s}\n"
)
WANTED = [
    ("text", "unknown-word", 0),
    ("compile", "no-time-bound", 1),
    ("compile", "too-deep", 2),
    ("compile", "never-known", 2),
    ("check", "no-home", 3),
]


def told(text: str) -> list[tuple[str, str, int]]:
    found = charted(draft(text, "m"), AUV).found
    return [(d.stage.value, d.code, d.where.line) for d in found]


@pytest.mark.parametrize(("text", "first"), [(LINES, 2), (YAML, 3)], ids=["lines", "yaml"])
def test_errors_of_all_stages_are_told_in_one_round(text: str, first: int) -> None:
    wanted = [(stage, code, first + line) for stage, code, line in WANTED]
    assert sorted(told(text)) == sorted(wanted)
    stages = [Stage(stage) for stage, _, _ in told(text)]
    assert stages == sorted(stages, key=list(Stage).index)


@pytest.mark.parametrize(
    "text",
    [
        # what a leg keeps from one that cannot be read is not known
        "a: depth 5 heading 0 gaer 4 timeout 60\ng: goto north 10 east 20 timeout 60\n",
        "a: altitude 3 haeding 0 timeout 60\nb: depth 5 timeout 60\nc: gear 4 timeout 60\n",
        # a home that cannot be read is a home
        "mission m vehicle auv\nhome 30.28 east\na: goto 30.2 120.1 gear 4 timeout 60\n",
        # the clock of a leg may stand in what cannot be read
        "a: depth 5 heading 0 gear 4 timeuot 60\n",
        "a: depth 5 gear 4\n  + timeuot 60\n",
        "mission: m\nlegs:\n  - a:\n      depth: 5 m\n      timeuot: 60 s\n",
        # a leg that cannot be read is a leg, and a target
        "a: gear 4 until depth > 3 -> b timeout 9\nb: dpeth 3\n",
    ],
)
def test_what_a_broken_statement_may_have_said_is_not_complained_of(text: str) -> None:
    found = told(text)
    assert len(found) == 1, found
    assert found[0][0] == "text"


def test_what_refuses_a_mission_whatever_its_legs_set_is_told_with_what_the_compiler_finds() -> (
    None
):
    text = (
        "a: depth 9000 heading 0 gear 4 until depth > 3 -> c timeout 60\n"
        "b: wait 5\n"
        "c: goto 30.28 120.15 gear 4 timeout 60\n"
        "on timeout -> c\n"
    )
    assert {(stage, code) for stage, code, _ in told(text)} == {
        ("compile", "too-deep"),
        ("check", "unreachable"),
        ("check", "no-home"),
        ("check", "no-way-up"),
    }


def test_a_vehicle_file_and_a_mission_that_are_wrong_are_told_together(tmp_path: Path) -> None:
    auv = (missions_folder() / "vehicles" / "auv.yaml").read_text(encoding="utf-8")
    (tmp_path / "mine.yaml").write_text(auv.replace("dive_rate: 0.35", "diverate: 0.35"))
    (tmp_path / "m.mission").write_text(LINES)
    with pytest.raises(Unreadable) as caught:
        prepare(tmp_path / "m.mission", str(tmp_path / "mine.yaml"))
    found = caught.value.diagnostics
    assert {d.stage for d in found} == {Stage.VEHICLE, Stage.TEXT}
    assert {Path(d.file).name for d in found} == {"mine.yaml", "m.mission"}


def test_check_tells_a_program_stage_code_and_place_of_each(tmp_path: Path) -> None:
    path = tmp_path / "m.mission"
    path.write_text(LINES)
    ran = CliRunner().invoke(check, [str(path), "--json"])
    assert ran.exit_code == 2
    refusals = json.loads(ran.stdout.splitlines()[-1])["refusals"]
    assert [(r["stage"], r["code"]) for r in refusals] == [(s, c) for s, c, _ in WANTED]
    for refusal in refusals:
        assert refusal["file"] == str(path)
        assert refusal["message"]
        assert refusal["hint"]
        line = LINES.split("\n")[refusal["line"] - 1]
        assert line[refusal["column"] - 1 :][: refusal["length"]].strip()
