"""Scenes of limits that operators set, of operators' commands, and of the program.

What does not live here: scenes of bodies, boards and sensors (scenes_at_sea).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from random import Random

from mission.verification.campaign.scene import (
    AA,
    AC,
    DOWN,
    STARTED,
    Scene,
    SceneRow,
    W,
    X,
    fault,
    heavy,
    joins,
    repeated,
    say,
)
from mission.verification.campaign.scenes_at_sea import AUTO_CLOSED, AUTO_OPEN
from mission.verification.campaign.trial import FOREVER
from mission.verification.rig.acts import MODEM, OTHER_BOAT, PORT, Act, Disturbance
from protocol.modem import Sender, wrap

# --- bounds --------------------------------------------------------------------------------------


def _tight(
    field: int,
    low: int,
    high: int,
    text: str,
    current: float | None = None,
    since: float = DOWN,
) -> Callable[[Random], Scene]:
    """Return a draw with a tight @SP at a random time from ``since`` on."""

    def draw(rng: Random) -> Scene:
        values = [b"2000", b"240", b"100", b"10"]
        values[field] = b"%d" % rng.randint(low, high)
        said = say(rng.uniform(since, since + 24.0), b"@SP,%b,$" % b",".join(values))
        return Scene(text, (), (said,), current=current)

    return draw


def _swept_away(rng: Random) -> Scene:
    """The position grows uncertain under way, before the vehicle reaches the radius."""
    said = say(rng.uniform(DOWN, 60.0), b"@SP,%d,240,100,10,$" % rng.randint(200, 330))
    return Scene("away", (fault("gps_lost", DOWN),), (said,), current=0.4)


def _silent_topside(rng: Random) -> Scene:
    return Scene("away", silence=rng.uniform(30.0, 60.0))


# --- operators -----------------------------------------------------------------------------------


def _held_stick(rng: Random) -> Scene:
    """The commander's stick is held; another boat orders W or X. Sometimes the radio drops out, and
    its commands arrive when it is back."""
    t = rng.uniform(DOWN, 60.0)
    held = repeated(t - 3.0, t + 25.0, rng.choice([0.2, 0.5, 1.0, 1.8]), b"@MMD6$")
    ordered = (joins(), say(t, rng.choice([X, W]), OTHER_BOAT))
    if rng.random() < 0.5:
        away = t + rng.uniform(10.5, 15.0)  # the other boat no longer commands (R12)
        back = away + rng.uniform(2.1, 6.0)
        held = repeated(t - 3.0, t + 25.0, 0.2, b"@MMD6$")
        held = [replace(one, after=back) if away < one.after < back else one for one in held]
    return Scene("there", (), (*ordered, *held))


def _neutral_stick(rng: Random) -> Scene:
    """The boat's program sends a neutral M now and then, twice each time (R1)."""
    t, every = rng.uniform(DOWN, 60.0), rng.uniform(2.5, 9.0)
    said = [
        *repeated(t + 1.0, t + 40.0, every, b"@MMF0$"),
        *repeated(t + 1.2, t + 40.0, every, b"@MMF0$"),
    ]
    return Scene("there", (), (say(t, rng.choice([X, W])), *said))


def _stick_taken_and_left(rng: Random) -> Scene:
    """The stick is held, and then the link is lost without an end."""
    t = rng.uniform(DOWN, 60.0)
    held = repeated(t, t + rng.uniform(1.0, 8.0), 0.2, b"@MMD%d$" % rng.randint(2, 9))
    return Scene(
        "there",
        (),
        (*held, Disturbance(held[-1].after + 0.1, Act.PART), Disturbance(t + 90.0, Act.JOIN)),
    )


def _other_commander(rng: Random) -> Scene:
    """Another boat tries to command, while the commander keeps sending."""
    t = rng.uniform(DOWN, 60.0)
    words = [
        AA,
        AC,
        b"@SP,2000,240,100,10,$",
        b"@NSOOOCCC$",
        b"@MMF5$",
        b"@ST,2025/01/11 16:56:06,$",
    ]
    talk = repeated(STARTED, t + 30.0, 4.0, b"@DU$")
    said = [say(t + 3.0 * i, rng.choice(words), OTHER_BOAT) for i in range(6)]
    return Scene("there", (), (joins(), *talk, *said))


