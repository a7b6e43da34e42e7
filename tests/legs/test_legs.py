"""Laws of legs: one contract over every type, and what each pilot steers."""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import replace

import pytest
from engine_world import Navigation

from mission.authoring.language import MissionErrors, parse, to_yaml
from mission.authoring.language.manual import PARTS
from mission.legs import (
    LEGS,
    Cover,
    Follow,
    Goto,
    Hold,
    LegType,
    Loiter,
    Rows,
    Surface,
    View,
    Wait,
    Yoyo,
    guidance,
)
from mission.legs.rows import corners
from mission.legs.words import Choice, Measure, Spot
from mission.model import Axis, LegKind, Local, Place, Position
from protocol.messages import Setpoint, Telemetry

SQUARE = (Local(0.0, 0.0), Local(0.0, 60.0), Local(60.0, 60.0), Local(60.0, 0.0))
KINDS = (
    Hold(),
    Wait(),
    Goto(Local(100.0, 0.0), 5.0),
    Follow((Local(50.0, 0.0), Local(50.0, 50.0)), 5.0),
    Rows(None, 0.0, 60.0, 10.0, 3, 1, 5.0),
    Cover(SQUARE, -1.0, 10.0, 0.0, 5.0),
    Yoyo(3.0, 9.0, 2),
    Loiter(None, 15.0, 1),
    Surface(),
)
BROKEN = (
    Goto(Local(1.0, 0.0), 0.0),
    Follow((), 5.0),
    Rows(None, 0.0, 60.0, 10.0, 0, 1, 5.0),
    Rows(None, 0.0, -1.0, 10.0, 2, 1, 5.0),
    Cover(SQUARE, -1.0, 0.0, 0.0, 5.0),
    Cover(SQUARE[:2], -1.0, 10.0, 0.0, 5.0),
    Cover(SQUARE, -1.0, 0.1, 0.0, 5.0),
    Cover((*SQUARE[:3], Position(30.0, 120.0)), -1.0, 10.0, 0.0, 5.0),
    Cover(SQUARE, -1.0, 10.0, 0.0, 5.0, skip=6.0),
    Yoyo(9.0, 3.0, 2),
    Yoyo(3.0, 9.0, 0),
    Loiter(None, 1.0, 1),
)
BASE = Setpoint(surge=0.5, depth=4.0)


def place(where: Place) -> tuple[float, float] | None:
    return (where.north, where.east) if isinstance(where, Local) else (0.0, 0.0)


def view(north=0.0, east=0.0, *, speed=0.8, current=(0.0, 0.0), depth=4.0, heading=0.0) -> View:
    nav = Navigation()
    nav.report = Telemetry(1.0, depth=depth, heading=heading)
    nav.north, nav.east, nav.speed, nav.current = north, east, speed, current
    return View(1.0, nav.estimate(1.0), depth, place)


def sail(pilot, seconds: float, *, speed=0.8, current=(0.0, 0.0), start=(0.0, 0.0)):
    """A point that goes where it is told at once: where it was, second by second."""
    (north, east), way = start, []
    for _ in range(int(seconds)):
        at = view(north, east, speed=speed, current=current)
        heading = pilot.setpoint(at).heading
        if pilot.finished(at):
            break
        north += speed * math.cos(heading) + current[0]
        east += speed * math.sin(heading) + current[1]
        way.append((north, east))
    return way


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: type(k).__name__)
def test_every_leg_type_keeps_the_contract(kind):
    row = LEGS[type(kind)]
    assert row.kind is type(kind)
    assert row.fault(kind) == ""
    if row.begin is None:
        return
    pilot = row.begin(kind, BASE, view())
    first = pilot.setpoint(view())
    assert first.surge == BASE.surge
    if Axis.HEADING in row.steers:
        assert first.heading is not None
        assert 0.0 <= first.heading < 2.0 * math.pi
        assert first.depth == BASE.depth
    if Axis.VERTICAL in row.steers:
        assert first.depth in row.depths(kind)
    blind = View(1.0, None, None, lambda p: None)
    row.begin(kind, BASE, blind).setpoint(blind)  # knows nothing, and says so without a crash
    twin = pilot.clone()
    for _ in range(3):
        twin.setpoint(view(1000.0, 1000.0, depth=9.0))
    assert pilot.setpoint(view()) == first


@dataclasses.dataclass(frozen=True, slots=True)
class Coil(LegKind):
    winding: float
    near: Place | None
    hand: int


COIL = LegType(
    name="toycoil",
    kind=Coil,
    description="as a snake does",
    clauses=(
        Measure("winding", "m", 1, 9, "how tight"),
        Spot("near", "near", "where"),
        Choice("hand", {"left": -1, "right": 1}, 1, "which way"),
    ),
)


