"""All cells: each configuration of each mission and profile, crossed with each event.

An exception out of the runtime is a violation like any other. A law that no cell asks, and a cell
that was skipped, are errors of this package. For each configuration the first event is played again
after all others. The result must be the same, else the copies of the runtime are not independent.

What does not live here: how results are shown (commands.exhaustive).
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mission.authoring.prepare import Prepared
from mission.model.tables import Table
from mission.verification.exhaustive.cell import Cell, Configuration, Event, before
from mission.verification.exhaustive.configurations import (
    Ground,
    configurations,
    ground,
    profiles_of,
)
from mission.verification.exhaustive.doubt_laws import DOUBT_LAWS
from mission.verification.exhaustive.end_laws import END_LAWS
from mission.verification.exhaustive.events import events_of
from mission.verification.exhaustive.fork import Fork
from mission.verification.exhaustive.laws import STATE_LAWS, Law
from mission.verification.exhaustive.leg_laws import LEG_LAWS
from mission.verification.exhaustive.line_laws import LINE_LAWS
from mission.verification.exhaustive.operator_laws import OPERATOR_LAWS
from mission.verification.exhaustive.proof_laws import PROOF_LAWS
from mission.verification.exhaustive.rest_laws import REST_LAWS
from mission.verification.exhaustive.world import World
from mission.verification.workers import results
from mission.verification.workers.contents import contents
from mission.verification.workers.kept import Kept
from mission.verification.workers.outcome import Lost
from mission.verification.workers.places import Place
from mission.verification.workers.progress import Progress

LAWS: Table[str, Law] = Table(
    lambda law: law.name,
    (
        *STATE_LAWS,
        *PROOF_LAWS,
        *LINE_LAWS,
        *OPERATOR_LAWS,
        *LEG_LAWS,
        *REST_LAWS,
        *DOUBT_LAWS,
        *END_LAWS,
    ),
)
KEPT = 200  # violations that are described; all are counted


@dataclass(slots=True)
class Found:
    """``asked``: how many cells each law applied to. ``broken``: how many violated it;
    ``violations`` describes up to KEPT of them."""

    missions: set[str] = field(default_factory=set)
    configurations: int = 0
    cells: int = 0
    events: int = 0  # events that can happen to the vehicle
    has: frozenset[str] = frozenset()  # what the vehicle has, which laws may need
    asked: Counter[str] = field(default_factory=Counter)
    broken: Counter[str] = field(default_factory=Counter)
    violations: list[dict[str, str]] = field(default_factory=list)
    undone: list[str] = field(default_factory=list)  # shares without a result, and why

    def add(self, other: Found) -> None:
        self.missions |= other.missions
        self.configurations += other.configurations
        self.cells += other.cells
        self.events = max(self.events, other.events)
        self.has |= other.has
        self.asked += other.asked
        self.broken += other.broken
        self.violations = (self.violations + other.violations)[:KEPT]
        self.undone += other.undone

    def as_json(self) -> dict[str, object]:
        return {
            "missions": len(self.missions),
            "configurations": self.configurations,
            "events": self.events,
            "cells": self.cells,
            "violations": self.violations,
            "undone": self.undone,
        }


@dataclass(frozen=True, slots=True)
class Share:
    """A mission on a profile, with all that a worker needs of them."""

    prepared: Prepared
    profile: str

    @property
    def name(self) -> str:
        """With what the result follows from."""
        of = self.prepared
        content = f"{of.chart.digest[:8]} {contents(of.vehicle)[:8]}"
        return f"{Path(of.source).name} {content} {self.profile}"


def shares_of(missions: Sequence[Prepared]) -> list[Share]:
    """Return each mission on each of its profiles, once. Raises Unreachable."""
    shares = (Share(of, profile) for of in missions for profile in profiles_of(of))
    return list({share.name: share for share in shares}.values())


def examine(
    shares: Sequence[Share],
    at: Place,
    kept: Kept[Found],
    tell: Callable[[str], None],
    undone: Callable[[Share, Lost], None] = lambda share, lost: None,
) -> Found:
    """Examine all cells. ``undone`` is called with each share that has no result."""
    found = Found()
    progress = Progress(len(shares), "missions on a profile", tell)
    done = results(_examined, shares, at, lambda share: share.name, kept, progress)
    for share, outcome in zip(shares, done, strict=True):
        if isinstance(outcome, Lost):
            found.undone.append(str(outcome))
            undone(share, outcome)
        else:
            found.add(outcome)
            tell(_words(share, found))
    return found


def unasked(found: Found, *, of_legs: bool = True) -> list[str]:
    """Return the laws of these vehicles that no cell asked. ``of_legs`` False: without laws that
    need a kind of leg."""
    own = (law for law in LAWS.values() if law.needs <= found.has)
    laws = [law for law in own if of_legs or not law.of_legs]
    return [law.name for law in laws if not found.asked[law.name]]


def _words(share: Share, found: Found) -> str:
    of = f"{Path(share.prepared.source).name} {share.profile}"
    return f"{of}: {found.cells} cells so far, {found.broken.total()} violations"


def _examined(share: Share) -> Found:
    return examine_ground(ground(share.prepared, share.profile))


def examine_ground(on: Ground, every: int = 1) -> Found:
    """Examine all cells of a mission on a profile. ``every``: only each n-th configuration, for
    tests."""
    found = Found({on.mission}, events=len(events_of(on.line)), has=on.line.has)
    for configuration, world in itertools.islice(configurations(on), 0, None, every):
        found.configurations += 1
        _examine(configuration, world, on, found)
    if found.cells != found.configurations * found.events:
        raise AssertionError("a cell was skipped")
    return found


def _examine(configuration: Configuration, world: World, on: Ground, found: Found) -> None:
    fork = Fork(world)
    first = ""
    for event in events_of(on.line):
        cell, fault = _played(configuration, event, on, fork)
        found.cells += 1
        first = first or _seen(cell)
        for name, words in _judged(cell, fault, found):
            found.broken[name] += 1
            _keep(found, cell, name, words)
    again, _ = _played(configuration, events_of(on.line)[0], on, fork)
    if _seen(again) != first:
        raise AssertionError(f"{configuration.name}: the same event twice is not the same")


def _played(
    configuration: Configuration, event: Event, on: Ground, fork: Fork[World]
) -> tuple[Cell, str]:
    world = fork.copy()
    world.at_once = ""
    world.paced.clear()
    cell = Cell(configuration, event, on.chart, before(world), world)
    try:
        event.play(world, configuration, on.chart)
    except Exception as error:  # any exception of the runtime is a finding
        return cell, f"{type(error).__name__}: {error}"
    return cell, ""


def _judged(cell: Cell, fault: str, found: Found) -> Iterator[tuple[str, str]]:
    if fault:
        yield "no exception leaves the runtime", fault
        return
    for law in LAWS.values():
        verdict = law.ask(cell) if law.needs <= cell.line.has else None
        if verdict is not None:
            found.asked[law.name] += 1
        if verdict:
            yield law.name, verdict


def _keep(found: Found, cell: Cell, law: str, words: str) -> None:
    if len(found.violations) < KEPT:
        c = cell.configuration
        found.violations.append(
            {
                "law": law,
                "mission": c.mission,
                "profile": c.profile,
                "configuration": c.name,
                "event": cell.event.name,
                "seen": words,
            }
        )


def _seen(cell: Cell) -> str:
    return f"{cell.sent} {cell.steps} {cell.states}"
