"""Laws of the states: rows of a name, a source, and a function that judges a cell.

A law returns None if it does not apply to a cell, "" if it holds, else what is wrong. It is written
from the design and the rules alone, never from what the engine does. All laws judge the bytes,
Steps and states of the runtime: R3-R14 and the states of docs/design.md.

What does not live here: laws of legs against limits and readings (leg_laws), of the answers to
operators (operator_laws).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

from mission.engine.restart import UNANSWERED, UNSEEN
from mission.model import (
    IDLE_EMPTY,
    IDLE_READY,
    IMPLICIT_SURFACE,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
)
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.lines import ANSWERS, HELD, LET_GO, WATER, X, surface_word

_AGAIN = re.compile(r" \((?:try )?\d of \d\)$")  # the end of a repeated frame's reason (R1, R18)
_AWAKE = "neutral"  # the beginning of the reason of a frame that keeps a board awake (R16)
STICK_QUIET = 2.0  # s (R6)
AT_ONCE = 0.1  # s within which X and W have left (R7)
AT_SURFACE = 0.5  # m (R7)
DEEP_REST, RISE_TIME = 2.0, 20.0  # m, s (R7)

Verdict = str | None


@dataclass(frozen=True, slots=True)
class Law:
    """``of_legs``: the law is about a kind of leg, which not every mission has. ``needs``: what a
    vehicle must have for the law to apply (lines)."""

    name: str
    source: str
    ask: Callable[[Cell], Verdict]
    of_legs: bool = False
    needs: frozenset[str] = frozenset()


def stays_down(cell: Cell) -> bool:
    """Whether the vehicle was in stopped for 20 s, its time to rise by buoyancy, and is over 2 m
    deep (R7)."""
    since = max((t for t, state in cell.world.states if state == STOPPED), default=math.inf)
    return cell.world.sea.depth > DEEP_REST and cell.world.now - since >= RISE_TIME


def wrong(*faults: tuple[bool, str]) -> str:
    """Return the text of the first fault that is so, "" if none is."""
    return next((words for is_so, words in faults if is_so), "")


# --- X, W, M ---------------------------------------------------------------------------------


def _order(letter: str, target: str) -> Callable[[Cell], Verdict]:
    def ask(cell: Cell) -> Verdict:
        if cell.event.command != letter:
            return None
        frame = X if letter == "X" else surface_word(cell.line)
        left = cell.frames(b"@ZA")
        late = not left or left[0].t > cell.before.t + AT_ONCE
        burst = cell.event.path == "tender"  # the boat sent a command just before
        return wrong(
            (cell.world.at_once not in (target, SURFACED), f"the state is {cell.world.at_once}"),
            (not left or left[0].data != frame, f"{left[:1]} left for the vehicle first"),
            (late and not burst, "it left late"),
        )

    return ask


def _answered(cell: Cell) -> Verdict:
    if cell.event.command not in ("X", "W") or cell.event.path == "modem":
        return None
    if cell.world.answers != "Y" or not cell.configuration.quiet:
        return None
    return wrong((not cell.answers(b"@ACK_Z" + cell.event.command.encode()), "no answer"))


def _taken(cell: Cell) -> bool:
    """Whether an M may take over (R6, R12); an emergency is taken over only by a push."""
    if cell.configuration.region != "emergency":
        return cell.event.path in ("boat", "push", "waited")
    silent = min(cell.before.stick_age, cell.before.emergency_age)
    return cell.event.path == "push" and silent >= STICK_QUIET


def _has_word(cell: Cell) -> bool:
    """Whether the board has frames for this M. An M without a frame changes nothing (R14)."""
    return not cell.event.word or cell.line.steers(cell.event.word)


def _stick(cell: Cell) -> Verdict:
    if not cell.event.command.startswith("M"):
        return None
    relayed = [t for t in cell.frames(b"@M") if t.reason.startswith("relay of")]
    if not (_taken(cell) and _has_word(cell)):
        return wrong(
            (cell.world.at_once != cell.configuration.state, f"now {cell.world.at_once}"),
            (bool(relayed), "it was passed on"),
        )
    return wrong(
        (cell.world.at_once != MANUAL_DRIVING, f"the state is {cell.world.at_once}"),
        (not relayed, "it was not passed on"),
    )


def _no_z_under_the_stick(cell: Cell) -> Verdict:
    """No Z leaves from the first M on, nor while the stick drove the vehicle before."""
    if cell.event.causes - {"M"} or not (
        (cell.event.command.startswith("M") and _taken(cell) and _has_word(cell))
        or cell.configuration.state == MANUAL_DRIVING
    ):
        return None
    if cell.state != MANUAL_DRIVING:
        return None
    driven = min((m.t for m in cell.frames(b"@M")), default=0.0)  # a push is two M
    words = [z for z in cell.frames(b"@ZA") if z.t >= driven]
    return wrong((bool(words), f"{words[:1]} under the stick"))


def _stick_let_go(cell: Cell) -> Verdict:
    """After 2 s without M, X0 leaves and the state is waiting."""
    if cell.configuration.state != MANUAL_DRIVING or cell.event.causes:
        return None
    if cell.world.now - cell.before.t < STICK_QUIET:
        return None
    return wrong(
        (cell.states[1:2] != [MANUAL_WAITING], f"the states are {cell.states}"),
        (not cell.frames(X), "no X0 left"),
    )


def _forgotten(cell: Cell) -> Verdict:
    if "minute" not in cell.event.causes or cell.configuration.region != "manual":
        return None
    deep = cell.world.sea.depth >= AT_SURFACE or "depth" in cell.world.sea.unknown
    if deep and not cell.configuration.auto:
        return wrong((cell.state != MANUAL_WAITING, f"AUTO is closed, and then {cell.state}"))
    if cell.world.sea.depth >= AT_SURFACE:
        return wrong((cell.state != SURFACING, f"deep, and the state is {cell.state}"))
    if "depth" in cell.world.sea.unknown:
        return wrong((cell.state != SURFACING, f"nobody knows how deep, and {cell.state}"))
    idle = IDLE_READY if cell.configuration.loaded else IDLE_EMPTY
    unknown = SURFACING  # the depth was stale when the minute was over
    return wrong((cell.state not in (idle, unknown, SURFACED), f"the state is {cell.state}"))


# --- the map of the states ----------------------------------------------------------------------

_STATES = (IDLE_EMPTY, IDLE_READY, MANUAL_DRIVING, MANUAL_WAITING, STOPPED, SURFACING, SURFACED)
# The causes that may lead from one region to another; "" is the mission's own way, or time.
_LIMITED = frozenset({"limit", "blind", "silence", "deaf", "sinks"})
_SINKING = frozenset({"sinks", "deeper"})  # from rest
_MOVES: dict[tuple[str, str], frozenset[str]] = {
    ("idle", "autonomous"): frozenset({"AA"}),
    ("idle", "manual"): frozenset({"M"}),
    ("idle", "emergency"): frozenset({"X", "W", "limit"}) | _SINKING,
    ("autonomous", "manual"): frozenset({"M"}),
    ("autonomous", "emergency"): frozenset({"X", "W", "restart", "end"}) | _LIMITED,
    ("autonomous", "idle"): frozenset({"NS", ""}),
    ("manual", "autonomous"): frozenset({"AA"}),
    ("manual", "emergency"): frozenset({"X", "W", "minute", "restart", "limit", "end"}) | _SINKING,
    ("manual", "idle"): frozenset({"minute", "restart"}),
    ("emergency", "manual"): frozenset({"M"}),
    ("emergency", "idle"): frozenset({"AC"}),
}


def _known_states(cell: Cell) -> Verdict:
    legs = {s.path for s in cell.chart.states if s.leg is not None}
    strange = [s for s in cell.states if s not in _STATES and s not in legs]
    foreign = cell.event.path == "whole" or not cell.configuration.loaded
    return wrong((bool(strange) and not foreign, f"{strange[:1]}"))


def _moves(cell: Cell) -> Verdict:
    for here, there in pairwise(s.partition("/")[0] for s in cell.states):
        if here == there:
            continue
        causes = _MOVES.get((here, there), frozenset())
        deaf = not cell.configuration.quiet and (here, there) == ("autonomous", "emergency")
        if (here, there) == ("manual", "idle") and WATER not in cell.line.has:
            causes |= {"AA"}  # to the last leg, which ends at once for a vehicle on land
        if not (causes & cell.event.causes or "" in causes or deaf):
            return f"{here} -> {there}: {cell.world.engine.reason}"
    return ""


def _emergency(cell: Cell) -> Verdict:
    """An emergency is left only as R7 says: stopped and surfaced by @AC, all by M. X and W change
    between them, and an ascent ends in surfaced."""
    allowed = {
        (SURFACING, SURFACED): frozenset({""}),
        (STOPPED, IDLE_EMPTY): frozenset({"AC"}),
        (SURFACED, IDLE_EMPTY): frozenset({"AC"}),
        (SURFACED, SURFACING): frozenset({"last"}),  # deep again as the program ends
    }
    asked = None
    for here, there in pairwise(cell.states):
        if not here.startswith("emergency"):
            continue
        asked = ""
        causes = allowed.get((here, there), frozenset())
        causes |= {STOPPED: {"X"}, SURFACING: {"W"}, MANUAL_DRIVING: {"M"}}.get(there, set())
        if "restart" in cell.event.causes:
            continue  # a new program: end_laws
        if there == SURFACING and cell.event.causes & ({"limit"} | _SINKING):
            continue
        if (here, there) == (STOPPED, SURFACING) and stays_down(cell):
            continue
        if not (causes & cell.event.causes or "" in causes):
            return f"{here} -> {there}"
    return "" if cell.configuration.region == "emergency" else asked


def _recorded(cell: Cell) -> Verdict:
    """Every change of state is recorded in a Step that leaves the old and enters the new state."""
    if "restart" in cell.event.causes:
        return None
    at = cell.configuration.state
    for step in cell.steps:
        if not step.entered and not step.exited:
            continue
        if at not in (step.exited[:1] or (at,)):
            return f"a Step leaves {step.exited[:1]} while the state is {at}"
        at = step.entered[-1] if step.entered else at
    placed = "time is up" in cell.event.name or cell.event.limit == "no answer"
    return wrong((at != cell.state and not placed, f"the Steps end in {at}, not in {cell.state}"))


def _under_way(cell: Cell) -> Verdict:
    """A mission or an emergency is stored as under way for a restart; idle is not."""
    kept = cell.world.store.content.under_way
    region = cell.region if cell.event.path != "whole" else kept.partition("/")[0]
    if region == "manual" and not cell.configuration.leaf:
        return None
    latched = region in ("autonomous", "emergency") or (
        region == "manual" and cell.configuration.region == "autonomous"
    )
    return wrong(
        (latched and not kept, f"nothing is kept in {cell.state}"),
        (region == "idle" and kept not in ("", UNANSWERED, UNSEEN), f"{kept} is kept in idle"),
    )


# --- what is sent -----------------------------------------------------------------------------


def _reasons(cell: Cell) -> Verdict:
    """Every command is in a Step with the same reason, or relays an operator's frame."""
    if not cell.frames():
        return None
    known = {words.split(": ", 1)[1] for s in cell.world.notes.steps for words in s.actions}
    for tx in cell.frames():
        reason = _AGAIN.sub("", tx.reason).removesuffix(HELD)
        if reason.startswith((LET_GO, _AWAKE)) and ANSWERS not in cell.line.has:
            continue
        relay = reason.startswith("relay of") and not tx.data.startswith(b"@Z")
        if not relay and reason not in known:
            return f"{tx.data!r} left because of {tx.reason!r}"
    return ""


