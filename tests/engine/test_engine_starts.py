"""R5, R6, R9 at their bounds: what an operator may order, to the last second and metre."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from engine_world import HOME, VEHICLE, M, W, World, X, leg, mission, sets

from mission.legs import Yoyo
from mission.model import IDLE_READY, MANUAL_DRIVING, STOPPED, SURFACING, NavigationMode, Restarted
from mission.navigation.fixes import metres
from protocol.messages import ClearMission, Emergency, Manual, Order, SetSafety, StartMission

MISSION = mission(leg("a", timeout=600.0), leg("b"))


def refusal(world: World, command: object) -> str:
    """Why not; "" if it was accepted."""
    (verdict,) = world.tell(command).verdicts
    assert verdict.accepted or verdict.why
    return verdict.why if not verdict.accepted else ""


def pushed(world: World, *, every: float = 0.2) -> str:
    """The same of the second M of a push."""
    first = refusal(world, M)
    world.t += every
    return refusal(world, M) if first else ""


# --- the stick ------------------------------------------------------------------------------


def test_the_stick_takes_over_from_an_emergency_after_just_two_seconds_without_one():
    for pause, may in ((1.999, False), (2.0, True)):
        world = World()
        world.tell(world.report(), M)
        world.tell(X)
        world.wait(pause, reports=False)
        assert (pushed(world) == "") is may
        assert (world.state == MANUAL_DRIVING) is may


def test_words_of_a_held_stick_that_have_waited_take_no_emergency_over():
    """The radio was away or the Pi stood still: what it says in 3 s comes in a tenth of one, and
    then it goes on."""
    for at_once in (15, 4, 3):
        world = World()
        world.tell(X)
        world.wait(3.0, reports=False)
        for _ in range(at_once):
            assert refusal(world, M) != ""
            world.t += 0.01
        for _ in range(20):
            world.t += 0.2
            held = refusal(world, M)
        assert (held != "", world.state) == (
            (True, STOPPED) if at_once > 3 else (False, MANUAL_DRIVING)
        )
        if at_once > 3:
            world.wait(2.0, reports=False)
            assert pushed(world) == ""


def test_a_push_takes_an_emergency_over_by_its_second_word_that_came_apart():
    for every, taken in ((0.05, False), (0.149, False), (0.15, True), (0.6, True), (1.999, True)):
        world = World()
        world.tell(X)
        world.wait(5.0, reports=False)
        assert (pushed(world, every=every) == "") is taken
    world.tell(X)
    world.wait(5.0, reports=False)
    assert pushed(world, every=2.0) != "", "two pushes"


def test_a_push_that_began_before_the_emergency_takes_none_over():
    world = World()
    world.wait(5.0, reports=False)
    world.tell(M)
    world.tell(X)
    for _ in range(20):
        world.t += 0.2
        assert refusal(world, M) != ""
    assert world.state == STOPPED


def test_the_first_m_ever_takes_over_from_an_emergency_two_seconds_after_it_began():
    world = World()
    together = world.tell(X, M).verdicts
    assert [v.accepted for v in together] == [True, False]
    for pause, taken in ((0.001, False), (1.999, False), (2.0, True)):
        world = World()
        world.tell(X)
        world.t += pause
        assert (pushed(world) == "") is taken


def test_a_restart_forgets_no_stick():
    """What the program before heard of it nobody knows: the first seconds count as not silent."""
    world = World()
    world.tell(Restarted(SURFACING))
    world.wait(1.0)
    assert refusal(world, M) != ""
    world.wait(1.5)
    assert refusal(world, M) != ""
    world.wait(2.0)
    assert pushed(world) == ""


def test_a_stick_that_was_refused_before_it_came_to_the_engine_is_held_all_the_same():
    world = World()
    world.tell(W)
    for _ in range(20):
        world.wait(0.3)
        world.engine.hear_stick(world.t)
    assert pushed(world) != ""
    world.wait(2.0)
    assert refusal(world, M) != ""
    world.t += 0.1
    world.engine.hear_stick(world.t)
    assert pushed(world) != "", "another boat's is held meanwhile"
    assert world.state == SURFACING


@pytest.mark.parametrize(
    "frame",
    [
        ("MM", b"@MMF0$"),
        ("MR", b"@MRL0$"),
        ("MT", b"@MT3,0$"),
        ("MS", b"@MS0,90$"),
        ("MD", b"@MDS3,0$"),
    ],
)
def test_a_neutral_stick_takes_no_emergency_over(frame: tuple[str, bytes]):
    world = World()
    world.tell(W)
    world.wait(5.0)
    assert "neutral" in refusal(world, Manual(*frame))
    assert world.state == SURFACING
    assert refusal(world, M) != ""
    assert "neutral" in refusal(world, Manual(*frame)), "nor does it go on with a push"
    world.t += 0.2
    assert refusal(world, M) != ""
    world.wait(2.0)
    assert pushed(world) == ""


@pytest.mark.parametrize(
    "frame",
    [
        ("MM", b"@MMB3$"),
        ("MR", b"@MRL5$"),
        ("MT", b"@MT1,-10$"),
        ("MS", b"@MS120,0$"),
        ("MP", b"@MP1,0$"),
    ],
)
def test_a_stick_that_asks_for_something_is_not_neutral(frame: tuple[str, bytes]):
    assert not Manual(*frame).neutral


def test_an_m_that_is_refused_counts_as_the_stick_too():
    world = World()
    world.tell(X, M)
    world.wait(1.5)
    assert "still for 2 s" in refusal(world, M)
    world.wait(1.5)
    assert refusal(world, M) != ""
    world.wait(2.0)
    assert pushed(world) == ""


def test_a_mission_starts_just_two_seconds_after_the_stick():
    for pause, may in ((1.999, False), (2.0, True)):
        world = World(MISSION)
        world.tell(world.report(), world.fix())
        world.tell(M)
        world.wait(pause, reports=False)
        assert (refusal(world, StartMission()) == "") is may


# --- limits ---------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [0.0, -1.0, math.inf, math.nan])
@pytest.mark.parametrize("name", ["radius", "time", "depth", "voltage"])
def test_a_limit_is_a_number_greater_than_0(name: str, bad: float):
    world = World()
    before = world.engine.bounds
    assert "greater than 0" in refusal(world, SetSafety(**{name: bad}))
    assert world.engine.bounds == before
    assert refusal(world, SetSafety(**{name: 5e-324})) == ""


def test_what_may_be_cleared_is_said_and_what_may_not_too():
    world = World(MISSION)
    assert world.engine.may_clear
    assert world.start()
    assert not world.engine.may_clear
    assert "a mission runs" in refusal(world, ClearMission())
    world.tell(Emergency(Order.SURFACE))
    world.depth = 5.0
    assert "wait until it is at the surface" in refusal(world, ClearMission())


# --- start ----------------------------------------------------------------------------------


def test_a_vehicle_that_was_heard_five_seconds_ago_may_start_and_later_not():
    for age, may in ((5.0, True), (5.001, False)):
        world = World(MISSION)
        world.tell(world.report())
        world.t += age
        world.tell(world.fix())
        assert (refusal(world, StartMission()) == "") is may


@pytest.mark.parametrize(("down", "may"), [(1.0, False), (0.5, False), (0.49, True), (-1.0, True)])
def test_no_mission_starts_while_reports_say_that_the_verticals_push_down(down: float, may: bool):
    """As flight 14613 of seed 11631: a board dived by itself, and a wave over its 1.4 m made the
    last depth 0.2 m."""
    world = World(MISSION)
    world.stops = False  # its board does not obey
    world.actuators = (0.0, 0.0, -down, -down, -down)
    world.tell(world.report(), world.fix())
    why = refusal(world, StartMission())
    assert why == ("" if may else "the verticals push it down: a mission starts at the surface")


def test_a_vehicle_without_a_depth_of_its_own_needs_none_to_start():
    bare = replace(VEHICLE, reports=VEHICLE.reports - {"depth"})
    body = mission(leg("a", settings=sets(surge=0.5, heading=0.0)))
    for vehicle, may in ((VEHICLE, False), (bare, True)):
        world = World(body, vehicle=vehicle)
        world.depth = None
        world.tell(world.report(), world.fix())
        assert (refusal(world, StartMission()) == "") is may
    assert "missing" in refusal(_without_depth(), StartMission())


def _without_depth() -> World:
    world = World(MISSION)
    world.depth = None
    world.tell(world.report(), world.fix())
    return world


def test_no_mission_starts_that_would_send_a_depth_beyond_the_limit_in_any_leg():
    yoyo = leg("y", kind=Yoyo(3.0, 9.0, 2), settings=sets(surge=0.5, heading=0.0))
    for limit, may in ((9.0, True), (8.9, False)):
        world = World(mission(leg("a"), yoyo))
        world.tell(world.report(), world.fix())
        world.tell(SetSafety(depth=limit))
        why = refusal(world, StartMission())
        assert (why == "") is may
        assert may or why.startswith("y: depth 9 m")


def test_home_may_be_as_far_as_the_radius_in_force():
    world = World(replace(MISSION, assume=(("start", 1000.0),)))
    fix = world.fix(north=30.0, east=40.0)
    home = (math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg))
    far = metres(*home, fix.latitude, fix.longitude)
    assert far == pytest.approx(50.0, abs=0.01)
    world.tell(world.report(), fix)
    world.tell(SetSafety(radius=math.nextafter(far, 0.0)))
    assert refusal(world, StartMission()).startswith("home is 50 m away")
    world.tell(SetSafety(radius=far))
    assert refusal(world, StartMission()) == ""
    assert world.nav.frame.origin == HOME


def test_a_mission_starts_as_far_from_home_as_it_assumes_and_no_farther():
    """Two sigma of a fix, 5 m, is as near as fixes can tell."""
    for assume, within in (((), 25.0), ((("start", 80.0),), 80.0), ((("start", 0.0),), 5.0)):
        for far, may in ((within - 0.1, True), (within + 0.1, False)):
            world = World(replace(MISSION, assume=assume))
            world.tell(world.report(), world.fix(north=far))
            why = refusal(world, StartMission())
            assert (why == "") is may
            assert may or why.startswith(f"home is {far:.0f} m away")
            assert may or f"within {within:g} m of it; go nearer, or let the mission assume" in why
            assert may or world.state == IDLE_READY


def test_a_start_takes_the_current_that_the_mission_assumes_whatever_was_learned():
    for assume, current in (((), VEHICLE.current), ((("current", 0.7),), 0.7)):
        world = World(replace(MISSION, assume=assume))
        world.tell(world.report(), world.fix())
        assert refusal(world, StartMission()) == ""
        assert world.nav.assumed_current == current


def test_how_far_home_is_must_be_known_by_a_fix_of_the_last_five_seconds():
    for age, may in ((None, False), (5.0, True), (5.001, False)):
        world = World(MISSION)
        if age is not None:
            world.tell(world.report(), world.fix())
            world.t += age
        world.tell(world.report())
        why = refusal(world, StartMission())
        assert (why == "") is may
        assert may or "start without fix" in why
        assert world.nav.mode is NavigationMode.FIX  # it was not told to reckon from here


@pytest.mark.parametrize("home", [HOME, None])
def test_places_of_before_a_dive_that_are_said_again_behind_it_start_no_mission(home):
    """The receiver's buffer is not where the vehicle came up, and no home."""
    world = World(replace(MISSION, home=home))
    said = [world.fix(north=0.5 * n) for n in range(5)]
    for again in (0.0, 240.0):
        world.t += again
        world.tell(world.report(), *(replace(fix, t=world.t) for fix in said))
    assert refusal(world, StartMission()).startswith("no fix for 5 s" if home else "no home")
    world.tell(*(world.fix(north=250.0 + 0.5 * n) for n in range(5)))
    assert refusal(world, StartMission())[:13] == ("home is 252 m" if home else "")


