"""Laws of a flight, by the truth of the body and the bytes on the wire.

Each is a function of the flight that returns what is wrong, or nothing. Times are the sea's. A mark is
a time that the scene's script has put on record (`World.mark`): `due` is when an ascent was asked for
or became due, and everything after it is judged as "nothing wants the vehicle under water".

Figures come from docs/rules.md and, where those leave a figure open, from physics:
a report may be 2 s old and two of them are needed; this hull rises at 0.25 m/s by itself.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from tests.sea.world import Sample, World

Law = Callable[[World], str]
UPWARD = re.compile(r"@ZA(WF|U(?:[1-9]|1[0-2]))\$")
TURNING = re.compile(r"@(ZA(WF|[UDFBLR](?:[1-9]|1[0-2])\$|[SE][1-9])|M)")
SURFACE = 1.0  # m of true depth that count as home
HELD = 3.0  # m, the same for a body that is heavier than water
MARGIN = 6.0  # m beyond the mission's depth limit that detection may cost


@dataclass(frozen=True)
class Said:
    """A word on the wire to the board."""

    at: float
    text: str


def said(
    world: World, pattern: str | re.Pattern[str], since: float = 0.0, until: float = 1e9
) -> list[Said]:
    """Words to the board that match, in a time."""
    return [
        Said(word.at, word.text)
        for word in world.board.words
        if since <= word.at <= until and re.search(pattern, word.text)
    ]


def _since(world: World, mark: str) -> list[Sample]:
    at = world.marks.get(mark)
    return [] if at is None else [sample for sample in world.samples if sample.at >= at]


def reached(mark: str = "due") -> Law:
    """The scene came to what it is about."""
    return lambda world: "" if mark in world.marks else f"the scene never came to '{mark}'"


def home(within: float, depth: float = SURFACE, off: bool = True) -> Law:
    """From `due` on: at the surface in this time, there at the end, and thrusters off (where asked)."""

    def law(world: World) -> str:
        after = _since(world, "due")
        first = next((sample for sample in after if sample.depth < depth), None)
        if not after:
            return ""
        last = after[-1]
        if first is None or first.at - after[0].at > within:
            when = "never" if first is None else f"{first.at - after[0].at:.0f} s"
            return f"not at the surface within {within:.0f} s ({when}), now {last.depth:.1f} m deep"
        tail = [sample for sample in after if sample.at > last.at - 15]
        if max(sample.depth for sample in tail) >= depth:
            return (
                f"up after {first.at - after[0].at:.0f} s, but {last.depth:.1f} m deep at the end"
            )
        if off and any(sample.turning for sample in tail):
            return f"at the surface, but thrusters turn at the end ({last.up:+.0f})"
        return ""

    return law


def never_deeper(limit: float) -> Law:
    """True depth at most the limit and what detection may cost."""

    def law(world: World) -> str:
        worst = max(sample.depth for sample in world.samples)
        return f"{worst:.1f} m deep, {limit:.0f} m allowed" if worst > limit else ""

    return law


def held_deep(depth: float, since: str, until: str) -> Law:
    """Between two marks it stays deeper than this: nothing has ended the mission."""

    def law(world: World) -> str:
        if missed := reached(since)(world) or reached(until)(world):
            return missed
        begin, end = world.marks[since], world.marks[until]
        high = [s for s in world.samples if begin <= s.at <= end and s.depth < depth]
        return (
            f"{high[0].depth:.1f} m deep {high[0].at - begin:.0f} s after {since}" if high else ""
        )

    return law


def upward_within(seconds: float, mark: str = "due") -> Law:
    """An upward word leaves within this time of a mark."""

    def law(world: World) -> str:
        if missed := reached(mark)(world):
            return missed
        at = world.marks[mark]
        if said(world, UPWARD, at, at + seconds):
            return ""
        later = said(world, UPWARD, at)
        when = f"after {later[0].at - at:.1f} s" if later else "never"
        return f"no upward word within {seconds:.0f} s of {mark} ({when})"

    return law


def word_within(pattern: str, seconds: float, mark: str) -> Law:
    """Such a word leaves within this time of a mark."""

    def law(world: World) -> str:
        if missed := reached(mark)(world):
            return missed
        at = world.marks[mark]
        if said(world, pattern, at, at + seconds):
            return ""
        return f"no {pattern} within {seconds:.0f} s of {mark}"

    return law


def held_up(patience: float = 50.0, sink: float = 2.3) -> Law:
    """From `due` on: deeper than `sink` and not 0.5 m higher than `patience` s ago: a word upward.

    Three ways take turns, full thrust for 20 s when it comes again and letting go for 20 s behind a push
    that led deeper; so 50 s without an upward word are a way out of turn.
    """

    def law(world: World) -> str:
        after = _since(world, "due")
        if not after:
            return ""
        began: Sample | None = None
        for sample in after:
            if sample.depth < sink or (began and sample.depth < began.depth - 0.5):
                began = None
            elif began is None:
                began = sample
            elif sample.at - began.at > patience and not said(world, UPWARD, began.at, sample.at):
                return (
                    f"{patience:.0f} s under water from {began.at - after[0].at:.0f} s after due, "
                    f"{began.depth:.1f} to {sample.depth:.1f} m, and no upward word"
                )
            elif said(world, UPWARD, sample.at - 0.05, sample.at):
                began = sample
        return ""

    return law


def passed(within: float = 0.2, pattern: bytes = rb"@ZA(X0|WF)\$") -> Law:
    """Each X and W of an operator is on the wire to the board within this time."""

    def law(world: World) -> str:
        sent = [pair for boat in world.operators for pair in boat.sent]
        for at, frame in sent + (world.acoustic.sent if world.acoustic else []):
            if not re.fullmatch(pattern, frame):
                continue
            text = frame.decode()
            if not said(world, re.escape(text), at, at + within + 0.06):
                later = said(world, re.escape(text), at)
                when = f"{later[0].at - at:.2f} s" if later else "never"
                return f"{text} of {at - 1000:.1f} s reached the board {when} later, {within} s allowed"
        return ""

    return law


def never(pattern: str, since: str, why: str, until: str = "") -> Law:
    """No such word to the board between two marks."""

    def law(world: World) -> str:
        if missed := reached(since)(world):
            return missed
        found = said(world, pattern, world.marks[since], world.marks.get(until, 1e9))
        return (
            f"{found[0].text} at {found[0].at - world.marks[since]:.1f} s: {why}" if found else ""
        )

    return law


def quiet(since: str, until: str = "") -> Law:
    """No word that turns a thruster between two marks."""
    return never(TURNING.pattern, since, "nobody asked for a thruster", until)


def legs(*steps: tuple[str, float]) -> Law:
    """Each leg's set (a pattern) leaves, within so many seconds of the one before (the first: `go`)."""

    def law(world: World) -> str:
        at = world.marks.get("go")
        if at is None:
            return "the mission was not started"
        for pattern, within in steps:
            found = said(world, pattern, at)
            if not found:
                return f"the set {pattern} never left"
            if found[0].at - at > within:
                return (
                    f"the set {pattern} left after {found[0].at - at:.1f} s, {within:.0f} s allowed"
                )
            at = found[0].at
        return ""

    return law