def _slides(t: float, rate: float, seconds: float) -> list[Disturbance]:
    return [say(t + i / rate, b"@DS1,%d$" % (i % 20)) for i in range(int(seconds * rate))]


def _slider(rng: Random) -> Scene:
    """The commander moves a rudder slider during legs or an ascent."""
    t = rng.uniform(DOWN, 60.0)
    rate = rng.choice([5.0, 60.0, 100.0, 200.0])
    moved = _slides(t, rate, 40.0)
    said = [say(t + 10.0 * (i + 1) + rng.random(), rng.choice([X, W])) for i in range(3)]
    return Scene("there", (heavy(rng, t),) if rng.random() < 0.4 else (), (*moved, *said))


def _busy_slider(rng: Random) -> Scene:
    """The same, heavy, with a board that receives nothing for a while after each command."""
    t = rng.uniform(DOWN, 60.0)
    rate = rng.choice([20.0, 60.0, 200.0])
    moved = _slides(t, rate, 60.0)
    seconds = rng.choice([rng.uniform(0.3, 0.45), rng.uniform(0.65, 0.9)])
    busy = fault("busy", t - 1.0, FOREVER, round(seconds, 2))
    said = say(t + rng.uniform(0.0, 5.0), rng.choice([X, W]))
    return Scene("there", (heavy(rng, t), busy), (*moved, said))


def _cleared_below(rng: Random) -> Scene:
    """X under water, then @AC at once and twice more."""
    t = rng.uniform(DOWN, 60.0)
    after = [say(t + d, AC) for d in (1.0, rng.uniform(3.0, 7.0), rng.uniform(8.0, 14.0))]
    return Scene("deep", (), (say(t, X), *after))


def _started_below(rng: Random) -> Scene:
    """AUTO is closed and opened under water, then the mission is started."""
    t = rng.uniform(DOWN, 60.0)
    said = [say(t, AUTO_CLOSED), say(t + 2.0, AUTO_OPEN)]
    starts = repeated(t + 3.0, t + 12.0, 1.5, AA)
    return Scene("pool", (), (*said, *starts))


def _started_with_auto_closed(rng: Random) -> Scene:
    """AUTO is closed and the vehicle comes up by itself; then somebody sends @AA all the same."""
    t = rng.uniform(DOWN, 60.0)
    return Scene("there", (), (say(t, AUTO_CLOSED), *repeated(t + 40.0, t + 60.0, 4.0, AA)))


def _auto_closed(rng: Random) -> Scene:
    return Scene("there", (), (say(rng.uniform(DOWN, 60.0), AUTO_CLOSED),))


def _late_copy(rng: Random) -> Scene:
    """A copy of @AA comes by modem after AUTO has ended the mission and is open again."""
    t = rng.uniform(DOWN, 60.0)
    copy = Disturbance(rng.uniform(100.0, 115.0), Act.SAY, wrap(AA, Sender.TOPSIDE), MODEM, "")
    return Scene("there", (), (say(t, AUTO_CLOSED), say(t + 3.0, AUTO_OPEN), copy))


def _ended(rng: Random) -> Scene:
    """SIGTERM under way, or in an ascent."""
    t = rng.uniform(DOWN, 60.0)
    weight = (heavy(rng, t),) if rng.random() < 0.3 else ()
    word = rng.choice([b"", W])
    return Scene("deep", weight, (*_maybe(t - 2.0, word), Disturbance(t, Act.END)))


def _modem_stick(rng: Random) -> Scene:
    said = Disturbance(rng.uniform(DOWN, 60.0), Act.SAY, wrap(b"@MMD6$", Sender.TOPSIDE), MODEM, "")
    return Scene("there", (), (said,))


# --- the program ---------------------------------------------------------------------------------


def _killed(t: float, back: float) -> tuple[Disturbance, ...]:
    """Kill the program at ``t`` and restart it at ``back``; the boat connects a second later."""
    return (
        Disturbance(t, Act.KILL),
        Disturbance(back, Act.BOOT),
        Disturbance(back + 1.0, Act.JOIN),
    )