@pytest.mark.parametrize("home", [HOME, None])
def test_one_absurd_depth_on_deck_is_no_dive_behind_which_a_new_place_is_asked_for(home):
    """A receiver may hold its place to the last bit at rest."""
    world = World(replace(MISSION, home=home))
    held = [world.fix(north=0.5 * n) for n in range(5)]
    for depth in (0.1, 0.11, 300.0, 0.1, 0.12):
        world.depth, world.t = depth, world.t + 2.0
        world.tell(world.report(), *(replace(fix, t=world.t) for fix in held))
    assert refusal(world, StartMission()) == ""


@pytest.mark.parametrize("home", [HOME, None])
def test_a_receiver_that_got_stuck_as_it_went_under_starts_no_mission_behind_the_dive(home):
    """It says its last place on without a pause, so nothing else tells that this is of before."""
    world = World(replace(MISSION, home=home))
    last = [world.fix(north=0.5 * n) for n in range(5)]
    for depth in (0.1, 0.7, 5.0, 5.01, 0.7, 0.1, 0.11):
        world.depth, world.t = depth, world.t + 2.0
        world.tell(world.report(), *(replace(fix, t=world.t) for fix in last))
    assert refusal(world, StartMission()).startswith("no fix for 5 s" if home else "no home")
    world.tell(*(world.fix(north=250.0 + 0.5 * n) for n in range(5)))
    assert refusal(world, StartMission())[:13] == ("home is 252 m" if home else "")


