"""A refusal for time or energy names the share of each leg, and changes that are enough."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.model.diagnostics import Diagnostic
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle

AUV = load_vehicle("auv")
ROUNDS = (
    "mission m vehicle auv\nsafety time {time}\nstart without fix\n"
    "out: depth 3 heading 0 gear 1 for {out}\n"
    "repeat {rounds} laps:\n  lap: heading 90 gear 1 for {lap}\n  turn: heading 270 for 10\nend\n"
)


def refused(text: str, vehicle: Vehicle = AUV) -> dict[str, Diagnostic]:
    mission = parse(text)
    chart = compile_mission(mission, vehicle, digest(mission))
    return {r.code: r for r in check_mission(chart, vehicle).refusals}


def text(time: str = "30min", out: float = 300, rounds: int = 5, lap: float = 600) -> str:
    return ROUNDS.format(time=time, out=out, rounds=rounds, lap=lap)


def test_the_share_of_each_leg_and_of_the_ascent_is_told() -> None:
    hint = refused(text())["time"].hint
    assert re.search(r"laps/lap 50\.0 min \(8\d%, 5 times\)", hint)
    assert "out 5.0 min" in hint
    assert "the ascent" in hint
    shares = [int(n) for n in re.findall(r"\((\d+)%", hint)]
    assert sum(shares) == pytest.approx(100, abs=3)


def test_the_changes_that_are_told_are_enough_and_one_less_is_not() -> None:
    hint = refused(text())["time"].hint
    clock = float(re.search(r"for (\S+) s in laps/lap \(now 600 s\)", hint)[1])  # type: ignore[index]
    rounds = int(re.search(r"repeat (\d+) laps \(now 5\)", hint)[1])  # type: ignore[index]
    minutes = int(re.search(r"or safety time (\d+) min", hint)[1])  # type: ignore[index]
    assert "time" not in refused(text(lap=clock))
    assert "time" in refused(text(lap=clock + 2))
    assert "time" not in refused(text(rounds=rounds))
    assert "time" in refused(text(rounds=rounds + 1))
    assert "time" not in refused(text(time=f"{minutes}min"))
    assert "time" in refused(text(time=f"{minutes - 1}min"))


def test_what_takes_the_energy_is_told_in_watt_hours_and_with_what_is_enough() -> None:
    small = replace(AUV, battery=replace(AUV.battery, usable=40 * 3600.0))
    plain = text(time="2h")
    found = refused(plain, small)["energy"]
    assert re.search(r"laps/lap \d+ Wh \(8\d%, 5 times\)", found.hint)
    clock = float(re.search(r"for (\S+) s in laps/lap", found.hint)[1])  # type: ignore[index]
    assert "energy" not in refused(text(time="2h", lap=clock), small)
    assert "energy" in refused(text(time="2h", lap=clock + 2), small)
    assert found.path


def test_no_change_is_told_where_none_is_enough() -> None:
    hint = refused(text(time="1min"))["time"].hint
    assert "enough would be" not in hint
    assert "laps/lap" in hint


def test_a_change_that_leaves_another_way_too_long_is_not_told() -> None:
    lines = (
        "mission m vehicle auv\nsafety time {time}s\nstart without fix\n"
        "s: depth 3 heading 0 gear 1 until depth > 2 -> c timeout 20 else b\n"
        "c: until depth > 9 -> surface timeout 950\n"
        "b: for 1000\n"
    )
    mission = parse(lines.format(time=3000))
    proved = check_mission(compile_mission(mission, AUV, digest(mission)), AUV).proved
    assert proved is not None
    hint = refused(lines.format(time=round(proved.worst_time - 100)))["time"].hint
    assert hint.startswith("of it: b 16.7 min")
    assert "in b (now" not in hint


ROWS = (
    "mission m vehicle auv\nsafety time {time} depth 12\nstart without fix\n"
    "mow: rows 4 bearing 90 length 150 spacing 20 from north 9 east 0 resurface {fixes} gear 4\n"
    "+ depth 6 timeout {clock}\n"
)


@pytest.mark.parametrize("fixes", [1, 2])
def test_rows_that_resurface_are_told_the_clock_that_their_author_wrote(fixes: int) -> None:
    plain = ROWS.format(time="65min", fixes=fixes, clock="1h")
    found = re.search(r"timeout (\d+) s in mow \(now 3600 s\)", refused(plain)["time"].hint)
    assert found
    for clock, short in ((int(found[1]), True), (int(found[1]) + 2, False)):
        tried = refused(ROWS.format(time="65min", fixes=fixes, clock=f"{clock}s"))
        assert ("time" not in tried) == short
