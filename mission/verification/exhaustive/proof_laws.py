"""Laws of what must be proved: the surface by depth, the ascent by trying, the chart by its edges.

What does not live here: for which cause a region is left (laws).
"""

from __future__ import annotations

from itertools import pairwise

from mission.model import SURFACED, SURFACING, Chart, Edge
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.exit_inputs import wish
from mission.verification.exhaustive.laws import AT_SURFACE, Law, Verdict, wrong
from mission.verification.exhaustive.lines import U12, WATER, X, upward, ways_of

_TURN = 10.0  # s that each way has (R7)
_EPS = 1e-6
_SUSPENDED = ("autonomous", "manual")
# The limits that are watched in manual, too, whatever the vehicle does (R5).
_REPORTED = ("hard depth", "roll-over", "voltage")


# --- the surface ---------------------------------------------------------------------------------


def _at_the_surface(cell: Cell) -> Verdict:
    """surfaced, the end of a mission, and idle after the stick: only where the true depth is that
    of the surface."""
    asked: Verdict = None
    first = cell.before.states - 1
    for i, ((_, here), (_, there)) in enumerate(pairwise(cell.world.states[first:])):
        ended = there.startswith("idle") and here.startswith(_SUSPENDED)
        ended = ended and not cell.event.causes & {"NS", "restart"}
        if there == SURFACED or ended:
            asked = ""
            depth = cell.world.depths[cell.before.states + i]
            if depth >= AT_SURFACE:
                return f"{here} -> {there} at {depth:.1f} m"
    return asked


def _never_gives_up(cell: Cell) -> Verdict:
    """While the depth does not fall, the vehicle's ways (W, X0 with U12, X0 alone) take turns
    without end, 10 s each (full thrust twice as long from the second time on). In an ascent, also
    in that of a leg, W leaves and the present turn continues."""
    if cell.event.path != "sinks":
        return None
    again = cell.configuration.state == SURFACING
    ways = _ways(cell)[again:]
    told = [t for t, _ in ways]
    turns = [b - a for a, b in pairwise([*told, cell.world.now])]
    pushes = [i for i, (_, way) in enumerate(ways) if way == U12]
    lasting = [_TURN * (2 if i in pushes[not again :] else 1) for i in range(len(ways))]
    beyond = [turn - due for turn, due in zip(turns, lasting, strict=True)]
    own = ways_of(cell.line)
    at = own.index(ways[0][1]) if again and ways else 0
    order = [own[(at + i) % len(own)] for i in range(len(ways))]
    return wrong(
        (cell.state != SURFACING, f"the state is {cell.state}"),
        ([way for _, way in ways] != order, f"{ways} were tried"),
        (not ways, "no way was tried"),
        (any(late > 0.5 for late in beyond), f"{turns} s each"),
        (any(late < -0.5 for late in beyond[again or cell.ascends : -1]), f"{turns} s each"),
    )


def _ways(cell: Cell) -> list[tuple[float, bytes]]:
    """Return the ways that an ascent tried from its W on, with their times. The X0 before a U12 is
    part of it."""
    said = [(t.t, t.data) for t in cell.frames(b"@ZA") if _first(t.reason)]
    own, halves = ways_of(cell.line), len(upward(cell.line)) > 1
    begun = next((i for i, (_, data) in enumerate(said) if data == own[0]), len(said))
    ways: list[tuple[float, bytes]] = []
    for t, data in said[begun:]:
        if halves and data == U12 and ways and ways[-1][1] == X:
            ways[-1] = (ways[-1][0], U12)
        elif data in own:
            ways.append((t, data))
    return ways


def _first(reason: str) -> bool:
    return "(try " not in reason


# --- an interruption -----------------------------------------------------------------------------


def _clock_goes_on(cell: Cell) -> Verdict:
    """Time in manual counts: a run that continues keeps the time of its start."""
    run = cell.world.engine.core.run
    if cell.before.started is None or run is None or "restart" in cell.event.causes:
        return None
    late = run.started - cell.before.started
    return wrong((abs(late) > _EPS, f"the mission's clock began {late:.1f} s later"))