def _after_stopped(cell: Cell) -> Verdict:
    """After stopped, only X0 and what operators asked for leaves."""
    if cell.configuration.state != STOPPED:
        return None
    if cell.event.causes & {"W", "M", "restart"} or SURFACING in cell.states:
        return None
    others = [t for t in cell.frames(b"@Z") if t.data != X]
    strange = [t for t in cell.frames() if t.data[:2] not in (b"@Z", b"@R", b"@D", b"@O")]
    return wrong((bool(others + strange), f"{(others + strange)[:1]} left"))


def _stop_repeats(cell: Cell) -> Verdict:
    """X0 leaves at least every 500 ms until it is acknowledged, and then no longer."""
    if cell.event.name != "X, answered late":
        return None
    times = [t.t - cell.before.t for t in cell.frames(X)]
    gaps = [b - a for a, b in pairwise(times)]
    return wrong(
        (len([t for t in times if t <= 2.5]) < 5, f"X0 left at {times}"),
        (any(gap > 0.55 for gap in gaps), f"X0 left at {times}"),
        (bool(times) and times[-1] > 3.3, "X0 leaves after it was acknowledged"),
    )


def _quiet_idle(cell: Cell) -> Verdict:
    """In idle, no Z leaves unasked."""
    if cell.configuration.region != "idle" or cell.region != "idle" or len(cell.states) > 1:
        return None
    if cell.event.causes & {"restart", "line"}:
        return None
    return wrong((bool(cell.frames(b"@Z")), f"{cell.frames(b'@Z')[:1]} left in idle"))


