"""Who holds an output when, and what an ascent that gains nothing sets (R18)."""

from __future__ import annotations

import pytest

from mission.engine.outputs import WITHIN, OutputKeeper, Situation
from mission.model import AUTONOMOUS
from mission.model.regions import EMERGENCY, IDLE, MANUAL
from mission.model.vehicle import Output

LAMP = Output("lamp", "led_pct", 0, 100, 5)
TILT = Output("tilt", "servo_deg", -30, 30, 0)
HOLD = Output("hold", "hold_depth", 0, 1, 0, excludes=("heave",))
WEIGHT = Output("weight", "passthrough1", 0, 1, 0, irreversible=True, ascent=1.0)


def at(region: str, **held: float) -> Situation:
    return Situation(region, 0.0, held, False, False)


def keeper(*outputs: Output) -> OutputKeeper:
    """Of a program that has told them all that they are safe."""
    one = OutputKeeper(outputs or (LAMP, TILT, WEIGHT))
    one.changes(at(EMERGENCY))
    return one


def test_the_first_emergency_of_a_program_says_the_safe_words_of_what_can_be_taken_back() -> None:
    """Whatever the program before it has told them."""
    one = OutputKeeper((LAMP, TILT, WEIGHT))
    assert one.told("lamp") is None
    assert one.changes(at(IDLE)) == {}
    assert one.changes(at(EMERGENCY)) == {"lamp": 5.0, "tilt": 0.0}
    assert one.told("lamp") == 5.0


def test_a_mission_says_what_it_names_though_it_be_safe() -> None:
    one = OutputKeeper((LAMP, TILT))
    assert one.changes(at(AUTONOMOUS, lamp=5.0)) == {"lamp": 5.0}


def test_what_an_operators_own_word_has_set_is_made_safe_by_the_next_emergency() -> None:
    one = keeper()
    one.changes(at(IDLE))
    one.pass_by({"led_pct"})
    assert one.told("lamp") is None
    assert one.changes(at(IDLE)) == {}
    assert one.changes(at(EMERGENCY)) == {"lamp": 5.0}


def test_an_operators_own_word_behind_an_emergency_stands_until_the_next() -> None:
    one = keeper()
    one.pass_by({"led_pct"})
    assert one.changes(at(EMERGENCY)) == {}
    assert one.told("lamp") is None
    assert one.changes(Situation(EMERGENCY, 9.0, {}, False, False)) == {"lamp": 5.0}


def test_at_rest_nothing_is_said_that_nobody_asked_for() -> None:
    one = keeper()
    assert one.changes(at(IDLE)) == {}
    one.set_by_hand("lamp", 50.0)
    assert one.changes(at(IDLE)) == {"lamp": 50.0}
    assert one.changes(at(IDLE)) == {}
    one.set_by_hand("lamp", 50.0)
    assert one.changes(at(IDLE)) == {"lamp": 50.0}  # asked again


def test_a_mission_holds_what_it_names_and_leaves_it_safe() -> None:
    one = keeper()
    one.set_by_hand("lamp", 50.0)
    one.set_by_hand("tilt", 7.0)
    one.changes(at(IDLE))
    assert one.changes(at(AUTONOMOUS, lamp=80.0)) == {"lamp": 80.0}
    assert one.why_not("lamp", 1.0, at(AUTONOMOUS, lamp=80.0)) == "the mission holds lamp"
    assert one.why_not("tilt", 1.0, at(AUTONOMOUS, lamp=80.0)) == ""
    assert one.changes(at(IDLE)) == {"lamp": 5.0}


def test_the_stick_takes_over_what_it_finds_and_a_resumed_mission_has_its_own_again() -> None:
    one = keeper()
    one.changes(at(AUTONOMOUS, lamp=80.0))
    assert one.changes(at(MANUAL, lamp=80.0)) == {}
    assert one.why_not("lamp", 20.0, at(MANUAL, lamp=80.0)) == ""
    one.set_by_hand("lamp", 20.0)
    assert one.changes(at(MANUAL, lamp=80.0)) == {"lamp": 20.0}
    assert one.changes(at(AUTONOMOUS, lamp=80.0)) == {"lamp": 80.0}