def _reports_anew(cell: Cell) -> Verdict:
    """R6: no reports come while the stick is held, so their age starts again with @AA."""
    c = cell.configuration
    if cell.event.path != "after the stick" or not (c.leaf and c.auto) or c.preceded:
        return None
    if cell.world.answers != "Y":
        return None
    return wrong((cell.region == "emergency", f"{cell.world.engine.reason}"))


def _reported_in_manual(cell: Cell) -> Verdict:
    """R5: in manual a limit is reported."""
    if cell.configuration.region != "manual" or cell.event.limit not in _REPORTED:
        return None
    seen = [row.name for row in cell.world.engine.breaches]
    return wrong((cell.event.limit not in seen, f"breached: {seen}"))


# --- the chart -----------------------------------------------------------------------------------


def _edges(chart: Chart, trigger: str) -> list[Edge]:
    return [e for e in chart.edges if e.trigger == trigger]


def _along_the_chart(cell: Cell) -> Verdict:
    """The first edge that is taken leaves this leg or a group around it, leads to where the chart
    says, and is open in this round."""
    c = cell.configuration
    if c.region != "autonomous":
        return None
    for step in cell.steps:
        if not step.exited or step.exited[0] != c.leaf:
            continue
        for edge in _edges(cell.chart, step.trigger):
            rounds = dict(c.rounds)
            open_ = all(
                (rounds.get(loop.group, 1) < _repeat(cell.chart, loop.group)) is loop.again
                for loop in edge.loops
            )
            return wrong(
                (not f"{c.leaf}/".startswith(edge.source + "/"), f"{edge.source} is not active"),
                (step.entered[-1:] != (edge.target,), f"to {step.entered}, not {edge.target}"),
                (not open_, f"{edge.trigger} in {c.rounds}"),
                (_miscounts(cell, edge), f"round {cell.world.engine.round} after {c.rounds}"),
            )
        return None
    return None


def _fulfilled(cell: Cell) -> Verdict:
    """When a leg's first exit holds, the leg is left, for another leg or its own next round."""
    if cell.event.name != "what the leg waits for":
        return None
    if wish(cell.configuration, cell.chart) is None:
        return None
    left = [s for s in cell.steps if cell.configuration.leaf in s.exited]
    return wrong((not left, "the leg goes on"))


def _repeat(chart: Chart, path: str) -> int:
    group = chart.state(path).group
    return group.repeat if group else 1


def _miscounts(cell: Cell, edge: Edge) -> bool:
    """Whether the round is wrong: one more while rounds are left, else the first again."""
    moved = [s for s in cell.steps if s.exited and s.exited[0].startswith("autonomous")]
    counts = [loop for loop in edge.loops if cell.state.startswith(loop.group + "/")]
    if len(moved) > 1 or len(counts) != 1 or cell.state != edge.target:
        return False
    loop = counts[0]
    rounds = cell.world.engine.core.run
    now = rounds.rounds.get(loop.group, 1) if rounds is not None else 0
    return now != (dict(cell.configuration.rounds).get(loop.group, 1) + 1 if loop.again else 1)


PROOF_LAWS: tuple[Law, ...] = (
    Law("at the surface is who is there", "R6, R7", _at_the_surface),
    Law(
        "an ascent tries every way and never gives up",
        "R7",
        _never_gives_up,
        needs=frozenset({WATER}),
    ),
    Law("an interruption does not stop the mission's clock", "R6", _clock_goes_on),
    Law("the age of the reports starts again with @AA", "R6", _reports_anew),
    Law("in manual a limit is reported", "R5", _reported_in_manual),
    Law("an exit that holds is taken", "design: the states", _fulfilled, of_legs=True),
    Law("a mission goes along its chart, round by round", "design: the states", _along_the_chart),
)