def _line_was_away(cell: Cell) -> Verdict:
    """After the line was disconnected, a stop, a leg's set and an ascent's command are sent again,
    since the board need not have received what was acknowledged. Nothing else leaves."""
    if "line" not in cell.event.causes or cell.region != cell.configuration.region:
        return None
    left = [t.data for t in cell.frames(b"@Z")]
    stopped = cell.state in (STOPPED, SURFACED)
    if stopped or cell.region == "idle":
        other = set(left) - {X}
        return wrong((bool(other) or (stopped and not left), f"{left} left in {cell.state}"))
    if cell.region == "manual":
        return wrong((cell.state == MANUAL_DRIVING and bool(left), f"{left} left under the stick"))
    holds = len(cell.states) == 1 and (cell.state == SURFACING or cell.leg is not None)
    return wrong((holds and not left, "what holds was not said again"))


def _to_the_surface(cell: Cell) -> Verdict:
    """From everywhere, W leads to the surface by whichever way works, and there to X0 (R7)."""
    if cell.event.path != "rises":
        return None
    last = cell.frames(b"@Z")[-1:]
    return wrong(
        (cell.state != SURFACED, f"the state is {cell.state}"),
        (not last or last[0].data != X, f"{last} was the last"),
    )


def _comes_up_alone(cell: Cell) -> Verdict:
    """Without operator and reports, a vehicle under way or left by the stick surfaces."""
    if "silence" not in cell.event.causes and cell.event.limit != "telemetry":
        return None
    c = cell.configuration
    if c.region != "autonomous" and not (c.region == "manual" and "minute" in cell.event.causes):
        return None
    if c.region == "manual" and (cell.world.sea.depth < AT_SURFACE or not c.auto):
        return None
    return wrong((cell.region != "emergency", f"the state is {cell.state}"))