def test_a_leg_type_is_known_for_as_long_as_it_is_registered():
    text = "mission m\na: toycoil winding 3 near home hand left for 5\n"
    for _ in range(2):
        with pytest.raises(MissionErrors, match="unknown word 'toycoil'"):
            parse(text)
        with LEGS.registered(COIL):
            assert parse(text).body[0].kind == Coil(3.0, "home", -1)
            assert parse(to_yaml(parse(text))) == parse(text)
            assert "toycoil" in PARTS["grammar"]()
        assert "toycoil" not in PARTS["grammar"]()


def test_the_contract_covers_every_row():
    assert {type(k) for k in KINDS} == set(LEGS)


@pytest.mark.parametrize("kind", BROKEN)
def test_figures_that_make_no_sense_are_named(kind):
    assert LEGS[type(kind)].fault(kind)


def test_goto_comes_back_to_its_line_and_arrives_in_a_current():
    pilot = LEGS[Goto].begin(Goto(Local(200.0, 0.0), 5.0), BASE, view())
    way = sail(pilot, 600, current=(0.0, 0.3))
    assert math.hypot(way[-1][0] - 200.0, way[-1][1]) <= 5.0
    assert max(abs(east) for _, east in way) < 1.0  # the crab angle holds it on the line
    assert pilot.finished(view(*way[-1]))


def test_goto_returns_to_the_line_from_off_it():
    pilot = LEGS[Goto].begin(Goto(Local(200.0, 0.0), 5.0), BASE, view())
    pilot.setpoint(view())
    way = sail(pilot, 120, start=(20.0, 30.0))
    assert abs(way[-1][1]) < 2.0


def test_a_current_that_cannot_be_overcome_still_gives_a_heading():
    pilot = LEGS[Goto].begin(Goto(Local(200.0, 0.0), 5.0), BASE, view())
    heading = pilot.setpoint(view(speed=0.3, current=(0.0, 2.0))).heading
    assert heading is not None
    assert math.isfinite(heading)


def test_follow_takes_its_points_in_order_and_passes_a_missed_one():
    kind = Follow((Local(50.0, 0.0), Local(50.0, 50.0)), 5.0)
    pilot = LEGS[Follow].begin(kind, BASE, view())
    pilot.setpoint(view())
    pilot.setpoint(view(60.0, 20.0))  # never within 5 m of the first, but past it
    assert pilot.track(view(50.0, 40.0)).distance == pytest.approx(10.0)
    pilot.setpoint(view(50.0, 47.0))
    assert pilot.finished(view(50.0, 47.0))


def test_rows_are_parallel_as_long_and_as_far_apart_as_asked():
    kind = Rows(None, math.pi / 2, 60.0, 10.0, 3, 1, 5.0)
    points = corners(kind, (0.0, 0.0))
    expected = [(0, 0), (0, 60), (-10, 60), (-10, 0), (-20, 0), (-20, 60)]
    assert [(round(n), round(e)) for n, e in points] == expected
    port = corners(replace(kind, side=-1), (0.0, 0.0))
    assert [(round(n), round(e)) for n, e in port][2] == (10, 60)


def test_loiter_settles_on_its_circle_on_the_side_it_was_told():
    for side in (1, -1):
        kind = Loiter(Local(0.0, 0.0), 15.0, side)
        way = sail(LEGS[Loiter].begin(kind, BASE, view(60.0, 0.0)), 400, start=(60.0, 0.0))
        late = way[200:]
        assert all(abs(math.hypot(*p) - 15.0) < 2.0 for p in late)
        turns = [
            math.atan2(b[1], b[0]) - math.atan2(a[1], a[0]) for a, b in itertools.pairwise(late)
        ]
        assert sum(math.copysign(1, math.remainder(t, math.tau)) for t in turns) * side > 0


def test_yoyo_goes_down_and_up_as_often_as_asked():
    pilot = LEGS[Yoyo].begin(Yoyo(3.0, 9.0, 2), BASE, view())
    depths = (1.0, 8.0, 8.6, 5.0, 3.4, 8.0, 8.7, 4.0, 3.2)
    seen = [pilot.setpoint(view(depth=d)).depth for d in depths]
    assert seen == [9.0, 9.0, 3.0, 3.0, 9.0, 9.0, 3.0, 3.0, 3.0]
    assert pilot.finished(view())


def test_yoyo_does_not_turn_on_a_depth_that_is_not_known():
    pilot = LEGS[Yoyo].begin(Yoyo(3.0, 9.0, 1), BASE, view())
    at = view()
    assert pilot.setpoint(replace(at, depth=None)).depth == 9.0


def test_cross_track_is_positive_to_starboard():
    track = guidance.along((0.0, 0.0), (100.0, 0.0), (50.0, 3.0))
    assert track.cross_track == pytest.approx(3.0)
    assert track.distance == pytest.approx(math.hypot(50.0, 3.0))
