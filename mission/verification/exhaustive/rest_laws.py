"""Laws of rest: a vehicle that sinks while stopped is brought up; otherwise no thruster turns.

What does not live here: the ascent itself (proof_laws), repeated stops (laws).
"""

from __future__ import annotations

from mission.model import MANUAL_WAITING, STOPPED, SURFACED, SURFACING
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.laws import DEEP_REST, Law, Verdict, stays_down, wrong
from mission.verification.exhaustive.lines import U12, WATER, W, X

_LATE = 3.0  # s for a report and the line
_ASKED = frozenset({"X", "W", "M", "AA", "AC", "NS", "restart", "minute", "silence", "line"})
_MAY_TURN = frozenset({"W", "NS", "restart"})  # after the last two AUTO is open


def _rests(cell: Cell) -> bool:
    c = cell.configuration
    return c.region == "idle" or c.state in (STOPPED, SURFACED, MANUAL_WAITING)


def _upward(cell: Cell) -> list[bytes]:
    return [t.data for t in cell.frames(b"@ZA") if t.data in (W, U12)]


def _brought_up(cell: Cell) -> Verdict:
    """R7: a vehicle that sinks from rest is brought up, except while AUTO is closed."""
    if not (_rests(cell) and cell.configuration.auto) or "sinks" not in cell.event.causes:
        return None
    return wrong(
        (cell.state != SURFACING, f"{cell.world.sea.depth:.1f} m deep, the state is {cell.state}"),
        (U12 not in _upward(cell), "no U12 left"),
    )


def _not_left_below(cell: Cell) -> Verdict:
    """R7: in stopped, buoyancy has 20 s; a vehicle that is still deep then is brought up."""
    c = cell.configuration
    if c.state != STOPPED or not c.auto or cell.event.causes & (_ASKED | {"blind", "limit"}):
        return None
    rests = min(cell.before.depth, cell.world.sea.depth) <= DEEP_REST
    if rests or not cell.world.reports or cell.world.spoils:
        return None
    if not stays_down(cell) or cell.world.now - cell.before.t < 20.0 + _LATE:
        return None
    return wrong((cell.state != SURFACING or U12 not in _upward(cell), f"left in {cell.state}"))


def _blind_at_rest(cell: Cell) -> Verdict:
    """R7: an unknown depth turns no thruster, since the vehicle may be on deck."""
    if not _rests(cell) or cell.event.sensor not in ("depth", "all"):
        return None
    if cell.event.causes & _ASKED - {"AC"}:
        return None
    return wrong((bool(_upward(cell)), f"{_upward(cell)[:1]} left, and the depth is not known"))


def _auto_closed(cell: Cell) -> Verdict:
    """R7, R13: while AUTO is closed nothing turns, since a hand may be at a thruster. A vehicle
    that was held up is let go, too: its last command, even from before the event, is a stop."""
    if not _rests(cell) or cell.configuration.auto or cell.event.causes & _MAY_TURN:
        return None
    said = {t.data for t in [*cell.frames(b"@ZA", 0)[-1:], *cell.frames(b"@ZA")]} - {X}
    return wrong((bool(said), f"{said} while AUTO is closed"))


_WET = frozenset({WATER})
REST_LAWS: tuple[Law, ...] = (
    Law("what sinks from rest is brought up by thrust", "R7", _brought_up, needs=_WET),
    Law("a stop leaves nobody below for longer than 20 s", "R7", _not_left_below, needs=_WET),
    Law("nothing turns by itself while AUTO is closed", "R7, R13", _auto_closed),
    Law("an unknown depth at rest turns no thruster", "R7", _blind_at_rest, needs=_WET),
)
