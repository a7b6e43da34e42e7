"""The other events: every reading, every answer, time, a restart; and the table of all events.

Readings come in the vehicle's report. Every event is played in every configuration. Where it must
not do anything, the laws ask just that.

What does not live here: what operators send (commands), limits (limit_events), what must follow
(laws).
"""

from __future__ import annotations

import itertools

from mission.engine.ending import STAYS_UP
from mission.model import Chart
from mission.model.tables import Table, derived
from mission.verification.exhaustive.added_events import ADDED_EVENTS
from mission.verification.exhaustive.cell import Configuration, Event
from mission.verification.exhaustive.commands import (
    COMMANDS,
    SETTLE,
    TURN,
    Play,
    behind,
    of_word,
    script,
)
from mission.verification.exhaustive.configurations import SHALLOW
from mission.verification.exhaustive.doubts import DOUBTS
from mission.verification.exhaustive.exit_inputs import come_true, end_leg
from mission.verification.exhaustive.limit_events import LIMITS, sinks
from mission.verification.exhaustive.lines import (
    ANSWERS,
    NO_TEMPERATURE,
    U12,
    WATER,
    Line,
    told,
    ways_of,
)
from mission.verification.exhaustive.world import World
from protocol.messages import SetSafety
from protocol.operator_words import WORDS
from protocol.topside import encode

PROVED = 9.0  # s: 6 s of a shallow depth (R7), and the reports before and after

# --- readings ------------------------------------------------------------------------------


def _missing(field: str, seconds: float = 8.9) -> Play:
    def play(world: World) -> None:
        world.sea.unknown.add(field)
        world.wait(seconds)

    return script(play)


def _absurd(attribute: str, value: float) -> Play:
    def play(world: World) -> None:
        setattr(world.sea, attribute, value)
        world.report()  # so that a handler that is due before the next report has the reading
        world.wait(8.9)

    return script(play)


def _frozen(field: str) -> Play:
    def play(world: World) -> None:
        world.wait(2.0)
        world.sea.frozen.add(field)
        world.wait(17.0)

    return script(play)


def _all_missing(world: World) -> None:
    world.sea.unknown |= {"depth", "altitude", "yaw", "roll", "pitch", "temperature"}
    world.wait(15.0)


def _missing_for_a_while(world: World) -> None:
    world.sea.unknown.add("depth")
    world.wait(3.5)
    world.sea.unknown.clear()
    world.wait(4.0)


def _reports(world: World) -> None:
    world.wait(4.1)


def _half_a_minute(world: World) -> None:
    world.wait(26.0)


def _fixes(world: World) -> None:
    world.put(SHALLOW)
    world.wait(2.0)
    world.fix()
    world.wait(1.0)
    world.fix()
    world.wait(SETTLE)


def _one_too_deep(world: World) -> None:
    """One sample beyond the bound, which is too few for the limit to act (R5)."""
    depth, period = world.sea.depth, world.line.period
    world.wait(period - world.now % period + 0.05 * period)
    world.sea.depth = depth + 1.0
    world.say(encode(SetSafety(depth=max(depth - 0.5, 0.1))))
    world.wait(period)
    world.say(encode(SetSafety(depth=60000.0)))
    world.wait(2.0 + SETTLE)  # what the last report causes is stored once its commands have left


_AT_SURFACE = frozenset({"surface"})
READINGS = (
    Event("good reports", script(_reports)),
    Event("good reports for half a minute", script(_half_a_minute)),
    Event("fixes at the surface", script(_fixes), also=_AT_SURFACE, needs=told("position")),
    Event(
        "one sample too deep",
        script(_one_too_deep),
        "SP",
        also=frozenset({"deeper"}),
        needs=told("depth"),
    ),
    Event(
        "depth missing",
        _missing("depth"),
        sensor="depth",
        after=2.1,
        also=frozenset({"blind"}),
        needs=told("depth"),
    ),
    Event(
        "altitude missing",
        _missing("altitude", 15.0),
        sensor="altitude",
        after=2.1,
        needs=told("altitude"),
    ),
    Event(
        "heading missing",
        _missing("yaw", 15.0),
        sensor="heading",
        after=2.1,
        needs=told("heading"),
    ),
    Event(
        "attitude missing", _missing("roll"), sensor="attitude", after=2.1, needs=told("attitude")
    ),
    Event(
        "all missing",
        script(_all_missing),
        sensor="all",
        after=2.1,
        also=frozenset({"blind"}),
        needs=told("depth"),
    ),
    Event("depth missing for 4 s", script(_missing_for_a_while), needs=told("depth")),
    Event(
        "temperature missing",
        _missing("temperature"),
        sensor="temperature",
        after=30.0,
        needs=frozenset({NO_TEMPERATURE}),
    ),
    Event(
        "depth absurd",
        _absurd("depth", 2000.0),
        sensor="depth",
        also=frozenset({"blind"}),
        needs=told("depth"),
    ),
    Event("altitude absurd", _absurd("altitude", -1.0), sensor="altitude", needs=told("altitude")),
    Event(
        "heading absurd", _absurd("yaw_offset_deg", 600.0), sensor="heading", needs=told("heading")
    ),
    Event("attitude absurd", _absurd("roll_deg", 400.0), sensor="attitude", needs=told("attitude")),
    Event(
        "temperature absurd",
        _absurd("temperature", -50.0),
        sensor="temperature",
        needs=told("temperature"),
    ),
    Event(
        "depth frozen",
        _frozen("depth"),
        sensor="depth",
        after=11.0,
        also=frozenset({"blind"}),
        needs=told("depth"),
    ),
    Event(
        "altitude frozen",
        _frozen("altitude"),
        sensor="altitude",
        after=11.0,
        needs=told("altitude"),
    ),
    Event("heading frozen", _frozen("yaw"), sensor="heading", after=11.0, needs=told("heading")),
    Event(
        "attitude frozen", _frozen("roll"), sensor="attitude", after=11.0, needs=told("attitude")
    ),
)


