"""Flights that can tell a rule from its absence: one row a scene, drawn with its own figures.

What is drawn at random seldom meets the one situation in which a rule matters (a body that sinks
while the operator has stopped it; a stick that is held while another boat orders W). A scene puts
it there: missions of its own, faults, deeds and how the vehicle is set up. Times are the
flight's; its mission begins about ``STARTED`` s.

What does not live here: what else happens in the flight (draw), what the rules are (the laws).
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

from links.simulated.settings import FaultEvent
from mission.campaign.deeds import BOAT, MODEM, OTHER_BOAT, TOPSIDE, Act, Deed
from mission.campaign.trial import FOREVER
from mission.language import parse
from mission.model import Mission
from protocol.modem import Sender, wrap

STARTED = 6.0  # s
DOWN = STARTED + 30.0  # s: at depth, in every mission of TEXTS but the transit
_HOME = "home 30.2874595 120.1535765\n"
_X, _W, _AA, _AC = b"@ZAX0$", b"@ZAWF$", b"@AA$", b"@AC$"
_AUTO_CLOSED, _AUTO_OPEN = b"@NSOOOCCC$", b"@NSOOOCCO$"
_PASS = "up: surface until fix timeout 3min\n"

TEXTS: Mapping[str, str] = {
    # There and back at 6 m, three minutes.
    "there": "mission there vehicle auv\n" + _HOME
    + "safety radius 600 time 20min depth 10 voltage 10\nassume current 0.5\n"
    "dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90\n"
    "out: heading 0 gear 8 for 60\nback: heading 180 gear 8 for 60\n" + _PASS,
    # A long way one way, which ends by its clock.
    "away": "mission away vehicle auv\n" + _HOME
    + "safety radius 1500 time 30min depth 10 voltage 10\nassume current 0.5\n"
    "dive: depth 5 heading 0 gear 4 until depth >= 4.5 timeout 90\n"
    "out: heading 0 gear 8 for 6min\n" + _PASS,
    # Deep, and long at one depth.
    "deep": "mission deep vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "dive: depth 14 heading 0 gear 4 until depth >= 13.5 timeout 4min\n"
    "stand: depth 14 heading 0 gear 4 for 4min\n" + _PASS,
    # Above a floor at 30 m.
    "bottom": "mission bottom vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 29 voltage 10\nassume current 0.5 floor 30\n"
    "dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90\n"
    "follow: altitude 20 heading 0 gear 4 for 3min else up\n" + _PASS,
    # At the surface, under way.
    "transit": "mission transit vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "go: heading 90 gear 8 for 3min\n" + _PASS,
    # Legs that ask for nothing below, one after the other.
    "adrift": "mission adrift vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90\n"
    "stand: depth 6 heading 0 gear 4 for 30\nadrift: stop up 0 for 60\n" + _PASS,
    # A pool: no fix, and none needed.
    "pool": "mission pool vehicle auv\nstart without fix\n"
    "safety radius 600 time 20min depth 10 voltage 10\nassume current 0.5\n"
    "dive: depth 5 heading 0 gear 4 until depth >= 4.5 timeout 90\n"
    "out: heading 0 gear 6 for 60\nup: surface timeout 3min\n",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Scene:
    """As drawn. ``silence``: of the topside, s; ``batteries``: the vehicle reports them."""

    text: str
    faults: tuple[FaultEvent, ...] = ()
    deeds: tuple[Deed, ...] = ()
    silence: float | None = None
    batteries: bool = False
    current: float | None = None  # m/s, towards the north


@dataclass(frozen=True, slots=True)
class SceneRow:
    says: str
    draw: Callable[[Random], Scene]


@functools.lru_cache(maxsize=len(TEXTS))
def mission_of(text: str) -> Mission:
    return parse(TEXTS[text])


def _say(t: float, data: bytes, address: str = BOAT) -> Deed:
    return Deed(t, Act.SAY, data, TOPSIDE, address)


def _joins(t: float = 4.0) -> Deed:
    return Deed(t, Act.JOIN, b"", TOPSIDE, OTHER_BOAT)


def _repeated(begin: float, end: float, every: float, data: bytes, who: str = BOAT) -> list[Deed]:
    return [_say(begin + every * i, data, who) for i in range(int((end - begin) / every) + 1)]


def _fault(
    name: str, begin: float, duration: float = FOREVER, value: float | None = None
) -> FaultEvent:
    return FaultEvent(name, round(begin, 1), round(duration, 1), value)


def _heavy(rng: Random, begin: float, duration: float = FOREVER) -> FaultEvent:
    """Beyond neutral, and within what the thrusters can lift."""
    return _fault("heavy", begin, duration, round(rng.uniform(20.0, 45.0), 1))


# --- bodies --------------------------------------------------------------------------------------


def _heavy_for_ever(rng: Random) -> Scene:
    value = round(rng.uniform(0.0, 45.0), 1)
    return Scene("there", (_fault("heavy", rng.uniform(2.0, 120.0), FOREVER, value),))


def _heavy_after_x(rng: Random) -> Scene:
    t = rng.uniform(DOWN, 80.0)
    return Scene("there", (_heavy(rng, t + rng.uniform(-5.0, 10.0)),), (_say(t, _X),))


def _heavy_when_surfaced(rng: Random) -> Scene:
    return Scene("there", (_heavy(rng, rng.uniform(80.0, 120.0)),), (_say(DOWN, _W),))


def _heavy_when_idle(rng: Random) -> Scene:
    said = (_say(DOWN, _W), _say(100.0, _AC), _say(108.0, _AC))
    return Scene("there", (_heavy(rng, rng.uniform(112.0, 130.0)),), said)


def _heavy_when_waiting(rng: Random) -> Scene:
    stick = _repeated(DOWN, DOWN + 2.0, 0.2, b"@MMF3$")
    return Scene("there", (_heavy(rng, DOWN + rng.uniform(0.0, 10.0)),), tuple(stick))


def _heavy_with_auto_closed(rng: Random) -> Scene:
    """The operator closes AUTO under water, and opens it while it sinks."""
    t = rng.uniform(DOWN, 60.0)
    said = (_say(t, _AUTO_CLOSED), _say(t + rng.uniform(5.0, 20.0), _AUTO_OPEN))
    return Scene("there", (_heavy(rng, t),), said)


def _capsized(rng: Random) -> Scene:
    said = (_say(rng.uniform(50.0, 60.0), _W),) if rng.random() < 0.5 else ()
    return Scene("deep", (_fault("capsized", rng.uniform(DOWN, 70.0)),), said)


def _capsized_and_heavy(rng: Random) -> Scene:
    t = rng.uniform(DOWN, 60.0)
    lasts = rng.uniform(160.0, 200.0)
    faults = (
        _fault("capsized", t, lasts),
        _fault("heavy", t, lasts, round(rng.uniform(20.0, 30.0), 1)),
    )
    return Scene("deep", faults, (_say(t + 10.0, _W),))


def _sinks_in_a_hold(rng: Random) -> Scene:
    return Scene("deep", (_heavy(rng, rng.uniform(70.0, 120.0)),))


def _sinks_adrift(rng: Random) -> Scene:
    return Scene("adrift", (_heavy(rng, rng.uniform(55.0, 70.0)),))


def _weak_thrusters(rng: Random) -> Scene:
    weak = _fault("verticals_weak", rng.uniform(10.0, 20.0), FOREVER, 0.1)
    return Scene("deep", (weak, _fault("light", 8.0, FOREVER, round(rng.uniform(0.0, 5.0), 1))))


# --- boards --------------------------------------------------------------------------------------


def _board(name: str, *, heavy: bool) -> Callable[[Random], Scene]:
    """A board that is not kind, when W is said."""

    def draw(rng: Random) -> Scene:
        t = rng.uniform(DOWN, 60.0)
        body = (_heavy(rng, t),) if heavy and rng.random() < 0.7 else ()
        return Scene("there", (_fault(name, t - 3.0), *body), (_say(t, _W),))

    return draw


def _deaf_to_x(rng: Random) -> Scene:
    """Nothing is acknowledged for a while, when X is said."""
    t = rng.uniform(DOWN, 60.0)
    name = rng.choice(["ack_lost", "command_lost", "stm32_silent"])
    return Scene("there", (_fault(name, t - 0.5, rng.uniform(4.0, 9.0)),), (_say(t, _X),))


def _acknowledged_and_garbled(rng: Random) -> Scene:
    t = rng.uniform(DOWN, 60.0)
    return Scene("there", (_fault("command_corrupted", t - 1.0, 12.0, 0.9),), (_say(t, _X),))


def _turns_after_a_stop(rng: Random) -> Scene:
    """It is restarted into a dive by itself, which any X0 ends."""
    return Scene(
        "there", (_fault("dives_until_stop", rng.uniform(90.0, 110.0)),), (_say(DOWN, _W),)
    )


def _refused(rng: Random) -> Scene:
    return Scene("there", (_fault("refuses", rng.uniform(60.0, 80.0), 120.0),))


def _no_answers(rng: Random) -> Scene:
    return Scene("there", (_fault("ack_lost", rng.uniform(DOWN, 80.0), 60.0),))


def _brown_out(rng: Random) -> Scene:
    return Scene(
        "away", (_fault("stm32_restart", rng.uniform(DOWN, 100.0), rng.uniform(1.0, 3.0)),)
    )


def _silent(rng: Random) -> Scene:
    return Scene(
        "away", (_fault("stm32_silent", rng.uniform(DOWN, 100.0), rng.uniform(8.0, 40.0)),)
    )


# --- sensors -------------------------------------------------------------------------------------


def _sensor(*names: str, text: str = "away") -> Callable[[Random], Scene]:
    def draw(rng: Random) -> Scene:
        return Scene(text, (_fault(rng.choice(names), rng.uniform(DOWN, 90.0)),))

    return draw


def _surfacing_blind(rng: Random) -> Scene:
    """The depth fails near the surface, and the vehicle is then ordered up from below."""
    name = rng.choice(["depth_frozen", "depth_full_scale", "depth_absurd", "depth_silent"])
    return Scene("deep", (_fault(name, rng.uniform(5.0, 9.0)),), (_say(DOWN, _W),))


def _stuck_receiver(rng: Random) -> Scene:
    return Scene(
        "deep", (_fault("gps_stuck", rng.uniform(4.0, 8.0)),), (_say(rng.uniform(40.0, 60.0), _W),)
    )


def _low_battery(rng: Random) -> Scene:
    low = _fault("battery_low", rng.uniform(DOWN, 80.0), FOREVER, round(rng.uniform(7.0, 9.0), 1))
    return Scene("away", (low,), batteries=True)


# --- bounds --------------------------------------------------------------------------------------


def _tight(field: int, low: int, high: int, text: str) -> Callable[[Random], Scene]:
    """An @SP while it is under way, or before."""

    def draw(rng: Random) -> Scene:
        values = [b"2000", b"240", b"100", b"10"]
        values[field] = b"%d" % rng.randint(low, high)
        said = _say(rng.uniform(DOWN, 60.0), b"@SP,%b,$" % b",".join(values))
        return Scene(text, (), (said,))

    return draw


def _swept_away(rng: Random) -> Scene:
    """Where it is grows uncertain under way, before the radius."""
    said = _say(rng.uniform(DOWN, 60.0), b"@SP,%d,240,100,10,$" % rng.randint(200, 330))
    return Scene("away", (_fault("gps_lost", DOWN),), (said,), current=0.4)


def _silent_topside(rng: Random) -> Scene:
    return Scene("away", silence=rng.uniform(30.0, 60.0))


# --- operators -----------------------------------------------------------------------------------


def _held_stick(rng: Random) -> Scene:
    """The commander's stick is held; another boat orders W or X."""
    t = rng.uniform(DOWN, 60.0)
    held = _repeated(t - 3.0, t + 25.0, rng.choice([0.2, 0.5, 1.0, 1.8]), b"@MMD6$")
    return Scene("there", (), (_joins(), _say(t, rng.choice([_X, _W]), OTHER_BOAT), *held))


