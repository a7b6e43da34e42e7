"""The rows of events: every command, every limit, every reading, every answer, time, a restart.

Whatever an operator says is encoded as his console does it; what a sensor says goes into an
``@SD``. An event is played in every configuration, also where it cannot do anything: then that is
the law.

What does not live here: what must follow (laws).
"""

from __future__ import annotations

import math
from collections.abc import Callable

from mission.exhaustive.cell import Configuration, Event
from mission.exhaustive.configurations import DEEP, SHALLOW, doubt
from mission.exhaustive.world import TENDER, World
from mission.model import Chart
from protocol.messages import MissionLine, SetSafety, SetTime
from protocol.topside import encode

Play = Callable[[World, Configuration, Chart], None]
POOL = (
    "mission pool vehicle auv",
    "safety radius 200 time 5min depth 5",
    "start without fix",
    "a: depth 2 heading 0 gear 4 for 20",
)
WIDE = encode(SetSafety(radius=60000.0))
SETTLE = 0.3  # s: the line, and an answer of the STM32
BELOW = 3.0  # s: the modem's turn


def _play(script: Callable[[World], None]) -> Play:
    return lambda world, configuration, chart: script(world)


def _says(frame: bytes, seconds: float = SETTLE) -> Play:
    def play(world: World) -> None:
        world.say(frame)
        world.wait(seconds)

    return _play(play)


def _other_says(frame: bytes) -> Play:
    """While the boat commands."""

    def play(world: World) -> None:
        world.say(WIDE)
        world.at_once = ""
        world.say(frame, TENDER)
        world.wait(SETTLE)

    return _play(play)


def _later_says(frame: bytes) -> Play:
    """After the boat has been silent for long enough."""

    def play(world: World) -> None:
        world.wait(10.5)
        world.at_once = ""
        world.say(frame, TENDER)
        world.wait(SETTLE)

    return _play(play)


def _below(frame: bytes) -> Play:
    def play(world: World) -> None:
        world.say_below(frame)
        world.wait(BELOW)

    return _play(play)


def _both(world: World) -> None:
    world.say_below(b"@RSCOOCCCC$")
    world.wait(0.5)
    world.say(b"@RSCOOCCCC$")
    world.wait(SETTLE)


def _start_while_staging(world: World) -> None:
    world.say(encode(MissionLine(2, 1, POOL[0])))
    world.say(b"@AA$")
    world.wait(SETTLE)


def _uploads(world: World) -> None:
    for number, line in enumerate(POOL, 1):
        world.say(encode(MissionLine(len(POOL), number, line)))
    world.wait(SETTLE)


def _nodes_answer(world: World) -> None:
    world.say(b"@NSOOOOOO$")
    for node in (b"STM32", b"BDGPS", b"UACM", b"CAMERA"):
        world.node(node + b" O\n")
    world.wait(SETTLE)


def _holds_the_stick(world: World) -> None:
    for _ in range(10):
        world.say(b"@MMF5$")
        world.wait(0.2)


