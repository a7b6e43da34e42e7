"""Compare the goals that a mission states with what its legs are expected to achieve.

    coverage    the mean share of the area that is seen
    position    radius in m that contains 95 % of dives: at the end of each row; for other legs, the
                larger of those at their begin and end

Legs that are not expected to achieve their goal are refused, row by row, with changes that are
enough: the same outlook tries each change before it is suggested.

What does not live here: the prediction (outlook.py), what a flight has achieved (coverage.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from mission.authoring.check.outlook import (
    MOST,
    Expected,
    TooManyError,
    expected,
    outlooks,
)
from mission.legs import LEGS, Cover, Rows
from mission.legs.pattern import Pattern
from mission.legs.purposes import OF_ANY, has_rows, purposes
from mission.model import Aims, Group, Leg, Mission, Node
from mission.model.diagnostics import Diagnostic, Stage
from mission.model.units import number_text
from mission.model.vehicle import Vehicle

_TRIED = 40  # changes are tried up to so many rows in the outlook: the Pi has a second for it
_FIXES = 8  # most rows between two fixes that are tried
_SHARES = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)


@dataclass(frozen=True, slots=True)
class Outlook:
    """The outlook of one leg: the share seen, and the error in m for each row, or one for a leg
    without rows. ``needs``: s of a long enough clock, if its own may end the leg too early."""

    leg: str
    coverage: float | None  # None: the leg states no swath
    errors: tuple[float, ...]
    aims: Aims
    rows: bool = True
    needs: float | None = None


@dataclass(frozen=True, slots=True)
class Judged:
    outlook: tuple[Outlook, ...] = ()
    refusals: tuple[Diagnostic, ...] = ()


def judged(mission: Mission, vehicle: Vehicle) -> Judged:
    """The outlook of each leg with a goal, and the refusals; empty for a mission without goals."""
    if not any(_stated(mission.body, mission.achieve)):
        return Judged()
    try:
        found, errors, late = outlooks(mission, vehicle)
    except TooManyError:
        message = f"a purpose is stated, and more than {MOST} rows are flown"
        return Judged(refusals=(_refusal(mission, message, "make two missions of it"),))
    told, refusals = [], list(_idle(mission))
    for path, leg, aims in purposes(mission):
        if path in found:
            outlook = replace(_outlook(path, found[path], aims), needs=late.get(path))
        else:
            outlook = Outlook(
                path, None, (errors[path],), tuple(aims.items()), rows=False, needs=late.get(path)
            )
        told.append(outlook)
        refusals += _refused(mission, vehicle, leg, outlook)
    return Judged(tuple(told), tuple(refusals))


def _stated(body: tuple[Node, ...], above: Aims) -> Iterator[Aims]:
    yield from filter(None, [above])
    for node in body:
        if isinstance(node, Group):
            yield from _stated(node.body, node.achieve)
        elif isinstance(node, Leg) and node.achieve:
            yield node.achieve


def _idle(mission: Mission) -> Iterator[Diagnostic]:
    """Refuse goals of rows on a mission or group without rows."""
    scopes: list[Mission | Group] = [mission, *_groups(mission.body)]
    for scope in scopes:
        idle = [name for name, _ in scope.achieve if name != OF_ANY]
        if idle and not has_rows(scope.body):
            message = f"{scope.name} has no rows that could achieve {idle[0]}"
            yield _refusal(scope, message, f"leave {idle[0]} out, or add rows")


def _groups(body: tuple[Node, ...]) -> Iterator[Group]:
    for node in body:
        if isinstance(node, Group):
            yield node
            yield from _groups(node.body)


def _outlook(path: str, one: Expected, aims: dict[str, float]) -> Outlook:
    coverage = one.coverage if one.pattern.swath else None
    return Outlook(path, coverage, one.errors, tuple(sorted(aims.items())))


def _refused(
    mission: Mission, vehicle: Vehicle, leg: Leg, outlook: Outlook
) -> Iterator[Diagnostic]:
    aims = dict(outlook.aims)
    if "coverage" in aims and outlook.coverage is None:
        message = f"{outlook.leg} is to cover a share of its area, but says no swath"
        yield _refusal(leg, message, "add swath, the m that are seen along each row")
    elif missed := tuple(_missed(outlook)):
        hint = _hint(mission, vehicle, leg, outlook)
        for message in missed:
            yield _refusal(leg, message, hint)


def _hint(mission: Mission, vehicle: Vehicle, leg: Leg, outlook: Outlook) -> str:
    if not outlook.rows:
        return "come up for a fix before it, make it shorter, or ask for less"
    cures = " or ".join(_cures(mission, vehicle, leg, outlook.leg))
    return f"enough would be: {cures}" if cures else _less(mission, vehicle, leg, outlook)


def _less(mission: Mission, vehicle: Vehicle, leg: Leg, outlook: Outlook) -> str:
    """The hint if no change is enough: the goal that is reachable with a fix after each row."""
    kind, told, best = leg.kind, "", outlook
    assert isinstance(kind, Rows | Cover)
    often = replace(leg, kind=replace(kind, resurface=1.0, unsure=0.0))
    if kind.resurface != 1.0 and _stands(often) and _tried(mission, vehicle):
        told, best = "with resurface 1 ", _with_leg(mission, vehicle, outlook.leg, often)
    asked = [_asked(name, best) for name, _ in outlook.aims]
    return (
        f"{told}ask for {' and '.join(asked)}; or make its rows shorter, or calibrate the vehicle "
        "(how sure it is of its speed and compass)"
    )


def _asked(name: str, outlook: Outlook) -> str:
    """The goal that is expected to be achieved, as mission text."""
    if name == "coverage":
        return f"coverage {math.floor(100.0 * (outlook.coverage or 0.0))}%"
    return f"{name} {math.ceil(max(outlook.errors))} m"


def _missed(outlook: Outlook) -> Iterator[str]:
    """The messages for goals that are not expected to be achieved."""
    aims = dict(outlook.aims)
    wanted = aims.get("coverage", 0.0)
    if outlook.coverage is not None and outlook.coverage < wanted:
        yield (
            f"{outlook.leg} is expected to cover {_percent(outlook.coverage)} of its area, "
            f"not {_percent(wanted)}; {_by_row(outlook.errors)}"
        )
    allowed = aims.get("position", math.inf)
    beyond = {row: e for row, e in enumerate(outlook.errors, 1) if e > allowed}
    if beyond:
        yield (
            f"{_ending(outlook, list(beyond))} {max(beyond.values()):.0f} m from where "
            f"{'they are' if outlook.rows else 'it is'} believed to (95 % of dives), "
            f"not {number_text(allowed)} m"
        )


def _percent(share: float) -> str:
    """The share as text, rounded down."""
    return f"{math.floor(1000.0 * share + 1e-6) / 10.0:g}%"


_TOLD = 8  # most rows that are named


def _ending(outlook: Outlook, beyond: list[int]) -> str:
    if not outlook.rows:
        return f"{outlook.leg} may end"
    rows = ", ".join(map(str, beyond[:_TOLD])) + (" ..." if len(beyond) > _TOLD else "")
    return f"row{'s' if len(beyond) > 1 else ''} {rows} of {outlook.leg} may end"


def _by_row(errors: tuple[float, ...]) -> str:
    worst = max(range(len(errors)), key=errors.__getitem__)
    return f"its row {worst + 1} may end {errors[worst]:.0f} m aside (95 % of dives)"


# --- changes ------------------------------------------------------------------------------


def _cures(mission: Mission, vehicle: Vehicle, leg: Leg, path: str) -> Iterator[str]:
    """For each kind of change, the smallest one that is enough."""
    kind, pattern = leg.kind, expected(mission, vehicle)[path].pattern
    assert isinstance(kind, Rows | Cover)
    if not _tried(mission, vehicle):
        return
    each: tuple[Iterator[tuple[str, Rows | Cover]], ...] = (
        _fixes(kind, len(pattern.rows)),
        _nearer(kind, pattern),
        _shorter(kind),
    )
    for changes in each:
        for told, changed in changes:
            if _does(mission, vehicle, path, replace(leg, kind=changed)):
                yield told
                break


def _fixes(kind: Rows | Cover, count: int) -> Iterator[tuple[str, Rows | Cover]]:
    most = int(kind.resurface) or count
    for rows in range(min(most - 1, count - 1, _FIXES), 0, -1):
        yield f"resurface {rows}", replace(kind, resurface=float(rows), unsure=0.0)


def _nearer(kind: Rows | Cover, pattern: Pattern) -> Iterator[tuple[str, Rows | Cover]]:
    for share in _SHARES:
        spacing = max(0.5, round(pattern.spacing * share, 1))
        yield f"spacing {number_text(spacing)} m", replace(kind, spacing=spacing)


def _shorter(kind: Rows | Cover) -> Iterator[tuple[str, Rows]]:
    """Shorter rows. None for ``cover``: which part of its area to leave out is not known."""
    if not isinstance(kind, Rows):
        return
    for share in _SHARES:
        length = max(1.0, float(round(kind.length * share)))
        yield f"length {number_text(length)} m", replace(kind, length=length)


def _does(mission: Mission, vehicle: Vehicle, path: str, changed: Leg) -> bool:
    return _stands(changed) and not any(_missed(_with_leg(mission, vehicle, path, changed)))


def _stands(changed: Leg) -> bool:
    row = LEGS[type(changed.kind)]
    return not (row.parts(changed) and row.parts_fault(changed))


def _with_leg(mission: Mission, vehicle: Vehicle, path: str, changed: Leg) -> Outlook:
    tried = replace(mission, body=_with(mission.body, path, changed))
    aims = next(aims for at, _, aims in purposes(tried) if at == path)
    return _outlook(path, expected(tried, vehicle)[path], aims)


def _tried(mission: Mission, vehicle: Vehicle) -> bool:
    """Whether the mission is small enough to try changes."""
    return sum(len(one.rows) for one in expected(mission, vehicle).values()) <= _TRIED


def _with(body: tuple[Node, ...], path: str, changed: Leg) -> tuple[Node, ...]:
    head, _, rest = path.partition("/")
    return tuple(
        node
        if node.name != head
        else replace(node, body=_with(node.body, rest, changed))
        if isinstance(node, Group)
        else changed
        for node in body
    )


def _refusal(place: Leg | Group | Mission, message: str, hint: str) -> Diagnostic:
    return Diagnostic(Stage.CHECK, "purpose", place.where, message, hint)