# --- answers, time, restart ----------------------------------------------------------------


def _answers(letter: str) -> Play:
    def play(world: World) -> None:
        world.answers = letter
        if letter:
            world.hear(f"@ACK_ZA{letter}$".encode())
        world.wait(4.0)

    return script(play)


def _leg_ends(world: World, configuration: Configuration, chart: Chart) -> None:
    world.answers = "Y"
    end_leg(world, configuration, chart)
    world.wait(2.0)


def _minute(*, deep: bool) -> Play:
    """A minute without reports; they come again just before its end."""

    def play(world: World) -> None:
        world.reports = False
        world.wait(56.0)
        world.sea.depth, world.reports = world.deep if deep else SHALLOW, True
        world.wait(7.0)

    return script(play)


def _minute_blind(world: World) -> None:
    world.reports = False
    world.wait(40.0)
    world.sea.unknown.add("depth")
    world.reports = True
    world.wait(23.0)


def _rises(world: World) -> None:
    world.answers = "Y"
    world.say(b"@ZAWF$")
    world.wait(2.0)
    world.put(SHALLOW)
    world.wait(10.0)


def _rises_by_thrust(world: World) -> None:
    """Rise by full thrust, not by W. If both have the same bytes, rise in the second round."""
    world.answers = "Y"
    world.put(world.deep)
    world.say(b"@ZAWF$")
    world.wait(SETTLE)
    world.rises_by = U12
    ways = ways_of(world.line)
    world.wait(TURN * (ways.index(U12) or len(ways)) + 14.0 + behind(world))


def _sinks_for_ever(world: World) -> None:
    world.answers = "Y"
    world.put(world.deep)
    world.say(b"@ZAWF$")
    world.wait(45.0)


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


def _line_is_back(world: World) -> None:
    world.wait(0.05)
    world.line_is_back()
    world.wait(2.0)


def _ends(*, deep: bool) -> Play:
    def play(world: World) -> None:
        world.answers = "Y"
        world.put(world.deep if deep else SHALLOW)
        world.wait(8.5)
        world.end()
        world.wait(1.0 if deep else PROVED + STAYS_UP)  # the program first sees whether it floats

    return script(play)


def _ends_at_once(world: World) -> None:
    world.answers = "Y"
    world.put(world.deep)
    world.wait(4.5)
    world.end(at_once=True)
    world.wait(15.0)


_SILENCE = frozenset({"silence", "minute"})
_ANSWERED, _WET = frozenset({ANSWERS}), frozenset({WATER})
OTHERS = (
    Event("ACK Y", _answers("Y"), needs=_ANSWERED),
    Event("ACK N", _answers("N"), also=frozenset({"deaf"}), needs=_ANSWERED),
    Event("no ACK", _answers(""), also=frozenset({"deaf"}), needs=_ANSWERED),
    Event("the leg's time is up", _leg_ends),
    Event("what the leg waits for", come_true),
    Event("a minute of silence, deep", _minute(deep=True), also=_SILENCE | {"deeper"}, needs=_WET),
    Event("a minute of silence, then at the surface", _minute(deep=False), also=_SILENCE),
    Event(
        "a minute of silence, the depth unknown",
        script(_minute_blind),
        also=_SILENCE,
        needs=told("depth"),
    ),
    Event("W, and nothing helps", script(_sinks_for_ever), "W", "sinks", needs=_WET),
    Event("W, and it rises", script(_rises), "W", "rises", needs=_WET),
    Event("W does not stick, U12 does", script(_rises_by_thrust), "W", "rises", needs=_WET),
    Event(
        "X, answered late", script(_unanswered_stop), "X", also=frozenset({"deaf"}), needs=_ANSWERED
    ),
    Event("the line is back", script(_line_is_back), also=frozenset({"line"})),
    Event("the program is to end, deep", _ends(deep=True), also=frozenset({"end"}), needs=_WET),
    Event("the program is to end, at the surface", _ends(deep=False), also=frozenset({"end"})),
    Event("the program ends at once", script(_ends_at_once), also=frozenset({"end", "last"})),
    Event("it sinks slowly", sinks(0.3, 10), also=frozenset({"sinks"}), needs=_WET),
    Event("restart", script(_restarts), also=frozenset({"restart"})),
)

EVENTS: Table[str, Event] = Table(
    lambda event: event.name, (*COMMANDS, *LIMITS, *READINGS, *OTHERS, *DOUBTS, *ADDED_EVENTS)
)


@derived(EVENTS, WORDS)
def events() -> tuple[Event, ...]:
    """Return the events of the table, and those of operator commands that have no row."""
    said = {event.command for event in EVENTS.values()}
    more = (of_word(word) for word in WORDS.values() if word.code not in said)
    return (*EVENTS.values(), *itertools.chain.from_iterable(more))


def events_of(line: Line) -> list[Event]:
    """Return the events that can happen to the vehicle of this line."""
    return [event for event in events() if event.needs <= line.has]
