"""Outputs and readings in both mission texts, in check, graph and diff."""

from __future__ import annotations

import json
from dataclasses import replace

import jsonschema
import pytest

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.diff.changes import changes
from mission.authoring.graph.outline import outline
from mission.authoring.graph.tables import tables
from mission.authoring.language import MissionErrors, digest, parse, to_lines, to_yaml
from mission.authoring.language.schema import schema
from mission.engine.engine import Engine
from mission.engine.guards import Sheet
from mission.engine.readings import Scope
from mission.engine.variables import reading_row, value_of
from mission.model import AUTONOMOUS, Chart, Health, Loaded
from mission.model.shipped import load_vehicle
from mission.model.units import GEARS
from mission.model.vehicle import Output, Vehicle
from mission.navigation import Navigation
from protocol.messages import StartMission, Telemetry

ROV = load_vehicle("rov")
AUV = load_vehicle("auv")
LINES = """mission dim vehicle rov
safety time 20min depth 20
assume current 0
start without fix
dive: down 9 output lamp 80 until metal > 50 timeout 30s
stay: down 5 for 5s
dark: down 5 output lamp 0 output servo -10 for 5s
"""
YAML = """mission: dim
vehicle: rov
safety: {time: 20 min, depth: 20 m}
assume: {current: 0}
start: without fix
legs:
  - dive: {down: 9, output: {lamp: 80}, until: metal > 50, timeout: 30 s}
  - stay: {down: 5, for: 5 s}
  - dark: {down: 5, output: {servo: -10, lamp: 0}, for: 5 s}
"""


def chart_of(text: str, vehicle: Vehicle = ROV) -> Chart:
    mission = parse(text, vehicle=vehicle)
    return compile_mission(mission, vehicle, digest(mission))


def refused(text: str, vehicle: Vehicle = ROV) -> tuple[str, str]:
    with pytest.raises(MissionErrors) as caught:
        chart_of(text, vehicle)
    found = caught.value.diagnostics[0]
    return found.code, found.message


def levels(chart: Chart) -> dict[str, dict[str, float]]:
    return {s.path.partition("/")[2]: dict(s.outputs) for s in chart.states if s.leg}


def test_both_texts_say_the_same_and_come_back() -> None:
    lines, yaml = parse(LINES), parse(YAML)
    assert lines == yaml
    assert digest(lines) == digest(yaml)
    assert parse(to_yaml(lines)) == lines
    assert parse(to_lines(lines)) == lines
    assert "dark: down 5 output lamp 0 output servo -10 for 5\n" in to_lines(lines)


def test_an_output_keeps_its_value_until_another_leg_or_an_ascent() -> None:
    assert levels(chart_of(LINES)) == {
        "dive": {"lamp": 80.0, "servo": 0.0},
        "stay": {"lamp": 80.0, "servo": 0.0},
        "dark": {"lamp": 0.0, "servo": -10.0},
        "surface": {"lamp": 0.0, "servo": 0.0},
    }


@pytest.mark.parametrize("rule", ["resurface 1", "unsure 15"])
@pytest.mark.parametrize(
    ("before", "own"), [(80, ""), (0, "output lamp 80"), (80, "output lamp 0")]
)
def test_an_output_is_one_in_all_rows_and_on_the_ways_up_between_them(
    rule: str, before: int, own: str
) -> None:
    lit = replace(AUV, outputs=(Output("lamp", "led_pct", 0, 100, 0),))
    made = levels(
        chart_of(
            f"mission m vehicle auv\nhome 30 120\nlamp: gear 0 output lamp {before} for 5\n"
            "mow: rows 3 bearing 0 length 50 spacing 10 from north 0 east 0 gear 8 depth 4 "
            f"{rule} {own} timeout 30min\nnext: gear 4 depth 4 heading 0 for 5\nup: surface for 9",
            lit,
        )
    )
    wanted = float(own.rpartition(" ")[2] or before)
    rows = {path: level["lamp"] for path, level in made.items() if path.startswith("mow/")}
    assert len([path for path in rows if "fix" in path]) == 2
    assert set(rows.values()) == {wanted}
    assert made["next"]["lamp"] == wanted
    assert made["up"]["lamp"] == 0.0