def test_the_stick_makes_safe_at_once_what_the_mission_moves_or_holds_the_vehicle_with() -> None:
    one = keeper(LAMP, HOLD)
    held = {"lamp": 80.0, "hold": 1.0}
    one.changes(at(AUTONOMOUS, **held))
    driving = Situation(MANUAL, 0.0, held, True, False)
    assert one.changes(driving) == {"hold": 0.0}
    one.set_by_hand("hold", 1.0)
    assert one.changes(driving) == {"hold": 1.0}


def test_what_the_stick_has_found_is_safe_behind_it_unless_it_was_set_by_hand_since() -> None:
    one = keeper()
    one.changes(at(AUTONOMOUS, lamp=80.0, tilt=9.0))
    one.set_by_hand("tilt", 7.0)
    assert one.changes(at(MANUAL, lamp=80.0, tilt=9.0)) == {"tilt": 7.0}
    assert one.changes(at(IDLE)) == {"lamp": 5.0}


def test_the_end_of_the_program_makes_safe_what_the_stick_has_found() -> None:
    one = keeper()
    one.changes(at(AUTONOMOUS, lamp=80.0))
    one.changes(at(MANUAL, lamp=80.0))
    assert one.changes(Situation(MANUAL, 0.0, {}, True, True)) == {"lamp": 5.0}


def test_an_emergency_makes_every_output_safe_once_and_what_was_set_does_not_come_back() -> None:
    one = keeper()
    one.set_by_hand("lamp", 50.0)
    one.changes(at(IDLE))
    assert one.changes(at(EMERGENCY)) == {"lamp": 5.0}
    assert one.changes(at(EMERGENCY)) == {}
    assert one.changes(at(IDLE)) == {}
    one.doubt()  # nobody knows what they are
    assert one.changes(at(IDLE)) == {}
    assert one.changes(at(EMERGENCY)) == {"lamp": 5.0, "tilt": 0.0}


def test_the_end_of_the_program_makes_safe_what_was_set() -> None:
    one = keeper()
    one.set_by_hand("lamp", 50.0)
    one.changes(at(IDLE))
    ending = Situation(IDLE, 0.0, {}, False, True)
    assert one.changes(ending) == {"lamp": 5.0}
    assert one.why_not("lamp", 1.0, ending)


def test_behind_a_line_that_was_away_all_that_is_held_is_said_again() -> None:
    one = keeper()
    one.changes(at(AUTONOMOUS, lamp=80.0))
    one.doubt()
    assert one.changes(at(AUTONOMOUS, lamp=80.0)) == {"lamp": 80.0}


def test_what_was_set_before_the_line_was_away_is_made_safe_all_the_same() -> None:
    one = keeper(HOLD)
    driving = Situation(MANUAL, 0.0, {}, True, False)
    one.set_by_hand("hold", 1.0)
    one.changes(driving)
    one.doubt()
    assert one.told("hold") is None
    assert one.changes(driving) == {}
    assert one.changes(at(MANUAL)) == {"hold": 0.0}  # the stick was let go
    assert one.told("hold") == 0.0
    one.changes(at(AUTONOMOUS, hold=1.0))
    one.doubt()
    assert one.changes(at(IDLE)) == {"hold": 0.0}  # the mission is over


def test_the_end_of_the_program_says_the_safe_word_again_behind_a_line_that_was_away() -> None:
    one = keeper(LAMP)
    one.doubt()
    assert one.changes(Situation(IDLE, 0.0, {}, False, True)) == {"lamp": 5.0}