def _restarted(word: bytes) -> Callable[[Random], Scene]:
    """Return a draw that kills and restarts the program in a mission, or after ``word``."""

    def draw(rng: Random) -> Scene:
        t = rng.uniform(DOWN, 60.0)
        killed = t + (rng.uniform(2.0, 40.0) if word == X else rng.uniform(2.0, 12.0))
        back = killed + rng.uniform(1.0, 6.0)
        ends = _killed(killed, back)
        return Scene(
            "deep", (heavy(rng, t),) if rng.random() < 0.3 else (), (*_maybe(t, word), *ends)
        )

    return draw


def _restarted_frozen(rng: Random) -> Scene:
    """The program is killed under water with a depth that froze at the surface. The board is deaf
    to U, and the vehicle neither rises nor sinks for a while."""
    t = rng.uniform(18.0, 24.0)
    faults = (
        fault("depth_frozen", rng.uniform(5.0, 8.0)),
        fault("deaf_to_u", t - 1.0),
        fault("heavy", t - 1.0, rng.uniform(30.0, 50.0), round(rng.uniform(14.5, 15.5), 1)),
    )
    return Scene("deep", faults, _killed(t, t + 2.0))


def _maybe(t: float, word: bytes) -> tuple[Disturbance, ...]:
    return (say(t, word),) if word else ()


def _pulled(rng: Random) -> Scene:
    t = rng.uniform(DOWN, 80.0)
    said = (say(t + 1.0, X),) if rng.random() < 0.5 else ()
    return Scene(
        "there",
        (),
        (Disturbance(t, Act.UNPLUG), *said, Disturbance(t + rng.uniform(2.0, 4.5), Act.PLUG)),
    )


def _restarted_at_full_scale(rng: Random) -> Scene:
    """The program is killed in any state, with a depth at full scale as it restarts; then comes a
    W, and sometimes a weight."""
    t = rng.uniform(DOWN, 150.0)
    said = (say(DOWN, rng.choice((W, X))),) if rng.random() < 0.7 else ()
    faults = [fault("depth_full_scale", t, rng.choice((FOREVER, rng.uniform(4.0, 60.0))))]
    if rng.random() < 0.3:
        faults += [heavy(rng, t + rng.uniform(0.0, 40.0))]
    ends = _killed(t, t + 2.0)
    return Scene("deep", tuple(faults), (*said, *ends, say(t + rng.uniform(6.0, 30.0), W)))


def _restarted_with_auto_closed(rng: Random) -> Scene:
    """Cleared at the surface, AUTO closed, heavy: on the ground when the program is killed."""
    said = (say(DOWN, W), say(100.0, AC), say(108.0, AC), say(112.0, AUTO_CLOSED))
    t = rng.uniform(290.0, 310.0)
    weight = heavy(rng, rng.uniform(114.0, 120.0))
    return Scene("there", (weight,), (*said, *_killed(t, t + rng.uniform(1.0, 6.0))))


def _held_and_then(rng: Random) -> Scene:
    """The vehicle is held up at the surface, or floats again; then an operator acts."""
    lasts = FOREVER if rng.random() < 0.5 else rng.uniform(30.0, 50.0)
    weight = fault("heavy", rng.uniform(85.0, 95.0), lasts, round(rng.uniform(17.0, 30.0), 1))
    t = rng.uniform(140.0, 160.0)
    stick = tuple(repeated(t, t + rng.uniform(0.0, 8.0), 0.2, rng.choice((b"@MMD6$", b"@MMF2$"))))
    then = rng.choice(
        (
            stick,
            (*stick, say(t + 20.0, W)),
            (say(t, AC), say(t + 6.0, AC), say(t + 60.0, W)),
            (say(t, W), say(t + rng.uniform(0.5, 15.0), AUTO_CLOSED)),
            (say(t, AUTO_CLOSED), say(t + rng.uniform(5.0, 25.0), AUTO_OPEN)),
        )
    )
    return Scene("there", (weight,), (say(DOWN, W), *then))


