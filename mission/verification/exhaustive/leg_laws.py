"""Laws of legs: limits and readings, refused and unanswered commands, time, and the whole set.

What does not live here: the laws of the states (laws), which legs a chart has (the compiler).
"""

from __future__ import annotations

import math

from mission.engine.clearance import ECHOES_MISSED, at_depth, is_guarded
from mission.legs import LEGS
from mission.model import (
    IMPLICIT_SURFACE,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    And,
    Back,
    By,
    Comparison,
    Expression,
    Not,
    Step,
    Trend,
)
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.laws import Law, Verdict, wrong
from mission.verification.exhaustive.lines import ANSWERS, THRUSTERS, WATER

_AHEAD = 4 / 12  # share of full thrust; below it the course over ground shows nothing
_OFF = 2.0  # m (limits: no progress)
_TRIES = 3  # R1
_PERIOD, _BLIND, _LATE = 2.0, 6.0, 0.1  # s: of reports; without a reading (design: the states)
_LOST = 3  # R8
_SEEN = 0.5  # m: noise of a depth and an altitude
_UNHEARD = ECHOES_MISSED + 2 * _PERIOD
# The variables of guards, by the sensor without which they are unknown.
_OF = {
    "depth": frozenset({"depth", "depth_rate"}),
    "altitude": frozenset({"altitude"}),
    "heading": frozenset({"heading"}),
    "attitude": frozenset({"pitch", "roll"}),
    "temperature": frozenset({"temperature"}),
}
_OF["all"] = frozenset().union(*_OF.values())


# --- limits ----------------------------------------------------------------------------------


def _thrust(cell: Cell) -> bool:
    """Whether a thruster certainly turns, because the leg states thrust."""
    leg = cell.leg
    s = leg.setpoint if leg is not None else None
    if s is None or leg is None or leg.leg is None:
        return False
    return LEGS[type(leg.leg.kind)].plain and bool(s.surge or s.turn or s.heave)


def _left(cell: Cell) -> list[Step]:
    """Return the Steps that leave the leg, those into its own next round included."""
    return [s for s in cell.steps if cell.configuration.leaf in s.exited]


def _stayed(cell: Cell) -> bool:
    return not _left(cell)


def _real(cell: Cell) -> bool:
    """Whether the event breaches the limit in this leg; most limits do not depend on the leg."""
    leg, limit = cell.leg, cell.event.limit
    kept = cell.configuration.quiet and _until_emergency(cell)
    state = leg.setpoint if leg is not None else None
    plain = leg is not None and leg.leg is not None and LEGS[type(leg.leg.kind)].plain
    if limit == "heading does not follow":
        return kept and plain and state is not None and state.heading is not None
    if limit == "no progress":
        if state is None or state.depth is None or state.altitude is not None:
            return False  # above the bottom the vehicle is sent a shallower depth
        return kept and plain and abs(state.depth - cell.world.deep) > _OFF
    if limit == "course against heading":
        return kept and plain and state is not None and state.surge >= _AHEAD
    if limit == "brown-out":
        return kept and _thrust(cell)
    if limit == "depth contradicted":
        return kept and plain
    if limit == "no answer":
        return _unanswered(cell) >= _LOST
    return True


def _until_emergency(cell: Cell) -> bool:
    """Whether no exit of the leg led to another leg."""
    return not any(s.entered[-1].startswith("autonomous") for s in _left(cell) if s.entered)


def _unanswered(cell: Cell) -> int:
    """Return the longest run of Z frames, X and W included, that left three times unanswered."""
    run = longest = tries = 0
    for tx in cell.frames(b"@ZA"):
        tries = tries + 1 if f"try {tries + 1} of" in tx.reason else 1
        if tries == _TRIES and cell.world.now - tx.t > 0.31:
            run += 1
        longest = max(longest, run)
    return longest


def _limits(cell: Cell) -> Verdict:
    """R5, R8: every breach in autonomous leads to an emergency. At rest and after the stick was
    let go, the hard depth and a descent surface; nothing else leaves the region."""
    limit, region = cell.event.limit, cell.configuration.region
    if not limit or limit == "uncertain":
        return None
    everywhere = limit in ("hard depth", "unexplained descent")
    state, auto = cell.configuration.state, cell.configuration.auto
    at_rest = region == "idle" or state in (MANUAL_WAITING, STOPPED, SURFACED)
    if everywhere and at_rest and auto:
        return wrong((cell.state != SURFACING, f"{limit}: the state is {cell.state}"))
    acts = region == "autonomous"
    if not acts:
        left = region == "manual" and (everywhere or "minute" in cell.event.causes)  # let go
        same = cell.region == region or left
        return wrong((not same, f"{limit} acts in {region}: {cell.state}"))
    ends_at_once = cell.configuration.leaf == IMPLICIT_SURFACE and WATER not in cell.line.has
    if not _real(cell) or ends_at_once:
        return None
    return wrong((cell.region != "emergency", f"{limit}: the state is {cell.state}"))


