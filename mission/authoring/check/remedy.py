"""A refusal for time or energy: the share of each leg, and the smallest changes that would do.

    excess = worst - allowed
    clock  = clock - excess / (rate * times)      of the leg with the greatest share
    rounds = rounds - ceil(excess / (share / rounds))    of the group with the greatest share

``rate`` is 1 for time, the leg's power for energy. Each change is tried by the same walk before it
is told: another way may be the worst one then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from mission.authoring.check.bounds import Bounds, Trail
from mission.authoring.check.flow import ROUNDS, Proof, trail
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, Chart, Leg, State

_TOLD = 5  # legs whose share is told
_TRIES = 3  # for a change that was not enough
_SHORTEST = 1.0  # s of a clock


@dataclass(frozen=True, slots=True)
class Figure:
    """What is bounded: ``of`` a step, ``worst`` of a walk, ``allowed``; ``shown`` in its unit.
    ``last`` is the last step of the worst way."""

    of: Callable[[Trail], float]
    worst: Callable[[Bounds], float]
    last: Callable[[Bounds], Trail | None]
    allowed: float
    shown: Callable[[float], str]

    def excess(self, proof: Proof) -> float:
        """Beyond what is allowed; infinite where nothing is proved."""
        return self.worst(proof.worst) - self.allowed if proof.worst else math.inf


@dataclass(frozen=True, slots=True)
class _Share:
    amount: float
    times: int
    time: float  # s


def hint(figure: Figure, chart: Chart, proof: Proof, walk: Callable[[Chart], Proof]) -> str:
    """``walk`` finds the worst case of a changed chart."""
    shares = _shares(figure, proof)
    total = sum(share.amount for share in shares.values())
    rows = sorted(shares.items(), key=lambda row: -row[1].amount)
    told = [f"{_name(path)} {_told(figure, share, total)}" for path, share in rows[:_TOLD]]
    rest = sum(share.amount for _, share in rows[_TOLD:])
    told += [f"{len(rows) - _TOLD} others {figure.shown(rest)}"] if rest else []
    text = f"of it: {', '.join(told)}"
    if proof.walked * 2 * _TRIES > ROUNDS:
        return text
    changes = [*_clock(figure, chart, proof, walk), *_rounds(figure, chart, proof, walk)]
    return f"{text}; enough would be: {' or '.join(changes)}" if changes else text


def _name(path: str) -> str:
    return "the ascent" if path == IMPLICIT_SURFACE else path.removeprefix(AUTONOMOUS + "/")


def _told(figure: Figure, share: _Share, total: float) -> str:
    times = f", {share.times} times" if share.times > 1 else ""
    return f"{figure.shown(share.amount)} ({share.amount / total:.0%}{times})"


def _shares(figure: Figure, proof: Proof) -> dict[str, _Share]:
    """By leg, on the way that is the worst."""
    found: dict[str, _Share] = {}
    for step in trail(figure.last(proof.worst) if proof.worst else None):
        before = found.get(step.leg, _Share(0.0, 0, 0.0))
        found[step.leg] = _Share(
            before.amount + figure.of(step), before.times + 1, before.time + step.time
        )
    return found


# --- changes ------------------------------------------------------------------------------


def _clock(
    figure: Figure, chart: Chart, proof: Proof, walk: Callable[[Chart], Proof]
) -> Iterator[str]:
    """A shorter clock for the leg with the greatest share."""
    shares = {p: s for p, s in _shares(figure, proof).items() if p != IMPLICIT_SURFACE}
    if not shares:
        return
    path, share = max(shares.items(), key=lambda row: row[1].amount)
    leg = chart.state(path).leg
    assert leg is not None
    word = "for" if leg.duration is not None else "timeout"
    now = clock = share.time / share.times
    tried = proof
    for _ in range(_TRIES):
        per_second = share.amount / share.time * share.times
        clock = math.floor(clock - figure.excess(tried) / per_second)
        if clock < _SHORTEST:
            return
        tried = walk(_with(chart, path, _clocked(chart.state(path), clock)))
        if figure.excess(tried) <= 0.0:
            yield f"{word} {clock:g} s in {_name(path)} (now {now:g} s)"
            return


def _rounds(
    figure: Figure, chart: Chart, proof: Proof, walk: Callable[[Chart], Proof]
) -> Iterator[str]:
    """Fewer rounds of the group with the greatest share."""
    shares = _shares(figure, proof)
    within = {
        state: sum(s.amount for path, s in shares.items() if path.startswith(state.path + "/"))
        for state in chart.states
        if state.group is not None and state.group.repeat > 1
    }
    if not within:
        return
    state, amount = max(within.items(), key=lambda row: row[1])
    assert state.group is not None
    now = rounds = state.group.repeat
    tried = proof
    for _ in range(_TRIES):
        if not amount:
            return
        rounds -= math.ceil(figure.excess(tried) / (amount / now))
        if rounds < 1:
            return
        tried = walk(_with(chart, state.path, _repeated(state, rounds)))
        if figure.excess(tried) <= 0.0:
            yield f"repeat {rounds} {_name(state.path)} (now {now})"
            return


def _with(chart: Chart, path: str, changed: State) -> Chart:
    return replace(chart, states=tuple(changed if s.path == path else s for s in chart.states))


def _clocked(state: State, clock: float) -> State:
    assert isinstance(state.leg, Leg)
    timed = state.leg.duration is not None
    leg = replace(state.leg, duration=clock) if timed else replace(state.leg, timeout=clock)
    return replace(state, leg=leg)


def _repeated(state: State, rounds: int) -> State:
    assert state.group is not None
    return replace(state, group=replace(state.group, repeat=rounds))
