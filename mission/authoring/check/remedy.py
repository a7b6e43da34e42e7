"""The hint for a refusal for time or energy: the share of each leg, and changes that are enough.

    excess = worst - allowed
    clock  = clock - excess / (rate * times)      of the leg with the greatest share
    rounds = rounds - ceil(excess / (share / rounds))    of the group with the greatest share

``rate`` is 1 for time, the leg's power for energy. The same walk tries each change before it is
suggested, since another way may then be the worst.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from mission.authoring.check.bounds import Bounds, Trail
from mission.authoring.check.flow import ROUNDS, Proof, trail
from mission.legs import LEGS
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, Chart, Group, Leg, Node, State

_TOLD = 5  # most legs that are named with their share
_TRIES = 3  # tries for each kind of change
_SHORTEST = 1.0  # s, the shortest clock that is suggested


@dataclass(frozen=True, slots=True)
class Figure:
    """The bounded figure: its value in a step (``of``), in the worst case, and as allowed.
    ``last``: the last step of the worst way. ``shown``: the value as text with its unit."""

    of: Callable[[Trail], float]
    worst: Callable[[Bounds], float]
    last: Callable[[Bounds], Trail | None]
    allowed: float
    shown: Callable[[float], str]

    def excess(self, proof: Proof) -> float:
        """The amount beyond what is allowed; infinite if nothing is proved."""
        return self.worst(proof.worst) - self.allowed if proof.worst else math.inf


@dataclass(frozen=True, slots=True)
class _Share:
    amount: float
    times: int
    time: float  # s


def hint(figure: Figure, chart: Chart, proof: Proof, walk: Callable[[Chart], Proof]) -> str:
    """The hint for a refusal. ``walk`` finds the worst case of a changed chart."""
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
    """The share of each leg on the worst way."""
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
    """Try a shorter clock for the leg with the greatest share."""
    shares = _written(chart, _shares(figure, proof))
    if not shares:
        return
    path, share = max(shares.items(), key=lambda row: row[1].amount)
    leg = _leg(chart, path)
    word = "for" if leg.duration is not None else "timeout"
    now = clock = share.time / share.times if chart.state(path).leg else leg.timeout or 0.0
    tried = proof
    for _ in range(_TRIES):
        clock = math.floor(clock - figure.excess(tried) * now / share.amount)
        if clock < _SHORTEST:
            return
        tried = walk(_clocked(chart, path, clock))
        if figure.excess(tried) <= 0.0:
            yield f"{word} {clock:g} s in {_name(path)} (now {now:g} s)"
            return


def _written(chart: Chart, shares: dict[str, _Share]) -> dict[str, _Share]:
    """The shares by legs as written. Parts that share a leg's clock count together; other parts
    are left out."""
    found: dict[str, _Share] = {}
    for path, share in shares.items():
        state = chart.state(path)
        if path == IMPLICIT_SURFACE:
            continue
        if isinstance(_leg_of(chart, state.parent), Leg):
            if not _shares_clock(state):
                continue
            path = state.parent
        before = found.get(path, _Share(0.0, 0, 0.0))
        found[path] = _Share(
            before.amount + share.amount, before.times + share.times, before.time + share.time
        )
    return found


def _shares_clock(part: State) -> bool:
    """Whether the part uses a share of its leg's clock. A run of rows does; a way up has its own
    clock."""
    leg = part.leg
    return leg is not None and leg.duration is None and not LEGS[type(leg.kind)].ascends


def _leg_of(chart: Chart, path: str) -> Node | None:
    """The leg or group at ``path`` in the mission as written."""
    body: tuple[Node, ...] = chart.mission.body
    found: Node | None = None
    for name in path.split("/")[1:]:
        found = next((node for node in body if node.name == name), None)
        body = found.body if isinstance(found, Group) else ()
    return found


def _leg(chart: Chart, path: str) -> Leg:
    leg = chart.state(path).leg or _leg_of(chart, path)
    assert isinstance(leg, Leg)
    return leg


def _rounds(
    figure: Figure, chart: Chart, proof: Proof, walk: Callable[[Chart], Proof]
) -> Iterator[str]:
    """Try fewer rounds of the group with the greatest share."""
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


def _clocked(chart: Chart, path: str, clock: float) -> Chart:
    """The chart with another clock of a leg, or of its parts by their shares."""
    leg = _leg(chart, path)
    timed = leg.duration is not None
    leg = replace(leg, duration=clock) if timed else replace(leg, timeout=clock)
    if chart.state(path).leg is not None:
        return _with(chart, path, replace(chart.state(path), leg=leg))
    for part in LEGS[type(leg.kind)].parts(leg):
        at = f"{path}/{part.name}"
        chart = _with(chart, at, replace(chart.state(at), leg=part))
    return chart


def _repeated(state: State, rounds: int) -> State:
    assert state.group is not None
    return replace(state, group=replace(state.group, repeat=rounds))