def _latched(cell: Cell) -> Verdict:
    """R7: a further limit neither restarts nor ends a surfacing."""
    if not cell.event.limit or cell.configuration.state != SURFACING:
        return None
    moved = [s.trigger for s in cell.steps if s.trigger and s.trigger != "surfaced"]
    return wrong((bool(moved), f"{moved}"))


def _uncertain(cell: Cell) -> Verdict:
    """R5: where only the 95 % bound reaches the radius, the mission's ``on uncertain`` is taken,
    once."""
    if cell.event.limit != "uncertain" or cell.configuration.region != "autonomous":
        return None
    if cell.configuration.leaf == IMPLICIT_SURFACE or not cell.configuration.quiet:
        return None
    ways = [e for e in cell.chart.edges if e.by is By.UNCERTAIN]
    if any(e.target == cell.configuration.leaf for e in ways):
        return None
    taken = [s for s in cell.steps if s.by is By.UNCERTAIN]
    return wrong(
        (len(taken) > 1, "answered twice"),
        (not taken and cell.region != "emergency", f"not answered: {cell.states}"),
    )


def _brown_out(cell: Cell) -> Verdict:
    """R8: after a brown-out the whole set leaves once more, before the emergency."""
    if cell.event.limit != "brown-out" or cell.leg is None or not _real(cell):
        return None
    again = [s for s in cell.steps if s.actions and "brown-out" in s.actions[0] and not s.trigger]
    return wrong((len(again) != 1, f"sent again {len(again)} times"))


# --- readings --------------------------------------------------------------------------------


def _kept_above(cell: Cell) -> Verdict:
    """R5: a depth above the bottom is no deeper than the altitude allows; without a known altitude,
    no deeper than the assumed floor allows."""
    held = cell.leg.setpoint if cell.leg is not None else None
    if held is None or cell.leg is None or not is_guarded(held) or cell.state != cell.leg.path:
        return None
    asked, height = held.depth or 0.0, held.altitude or 0.0
    allowed = min(cell.world.vehicle.limits.depth, cell.chart.mission.safety.depth or math.inf)
    blind = min(asked, float(math.floor(cell.chart.mission.floor(allowed) - height)))
    bottom = max(cell.before.depth, cell.world.sea.depth) + cell.world.sea.altitude
    seen = min(asked, bottom - height + _SEEN)
    levels = [int(tx.data[4:-1]) for tx in cell.frames(b"@ZAS", since=0)]
    here = levels[-len(cell.frames(b"@ZAS")) :] if cell.frames(b"@ZAS") else []
    gone = cell.event.sensor in ("altitude", "all")
    gone = gone and cell.world.now - cell.before.t - cell.event.after > _UNHEARD
    return wrong(
        (any(level > max(seen, blind) for level in here), f"held at {here}, clear is {seen:.1f}"),
        (gone and levels[-1] > blind, f"held at {levels[-1]} without an altitude"),
    )


def _can_hold(expression: Expression, unknown: frozenset[str], wanted: bool = True) -> bool:
    """Whether an expression could be ``wanted`` while these variables are unknown (Kleene)."""
    if isinstance(expression, Comparison | Trend | Back):
        return unknown.isdisjoint(expression.asks)
    if isinstance(expression, Not):
        return _can_hold(expression.operand, unknown, not wanted)
    every = isinstance(expression, And) is wanted
    parts = [_can_hold(one, unknown, wanted) for one in expression.operands]
    return all(parts) if every else any(parts)


def _unknown(cell: Cell) -> Verdict:
    """A guard that is unknown never opens an exit."""
    if not cell.event.sensor:
        return None
    unknown, since = _OF[cell.event.sensor], cell.before.t + cell.event.after
    guards = {e.trigger: e.guard for e in cell.chart.edges if e.guard is not None}
    asked: Verdict = None
    if cell.leg is not None:
        asked = ""
    for step in cell.steps:
        guard = guards.get(step.trigger)
        if guard is None or step.t < since:
            continue
        if not _can_hold(guard.expression, unknown):
            return f"{step.trigger} was taken, and {cell.event.sensor} is not known"
    return asked