def test_a_bare_line_sets_what_the_legs_behind_it_keep() -> None:
    text = LINES.replace("stay: down 5 for 5s", "output servo 3\nstay: down 5 for 5s")
    assert levels(chart_of(text))["stay"] == {"lamp": 80.0, "servo": 3.0}


def test_ways_that_bring_different_values_have_to_be_told_apart() -> None:
    text = LINES.replace("until metal > 50", "until metal > 50 -> dark").replace(
        "output lamp 0 ", ""
    )
    other = text.replace("stay: down 5 for", "stay: down 5 output lamp 3 for")
    assert levels(chart_of(text))["dark"]["lamp"] == 80.0
    rule, message = refused(other)
    assert rule == "axis-conflict"
    assert message == (
        "dark omits output lamp, and the ways into it bring different values: "
        "80 from dive, 3 from stay"
    )


@pytest.mark.parametrize(
    ("old", "new", "rule", "message"),
    [
        ("lamp 80", "beam 80", "unknown-output", "rov has no output beam"),
        ("lamp 80", "lamp 101", "output-range", "lamp 101 is outside 0 to 100 %"),
        ("lamp 80", "lamp 0.5", "output-range", "lamp 0.5 is not a whole number"),
        ("lamp 80", "lamp 80 %", "unit", "output lamp takes a bare number, not one in %"),
        ("lamp 80", "hold_depth 1", "axis-clash", "output hold_depth and heave exclude each other"),
        ("lamp 0 output servo -10", "lamp 0 output lamp 1", "twice", "output lamp appears twice"),
        ("metal > 50", "usbl1 > 50", "unknown-variable", "unknown variable 'usbl1'"),
        ("metal > 50", "metal > 50 m", "unit", "metal takes a bare number, not one in m"),
    ],
)
def test_what_no_vehicle_file_allows_is_refused(
    old: str, new: str, rule: str, message: str
) -> None:
    assert old in LINES
    assert refused(LINES.replace(old, new)) == (rule, message)


def test_no_mission_sets_what_a_limit_needs_or_what_cannot_be_taken_back() -> None:
    text = "mission m vehicle coreboard\nstart without fix\nassume current 0\na: output {} for 5s\n"
    core = load_vehicle("coreboard")
    rule, message = refused(text.format("ins 0"), core)
    assert (rule, message.partition(":")[0]) == ("needed-output", "no mission may set ins")
    usbl = replace(core.outputs[0], irreversible=True)
    weight = replace(core, outputs=(usbl, *core.outputs[1:]))
    assert refused(text.format("usbl 1"), weight)[0] == "irreversible"