def test_without_a_fix_a_mission_that_allows_it_reckons_from_where_it_is():
    for home, frame in ((HOME, HOME), (None, None)):
        world = World(mission(leg("a"), home=home, start_without_fix=True))
        world.tell(world.report())
        assert refusal(world, StartMission()) == ""
        assert world.nav.mode is NavigationMode.DEAD_RECKONING
        assert (world.nav.frame.origin if world.nav.frame else None) == frame
        assert world.engine.estimate.mode is NavigationMode.DEAD_RECKONING


@pytest.mark.parametrize(("fixes", "hdop", "age"), [(1, 1.0, 600.0), (5, 1.0, 5.1), (5, 4.0, 0.0)])
def test_home_is_where_it_is_started_and_no_place_of_before(fixes: int, hdop: float, age: float):
    """It was carried, or its fixes are no home: the next fix tells where on the earth that is."""
    world = World(mission(leg("a"), home=None, start_without_fix=True))
    world.nav.set_origin(HOME, world.t)
    world.tell(*(world.fix(0.5 * n, hdop=hdop) for n in range(fixes)))
    world.t += age
    world.tell(world.report())
    assert refusal(world, StartMission()) == ""
    assert world.nav.frame is None
    assert world.nav.mode is NavigationMode.DEAD_RECKONING


