"""Laws of a restart and of the program's end: a vehicle under way comes up, one at rest is left at
rest. Rows as in laws.

What does not live here: what is stored for a restart (laws), how long the end may take (serve).
"""

from __future__ import annotations

from mission.model import IDLE_EMPTY, IDLE_READY, MANUAL_DRIVING, STOPPED, SURFACED, SURFACING
from mission.model.regions import MANUAL
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.laws import AT_ONCE, AT_SURFACE, DEEP_REST, Law, Verdict, wrong
from mission.verification.exhaustive.lines import HELD, WATER, X, upward

_AT_REST = (STOPPED, SURFACED)


def _under_way(cell: Cell, state: str) -> bool:
    """Whether a mission or an ascent is under way; a mission that the stick interrupts counts."""
    region = state.partition("/")[0]
    interrupted = region == "manual" and bool(cell.configuration.leaf)
    return region == "autonomous" or state == SURFACING or interrupted


def _restarts(cell: Cell) -> Verdict:
    if "restart" not in cell.event.causes:
        return None
    c, first = cell.configuration, [t.data for t in cell.frames(b"@ZA") if t.t < AT_ONCE]
    if _under_way(cell, c.state):
        up = upward(cell.line)
        return wrong(
            (cell.state != SURFACING, f"the state is {cell.state}"),
            (first[: len(up)] != up, f"{first} left"),  # full thrust: no depth is known yet
        )
    judged = c.loaded and not c.state.startswith(MANUAL)  # no wait for the check (preload)
    idle = IDLE_READY if judged else IDLE_EMPTY
    return wrong(
        (cell.state != (c.state if c.state in _AT_REST else idle), f"the state is {cell.state}"),
        (c.state in _AT_REST and X not in first, f"{first} left"),
        (bool(set(first) - {X}), f"{first} left"),
    )


def _ends_upward(cell: Cell) -> Verdict:
    if "end" not in cell.event.causes or not _under_way(cell, cell.world.ended_in):
        return None
    if cell.world.ended_in == MANUAL_DRIVING:
        return None  # the stick continues to drive
    goals = (SURFACING, SURFACED) if cell.world.sea.depth < AT_SURFACE else (SURFACING,)
    return wrong(
        (cell.state not in goals, f"the state is {cell.state}"),
        (cell.world.engine.settled != (cell.state == SURFACED), "when it may go"),
    )


def _sinks_again(cell: Cell) -> bool:
    """Whether the program ends at once in surfaced while the vehicle is under water again."""
    deep = cell.world.sea.depth >= AT_SURFACE and cell.configuration.auto
    return "last" in cell.event.causes and cell.world.ended_in == SURFACED and deep


def _ends_at_rest(cell: Cell) -> Verdict:
    """At rest no thruster turns, and the program may end where the vehicle can be left alone. A
    vehicle that the stick leaves deep is brought up."""
    if "end" not in cell.event.causes or _under_way(cell, cell.world.ended_in):
        return None
    if _sinks_again(cell):
        return None
    shallow = cell.world.sea.depth < AT_SURFACE
    if cell.world.ended_in.startswith("manual") and not shallow and cell.configuration.auto:
        return wrong((cell.state not in (SURFACING, MANUAL_DRIVING), f"{cell.state}"))
    others = [t.data for t in cell.frames(b"@Z", cell.world.ended_after) if t.data != X]
    return wrong(
        (bool(others), f"{others[:1]} left"),
        (shallow and not cell.world.engine.settled, f"it stays in {cell.state}"),
        (_is_deep(cell) and cell.world.engine.settled, f"it may go, deep, out of {cell.state}"),
    )


def _is_deep(cell: Cell) -> bool:
    """Whether the believed depth is deep, and the program was not told to end at once."""
    deep, state = cell.world.sea.depth > DEEP_REST, cell.world.engine.core.vehicle_state
    return deep and state.depth is not None and "last" not in cell.event.causes


def _last_words(cell: Cell) -> Verdict:
    """Under water the last commands are X0 and U12, and nothing follows them."""
    under_way = _under_way(cell, cell.world.ended_in) or _sinks_again(cell)
    if "last" not in cell.event.causes or not under_way:
        return None
    frames = cell.frames(b"@Z", cell.world.ended_after)
    left = [t.data for t in frames if HELD not in t.reason]
    return wrong(
        (cell.state != SURFACING, f"the state is {cell.state}"),
        (left != upward(cell.line), f"{left} left"),
    )


END_LAWS: tuple[Law, ...] = (
    Law("a restart surfaces what was under way and leaves the rest at rest", "R7", _restarts),
    Law("an ordered end brings up what is under way first", "R7", _ends_upward),
    Law("an ordered end turns nothing where nothing is under way", "R7", _ends_at_rest),
    Law("the last words of a program are X0 and U12", "R7", _last_words, needs=frozenset({WATER})),
)
