"""The exported chart, run by an independent engine, visits the states that ours visits.

python-statemachine reads the SCXML; ours is the Machine, with rounds counted as Edge says.
"""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from graph_charts import chart
from later import installed

from mission.authoring.graph.scxml import RESUME, event_of, events, identifier, scxml
from mission.authoring.prepare import prepare
from mission.engine.machine import Machine
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, By, Chart, Edge
from mission.model.regions import AGAIN, LEG, REGION_EDGES
from mission.model.shipped import missions_folder

io = installed("statemachine.io", "python-statemachine is not installed")

NESTED = """mission nested vehicle auv
home 30.2874595 120.1535765
safety radius 900 time 40min depth 10 voltage 10
assume current 0.1
dive: depth 3 heading 0 gear 4 until depth >= 2.5 timeout 30
repeat 2 outer:
one: depth 3 heading 0 gear 4 until travelled >= 5 timeout 20 else one
repeat 3 inner:
two: depth 3 heading 90 gear 4 for 5s
three: depth 3 heading 180 gear 4 until travelled >= 5 or altitude < 1 timeout 20
on depth > 6 -> two
end
on altitude < 2 -> one
end
last: depth 3 heading 0 gear 4 for 10s
up: surface timeout 3min
on battery < 11 -> outer
on depth > 8 -> last
"""


class Ours:
    """Edges taken as the engine takes them: by trigger, rounds counted."""

    def __init__(self, which: Chart) -> None:
        self.chart, self.machine = which, Machine(which)
        self.machine.move("load", "idle/ready")
        self.rounds = {s.path: 1 for s in which.states if s.group}
        self.repeat = {s.path: s.group.repeat for s in which.states if s.group}
        self.interrupted = which.initial
        self.acted: set[str] = set()

    def possible(self) -> list[tuple[str, Any]]:
        at = self.machine.active
        found: list[tuple[str, Any]] = [
            (events(self.chart)[e.trigger], e) for e in self.chart.edges if self.may(e, at)
        ]
        for row in REGION_EDGES:
            if at == row.source or at.startswith(f"{row.source}/"):
                found.append((event_of(row), row))
                if row.target == LEG and row.source == "manual":
                    found.append((RESUME, row))
        return found

    def may(self, edge: Edge, at: str) -> bool:
        inside = at == edge.source or at.startswith(f"{edge.source}/")
        handled = at == edge.source or at not in (edge.target, IMPLICIT_SURFACE)
        return (
            inside
            and handled
            and all(
                (self.rounds[loop.group] < self.repeat[loop.group]) == loop.again
                for loop in edge.loops
            )
        )

    def take(self, event: str, what: Any) -> None:
        if self.machine.region == AUTONOMOUS:
            self.interrupted = self.machine.active
        if isinstance(what, Edge):
            if what.by in (By.ON, By.UNCERTAIN):
                if event in self.acted:  # the second time
                    self.machine.fire(AGAIN)
                    return
                self.acted.add(event)
            _, entered = self.machine.fire(what.trigger)
            self.enter(entered)
            for loop in what.loops:
                self.rounds[loop.group] = self.rounds[loop.group] + 1 if loop.again else 1
            return
        target = what.target
        if target == LEG:
            target = self.interrupted if event == RESUME else self.chart.initial
        _, entered = self.machine.move(what.name, target)
        if event != RESUME:
            self.enter(entered)
            self.acted = set() if what.target == LEG else self.acted

    def enter(self, paths: tuple[str, ...]) -> None:
        for path in paths:
            if path in self.rounds:
                self.rounds[path] = 1


def theirs(which: Chart, folder: Path) -> Any:
    path = folder / "chart.scxml"
    path.write_text(scxml(which), encoding="utf-8")
    return io.load(path)()


def leaf(machine: Any) -> str:
    return str(max((state.id for state in machine.configuration), key=len))


def charts() -> list[Path]:
    folder = missions_folder()
    return sorted([*folder.glob("*.yaml"), *folder.glob("*.mission")])


def walk(which: Chart, folder: Path, steps: int, seed: int) -> int:
    """Random events; how many of the chart's own edges were taken."""
    chance, ours, other, taken = random.Random(seed), Ours(which), theirs(which, folder), 0
    for _ in range(steps):
        assert leaf(other) == identifier(ours.machine.active)
        offers = ours.possible()
        own = [offer for offer in offers if isinstance(offer[1], Edge)]
        if own and chance.random() < 0.9:
            offers = [o for o in own if o[1].target != IMPLICIT_SURFACE] or own
            onward = [o for o in offers if o[1].by is not By.ON]
            offers = onward if onward and chance.random() < 0.8 else offers
            taken += 1
        elif ours.machine.active == "idle/ready":
            offers = [offer for offer in offers if offer[0] == "start"]
        event, what = chance.choice(offers)
        ours.take(event, what)
        other.send(event)
    return taken


@pytest.mark.parametrize("path", charts(), ids=lambda path: path.name)
def test_shipped_missions_run_alike_in_both_engines(path: Path, tmp_path: Path) -> None:
    assert walk(prepare(path).chart, tmp_path, 160, 1) > 30


@pytest.mark.parametrize("seed", range(4))
def test_rounds_in_rounds_and_handlers_run_alike_in_both_engines(seed: int, tmp_path: Path) -> None:
    source = tmp_path / "nested.mission"
    source.write_text(NESTED)
    assert walk(prepare(source).chart, tmp_path, 250, seed) > 60


def test_charts_made_by_hand_run_alike_in_both_engines(tmp_path: Path) -> None:
    assert walk(chart(3, 3, 3, repeat=3), tmp_path, 280, 2) > 60


def test_a_handler_does_nothing_in_the_leg_it_leads_to(tmp_path: Path) -> None:
    source = tmp_path / "nested.mission"
    source.write_text(NESTED)
    which = prepare(source).chart
    edge = next(e for e in which.edges if e.target.endswith("/two") and e.source.endswith("/inner"))
    ours, other = Ours(which), theirs(which, tmp_path)
    for name in ("start", events(which)["autonomous/dive:until1"]):
        event, what = next(o for o in ours.possible() if o[0] == name)
        ours.take(event, what)
        other.send(event)
    other.send(events(which)["autonomous/outer/one:until1"])
    assert leaf(other) == identifier(edge.target)
    other.send(events(which)[edge.trigger])
    assert leaf(other) == identifier(edge.target)