def _neutral_stick(rng: Random) -> Scene:
    """A program that says now and then that the stick is in neutral."""
    t = rng.uniform(DOWN, 60.0)
    said = _repeated(t + 1.0, t + 40.0, rng.uniform(2.5, 9.0), b"@MMF0$")
    return Scene("there", (), (_say(t, rng.choice([_X, _W])), *said))


def _stick_taken_and_left(rng: Random) -> Scene:
    """Held, and then the link is lost without a goodbye."""
    t = rng.uniform(DOWN, 60.0)
    held = _repeated(t, t + rng.uniform(1.0, 8.0), 0.2, b"@MMD%d$" % rng.randint(2, 9))
    return Scene(
        "there", (), (*held, Deed(held[-1].after + 0.1, Act.PART), Deed(t + 90.0, Act.JOIN))
    )


def _other_commander(rng: Random) -> Scene:
    """Somebody else would command, while the commander goes on saying something."""
    t = rng.uniform(DOWN, 60.0)
    words = [
        _AA,
        _AC,
        b"@SP,2000,240,100,10,$",
        b"@NSOOOCCC$",
        b"@MMF5$",
        b"@ST,2025/01/11 16:56:06,$",
    ]
    talk = _repeated(STARTED, t + 30.0, 4.0, b"@DU$")
    said = [_say(t + 3.0 * i, rng.choice(words), OTHER_BOAT) for i in range(6)]
    return Scene("there", (), (_joins(), *talk, *said))


