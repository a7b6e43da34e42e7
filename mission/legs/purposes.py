"""Which legs are flown for something (`achieve`), as the check and the flights judge them.

rows        all that is said of them: by the leg, its groups, the mission, the innermost first
an ascent   nothing
any other   the position alone, where whoever says it has no rows to say it of
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TypeVar

from mission.legs import LEGS
from mission.model import Group, Leg, Mission, Node, aims_of

_Scope = TypeVar("_Scope", Mission, Group)

OF_ANY = "position"  # the aim that legs without rows have, too


def purposes(mission: Mission) -> Iterator[tuple[str, Leg, dict[str, float]]]:
    """Path, leg and aims of each leg that has some, in the mission's order."""
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
    """Without what is said of rows."""
    body = tuple(_not_of_rows(n) if isinstance(n, Group) else n for n in scope.body)
    return replace(scope, body=body, achieve=() if has_rows(scope.body) else scope.achieve)