_TIME = encode(SetTime("2026-03-01T12:00:00"))
_STOPS_BEHIND = frozenset({"X", "M", "AA"})
# fmt: off
COMMANDS = (
    Event("X", _says(b"@ZAX0$"), "X"),
    Event("W", _says(b"@ZAWF$"), "W"),
    Event("X of another connection", _other_says(b"@ZAX0$"), "X", "tender"),
    Event("W of another connection", _other_says(b"@ZAWF$"), "W", "tender"),
    Event("X by modem", _below(b"@ZAX0$"), "X", "modem"),
    Event("W by modem", _below(b"@ZAWF$"), "W", "modem"),
    Event("X among others in one burst", _says(b"@AA$@ZAX0$"), "X", also=_STOPS_BEHIND),
    Event("X and W again", _says(b"@ZAX0$@ZAWF$@ZAX0$"), "X", also=frozenset({"W"})),
    Event("MM", _says(b"@MMF5$"), "MM"),
    Event("MT", _says(b"@MT1,-10$"), "MT"),
    Event("MD", _says(b"@MDA2,-2$"), "MD"),
    Event("MR", _says(b"@MRL5$"), "MR"),
    Event("MS", _says(b"@MS120,-90$"), "MS"),
    Event("MP", _says(b"@MP120,-90$"), "MP"),
    Event("M of another connection", _other_says(b"@MMF5$"), "MM", "tender"),
    Event("M by modem", _below(b"@MMF5$"), "MM", "modem"),
    Event("M held for 2 s", _play(_holds_the_stick), "MM"),
    Event("AA", _says(b"@AA$", 3.0), "AA"),
    Event("AA of another connection", _other_says(b"@AA$"), "AA", "tender"),
    Event("AA while staging", _play(_start_while_staging), "AA", "staging"),
    Event("AC", _says(b"@AC$"), "AC"),
    Event("AC of another connection", _other_says(b"@AC$"), "AC", "tender"),
    Event("AC of another, the boat silent", _later_says(b"@AC$"), "AC"),
    Event("AW, a line", _says(encode(MissionLine(2, 1, POOL[0]))), "AW"),
    Event("AW, a whole mission", _play(_uploads), "AW", "whole"),
    Event("AW, a line out of place", _says(encode(MissionLine(9, 4, POOL[0]))), "AW", "misplaced"),
    Event("AQ", _says(b"@AQ$"), "AQ"),
    Event("DU", _says(b"@DU$"), "DU"),
    Event("NI", _says(b"@NI$"), "NI"),
    Event("ST", _says(_TIME), "ST"),
    Event("ST by modem", _below(_TIME), "ST", "modem"),
    Event("SP", _says(WIDE), "SP"),
    Event("SP with an item missing", _says(b"@SP,100,5,20$"), "SP", "broken"),
    Event("RS", _says(b"@RSCOOCCCO$"), "RS"),
    Event("RI", _says(b"@RI$"), "RI"),
    Event("RS by both paths", _play(_both), "RS", "both"),
    Event("rudder", _says(b"@DS3,20$"), "D"),
    Event("NS, all open", _play(_nodes_answer), "NS", "open"),
    Event("NS, AUTO closed", _says(b"@NSOOOOOC$", 1.0), "NS", "auto"),
    Event("NS, STM32 closed", _says(b"@NSOCOOOO$"), "NS", "stm32"),
    Event("noise", _says(b"@ZA\xff\x00W0$@@AAX$@M"), "noise"),
)
# fmt: on


# --- limits --------------------------------------------------------------------------------


def _tightens(limits: SetSafety, seconds: float = 4.5) -> Play:
    def play(world: World) -> None:
        world.say(encode(limits))
        world.wait(seconds)

    return _play(play)


def _too_deep(world: World) -> None:
    world.sea.depth = DEEP
    world.wait(4.0)
    world.say(encode(SetSafety(depth=1.5)))
    world.wait(4.5)


def _hard_depth(world: World) -> None:
    world.sea.depth = 103.0
    world.wait(12.5)


def _sinks(world: World) -> None:
    world.wait(2.0)
    for _ in range(3):
        world.sea.depth += 3.0
        world.wait(2.0)
    world.wait(0.1)


def _blinded(world: World) -> None:
    world.sea.unknown.add("depth")
    world.wait(8.5)


def _silent(world: World) -> None:
    world.reports = False
    world.wait(7.5)


def _topside_silent(world: World) -> None:
    world.engine.limit_topside_silence(3.0)
    world.wait(4.5)


def _rolls(world: World) -> None:
    world.sea.roll_deg = 75.0
    world.wait(4.5)


def _low(world: World) -> None:
    world.sea.control_v = 9
    world.wait(14.5)