def sinking_noticed(deep: float = 2.6, within: float = 8.0) -> Law:
    """On deck or at the surface: deeper than 2 m, 0.5 m deeper than it has been, and sinking for
    two reports: a word upward (R7).

    2.6 m is out of the sensor's noise; 8 s are two reports (at most 2.1 s apart, the first one just
    before), and 3 s for the word itself.
    """

    def law(world: World) -> str:
        began: float | None = None
        least = math.inf
        for sample in _since(world, "due"):
            least = min(least, sample.depth)
            if sample.depth < max(deep, least + 0.5) or sample.rate < 0.05:
                began = None
            elif began is None:
                began = sample.at
            elif sample.at - began > within:
                if not said(world, UPWARD, began - 25, sample.at):
                    return f"sank for {within:.0f} s, {sample.depth:.1f} m deep, and no upward word"
                began = sample.at
        return ""

    return law


def lives() -> Law:
    """The program ends when a signal asks for it, and not otherwise: not at a start either."""

    def law(world: World) -> str:
        ends = [f"{code} at {at - 1000:.0f} s" for at, code in world.pi.ended]
        return f"serve ended by itself: {', '.join(ends[:5])}" if ends else ""

    return law


def noted(note: str) -> Law:
    """The script noted this answer, and no other of that name."""
    name = note.partition("=")[0] + "="

    def law(world: World) -> str:
        answers = [other for other in world.notes if other.startswith(name)]
        return "" if answers and set(answers) == {note} else f"{note} wanted: {world.notes}"

    return law


def off_within(seconds: float, mark: str = "due") -> Law:
    """Every thruster is told to stand still this soon after a mark, and for 10 s (X is not undone)."""

    def law(world: World) -> str:
        after = _since(world, mark)
        if not after:
            return ""
        at = after[0].at
        turning = [s for s in after if s.turning and at + seconds < s.at < at + 10]
        return f"thrusters turn {turning[0].at - at:.2f} s after {mark}" if turning else ""

    return law


def beating(longest: float, mark: str = "due") -> Law:
    """From a mark on a good frame comes at least this often (R16, R17)."""

    def law(world: World) -> str:
        at = world.marks.get(mark, world.now)
        beats = [at, *(beat for beat in world.board.beats if beat > at), world.now]
        gap = max(b - a for a, b in itertools.pairwise(beats))
        return f"no frame to the board for {gap:.1f} s" if gap > longest else ""

    return law


def told(name: str, never_said: str) -> Law:
    """A command of the operator's (noted as `name=code text`) failed, and did not say this."""

    def law(world: World) -> str:
        note = next((note for note in world.notes if note.startswith(f"{name}=")), "")
        if not note or note.startswith(f"{name}=0 ") or never_said in note:
            return f"{note or name + ' never ended'}: a failure wanted, and not '{never_said}'"
        return ""

    return law
