"""Laws of setpoints between the steps of a vehicle's words: refused or stated, never in secret."""

from __future__ import annotations

import math

import pytest
from engine_world import VEHICLE, compiled, leg, mission, sets, when
from hypothesis import example, given
from hypothesis import strategies as st

from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import MissionErrors
from mission.authoring.compiler.granularity import rounded
from mission.authoring.language import parse
from mission.authoring.prepare import Unreadable, prepare
from mission.legs import Hold, Yoyo
from mission.model import Leg, Set
from protocol.messages import Setpoint
from protocol.vehicles import VEHICLES, codec

HELD = sets(surge=0.5, heading=1.0, depth=5.0)


def problems(*body) -> list[tuple[str, str, str]]:
    with pytest.raises(MissionErrors) as caught:
        compiled(mission(*body))
    return [(p.code, p.message, p.hint) for p in caught.value.diagnostics]


def assumed(text: str) -> list[str]:
    from mission.authoring.compiler.compiler import compile_mission
    from mission.authoring.language import digest

    read = parse(text)
    return list(check_mission(compile_mission(read, VEHICLE, digest(read)), VEHICLE).assumed)


def test_a_depth_that_cannot_be_told_is_refused_with_both_neighbours():
    assert problems(leg("a", settings=sets(surge=0.5, heading=1.0, depth=4.5))) == [
        (
            "between-steps",
            "auv cannot be told depth 4.5 m: it would hold 4 m",
            "write 4 m or 5 m",
        )
    ]


def test_an_altitude_and_the_depths_of_a_profile_are_refused_alike():
    held = sets(surge=0.5, heading=1.0, altitude=2.5)
    assert [p[0] for p in problems(leg("a", settings=held))] == ["between-steps"]
    yoyo = leg("y", kind=Yoyo(1, 2.5, 6.0), settings=sets(surge=0.5, heading=1.0))
    assert "depth 2.5 m" in problems(yoyo)[0][1]


def test_it_stands_where_the_author_wrote_it(tmp_path):
    file = tmp_path / "m.yaml"
    file.write_text("mission: m\nlegs:\n  - a: {depth: 4.5 m, heading: 90, gear: 4, for: 20 s}\n")
    with pytest.raises(Unreadable) as caught:
        prepare(file)
    (problem,) = caught.value.diagnostics
    assert (problem.where.line, problem.offending) == (3, "depth")


def test_a_kept_value_is_complained_of_once_and_a_stated_one_each_time():
    body = (
        Set("s", sets(surge=0.5, heading=1.0, depth=4.5)),
        leg("a", when("depth", ">", 1), settings=()),
        leg("b", when("depth", ">", 1), settings=()),
    )
    assert len(problems(*body)) == 1
    again = parse("a: depth 4.5 heading 0 gear 4 for 5\nb: depth 5 for 5\nc: depth 4.5 for 5\n")
    with pytest.raises(MissionErrors) as caught:
        compiled(again)
    assert [p.where.line for p in caught.value.diagnostics] == [1, 3]


def test_what_the_sensor_cannot_tell_apart_is_stated_by_the_check():
    text = "mission m\nhome 30 120\nsafety radius 900 time 10min depth 20 voltage 10\n"
    rows = assumed(text + "a: depth 5 heading 92.5 gear 4 for 20\nb: depth 4.05 for 20\n")
    assert "heading 92.5 deg is sent as 92 deg, the nearest that auv can be told" in rows
    assert "depth 4.05 m is sent as 4 m, the nearest that auv can be told" in rows
    assert not [
        row for row in assumed(text + "a: depth 5 heading 92 gear 4 for 20\n") if "sent" in row
    ]


def test_a_heading_that_the_leg_steers_is_no_concern_of_the_author():
    steered = (
        "mission m\nhome 30 120\nsafety radius 900 time 20min depth 20 voltage 10\n"
        "g: goto north 50 east 30 gear 6 depth 5 timeout 5min\n"
    )
    assert not [row for row in assumed(steered) if "sent" in row]


@given(st.integers(0, 60), st.integers(0, 359))
def test_whole_metres_and_degrees_are_never_complained_of(depth: int, heading: int):
    exact = Setpoint(surge=0.5, heading=math.radians(heading), depth=float(depth))
    assert not list(rounded(Leg("a", Hold()), exact, VEHICLE))


def south(frames: list[bytes]) -> list[bytes]:
    """180 and -180 degrees are one heading."""
    return [frame.replace(b"H-180", b"H180") for frame in frames]


@example(0.0, -3.140625)
@given(st.floats(0.0, 60.0), st.floats(-math.pi, math.pi))
def test_the_nearest_is_what_the_codec_sends(depth: float, heading: float):
    wanted = Setpoint(surge=0.5, heading=heading, depth=depth)
    found = {r.word: r.nearest for r in rounded(Leg("a", Hold()), wanted, VEHICLE)}
    told = Setpoint(
        surge=0.5,
        heading=math.radians(found["heading"]) if "heading" in found else heading,
        depth=found.get("depth", depth),
    )
    for dialect in ("as-built", "documented"):
        made = codec("auv", dialect, {})
        assert south(made.encode(wanted)) == south(made.encode(told))


@pytest.mark.parametrize("row", list(VEHICLES.values()), ids=lambda r: r.name)
@pytest.mark.parametrize("axis", ["depth", "altitude", "heading"])
def test_every_vehicle_tells_apart_what_it_says_it_does(row, axis):
    """Half a step and more is heard; where no step is named, a centimetre and a milliradian are."""
    step = getattr(row.granularity, axis) or (1e-3 if axis == "heading" else 1e-2)
    base = {"surge": 0.5, "heading": 0.0, "depth": 3.0}
    if axis == "altitude":
        base = {"surge": 0.5, "heading": 0.0, "altitude": 3.0}
    made = codec(row.name, row.dialects[0], {})
    try:
        first = made.encode(Setpoint(**base))
        other = made.encode(Setpoint(**base | {axis: base[axis] + 0.6 * step}))
    except ValueError:
        pytest.skip(f"{row.name} holds no {axis}")
    assert first != other
    if getattr(row.granularity, axis):
        assert made.encode(Setpoint(**base | {axis: base[axis] + 0.4 * step})) == first