def _implicit_end(cell: Cell) -> Verdict:
    """A mission ends only out of the implicit leg, with everything stopped."""
    ended = [
        step for step in cell.steps if step.trigger != "auto off" and IDLE_READY in step.entered
    ]
    ended = [s for s in ended if s.exited and s.exited[0].startswith("autonomous")]
    if not ended:
        return None
    return wrong(
        (ended[0].exited[0] != IMPLICIT_SURFACE, f"out of {ended[0].exited[0]}"),
        (not ended[0].actions or "stopped" not in ended[0].actions[0], "nothing was stopped"),
    )


STATE_LAWS: tuple[Law, ...] = (
    Law("X acts from everywhere within the step", "R7", _order("X", STOPPED)),
    Law("W acts from everywhere within the step", "R7", _order("W", SURFACING)),
    Law("who gave X or W hears what became of it", "R7, R12", _answered),
    Law("M takes over at once, an emergency by a push behind 2 s of silence", "R6", _stick),
    Law("under the stick no Z leaves", "R6", _no_z_under_the_stick),
    Law("2 s after the stick everything is stopped", "R6", _stick_let_go),
    Law("60 s after the stick: idle at the surface, surfacing where deep", "R6", _forgotten),
    Law("only states that the design knows", "design: the states", _known_states),
    Law("from region to region only for a cause", "design: the states, R5-R8", _moves),
    Law("no exit from an emergency but R7's", "R7", _emergency),
    Law("every change of state is on record", "design: the states", _recorded),
    Law("what is under way is kept for a restart", "design: the states", _under_way),
    Law("no command without a reason", "design: the states", _reasons),
    Law("after stopped nothing leaves but what is allowed", "R7", _after_stopped),
    Law(
        "X0 every 500 ms until it is acknowledged", "R7", _stop_repeats, needs=frozenset({ANSWERS})
    ),
    Law("in idle nothing leaves that nobody asked for", "design: the states", _quiet_idle),
    Law("behind a line that was away what holds is said again", "R7, R8", _line_was_away),
    Law("from everywhere to the surface by W", "R7", _to_the_surface, needs=frozenset({WATER})),
    Law("who is left alone comes up", "R6, R8", _comes_up_alone),
    Law("a mission ends out of the implicit leg, stopped", "design: the states", _implicit_end),
)
