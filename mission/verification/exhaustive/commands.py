"""Events from operators: every command, by every path.

Commands are encoded as a console does it. Every event is played in every configuration. Where it
must not do anything, the laws ask just that. An operator command without a row is sent as its
examples show it, so a new command is tried, too.

What does not live here: what happens to the vehicle (events), what must follow (laws).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mission.model import Chart
from mission.onboard.runtime.frontseat import HELD_S
from mission.verification.exhaustive.cell import Configuration, Event
from mission.verification.exhaustive.lines import ways_of
from mission.verification.exhaustive.world import TENDER, World
from protocol.messages import MissionLine, SetSafety, SetTime
from protocol.operator_words import OperatorWord
from protocol.topside import encode

Play = Callable[[World, Configuration, Chart], None]


def pool(vehicle: str) -> tuple[str, ...]:
    """Return the lines of a mission that every vehicle can fly."""
    return (
        f"mission pool vehicle {vehicle}",
        "safety radius 100 time 5min depth 5",
        "start without fix",
        "a: gear 4 for 20",
    )


FIRST = pool("auv")[0]
WIDE = encode(SetSafety(radius=60000.0))
LOOSE = encode(SetSafety(radius=65000.0))
FALSE_HEAD = b"#\x02\x80\x0c\x01"  # noise that looks like the head of a content of 3200 bytes
COPIED = 6.0  # s by which a copy is late: all is answered, and the 5 s for two paths are over
TURN = 10.0  # s that each way of an ascent has (R7)
SETTLE = 0.3  # s for the line and an answer of the STM32
_PASSED = HELD_S + SETTLE  # s: a relay waits for an answer that never comes
BELOW = 3.0  # s for the modem
WORD = "word"  # the path (the boat's) of an event that is made of a row of WORDS


def script(of: Callable[[World], None]) -> Play:
    return lambda world, configuration, chart: of(world)


def _says(frame: bytes, seconds: float = SETTLE) -> Play:
    def play(world: World) -> None:
        world.say(frame)
        world.wait(seconds)

    return script(play)


def _other_says(frame: bytes) -> Play:
    """Another connection sends a frame while the boat is the commander."""

    def play(world: World) -> None:
        world.say(WIDE)
        world.at_once = ""
        world.say(frame, TENDER)
        world.wait(SETTLE)

    return script(play)


def _later_says(frame: bytes) -> Play:
    """Another connection sends a frame after the boat was silent long enough (R12)."""

    def play(world: World) -> None:
        world.wait(10.5)
        world.at_once = ""
        world.say(frame, TENDER)
        world.wait(SETTLE)

    return script(play)


def _below(frame: bytes) -> Play:
    def play(world: World) -> None:
        world.say_below(frame)
        world.wait(BELOW)

    return script(play)


def _both(world: World) -> None:
    world.say_below(b"@RSCOOCCCC$")
    world.wait(0.5)
    world.say(b"@RSCOOCCCC$")
    world.wait(_PASSED)


def _start_while_staging(world: World) -> None:
    world.say(encode(MissionLine(2, 1, FIRST)))
    world.say(b"@AA$")
    world.wait(SETTLE)


def _uploads(world: World) -> None:
    lines = pool(world.vehicle.name)
    for number, line in enumerate(lines, 1):
        world.say(encode(MissionLine(len(lines), number, line)))
    world.wait(SETTLE)


def _nodes_answer(world: World) -> None:
    world.say(b"@NSOOOOOO$")
    for node in (b"STM32", b"BDGPS", b"UACM", b"CAMERA"):
        world.node(node + b" O\n")
    world.wait(SETTLE)


def _closes(world: World, letters: bytes, closed: str = "") -> None:
    world.say(b"@NS" + letters + b"$")
    for node in ("STM32", "BDGPS", "UACM", "CAMERA"):
        world.node(f"{node} {'C' if node == closed else 'O'}\n".encode())
    world.wait(SETTLE)


def _modem_closes(world: World) -> None:
    _closes(world, b"OOOCOO", "UACM")


def _camera_closes(world: World) -> None:
    _closes(world, b"OOOOCO", "CAMERA")


def _pi_closes(world: World) -> None:
    _closes(world, b"COOOOO")


def _sticks_and_starts(world: World) -> None:
    """Hold the stick for 6 s, then send @AA. The vehicle sends no report meanwhile."""
    world.reports = False
    for _ in range(30):
        world.say(b"@MMF5$")
        world.wait(0.2)
    world.wait(2.0)
    world.at_once = ""
    world.say(b"@AA$")
    world.wait(1.0)
    world.reports = True
    world.wait(3.0)


def _pushes(frame: bytes, words: int = 2) -> Play:
    """Send ``words`` M. The state after the second counts: the first takes no emergency over
    (R6)."""

    def play(world: World) -> None:
        for said in range(words):
            if said < 2:
                world.at_once = ""
            world.say(frame)
            world.wait(0.2)
        world.wait(SETTLE)

    return script(play)


def _clears_again(world: World) -> None:
    world.say(b"@AC$")
    world.wait(6.0)
    world.at_once = ""
    world.say(b"@AC$")
    world.wait(SETTLE)


def _clears_blind(world: World) -> None:
    world.sea.unknown.add("depth")
    world.wait(2.1)
    _clears_again(world)


def _slides(world: World, seconds: float) -> None:
    """Send 60 rudder commands a second; the line carries half of them."""
    for i in range(int(seconds * 60)):
        world.say(b"@DS%d,%d$" % (i % 3 + 1, i % 20))
        world.wait(1.0 / 60.0)


def behind(world: World) -> float:
    """Return by how many s a way comes later because the W came in an ascent, which continues
    (R7)."""
    ascent = world.engine.core.ascent
    again = ascent is not None and ascent.began < world.now - 2.0 * SETTLE
    return TURN * (len(ways_of(world.line)) - 1) if again else 0.0


def _surfaces_under_a_slider(world: World) -> None:
    world.say(b"@ZAWF$")
    _slides(world, 12.0 + behind(world))


def _surfaces_behind_noise(world: World) -> None:
    """Send W by modem after a false head, which keeps the content unfinished for over a second."""
    world.hear_modem(FALSE_HEAD + b"\xff")
    world.at_once = ""
    world.say_below(b"@ZAWF$")
    world.wait(BELOW)


def _starts_late(world: World) -> None:
    world.say(b"@AA$")
    world.wait(COPIED)
    world.say_below(b"@AA$")
    world.wait(BELOW)


def _loosens_late(world: World) -> None:
    for limits in (LOOSE, WIDE):
        world.say(limits)
    world.wait(COPIED)
    world.say_below(LOOSE)
    world.wait(BELOW)


def of_word(word: OperatorWord) -> Iterator[Event]:
    """Return events of a command without a row here, one for each of its examples."""
    for number, frame in enumerate(word.examples, 1):
        yield Event(f"{word.code}, example {number}", _says(frame), word.code, WORD)


def _stick(frame: bytes) -> Event:
    code = frame[1:3].decode()
    return Event(code, _says(frame), code, word=frame)


_TIME = encode(SetTime("2026-03-01T12:00:00"))
_STOPS_BEHIND = frozenset({"X", "M", "AA"})
# fmt: off
COMMANDS = (
    Event("X", _says(b"@ZAX0$"), "X"),
    Event("W", _says(b"@ZAWF$"), "W"),
    Event("X of another connection", _other_says(b"@ZAX0$"), "X", "tender"),
    Event("W of another connection", _other_says(b"@ZAWF$"), "W", "tender"),
    Event("W under a slider", script(_surfaces_under_a_slider), "W", "slider"),
    Event("W by modem behind noise", script(_surfaces_behind_noise), "W", "modem"),
    Event("X by modem", _below(b"@ZAX0$"), "X", "modem"),
    Event("W by modem", _below(b"@ZAWF$"), "W", "modem"),
    Event("X among others in one burst", _says(b"@AA$@ZAX0$"), "X", also=_STOPS_BEHIND),
    Event("X and W again", _says(b"@ZAX0$@ZAWF$@ZAX0$"), "X", also=frozenset({"W"})),
    _stick(b"@MMF5$"),
    _stick(b"@MT1,-10$"),
    _stick(b"@MDA2,-2$"),
    _stick(b"@MRL5$"),
    _stick(b"@MS120,-90$"),
    _stick(b"@MP120,-90$"),
    Event("M of another connection", _other_says(b"@MMF5$"), "MM", "tender"),
    Event("M by modem", _below(b"@MMF5$"), "MM", "modem"),
    Event("M held for 2 s", _pushes(b"@MMF5$", 10), "MM", "push"),
    Event("MT, a push", _pushes(b"@MT1,-10$"), "MT", "push", word=b"@MT1,-10$"),
    Event("M of a stick that was held, which have waited", _says(b"@MMF5$" * 10), "MM", "waited"),
    Event("AA", _says(b"@AA$", 3.0), "AA"),
    Event("AA of another connection", _other_says(b"@AA$"), "AA", "tender"),
    Event("AA while staging", script(_start_while_staging), "AA", "staging"),
    Event("MM, neutral", _says(b"@MMF0$"), "MM", also=frozenset({"neutral"})),
    Event("AA, and once more by modem", script(_starts_late), path="both",
          also=frozenset({"AA", "copy"})),
    Event("AC", _says(b"@AC$"), "AC"),
    Event("AC again after 6 s", script(_clears_again), "AC", "again"),
    Event("AC again, the depth unknown", script(_clears_blind), "AC", "again", sensor="depth",
          after=2.1, also=frozenset({"blind"})),
    Event("AC of another connection", _other_says(b"@AC$"), "AC", "tender"),
    Event("AC of another, the boat silent", _later_says(b"@AC$"), "AC"),
    Event("AW, a line", _says(encode(MissionLine(2, 1, FIRST))), "AW"),
    Event("AW, a whole mission", script(_uploads), "AW", "whole"),
    Event("AW, a line out of place", _says(encode(MissionLine(9, 4, FIRST))), "AW", "misplaced"),
    Event("AQ", _says(b"@AQ$"), "AQ"),
    Event("DU", _says(b"@DU$"), "DU"),
    Event("NI", _says(b"@NI$"), "NI"),
    Event("ST", _says(_TIME), "ST"),
    Event("ST by modem", _below(_TIME), "ST", "modem"),
    Event("SP", _says(WIDE), "SP"),
    Event("SP twice, the first once more by modem", script(_loosens_late), path="both",
          also=frozenset({"SP", "copy"})),
    Event("SP with an item missing", _says(b"@SP,100,5,20$"), "SP", "broken"),
    Event("RS", _says(b"@RSCOOCCCO$", _PASSED), "RS"),
    Event("RI", _says(b"@RI$", _PASSED), "RI"),
    Event("RS by both paths", script(_both), "RS", "both"),
    Event("rudder", _says(b"@DS3,20$", _PASSED), "D"),
    Event("rudder, a step", _says(b"@DA2,-2$", _PASSED), "D"),
    Event("rudder of another connection", _other_says(b"@DS3,20$"), "D", "tender"),
    Event("NS, all open", script(_nodes_answer), "NS", "open"),
    Event("NS, AUTO closed", _says(b"@NSOOOOOC$", 1.0), "NS", "auto"),
    Event("NS, UACM closed", script(_modem_closes), "NS", "uacm"),
    Event("NS, CAMERA closed", script(_camera_closes), "NS", "camera"),
    Event("NS, Pi closed", script(_pi_closes), "NS", "pi"),
    Event("NS, a node that does not answer", _says(b"@NSOOOCOO$", 5.5), "NS", "unanswered"),
    Event("NS, STM32 closed", _says(b"@NSOCOOOO$"), "NS", "stm32"),
    Event("a Z that is not the operator's", _says(b"@ZAF11$@ZAS77$"), "Z"),
    Event("X and W with another argument", _says(b"@ZAX1$@ZAW0$"), "Z"),
    Event("the stick for 6 s, then AA", script(_sticks_and_starts), "AA", "after the stick",
          also=frozenset({"M"})),
    Event("noise", _says(b"@ZA\xff\x00W0$@@AAX$@M"), "noise"),
)
# fmt: on
