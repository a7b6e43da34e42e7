"""Laws of an ascent that doubtful readings could mislead; rows as in laws.

What does not live here: ascents with a believed depth (proof_laws).
"""

from __future__ import annotations

from itertools import pairwise

from mission.model import SURFACING
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.laws import Law, Verdict, wrong
from mission.verification.exhaustive.lines import GPS, U12, WATER, W, X, upward

_KNOWN = 10.0  # s until three reports have shown the roll, and a missing depth is unknown
_TOLD = 34.0  # s for the leap, reports that agree, a window of movement, and a turn under way


def _tried(cell: Cell, since: float = 0.0) -> list[bytes]:
    """Return the ways tried from ``since`` s on, without repeats: W, U12 and D12 stand for theirs,
    X0 for letting go."""
    begin, halves = cell.before.t + since, len(upward(cell.line)) > 1
    said = [t.data for t in cell.frames(b"@ZA") if t.t >= begin and "(try " not in t.reason]
    pairs = pairwise([*said, b""])
    first = (b"@ZAU", b"@ZAD") if halves else ()  # an X0 before these is their first half
    return [data for data, then in pairs if data != X or then[:4] not in first]


def _not_proved_again(cell: Cell) -> Verdict:
    """R7: the surface is 6 s of shallow depth without a silence."""
    if cell.event.path != "quiet":
        return None
    return wrong((cell.state != SURFACING, f"the state is {cell.state}"))


def _not_proved_by_fixes(cell: Cell) -> Verdict:
    """R7: without a depth, fixes prove nothing before the vehicle can have come up."""
    if cell.event.path != "fixes":
        return None
    return wrong((cell.state != SURFACING, f"the state is {cell.state}"))


def _not_pushed_again(cell: Cell) -> Verdict:
    """R7: upside down, a push that has led 1 m deeper is not tried again."""
    if cell.event.path != "over":
        return None
    ways = _tried(cell, _KNOWN)
    again = [way for way in (W, U12) if ways.count(way) > 1]
    return wrong(
        (cell.state != SURFACING, f"the state is {cell.state}"),
        (bool(again), f"{again} led deeper, and again"),
        (not ways or ways[-1] in (W, U12), f"{ways[-1:]} in the end"),
    )


def _not_pushed_blind(cell: Cell) -> Verdict:
    """R7: upside down without a believed depth, the vehicle is let go and nothing else is tried."""
    if cell.event.path != "over, blind":
        return None
    ways = _tried(cell, _KNOWN + 2.0)
    return wrong(
        (cell.state != SURFACING, f"the state is {cell.state}"),
        (not ways or set(ways) != {X}, f"{ways} were tried"),
    )


def _kept_by_its_change(cell: Cell) -> Verdict:
    """R7: a depth of which only the zero is contradicted shows whether the depth falls."""
    if cell.event.path != "elsewhere":
        return None
    ways = _tried(cell, _TOLD)
    return wrong(
        (cell.state != SURFACING, f"the state is {cell.state}"),
        (bool(ways), f"{ways} were tried though it rises"),
    )


_WET, _GPS = frozenset({WATER}), frozenset({GPS})
DOUBT_LAWS: tuple[Law, ...] = (
    Law("what was shallow before a silence proves no surface", "R7", _not_proved_again, needs=_WET),
    Law(
        "without a depth no fix proves the surface too soon", "R7", _not_proved_by_fixes, needs=_GPS
    ),
    Law("upside down no push that led deeper is tried again", "R7", _not_pushed_again, needs=_WET),
    Law("upside down and blind it is let go", "R7", _not_pushed_blind, needs=_WET),
    Law(
        "what makes a depth fall of which the zero is doubted is kept",
        "R7",
        _kept_by_its_change,
        needs=_WET,
    ),
)