def test_the_schema_takes_outputs_as_a_table_of_numbers() -> None:
    leg = {"down": 5, "output": {"lamp": 80, "servo": "-10"}, "for": "5 s"}
    jsonschema.validate({"mission": "m", "legs": [{"a": leg}]}, schema())
    for wrong in ({}, {"la mp": 1}, {"lamp": [1]}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(
                {"mission": "m", "legs": [{"a": {**leg, "output": wrong}}]}, schema()
            )


def test_a_picture_and_a_table_show_them() -> None:
    chart = chart_of(LINES)
    shown = json.loads(tables(chart))["states"]
    assert {s["path"]: s["outputs"] for s in shown if "outputs" in s}["autonomous/dark"] == {
        "lamp": 0.0,
        "servo": -10.0,
    }
    assert "lamp 80" in str(outline(chart))


def test_a_difference_is_told_by_leg_and_none_is_told_where_the_vehicle_sees_none() -> None:
    before = chart_of(LINES)
    after = chart_of(LINES.replace("lamp 80", "lamp 60"))
    rows = changes(before, after, (ROV, ROV)).rows
    assert [(r.places, r.what, r.before, r.after) for r in rows] == [
        (("dive", "stay"), "output lamp", "80", "60")
    ]
    named = LINES.replace("for 5s\ndark", "output hold_heading 0 for 5s\ndark")
    assert changes(before, chart_of(named), (ROV, ROV)).rows == ()


# --- readings ------------------------------------------------------------------------------------


def asked(report: Telemetry | None, now: float = 1.0) -> float | None:
    ((name, source),) = chart_of(LINES).sources
    scope = Scope(now, None, report, lambda s: Health(True, "", 0.0), 0, 0, 0, 1, lambda: None)
    return value_of(reading_row(name, source), scope)


def test_a_reading_is_what_the_newest_report_says_and_unknown_when_it_is_old() -> None:
    report = Telemetry(1.0, board=(("metal_pct", 60.0),))
    assert asked(report) == 60.0
    assert asked(report, 7.1) is None
    assert asked(Telemetry(1.0)) is None
    assert asked(None) is None


def test_a_guard_on_a_reading_opens_when_it_holds() -> None:
    chart = chart_of(LINES)
    sheet = Sheet(chart.sources)
    guard = next(e.guard for e in chart.edges if e.guard is not None)
    test = sheet.add(guard)
    for level, holds in ((51.0, True), (50.0, False)):
        report = Telemetry(1.0, board=(("metal_pct", level),))
        scope = Scope(1.0, None, report, lambda s: Health(True, "", 0.0), 0, 0, 0, 1, lambda: None)
        assert test.test(sheet.values(scope), scope) is holds


def test_the_vehicle_that_flies_says_which_readings_there_are() -> None:
    other = replace(ROV, readings={"iron": "metal_pct"})
    assert chart_of(LINES.replace("metal", "iron"), other).sources[0][0] == "iron"
    assert refused(LINES, other)[0] == "unknown-variable"


def test_a_speed_is_made_by_the_gears_of_the_vehicle_that_flies() -> None:
    text = LINES.replace("down 5 for 5s", "down 5 speed 0.4 for 5s")
    table = ROV.speed_by_gear
    slow = replace(ROV, speed_by_gear=replace(table, y=tuple(y / 2 for y in table.y)))
    for vehicle in (ROV, slow):
        surge = max(state.setpoint.surge or 0.0 for state in chart_of(text, vehicle).states)
        assert surge == vehicle.gear_near(0.4) / GEARS
    assert ROV.gear_near(0.4) < slow.gear_near(0.4)
    too_fast = refused(LINES.replace("down 5 for 5s", "down 5 speed 0.6 for 5s"), slow)
    assert too_fast[0] == "too-fast"


def test_what_a_mission_asks_of_the_vehicle_file_is_told_like_every_variable() -> None:
    engine = Engine(ROV, None)
    engine.step(1.0, [Loaded(chart_of(LINES))])
    engine.step(2.0, [Telemetry(2.0, board=(("metal_pct", 60.0),))])
    assert (engine.readings["metal"].value, engine.readings["metal"].valid) == (60.0, True)


@pytest.mark.parametrize("started", [False, True])
def test_no_guard_goes_by_a_report_that_the_vehicle_file_calls_stale(started: bool) -> None:
    quick = replace(ROV, stale_after=1.0)
    engine = Engine(quick, Navigation(quick))
    engine.step(1.0, [Loaded(chart_of(LINES, quick))])
    for t in (2.0, 2.5, 3.0):
        report = Telemetry(t, depth=0.1 + 0.01 * t, heading=1.0, board=(("metal_pct", 60.0),))
        engine.step(t, [report])
    engine.step(3.1, [StartMission()] if started else [])
    assert (engine.region == AUTONOMOUS) is started
    for name in ("metal", "speed", "depth"):
        assert engine.readings[name].valid, name
    engine.step(4.1)
    for name in ("metal", "speed", "depth"):
        assert engine.readings[name].reason == "stale", name


def test_a_trend_of_a_reading_is_known_to_the_vehicle_that_has_it() -> None:
    rising = LINES.replace("metal > 50", "metal rises 20 within 30 s")
    assert chart_of(rising).sources[0][0] == "metal"
    assert to_lines(parse(rising, vehicle=ROV)).count("metal rises 20 within 30 s") == 1
    assert refused(rising.replace("20 within", "20 m within"))[0] == "unit"
    assert refused(rising.replace("20 within", "-1 within"))[0] == "range"