def _turns_away(world: World, configuration: Configuration, chart: Chart) -> None:
    """From the heading that the leg holds, if it does."""
    state = chart.state(configuration.leaf) if configuration.leaf else None
    held = state.setpoint.heading if state is not None and state.setpoint is not None else None
    for number in range(10):
        world.sea.heading_deg = math.degrees(held or 0.0) + 15.0 * (number + 1)
        world.wait(2.0)


def _goes_elsewhere(world: World) -> None:
    world.sea.depth = SHALLOW
    world.wait(2.0)
    world.sea.course_deg = world.sea.heading_deg + 120.0
    for _ in range(24):
        world.fix()
        world.wait(1.0)


def _loses_power(world: World) -> None:
    world.wait(2.5)
    world.sea.powered = False
    world.wait(9.0)


def _doubts(world: World) -> None:
    here = world.engine.estimate
    if here is None:
        return
    doubt(world)


def _nobody_answers(world: World, configuration: Configuration, chart: Chart) -> None:
    world.answers = ""
    _end_leg(world, configuration, chart)
    world.wait(24.0)


def _end_leg(world: World, configuration: Configuration, chart: Chart) -> None:
    """Its time is up in a moment."""
    if configuration.region != "autonomous":
        return
    leg = chart.state(configuration.leaf).leg
    assert leg is not None
    times = [t for t in (leg.duration, leg.timeout) if t is not None]
    if times:
        world.engine.place(configuration.leaf, dict(configuration.rounds), min(times) - 0.05)


LIMITS = (
    Event("limit radius", _tightens(SetSafety(radius=1.0)), "SP", limit="radius"),
    Event("limit time", _tightens(SetSafety(time=0.6), 1.0), "SP", limit="time"),
    Event("limit depth", _play(_too_deep), "SP", limit="depth"),
    Event("limit hard depth", _play(_hard_depth), limit="hard depth"),
    Event("limit unexplained descent", _play(_sinks), limit="unexplained descent"),
    Event("limit depth unknown", _play(_blinded), limit="depth unknown", sensor="depth", after=6.0),
    Event("limit telemetry", _play(_silent), limit="telemetry"),
    Event("limit topside", _play(_topside_silent), limit="topside"),
    Event("limit no answer", _nobody_answers, limit="no answer"),
    Event("limit roll-over", _play(_rolls), limit="roll-over"),
    Event("limit voltage", _play(_low), limit="voltage"),
    Event("limit heading does not follow", _turns_away, limit="heading does not follow"),
    Event("limit course against heading", _play(_goes_elsewhere), limit="course against heading"),
    Event("limit brown-out", _play(_loses_power), limit="brown-out"),
    Event("limit uncertain", _play(_doubts), "SP", limit="uncertain"),
)


# --- readings ------------------------------------------------------------------------------


def _missing(field: str, seconds: float = 8.9) -> Play:
    def play(world: World) -> None:
        world.sea.unknown.add(field)
        world.wait(seconds)

    return _play(play)


def _absurd(attribute: str, value: float) -> Play:
    def play(world: World) -> None:
        setattr(world.sea, attribute, value)
        world.wait(8.9)

    return _play(play)


def _frozen(field: str) -> Play:
    def play(world: World) -> None:
        world.wait(2.0)
        world.sea.frozen.add(field)
        world.wait(17.0)

    return _play(play)


def _reports(world: World) -> None:
    world.wait(4.1)


def _fixes(world: World) -> None:
    world.sea.depth = SHALLOW
    world.wait(2.0)
    world.fix()
    world.wait(1.0)
    world.fix()
    world.wait(SETTLE)


def _one_too_deep(world: World) -> None:
    """A single sample beyond the bound: less than R5 asks for."""
    depth = world.sea.depth
    world.wait(2.0 - (world.now % 2.0) + 0.1)
    world.sea.depth = depth + 1.0
    world.say(encode(SetSafety(depth=max(depth - 0.5, 0.1))))
    world.wait(2.0)
    world.say(encode(SetSafety(depth=60000.0)))
    world.wait(2.0)


