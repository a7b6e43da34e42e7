"""Laws of the serial line: what leaves in which state, how often, and with which gap.

What does not live here: why a frame leaves (laws), which set a leg has (leg_laws).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby, pairwise

from mission.model import STOPPED, SURFACED, SURFACING, Tx
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.laws import Law, Verdict, wrong
from mission.verification.exhaustive.lines import ANSWERS, D12, REPEATS, U12, W, X
from mission.verification.rig.line import GAP_S, crowded
from protocol.vehicles import line_rate

_ANSWER = 0.3  # s (R1)
_TRIES = 3  # R1
_EPS = 1e-6
BITS_PER_BYTE = 10  # 8N1
_SLACK = 0.03  # s for what is on the line
_HALVES = 0.15  # s for an answer and what is on the line


def _sent_in(cell: Cell, state: str) -> Iterator[Tx]:
    """Yield what left for the vehicle in this state, from the frame of its entry on. The order in
    which frames left decides, not the time: one instant may have had several inputs."""
    world, before = cell.world, cell.before
    taken = zip(world.left[before.states :], world.states[before.states :], strict=True)
    spans = [(before.sent, (-1.0, cell.configuration.state)), *taken, (len(world.sent), (-1.0, ""))]
    for (since, (t, here)), (until, _) in pairwise(spans):
        if here == state:
            left = cell.frames(since=since, until=until)
            yield from left[_before_the_order(left, t) :]


def _before_the_order(left: list[Tx], t: float) -> int:
    """Return how many frames left with the input of ``t`` before its X or W."""
    first = next((i for i, tx in enumerate(left) if tx.data in (X, W)), 0)
    return first if left and left[first].t == t else 0


def _only(cell: Cell, state: str, allowed: tuple[bytes, ...]) -> Verdict:
    if "restart" in cell.event.causes:  # a new program begins with a new line
        return None
    sent = list(_sent_in(cell, state))
    if state not in cell.states:
        return None
    relays = (b"@R", b"@D", b"@O")
    strange = [t for t in sent if t.data not in allowed and t.data[:2] not in relays]
    return wrong((bool(strange), f"{strange[:1]} left in {state}"))


def _stopped(cell: Cell) -> Verdict:
    """R7: after an X nothing of an earlier set follows, not even the rest of a set half sent."""
    return _only(cell, STOPPED, (X,))


def _surfacing(cell: Cell) -> Verdict:
    return _only(cell, SURFACING, (W, X, U12, D12))


def _surfaced(cell: Cell) -> Verdict:
    return _only(cell, SURFACED, (X,))


def _gap(cell: Cell) -> Verdict:
    """Frames keep their gap. A restart is left out, since the new program's time begins at 0."""
    if "restart" in cell.event.causes or len(cell.frames()) < 2:
        return None
    found = crowded(cell.frames())
    return found.says if found else ""


def _one_outstanding(cell: Cell) -> Verdict:
    """R1: without an answer, a Z waits for the end of the one before. X and W do not wait; manual
    and idle are left out."""
    if cell.event.name != "no ACK" or cell.configuration.region in ("manual", "idle"):
        return None
    for a, b in pairwise(t for t in cell.frames(b"@ZA") if t.t > cell.before.t + GAP_S):
        if b.data not in (X, W) and b.t - a.t < _ANSWER - _EPS:
            return f"{b.data!r} left {b.t - a.t:.3f} s after {a.data!r}"
    return ""


def _tries(cell: Cell) -> Verdict:
    """R1: a frame leaves three times at most for one command. A stop repeats X by new commands."""
    again = [t for t in cell.frames(b"@ZA") if "(try " in t.reason]
    if not again:
        return None
    last = f"of {_TRIES})"
    odd = [t for t in again if not t.reason.endswith(last) or "(try 4" in t.reason]
    return wrong((bool(odd), f"{odd[:1]}"))


def _halves(cell: Cell) -> Verdict:
    """R7: U12 follows X0 within _HALVES, whatever is relayed meanwhile."""
    thrust = [t for t in cell.frames(U12) if t.t > cell.before.t]
    if cell.event.path != "slider" or cell.world.answers != "Y" or not cell.configuration.quiet:
        return None
    if SURFACED in cell.states or cell.states[-1] != SURFACING:
        return None
    cleared = [t for t in cell.frames(X) if thrust and t.t < thrust[0].t]
    apart = thrust[0].t - cleared[-1].t if cleared else None
    relays = cell.frames(b"@D")
    return wrong(
        (not thrust, "U12 never left"),
        (apart is None or apart > _HALVES, f"U12 left {apart} s after X0"),
        (not relays, "nothing was relayed"),
    )


def _paced(cell: Cell) -> Verdict:
    """A board that acknowledges nothing is sent a frame within each of its periods, from the first
    on."""
    board, said = cell.line.board, cell.world.paced
    if board is None or len(said) < 2 or "restart" in cell.event.causes:
        return None
    worst = max(b[0] - a[0] for a, b in pairwise(said))
    return wrong((worst > board.period + _SLACK, f"nothing was said for {worst:.2f} s"))


def _carried(cell: Cell) -> Verdict:
    """A burst begins only when the line has carried the one before."""
    board = cell.line.board
    if board is None or "restart" in cell.event.causes:
        return None
    byte = BITS_PER_BYTE / line_rate(cell.world.vehicle.codec, cell.world.vehicle.wire)
    free = -1.0
    for t, together in groupby(cell.world.paced, key=lambda one: one[0]):
        if t < free - _EPS:
            return f"at {t:.4f} s the line is not free before {free:.4f} s"
        free = t + byte * sum(size for _, size in together)
    return ""


_ANSWERED, _SAID_AGAIN = frozenset({ANSWERS}), frozenset({REPEATS})
LINE_LAWS: tuple[Law, ...] = (
    Law("in stopped nothing leaves but X0 and relays", "R7", _stopped),
    Law("in surfacing nothing leaves but W, X0, U12, D12 and relays", "R7", _surfacing),
    Law("in surfaced nothing leaves but X0 and relays", "R7", _surfaced),
    Law("both halves of an ascent leave under a slider", "R7", _halves, needs=_ANSWERED),
    Law("20 ms between two frames to the STM32", "as built", _gap, needs=_ANSWERED),
    Law("one Z outstanding", "R1", _one_outstanding, needs=_ANSWERED),
    Law("a frame is tried three times", "R1", _tries, needs=_ANSWERED),
    Law(
        "what holds is said again within the board's period", "R16, R17", _paced, needs=_SAID_AGAIN
    ),
    Law("a board is sent no more than its line carries", "R7", _carried, needs=_SAID_AGAIN),
)
