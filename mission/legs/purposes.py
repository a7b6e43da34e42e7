"""Which legs have aims (`achieve`), by which the check and the flights judge them.

rows        all aims of the leg, its groups and the mission, the innermost first
an ascent   none
any other   the position alone, if the leg, group or mission that states it has no rows
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TypeVar

from mission.legs import LEGS
from mission.model import Group, Leg, Mission, Node, aims_of

_Scope = TypeVar("_Scope", Mission, Group)

OF_ANY = "position"  # the only aim of legs without rows


def purposes(mission: Mission) -> Iterator[tuple[str, Leg, dict[str, float]]]:
    """Path, leg and aims of each leg that has aims, in the mission's order."""
    others = _not_of_rows(mission)
    each = zip(
        aims_of(mission.body, mission.achieve), aims_of(others.body, others.achieve), strict=True
    )
    for (path, leg, aims), (_, _, other) in each:
        row = LEGS[type(leg.kind)]
        if not row.surveys:
            aims = {} if row.ascends else {n: v for n, v in other.items() if n == OF_ANY}
        if aims:
            yield path, leg, aims


def has_rows(body: Iterable[Node]) -> bool:
    return any(
        has_rows(node.body)
        if isinstance(node, Group)
        else isinstance(node, Leg) and LEGS[type(node.kind)].surveys
        for node in body
    )


def _not_of_rows(scope: _Scope) -> _Scope:
    """The scope without the aims that are stated for rows."""
    body = tuple(_not_of_rows(n) if isinstance(n, Group) else n for n in scope.body)
    return replace(scope, body=body, achieve=() if has_rows(scope.body) else scope.achieve)