def _slider(rng: Random) -> Scene:
    """A rudder slider of the commander, for as long as it moves, and an ascent or legs beside it."""
    t = rng.uniform(DOWN, 60.0)
    rate = rng.choice([5.0, 20.0, 60.0, 200.0])
    moved = [_say(t + i / rate, b"@DS1,%d$" % (i % 20)) for i in range(int(40.0 * rate))]
    said = [_say(t + 10.0, rng.choice([_X, _W]))] if rng.random() < 0.5 else []
    return Scene("there", (_heavy(rng, t),) if rng.random() < 0.4 else (), (*moved, *said))


def _cleared_below(rng: Random) -> Scene:
    """X under water, and @AC at once and again; then a start."""
    t = rng.uniform(DOWN, 60.0)
    after = [_say(t + d, _AC) for d in (1.0, rng.uniform(3.0, 7.0), rng.uniform(8.0, 14.0))]
    return Scene("deep", (), (_say(t, _X), *after))


def _started_below(rng: Random) -> Scene:
    """AUTO is closed and opened under water, then a start."""
    t = rng.uniform(DOWN, 60.0)
    said = [_say(t, _AUTO_CLOSED), _say(t + 2.0, _AUTO_OPEN)]
    starts = _repeated(t + 3.0, t + 12.0, 1.5, _AA)
    return Scene(rng.choice(["deep", "pool"]), (), (*said, *starts))


