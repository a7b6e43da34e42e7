"""Rows with fixes at the surface between them: the leg is divided into runs, with ascents between.

    resurface N   a fix after every N rows
    unsure M      single rows; after each, the estimate's uncertainty is checked, and a fix follows
                  if it is more than M m

The estimate learns the current from every two fixes, and the next rows are steered with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

from mission.legs.hold import Hold
from mission.legs.surface import Surface
from mission.legs.words import Measure
from mission.model import Back, Comparison, Exit, Guard, Leg, LegKind, Setting, terms
from mission.model.texts import Term

RESURFACE = Measure(
    "resurface", "", 1, 9999, "up for a fix after so many rows", 0.0, "2", silent=True
)
UNSURE = Measure(
    "unsure",
    "m",
    1,
    10000,
    "up for a fix after a row where `uncertainty` is more",
    0.0,
    "15",
    silent=True,
)
FIX_S = 300.0  # from ascent to fix at most; then the leg's else, or the mission's on timeout
_SINCE_BEGIN = frozenset({"elapsed", "travelled"})  # variables that count from a leg's beginning
_LOOK_S = 4.0  # two reports: how long the uncertainty is checked between two rows


@dataclass(frozen=True, slots=True)
class Run:
    """The rows between two looks. ``first``: the number of its first row in the leg, from 0.
    ``kind``: what is flown. ``share``: of the leg's timeout. ``heading``: of its last row, rad."""

    first: int
    kind: LegKind
    share: float
    heading: float


def parted(leg: Leg, runs: Iterable[Run], unsure: float) -> tuple[Leg, ...]:
    """The legs of a divided leg. ``unsure``: m of uncertainty; 0: a fix in any case."""
    runs = tuple(runs)
    parts = [_flown(leg, runs[0])]
    for before, run in pairwise(runs):
        parts += [*_between(leg, run.first, before.heading, unsure), _flown(leg, run)]
    return tuple(parts)


def _flown(leg: Leg, run: Run) -> Leg:
    timeout = None if leg.timeout is None else leg.timeout * run.share
    return replace(leg, name=_name(run.first), kind=run.kind, timeout=timeout, achieve=())


def _name(row: int) -> str:
    return f"row{row + 1}"


def _between(leg: Leg, row: int, heading: float, unsure: float) -> Iterator[Leg]:
    """The legs before ``row``: a fix, or first a look at whether one is needed."""
    if unsure > 0.0:
        known = Comparison("uncertainty", "<=", unsure, where=leg.where)
        kept = (*leg.settings, Setting("heading", heading, leg.where))
        onwards = (Exit(Guard(known), _name(row), leg.where),)
        yield Leg(f"look{row}", Hold(), kept, onwards, duration=_LOOK_S,
                  otherwise=leg.otherwise, where=leg.where)  # fmt: skip
    up = Surface(until_fix=True, keeps_outputs=True)
    yield Leg(f"fix{row}", up, timeout=FIX_S, otherwise=leg.otherwise, where=leg.where)


def parting_fault(leg: Leg, resurface: float, unsure: float) -> str:
    """Why the rows of this leg cannot resurface; "" if they can."""
    said = {setting.word for setting in leg.settings}
    if resurface and unsure:
        return "resurface and unsure are two rules for one thing: keep one"
    if "surge" not in said or said.isdisjoint({"depth", "altitude"}):
        return "at the surface all is off: say gear, and depth or altitude, in this leg"
    if leg.duration is not None:
        return "rows that resurface end by themselves: say timeout, not for"
    if any(way.target is None for way in leg.exits):
        return "until would lead to the next part of the rows: say until ... -> NAME"
    asked = (term for way in leg.exits for term in terms(way.guard.expression))
    return next(filter(None, map(_anew, asked)), "")


def _anew(term: Term) -> str:
    """Why a guard's term would count in each run, not in the whole leg; "" if it would not."""
    if isinstance(term, Comparison):
        if term.variable not in _SINCE_BEGIN:
            return ""
        asked, instead = term.variable, "ask for mission_time, or say timeout and else"
    elif isinstance(term, Back):
        asked, instead = f"{term.variable} back", "ask in a leg behind them"
    elif term.of_depth or term.window == math.inf:
        moves = "rises" if term.rises else "falls"
        asked, instead = f"{term.variable} {moves}", "say within so many s"
    else:
        return ""
    return f"{asked} would count anew in each run of rows that resurface: {instead}"
