"""Scenes of bodies that are heavy, weak or upside down, and of boards and sensors that fail.

What does not live here: scenes of operators, the program and set limits (scenes_aboard).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from random import Random

from links.simulated.added import LIES
from links.simulated.settings import FaultEvent
from mission.verification.campaign.scene import (
    AC,
    DOWN,
    Scene,
    SceneRow,
    W,
    X,
    fault,
    heavy,
    repeated,
    say,
)
from mission.verification.campaign.trial import FOREVER

AUTO_CLOSED, AUTO_OPEN = b"@NSOOOCCC$", b"@NSOOOCCO$"


# --- bodies --------------------------------------------------------------------------------------


def _heavy_for_ever(rng: Random) -> Scene:
    value = round(rng.uniform(0.0, 45.0), 1)
    return Scene("there", (fault("heavy", rng.uniform(2.0, 120.0), FOREVER, value),))


def _heavy_after_x(rng: Random) -> Scene:
    t = rng.uniform(DOWN, 80.0)
    return Scene("there", (heavy(rng, t + rng.uniform(-5.0, 10.0)),), (say(t, X),))


def _neutral_after_x(rng: Random) -> Scene:
    """The vehicle neither rises nor sinks noticeably."""
    t = rng.uniform(DOWN, 80.0)
    weight = fault("heavy", t - 2.0, FOREVER, round(rng.uniform(14.8, 15.3), 1))
    return Scene("there", (weight,), (say(t, X),))


def _unliftable(rng: Random) -> Scene:
    """For a while nothing lifts the vehicle: by then every way has been tried."""
    t, lasts = rng.uniform(DOWN, 60.0), rng.uniform(100.0, 140.0)
    weight = fault("heavy", t, lasts, round(rng.uniform(16.0, 25.0), 1))
    said = (say(t + 5.0, W),) if rng.random() < 0.5 else ()
    return Scene("there", (weight, fault("verticals_dead", t, lasts)), said)


def _heavy_when_surfaced(rng: Random) -> Scene:
    slightly = fault("heavy", rng.uniform(80.0, 120.0), FOREVER, round(rng.uniform(16.5, 20.0), 1))
    weight = slightly if rng.random() < 0.5 else heavy(rng, rng.uniform(80.0, 120.0))
    return Scene("there", (weight,), (say(DOWN, W),))


def _held_up(rng: Random) -> Scene:
    """Heavy out of surfaced, so that thrust holds the vehicle up. Then faults end the thrust, again
    and again, mostly without a depth that shows it."""
    begin = rng.uniform(80.0, 100.0)
    faults = [fault("heavy", begin, FOREVER, round(rng.uniform(18.0, 40.0), 1))]
    if rng.random() < 0.7:
        blinds = "depth_silent", "depth_full_scale", "depth_absurd", "depth_frozen"
        faults += [fault(rng.choice(blinds), begin + rng.uniform(25.0, 60.0))]
    t = begin + rng.uniform(40.0, 80.0)
    for _ in range(rng.randint(2, 4)):
        faults += [fault(rng.choice(_ENDS_A_HOLD), t, rng.uniform(1.0, 4.0))]
        t += rng.uniform(3.0, 7.0) if rng.random() < 0.8 else rng.uniform(20.0, 60.0)
    return Scene("there", tuple(faults), (say(DOWN, W),))


_ENDS_A_HOLD = ("stm32_restart", "stm32_restart", "command_lost", "deaf_to_u")


def _heavy_when_idle(rng: Random) -> Scene:
    said = (say(DOWN, W), say(100.0, AC), say(108.0, AC))
    return Scene("there", (heavy(rng, rng.uniform(112.0, 130.0)),), said)


def _heavy_when_waiting(rng: Random) -> Scene:
    stick = repeated(DOWN, DOWN + 2.0, 0.2, b"@MMF3$")
    return Scene("there", (heavy(rng, DOWN + rng.uniform(0.0, 10.0)),), tuple(stick))


def _heavy_with_auto_closed(rng: Random) -> Scene:
    """The operator closes AUTO under water, and opens it while the vehicle sinks."""
    t = rng.uniform(DOWN, 60.0)
    said = (say(t, AUTO_CLOSED), say(t + rng.uniform(5.0, 20.0), AUTO_OPEN))
    return Scene("there", (heavy(rng, t),), said)


def _capsized(rng: Random) -> Scene:
    said = (say(rng.uniform(50.0, 60.0), W),) if rng.random() < 0.5 else ()
    text = rng.choice(["deep", "loose"])
    return Scene(text, (fault("capsized", rng.uniform(DOWN, 70.0)),), said)


def _capsized_and_heavy(rng: Random) -> Scene:
    t = rng.uniform(DOWN, 60.0)
    lasts = rng.uniform(160.0, 200.0)
    faults = (
        fault("capsized", t, lasts),
        fault("heavy", t, lasts, round(rng.uniform(20.0, 30.0), 1)),
    )
    return Scene("loose", faults, (say(t + rng.uniform(10.0, 20.0), W),))


def _capsized_blind(rng: Random) -> Scene:
    """Upside down and without a depth, and then W: every push leads down."""
    t = rng.uniform(DOWN, 60.0)
    name = rng.choice(["depth_full_scale", "depth_silent", "depth_absurd"])
    faults = (fault("capsized", t), fault(name, t + rng.uniform(0.0, 5.0)))
    return Scene("loose", faults, (say(t + rng.uniform(8.0, 20.0), W),))


def _sinks_unseen(rng: Random) -> Scene:
    """Sinks to the ground over a minute after letting go, with no known depth; then one is."""
    t = rng.uniform(170.0, 190.0)
    faults = (
        fault("heavy", t, FOREVER, round(rng.uniform(25.0, 40.0), 1)),
        fault("depth_full_scale", t - 4.0, rng.uniform(150.0, 200.0)),
    )
    return Scene("deep", faults, (say(DOWN, W), say(t - 8.0, AC)))


def _heavy_beside(rng: Random) -> Scene:
    """Heavy, with a depth that is off by metres from then on; only U12 lifts it."""
    t = rng.uniform(DOWN, 60.0)
    off = fault("depth_too_deep", t, FOREVER, round(rng.uniform(6.0, 12.0), 1))
    return Scene("there", (*_lifted_by_u_alone(rng, t), off), (say(t + 5.0, W),))


def _heavy_and_clogged(rng: Random) -> Scene:
    """Heavy, with a port that is clogged until the vehicle is deep; only U12 lifts it."""
    t = rng.uniform(DOWN, 60.0)
    clogged = fault("depth_stuck", t, rng.uniform(40.0, 60.0))
    return Scene("deep", (*_lifted_by_u_alone(rng, t, 48.0, 54.0), clogged))


def _lifted_by_u_alone(
    rng: Random, t: float, least: float = 46.0, most: float = 49.5
) -> tuple[FaultEvent, FaultEvent]:
    """Thrust for 40 s of 60, as the last turns without a depth give, does not lift the weight."""
    weight = fault("heavy", t, FOREVER, round(rng.uniform(least, most), 1))
    return weight, fault("deaf_to_w", t)


def _sinks_in_a_hold(rng: Random) -> Scene:
    return Scene("deep", (heavy(rng, rng.uniform(70.0, 120.0)),))


def _sinks_adrift(rng: Random) -> Scene:
    """Heavy by some newtons; or by so little that the rate makes it no descent (R5)."""
    t = rng.uniform(55.0, 70.0)
    slow = fault("heavy", t, FOREVER, round(rng.uniform(15.2, 16.0), 1))
    return Scene("adrift", (rng.choice([heavy(rng, t), slow]),))


def _weak_thrusters(rng: Random) -> Scene:
    """The verticals are too weak to leave the surface."""
    return Scene(
        "deep", (fault("verticals_weak", 2.0, FOREVER, round(rng.uniform(0.05, 0.25), 2)),)
    )


# --- boards --------------------------------------------------------------------------------------


def _board(name: str, *, sinks: bool) -> Callable[[Random], Scene]:
    """A board that misbehaves when W is sent."""

    def draw(rng: Random) -> Scene:
        t = rng.uniform(DOWN, 60.0)
        body = (heavy(rng, t),) if sinks and rng.random() < 0.7 else ()
        return Scene("there", (fault(name, t - 3.0), *body), (say(t, W),))

    return draw


def _deaf_to_x(rng: Random) -> Scene:
    """For a while nothing is acknowledged, just as X is sent."""
    t = rng.uniform(DOWN, 60.0)
    name = rng.choice(["ack_lost", "command_lost", "stm32_silent"])
    return Scene("there", (fault(name, t - 0.5, rng.uniform(4.0, 9.0)),), (say(t, X),))


def _acknowledged_and_garbled(rng: Random) -> Scene:
    t = rng.uniform(DOWN, 60.0)
    return Scene("there", (fault("command_corrupted", t - 1.0, 12.0, 0.9),), (say(t, X),))


def _turns_after_a_stop(rng: Random) -> Scene:
    """At rest the board goes into a dive by itself, which any X0 ends."""
    return Scene("there", (fault("dives_until_stop", rng.uniform(90.0, 110.0)),), (say(DOWN, W),))


def _refused(rng: Random) -> Scene:
    return Scene("there", (fault("refuses", rng.uniform(60.0, 80.0), 120.0),))


def _no_answers(rng: Random) -> Scene:
    return Scene("there", (fault("ack_lost", rng.uniform(DOWN, 80.0), 60.0),))


def _brown_out(rng: Random) -> Scene:
    return Scene("away", (fault("stm32_restart", rng.uniform(DOWN, 100.0), rng.uniform(1.0, 3.0)),))


def _silent(rng: Random) -> Scene:
    return Scene("away", (fault("stm32_silent", rng.uniform(DOWN, 100.0), rng.uniform(8.0, 40.0)),))


# --- sensors -------------------------------------------------------------------------------------


def _sensor(*names: str, text: str = "away") -> Callable[[Random], Scene]:
    def draw(rng: Random) -> Scene:
        return Scene(text, (fault(rng.choice(names), rng.uniform(DOWN, 90.0)),))

    return draw


def _surfacing_blind(rng: Random) -> Scene:
    """The depth fails near the surface, and the vehicle is then ordered up from below."""
    name = rng.choice(["depth_frozen", "depth_full_scale", "depth_absurd", "depth_silent"])
    return Scene("deep", (fault(name, rng.uniform(5.0, 9.0)),), (say(DOWN, W),))


def _stuck_receiver(rng: Random) -> Scene:
    return Scene(
        "deep", (fault("gps_stuck", rng.uniform(4.0, 8.0)),), (say(rng.uniform(40.0, 60.0), W),)
    )


def _wandering(rng: Random) -> Scene:
    wanders = fault(rng.choice(["gps_wanders", "gps_in_turn"]), rng.uniform(4.0, 8.0))
    return Scene("deep", (wanders,), (say(rng.uniform(40.0, 60.0), W),))


def _blind_and_wandering(rng: Random) -> Scene:
    """The receiver reports false places, and no depth contradicts them."""
    t = rng.uniform(DOWN, 60.0)
    wanders = fault("gps_wanders", rng.uniform(4.0, 8.0))
    return Scene("deep", (wanders, fault("depth_full_scale", t - 2.0)), (say(t, W),))


def _heavy_and_wandering(rng: Random) -> Scene:
    """Heavy, only U12 lifts it, and the receiver reports false places. After an X the vehicle sinks
    for so long that it is not back where it was when half a minute of fixes could contradict its
    depth. Mostly the depth is late, too, and the fixes contradict it."""
    t = rng.uniform(DOWN, 60.0)
    wanders = fault("gps_wanders", rng.uniform(4.0, 8.0))
    late = (_late(t),) if rng.random() < 0.8 else ()
    return Scene("deep", (*_lifted_by_u_alone(rng, t, 48.0, 49.0), wanders, *late), (say(t, X),))


def _heavy_and_late(rng: Random) -> Scene:
    """The same with less weight and a late depth: no turn of full thrust shows a rise."""
    t = rng.uniform(DOWN, 60.0)
    wanders = fault("gps_wanders", rng.uniform(4.0, 8.0))
    return Scene("deep", (*_lifted_by_u_alone(rng, t, 38.0, 45.0), wanders, _late(t)), (say(t, X),))


def _late(t: float) -> FaultEvent:
    return fault("depth_late", t + 1.7, FOREVER, 9.0)


def _clogged(rng: Random) -> Scene:
    return Scene("deep", (fault("depth_stuck", rng.uniform(14.0, 30.0)),))


def _clogged_at_the_surface(rng: Random) -> Scene:
    """The port clogs before the dive; the receiver repeats its last places, or makes some up."""
    begin = rng.uniform(6.0, 9.0)
    again = fault("gps_in_turn", begin, FOREVER, float(rng.randint(1, 5)))
    places = rng.choice([again, fault("gps_wanders", begin)])
    return Scene("deep", (fault("depth_stuck", rng.uniform(5.0, 6.5)), places))


def _lying(*sensors: str) -> Callable[[Random], Scene]:
    """Return a draw: one added sensor is wrong, from before the dive or in it, in a current."""

    def draw(rng: Random) -> Scene:
        name = f"{rng.choice(sensors)}_{rng.choice(LIES)}"
        begin = rng.choice([1.0, round(rng.uniform(DOWN, 90.0), 1)])
        text = rng.choice(["away", "there", "stubborn", "home"])
        return Scene(text, (fault(name, begin),), current=round(rng.uniform(0.0, 0.5), 2))

    return draw


def _second_alone(rng: Random) -> Scene:
    """The first receiver has failed, and the second reports nothing true."""
    gone = fault(rng.choice(["gps_silent", "gps_lost", "gps_stuck"]), rng.uniform(4.0, 90.0))
    how = rng.choice(["gps2_stuck", "gps2_wanders", "gps2_jump", "gps2_lost"])
    return Scene(rng.choice(["deep", "home"]), (gone, fault(how, rng.uniform(4.0, 90.0))))


def _low_battery(rng: Random) -> Scene:
    low = fault("battery_low", rng.uniform(DOWN, 80.0), FOREVER, round(rng.uniform(7.0, 9.0), 1))
    return Scene("away", (low,), batteries=True)


AT_SEA: Mapping[str, SceneRow] = {
    "heavy_for_ever": SceneRow(
        "less buoyancy for ever, down to what thrust lifts", _heavy_for_ever
    ),
    "heavy_after_x": SceneRow("X, and it is heavy", _heavy_after_x),
    "neutral_after_x": SceneRow("X, and it is neutral", _neutral_after_x),
    "heavy_when_surfaced": SceneRow("surfaced, and then heavy", _heavy_when_surfaced),
    "held_up": SceneRow("held up at the surface, and what ends that", _held_up),
    "heavy_when_idle": SceneRow("idle, and then heavy", _heavy_when_idle),
    "heavy_when_waiting": SceneRow("the stick is let go, and it is heavy", _heavy_when_waiting),
    "heavy_with_auto_closed": SceneRow("AUTO is closed while it is heavy", _heavy_with_auto_closed),
    "unliftable": SceneRow("heavy and without verticals for a while", _unliftable),
    "sinks_in_a_hold": SceneRow("heavy at the depth that is held", _sinks_in_a_hold),
    "sinks_adrift": SceneRow("heavy in a leg that asks for no depth", _sinks_adrift),
    "capsized": SceneRow("upside down, and buoyant", _capsized),
    "capsized_and_heavy": SceneRow("upside down, and heavy for a while", _capsized_and_heavy),
    "capsized_blind": SceneRow("upside down without a depth, and W", _capsized_blind),
    "sinks_unseen": SceneRow("idle, and heavy while no depth is known", _sinks_unseen),
    "heavy_beside": SceneRow("heavy, and its depth is off by metres", _heavy_beside),
    "heavy_and_clogged": SceneRow("heavy, its port clogged for a while", _heavy_and_clogged),
    "weak_thrusters": SceneRow(
        "verticals too weak for the depth that is asked for", _weak_thrusters
    ),
    "deaf_to_w": SceneRow("W, and the board does not hear it", _board("deaf_to_w", sinks=True)),
    "deaf_to_u": SceneRow("W, and the board does not hear U", _board("deaf_to_u", sinks=False)),
    "dives_until_up": SceneRow("it dives until it hears U", _board("dives_until_up", sinks=False)),
    "dives_until_stop": SceneRow(
        "it dives until it hears X", _board("dives_until_stop", sinks=False)
    ),
    "obeys_late": SceneRow("commands are obeyed late", _board("obeys_late", sinks=True)),
    "deaf_to_x": SceneRow("X, and no answer", _deaf_to_x),
    "garbled_x": SceneRow("X, and what arrives is garbled", _acknowledged_and_garbled),
    "turns_after_a_stop": SceneRow("at rest, and it dives by itself", _turns_after_a_stop),
    "refused": SceneRow("sets are answered N", _refused),
    "no_answers": SceneRow("no command is answered", _no_answers),
    "brown_out": SceneRow("the board forgets everything", _brown_out),
    "silent": SceneRow("the board is heard no more", _silent),
    "blind": SceneRow(
        "the depth fails under water", _sensor("depth_full_scale", "depth_silent", "depth_frozen")
    ),
    "surfacing_blind": SceneRow("the depth fails before it dives", _surfacing_blind),
    "wandering_receiver": SceneRow("a receiver that wanders under water, and W", _wandering),
    "blind_and_wandering": SceneRow(
        "no depth, a receiver that wanders, and W", _blind_and_wandering
    ),
    "heavy_and_wandering": SceneRow("heavy, and fixes made up", _heavy_and_wandering),
    "heavy_and_late": SceneRow("heavy, fixes made up, and a depth that is late", _heavy_and_late),
    "clogged": SceneRow("the port of the depth clogs on the way down", _clogged),
    "clogged_at_the_surface": SceneRow(
        "the port clogs at the surface, and the receiver lies", _clogged_at_the_surface
    ),
    "stuck_receiver": SceneRow("a receiver that is stuck, and W", _stuck_receiver),
    "wrong_compass": SceneRow(
        "the compass turns the wrong way", _sensor("heading_mirrored", text="there")
    ),
    "loose_compass": SceneRow(
        "course and heading differ at the surface",
        lambda rng: Scene("transit", (fault("heading_off", 8.0, FOREVER, rng.uniform(150, 180)),)),
    ),
    "lying_log": SceneRow("an added log of speed lies", _lying("speed_log", "doppler")),
    "lying_place": SceneRow("an added acoustic system lies", _lying("acoustic", "ranges")),
    "lying_second": SceneRow("the first receiver is out, the second lies", _second_alone),
    "low_battery": SceneRow("a control battery that is reported, and low", _low_battery),
    "blind_compass": SceneRow(
        "the compass fails under way", _sensor("heading_full_scale", "heading_frozen")
    ),
    "blind_altimeter": SceneRow(
        "the altimeter fails above the floor",
        _sensor("altitude_full_scale", "altitude_frozen", text="bottom"),
    ),
    "blind_above_the_bottom": SceneRow(
        "the altimeter fails where a depth is kept above the bottom",
        _sensor("altitude_full_scale", "altitude_frozen", "altitude_silent", text="clear"),
    ),
    "onto_the_shoal": SceneRow(
        "more current than was assumed, onto an area that is kept out of",
        lambda rng: Scene("shoal", current=round(rng.uniform(0.7, 0.9), 2)),
    ),
    "full_scale_roll": SceneRow("roll and pitch are garbage", _sensor("attitude_full_scale")),
}