def _started_from_stick(rng: Random) -> Scene:
    """The stick leads down with no mission interrupted, is let go, and @AA is sent."""
    t = rng.uniform(DOWN, 60.0)
    ended = say(t, AUTO_CLOSED), say(t + 2.0, AUTO_OPEN)
    stick = repeated(t + 5.0, t + 12.0, 0.2, b"@MMD8$")
    return Scene("pool", (), (*ended, *stick, *repeated(t + 14.8, t + 20.0, 1.5, AA)))


def _stick_out_of_time(rng: Random) -> Scene:
    """The stick interrupts a mission for longer than its three minutes, which keep running."""
    t = rng.uniform(45.0, 60.0)
    stick = repeated(t, t + 60.0, 0.5, b"@MMF3$")
    return Scene("away", (), (say(30.0, b"@SP,2000,3,100,10,$"), *stick, say(t + 64.0, AA)))


def _answered_by_another(rng: Random) -> Scene:
    """Something else on the port acknowledges the X; the board has fallen silent."""
    t = rng.uniform(DOWN, 60.0)
    answers = [
        Disturbance(t + 0.6, Act.SAY, b"@ACK_Z%bY$" % code, PORT, "") for code in (b"A", b"X")
    ]
    cut = (Disturbance(t, Act.UNPLUG), say(t + 0.55, X), *answers, Disturbance(t + 3.0, Act.PLUG))
    return Scene("there", (fault("stm32_silent", t),), cut)


ABOARD: Mapping[str, SceneRow] = {
    "short_time": SceneRow("@SP with less time", _tight(1, 1, 3, "away")),
    "small_radius": SceneRow(
        "@SP with a smaller radius", _tight(0, 40, 80, "stubborn", current=0.05)
    ),
    "shallow_depth": SceneRow(
        "@SP with less depth than it has", _tight(2, 5, 9, "deep", since=STARTED + 42.0)
    ),
    "swept_away": SceneRow("uncertain before it is beyond the radius", _swept_away),
    "silent_topside": SceneRow("a bound on the topside's silence", _silent_topside),
    "held_stick": SceneRow("a stick that is held, and somebody else's W", _held_stick),
    "neutral_stick": SceneRow("a stick in neutral, now and then, in an emergency", _neutral_stick),
    "stick_left": SceneRow("the stick is held, and the link is lost", _stick_taken_and_left),
    "other_commander": SceneRow("two would command", _other_commander),
    "slider": SceneRow("a slider at 5 to 200 Hz", _slider),
    "busy_slider": SceneRow("a slider, and a board that is busy", _busy_slider),
    "cleared_below": SceneRow("@AC under water", _cleared_below),
    "started_below": SceneRow("@AA under water", _started_below),
    "auto_closed": SceneRow("AUTO is closed under way", _auto_closed),
    "started_with_auto_closed": SceneRow("@AA with AUTO closed", _started_with_auto_closed),
    "modem_stick": SceneRow("an M by modem", _modem_stick),
    "late_copy": SceneRow("a copy of a word, late", _late_copy),
    "ended": SceneRow("the program is ended in order", _ended),
    "restarted": SceneRow("killed in a mission", _restarted(b"")),
    "restarted_after_w": SceneRow("killed in an ascent", _restarted(W)),
    "restarted_after_x": SceneRow("killed when it was stopped", _restarted(X)),
    "restarted_frozen": SceneRow("killed, and its depth stands", _restarted_frozen),
    "restarted_at_full_scale": SceneRow("its depth at full scale", _restarted_at_full_scale),
    "restarted_with_auto_closed": SceneRow(
        "killed where it has sunk in idle, AUTO closed", _restarted_with_auto_closed
    ),
    "held_and_then": SceneRow("held up at the surface, and an operator acts", _held_and_then),
    "started_from_stick": SceneRow("a start out of a dive by the stick", _started_from_stick),
    "stick_out_of_time": SceneRow("the mission's time ends after the stick", _stick_out_of_time),
    "answered_by_another": SceneRow("something else acknowledges an X", _answered_by_another),
    "pulled": SceneRow("the cable is pulled for a moment", _pulled),
}