def test_a_mission_that_allows_it_still_does_not_start_far_from_home_where_that_is_known():
    world = World(mission(leg("a"), start_without_fix=True))
    world.tell(SetSafety(radius=200.0))
    world.tell(world.report(), world.fix(north=250.0))
    assert "250 m away" in refusal(world, StartMission())
    assert world.state == IDLE_READY


@pytest.mark.parametrize("age", [5.1, 59.0])
def test_a_fix_of_the_last_minute_still_tells_that_home_is_far_and_where_it_begins(age: float):
    for north, said in ((250.0, "250 m away"), (20.0, "")):
        world = World(mission(leg("a"), start_without_fix=True))
        world.tell(SetSafety(radius=200.0))
        world.tell(world.report(), world.fix(north=north))
        world.t += age
        world.tell(world.report())
        assert said in refusal(world, StartMission())
        assert world.state == ("autonomous/a" if not said else IDLE_READY)
        assert world.nav.mode is NavigationMode.FIX


def test_a_fix_that_navigation_never_took_is_no_place_to_reckon_from():
    """It came before navigation was loaded, or was refused: no limit could act by the estimate."""
    for age in (1.0, 20.0):
        world = World(mission(leg("a"), start_without_fix=True))
        world.nav.fix = lambda _: None
        world.tell(world.fix(north=1.0))
        world.t += age
        world.tell(world.report())
        assert refusal(world, StartMission()) == ""
        assert (world.nav.mode, world.nav.within) == (NavigationMode.DEAD_RECKONING, 25.0)


def test_a_home_that_no_fix_has_told_of_is_as_near_as_the_mission_assumes_and_no_nearer():
    for assumed, within in (((), 25.0), ((("start", 60.0),), 60.0)):
        world = World(mission(leg("a"), start_without_fix=True, assume=assumed))
        world.tell(world.fix(north=250.0))
        world.t += 60.1
        world.tell(world.report())
        assert refusal(world, StartMission()) == ""
        assert (world.nav.mode, world.nav.within) == (NavigationMode.DEAD_RECKONING, within)


def test_a_start_in_an_emergency_or_without_a_mission_says_what_to_do():
    world = World()
    assert refusal(world, StartMission()) == "no mission is stored"
    world.tell(X)
    assert "clear it" in refusal(world, StartMission())
    assert world.state == STOPPED