def test_what_cannot_be_taken_back_is_the_operators_in_every_state_and_stays() -> None:
    one = keeper()
    for region in (IDLE, AUTONOMOUS, MANUAL, EMERGENCY):
        assert one.why_not("weight", 1.0, at(region)) == ""
    one.set_by_hand("weight", 1.0)
    assert one.changes(at(EMERGENCY))["weight"] == 1.0
    one.changes(Situation(EMERGENCY, 9.0, {}, False, False))
    assert one.said["weight"] == 1.0
    assert one.changes(at(EMERGENCY)) == {}
    one.doubt()
    assert one.changes(at(EMERGENCY))["weight"] == 1.0, "let go again, since the board may be new"


def climbed(depths: list[float | None], *outputs: Output) -> float | None:
    """The second in which a weight goes, of an ascent with these depths, one a second."""
    one = keeper(*outputs)
    for t, depth in enumerate(depths):
        if one.watch_ascent(float(t), depth, True):
            assert one.changes(at(EMERGENCY))["weight"] == 1.0
            return float(t)
    return None


def test_an_ascent_that_gains_less_than_a_metre_in_120_s_drops_what_is_armed() -> None:
    assert climbed([20.0] * 300) == WITHIN
    assert climbed([20.0 - 0.0080 * t for t in range(300)]) == WITHIN
    assert climbed([20.0 - 0.0085 * t for t in range(1000)]) is None
    late = [20.0 - 0.1 * min(t, 100) for t in range(400)]  # it sticks at 10 m
    assert climbed(late) == 100.0 + WITHIN


def test_an_unknown_depth_counts_as_not_gained() -> None:
    assert climbed([None] * 300) == WITHIN
    seen = [None] * 50 + [20.0 - 0.1 * t for t in range(150)]
    assert climbed(seen) is None


def test_what_is_not_armed_or_not_an_ascent_is_never_dropped() -> None:
    unarmed = Output("weight", "passthrough1", 0, 1, 0, irreversible=True)
    assert climbed([20.0] * 500, unarmed) is None
    one = keeper()
    for t in range(500):
        one.watch_ascent(float(t), 20.0, t % 100 != 0)
    assert one.changes(at(EMERGENCY)) == {}


@pytest.mark.parametrize("region", [IDLE, AUTONOMOUS])
def test_what_fights_a_setpoint_is_set_by_hand_under_the_stick_alone(region: str) -> None:
    one = keeper(HOLD)
    assert "take the stick first" in one.why_not("hold", 1.0, at(region))
    driving = Situation(MANUAL, 0.0, {}, True, False)
    assert one.why_not("hold", 1.0, driving) == ""
    one.set_by_hand("hold", 1.0)
    assert one.changes(driving) == {"hold": 1.0}
    assert one.changes(Situation(MANUAL, 0.0, {}, False, False)) == {"hold": 0.0}


def test_what_may_not_be_set_by_hand_is_told_with_its_reason() -> None:
    one = keeper()
    there = "no output lmp; the vehicle file names: "
    assert one.why_not("lmp", 1.0, at(IDLE)) == there + "lamp; tilt; weight"
    assert OutputKeeper(()).why_not("lmp", 1.0, at(IDLE)) == there + "none"
    assert one.why_not("lamp", 101.0, at(IDLE)) == LAMP.fault(101.0) != ""
    assert one.why_not("weight", 1.0, at(EMERGENCY)) == one.why_not("lamp", 1.0, at(IDLE)) == ""


def test_an_ascent_that_is_watched_names_the_instant_at_which_it_has_gained_too_little() -> None:
    one = keeper()
    assert one.next_timer() is None
    assert one.watch_ascent(7.0, 20.0, True) == ""
    assert one.next_timer() == 127.0
    assert one.watch_ascent(126.9, 20.0, True) == ""
    assert "less than 1 m in 120 s" in one.watch_ascent(127.0, 20.0, True)
    assert one.watch_ascent(128.0, 20.0, False) == ""
    assert one.next_timer() is None


def test_a_clone_goes_its_own_way() -> None:
    one = keeper()
    two = one.clone()
    two.set_by_hand("lamp", 50.0)
    assert two.changes(at(IDLE)) == {"lamp": 50.0}
    assert one.changes(at(IDLE)) == {}