_AT_SURFACE = frozenset({"surface"})
READINGS = (
    Event("good reports", _play(_reports)),
    Event("fixes at the surface", _play(_fixes), also=_AT_SURFACE),
    Event("one sample too deep", _play(_one_too_deep), "SP"),
    Event("depth missing", _missing("depth"), sensor="depth", after=6.0, also=frozenset({"blind"})),
    Event("altitude missing", _missing("altitude", 15.0), sensor="altitude", after=6.0),
    Event("heading missing", _missing("yaw", 15.0), sensor="heading", after=6.0),
    Event("temperature missing", _missing("temperature"), sensor="temperature", after=30.0),
    Event("depth absurd", _absurd("depth", 2000.0), sensor="depth", also=frozenset({"blind"})),
    Event("altitude absurd", _absurd("altitude", -1.0), sensor="altitude"),
    Event("heading absurd", _absurd("yaw_offset_deg", 400.0), sensor="heading"),
    Event("temperature absurd", _absurd("temperature", -50.0), sensor="temperature"),
    Event("depth frozen", _frozen("depth"), sensor="depth", after=11.0, also=frozenset({"blind"})),
    Event("altitude frozen", _frozen("altitude"), sensor="altitude", after=11.0),
    Event("heading frozen", _frozen("yaw"), sensor="heading", after=11.0),
)


# --- answers, time, restart ----------------------------------------------------------------


def _answers(letter: str) -> Play:
    def play(world: World) -> None:
        world.answers = letter
        if letter:
            world.hear(f"@ACK_ZA{letter}$".encode())
        world.wait(4.0)

    return _play(play)


def _leg_ends(world: World, configuration: Configuration, chart: Chart) -> None:
    world.answers = "Y"
    _end_leg(world, configuration, chart)
    world.wait(2.0)


def _minute(depth: float) -> Play:
    """Of silence; the vehicle is heard again just before its end."""

    def play(world: World) -> None:
        world.reports = False
        world.wait(56.0)
        world.sea.depth, world.reports = depth, True
        world.wait(7.0)

    return _play(play)


def _rises(world: World) -> None:
    world.answers = "Y"
    world.say(b"@ZAWF$")
    world.wait(2.0)
    world.sea.depth = SHALLOW
    world.wait(10.0)


def _rises_by_thrust(world: World) -> None:
    world.answers, world.sea.depth = "Y", DEEP
    world.say(b"@ZAWF$")
    world.rises_by = b"@ZAU12$"
    world.wait(24.0)


def _unanswered_stop(world: World) -> None:
    world.answers = ""
    world.say(b"@ZAX0$")
    world.wait(2.5)
    world.answers = "Y"
    world.wait(2.0)


def _restarts(world: World) -> None:
    world.wait(0.05)
    world.restart()
    world.wait(SETTLE)


_SILENCE = frozenset({"silence", "minute"})
OTHERS = (
    Event("ACK Y", _answers("Y")),
    Event("ACK N", _answers("N"), also=frozenset({"deaf"})),
    Event("no ACK", _answers(""), also=frozenset({"deaf"})),
    Event("the leg's time is up", _leg_ends),
    Event("a minute of silence, deep", _minute(DEEP), also=_SILENCE),
    Event("a minute of silence, then at the surface", _minute(SHALLOW), also=_SILENCE),
    Event("W, and it rises", _play(_rises), "W", "rises"),
    Event("W does not stick, U12 does", _play(_rises_by_thrust), "W", "rises"),
    Event("X, answered late", _play(_unanswered_stop), "X", also=frozenset({"deaf"})),
    Event("restart", _play(_restarts), also=frozenset({"restart"})),
)

EVENTS: tuple[Event, ...] = (*COMMANDS, *LIMITS, *READINGS, *OTHERS)