def _blind(cell: Cell) -> Verdict:
    """A leg is left when a reading that its set needs is unknown for 6 s."""
    leg, sensor = cell.leg, cell.event.sensor
    if leg is None or leg.leg is None or leg.setpoint is None or sensor == "temperature":
        return None
    if not sensor or cell.ascends:
        return None
    needs = ("depth", "altitude", "heading") if sensor == "all" else (sensor,)
    held = at_depth(leg.setpoint) if is_guarded(leg.setpoint) else leg.setpoint
    if all(getattr(held, need, None) is None for need in needs):
        return None
    left = [s.t - cell.before.t for s in _left(cell)]
    prompt = cell.event.name.endswith("missing")
    late = prompt and bool(left) and left[0] > _PERIOD + _BLIND + _LATE
    return wrong((not left, "the leg goes on"), (late, f"the leg goes on for {left[:1]} s"))


# --- answers ---------------------------------------------------------------------------------


def _refused(cell: Cell) -> Verdict:
    """R8: if a Z of the leg's set is answered N, the leg's else follows."""
    if cell.event.name != "ACK N" or cell.leg is None or cell.configuration.quiet:
        return None
    if cell.leg.leg is None or cell.ascends:
        return None
    ways = [s.by for s in _left(cell)[:1]]
    return wrong(
        (not ways, "the leg goes on"),
        (ways[:1] not in ([By.ELSE], [By.LIMIT]), f"the leg is left by {ways[:1]}"),
    )


def _lost(cell: Cell) -> Verdict:
    """R8: after three unanswered Z in succession the vehicle surfaces."""
    if cell.configuration.region != "autonomous" or _unanswered(cell) < _LOST:
        return None
    if "emergency" not in (s.partition("/")[0] for s in cell.states[1:]):
        return f"{_unanswered(cell)} Z without an answer: {cell.state}"
    return ""


# --- time, and the whole set -----------------------------------------------------------------


def _timed(cell: Cell) -> Verdict:
    """A leg is left when its time is up, whatever the readings."""
    if cell.event.name != "the leg's time is up" or cell.leg is None or cell.leg.leg is None:
        return None
    if cell.leg.leg.timeout is None and cell.leg.leg.duration is None:
        return None
    return wrong((_stayed(cell), "the leg goes on"))


def _whole_set(cell: Cell) -> Verdict:
    """On entry of a leg, its complete set leaves, in order."""
    entries = [s for s in cell.steps if s.entered and s.entered[-1].startswith("autonomous")]
    if not entries or cell.event.path == "whole" or cell.world.answers != "Y":
        return None
    last = entries[-1]
    state = cell.chart.state(last.entered[-1])
    if state.leg is None or state.setpoint is None or cell.state != state.path:
        return None
    if not LEGS[type(state.leg.kind)].plain or cell.world.now - last.t < 1.5:
        return None
    sent = [t for t in cell.frames(b"@ZA") if t.t >= last.t and "(try " not in t.reason]
    left = [t.data for t in sent]
    held = state.setpoint
    if is_guarded(held):  # at whichever depth: _kept_above
        told = [int(data[4:-1]) for data in left if data.startswith(b"@ZAS")]
        held = at_depth(held, float(told[0]) if told else None)
    wanted = list(cell.line.words(held))
    if left[:1] == [b"@ZAX0$"] != wanted[:1]:
        left = left[1:]
    return wrong((left[: len(wanted)] != wanted, f"{left} left, not {wanted}"))


def _rounds_go_on(cell: Cell) -> Verdict:
    """After an interruption, a leg's rounds are as before (design: history)."""
    c = cell.configuration
    if cell.event.name != "AA" or c.region != "manual" or not c.rounds:
        return None
    if cell.state != c.leaf:
        return None
    inner = max(c.rounds, key=lambda pair: len(pair[0]))
    return wrong((cell.world.engine.round != inner[1], f"round {cell.world.engine.round}"))


_ANSWERED = frozenset({ANSWERS})
LEG_LAWS: tuple[Law, ...] = (
    Law("a breach leads to its response where it acts, and only there", "R5, R8", _limits),
    Law("a limit does not begin a surfacing anew", "R7", _latched),
    Law(
        "not sure of the radius: the mission's own way",
        "R5",
        _uncertain,
        needs=frozenset({"position"}),
    ),
    Law(
        "after a brown-out the set leaves once more",
        "R8",
        _brown_out,
        of_legs=True,
        needs=frozenset({THRUSTERS}),
    ),
    Law("unknown never opens an exit", "design: the states", _unknown),
    Law("a set whose reading is unknown is given up", "design: the states", _blind, of_legs=True),
    Law("a depth is kept above the bottom", "R5", _kept_above, of_legs=True),
    Law("a refused Z leads to the leg's else", "R8", _refused, of_legs=True, needs=_ANSWERED),
    Law("three Z without an answer surface", "R8", _lost, needs=_ANSWERED),
    Law("every leg is left when its time is up", "design: the states", _timed),
    Law("a leg's whole set leaves on entry", "design: the states", _whole_set, of_legs=True),
    Law("rounds go on after an interruption", "design: the states", _rounds_go_on, of_legs=True),
)