def _started_with_auto_closed(rng: Random) -> Scene:
    """It comes up by itself; then somebody starts it all the same."""
    t = rng.uniform(DOWN, 60.0)
    return Scene("there", (), (_say(t, _AUTO_CLOSED), *_repeated(t + 40.0, t + 60.0, 4.0, _AA)))


def _auto_closed(rng: Random) -> Scene:
    return Scene("there", (), (_say(rng.uniform(DOWN, 60.0), _AUTO_CLOSED),))


def _late_copy(rng: Random) -> Scene:
    """A copy of @AA, or of a looser @SP, by modem, when the mission is over or the bound tighter."""
    start = Deed(STARTED + rng.uniform(20.0, 100.0), Act.SAY, wrap(_AA, Sender.TOPSIDE), MODEM, "")
    return Scene("there", (), (_say(DOWN, _W), _say(75.0, _AC), _say(82.0, _AC), start))


def _modem_stick(rng: Random) -> Scene:
    said = Deed(rng.uniform(DOWN, 60.0), Act.SAY, wrap(b"@MMD6$", Sender.TOPSIDE), MODEM, "")
    return Scene("there", (), (said,))


# --- the program ---------------------------------------------------------------------------------


def _restarted(word: bytes) -> Callable[[Random], Scene]:
    """Killed in a mission, or in what the word began, and begun anew."""

    def draw(rng: Random) -> Scene:
        t = rng.uniform(DOWN, 60.0)
        killed = t + (rng.uniform(2.0, 40.0) if word == _X else rng.uniform(2.0, 12.0))
        back = killed + rng.uniform(1.0, 6.0)
        ends = [Deed(killed, Act.KILL), Deed(back, Act.BOOT), Deed(back + 1.0, Act.JOIN)]
        return Scene(
            "deep", (_heavy(rng, t),) if rng.random() < 0.3 else (), (*_maybe(t, word), *ends)
        )

    return draw


def _maybe(t: float, word: bytes) -> tuple[Deed, ...]:
    return (_say(t, word),) if word else ()


def _pulled(rng: Random) -> Scene:
    t = rng.uniform(DOWN, 80.0)
    said = (_say(t + 1.0, _X),) if rng.random() < 0.5 else ()
    return Scene(
        "there", (), (Deed(t, Act.UNPLUG), *said, Deed(t + rng.uniform(2.0, 4.5), Act.PLUG))
    )


SCENES: Mapping[str, SceneRow] = {
    "heavy_for_ever": SceneRow("less buoyancy for ever, down to what thrust lifts", _heavy_for_ever),
    "heavy_after_x": SceneRow("X, and it is heavy", _heavy_after_x),
    "heavy_when_surfaced": SceneRow("surfaced, and then heavy", _heavy_when_surfaced),
    "heavy_when_idle": SceneRow("idle, and then heavy", _heavy_when_idle),
    "heavy_when_waiting": SceneRow("the stick is let go, and it is heavy", _heavy_when_waiting),
    "heavy_with_auto_closed": SceneRow("AUTO is closed while it is heavy", _heavy_with_auto_closed),
    "sinks_in_a_hold": SceneRow("heavy at the depth that is held", _sinks_in_a_hold),
    "sinks_adrift": SceneRow("heavy in a leg that asks for no depth", _sinks_adrift),
    "capsized": SceneRow("upside down, and buoyant", _capsized),
    "capsized_and_heavy": SceneRow("upside down, and heavy for a while", _capsized_and_heavy),
    "weak_thrusters": SceneRow("verticals too weak for the depth that is asked for", _weak_thrusters),
    "deaf_to_w": SceneRow("W, and the board does not hear it", _board("deaf_to_w", heavy=True)),
    "deaf_to_u": SceneRow("W, and the board does not hear U", _board("deaf_to_u", heavy=False)),
    "dives_until_up": SceneRow("it dives until it hears U", _board("dives_until_up", heavy=False)),
    "dives_until_stop": SceneRow("it dives until it hears X", _board("dives_until_stop", heavy=False)),
    "obeys_late": SceneRow("commands are obeyed late", _board("obeys_late", heavy=True)),
    "deaf_to_x": SceneRow("X, and no answer", _deaf_to_x),
    "garbled_x": SceneRow("X, and what arrives is garbled", _acknowledged_and_garbled),
    "turns_after_a_stop": SceneRow("at rest, and it dives by itself", _turns_after_a_stop),
    "refused": SceneRow("sets are answered N", _refused),
    "no_answers": SceneRow("no command is answered", _no_answers),
    "brown_out": SceneRow("the board forgets everything", _brown_out),
    "silent": SceneRow("the board is heard no more", _silent),
    "blind": SceneRow("the depth fails under water",
                      _sensor("depth_full_scale", "depth_silent", "depth_frozen")),
    "surfacing_blind": SceneRow("the depth fails before it dives", _surfacing_blind),
    "stuck_receiver": SceneRow("a receiver that is stuck, and W", _stuck_receiver),
    "wrong_compass": SceneRow("the compass turns the wrong way", _sensor("heading_mirrored", text="there")),
    "loose_compass": SceneRow("course and heading differ at the surface",
                              lambda rng: Scene("transit", (_fault("heading_off", 8.0, FOREVER, 100.0),))),
    "low_battery": SceneRow("a control battery that is reported, and low", _low_battery),
    "short_time": SceneRow("@SP with less time", _tight(1, 1, 3, "away")),
    "small_radius": SceneRow("@SP with a smaller radius", _tight(0, 40, 120, "away")),
    "shallow_depth": SceneRow("@SP with less depth", _tight(2, 2, 3, "deep")),
    "swept_away": SceneRow("uncertain before it is beyond the radius", _swept_away),
    "silent_topside": SceneRow("a bound on the topside's silence", _silent_topside),
    "held_stick": SceneRow("a stick that is held, and somebody else's W", _held_stick),
    "neutral_stick": SceneRow("a stick in neutral, now and then, in an emergency", _neutral_stick),
    "stick_left": SceneRow("the stick is held, and the link is lost", _stick_taken_and_left),
    "other_commander": SceneRow("two would command", _other_commander),
    "slider": SceneRow("a slider at 5 to 200 Hz", _slider),
    "cleared_below": SceneRow("@AC under water", _cleared_below),
    "started_below": SceneRow("@AA under water", _started_below),
    "auto_closed": SceneRow("AUTO is closed under way", _auto_closed),
    "started_with_auto_closed": SceneRow("@AA with AUTO closed", _started_with_auto_closed),
    "modem_stick": SceneRow("an M by modem", _modem_stick),
    "blind_compass": SceneRow("the compass fails under way",
                              _sensor("heading_full_scale", "heading_frozen")),
    "blind_altimeter": SceneRow("the altimeter fails above the floor",
                                _sensor("altitude_full_scale", "altitude_frozen", text="bottom")),
    "full_scale_roll": SceneRow("roll and pitch are garbage", _sensor("attitude_full_scale")),
    "late_copy": SceneRow("a copy of a word, late", _late_copy),
    "restarted": SceneRow("killed in a mission", _restarted(b"")),
    "restarted_after_w": SceneRow("killed in an ascent", _restarted(_W)),
    "restarted_after_x": SceneRow("killed when it was stopped", _restarted(_X)),
    "pulled": SceneRow("the cable is pulled for a moment", _pulled),
}  # fmt: skip
