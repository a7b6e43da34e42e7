"""Laws of the machine: the library against a plain interpreter, and the names it must bear."""

from __future__ import annotations

import random

import pytest
from engine_world import compiled, leg, mission, when
from hypothesis import given, settings
from hypothesis import strategies as st
from transitions import MachineError

from mission.engine.machine import Machine, NoSuchEdge
from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    STOPPED,
    SURFACED,
    SURFACING,
    Group,
)
from mission.model.regions import REGION_EDGES, REGIONS


def interpreted(active: str, target: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Leave up to the common ancestor of the active state and its target, enter down."""
    here, there = active.split("/"), target.split("/")
    common = 0
    while common < min(len(here), len(there)) - 1 and here[common] == there[common]:
        common += 1
    if here[: common + 1] == there[: common + 1] and len(there) <= common + 1 < len(here):
        common = len(there) - 1  # into an ancestor: it is left and entered
    exited = tuple("/".join(here[:i]) for i in range(len(here), common, -1))
    entered = tuple("/".join(there[:i]) for i in range(common + 1, len(there) + 1))
    return exited, entered


@st.composite
def trees(draw, depth: int = 0):
    """Groups inside groups with legs that jump anywhere."""
    nodes = []
    for i in range(draw(st.integers(1, 3))):
        if depth < 3 and draw(st.booleans()):
            nodes.append(Group(f"g{i}", draw(st.integers(1, 2)), draw(trees(depth + 1))))
        else:
            nodes.append(leg(f"l{i}", when("depth", ">", 1)))
    return tuple(nodes)


@pytest.mark.proof
@settings(max_examples=40, deadline=None)
@given(trees(), st.randoms(use_true_random=False))
def test_the_library_agrees_with_a_plain_interpreter(body, rng: random.Random):
    chart = compiled(mission(*body))
    machine = Machine(chart)
    machine.move("load", IDLE_READY)
    machine.move("start", chart.initial)
    for _ in range(60):
        edges = [e for e in chart.edges if machine.active.startswith(e.source)]
        inside = [e for e in edges if e.source in _ancestry(machine.active)]
        if not inside or not machine.active.startswith(AUTONOMOUS):
            machine.restore(rng.choice([s.path for s in chart.states if s.leg]))
            continue
        edge = rng.choice(inside)
        expected = interpreted(machine.active, edge.target)
        assert machine.fire(edge.trigger) == expected
        assert machine.active == edge.target
        assert machine.region == edge.target.partition("/")[0]


def _ancestry(path: str) -> set[str]:
    parts = path.split("/")
    return {"/".join(parts[:i]) for i in range(1, len(parts) + 1)}


@pytest.mark.parametrize("name", ["add", "_func", "state", "trigger", "a_b", "on", "2nd", "is_x"])
def test_any_name_of_a_leg_builds_and_runs(name: str):
    chart = compiled(mission(leg(name, when("depth", ">", 1)), leg("next")))
    machine = Machine(chart)
    machine.move("load", IDLE_READY)
    assert machine.move("start", chart.initial)[1][-1] == f"{AUTONOMOUS}/{name}"
    machine.fire(f"{AUTONOMOUS}/{name}:until1")
    assert machine.active == f"{AUTONOMOUS}/next"


def test_every_region_edge_can_be_taken_from_each_of_its_sources():
    chart = compiled(mission(leg("a")))
    leaves = [*(leaf for r in REGIONS.values() for leaf in r), chart.initial]
    for row in REGION_EDGES:
        for leaf in leaves:
            if leaf == row.source or leaf.startswith(row.source + "/"):
                machine = Machine(chart)
                machine.restore(leaf)
                machine.move(row.name, row.target or chart.initial)
                assert machine.active == (row.target or chart.initial)


def test_from_every_leaf_there_is_a_way_to_stopped_to_surfacing_and_to_the_stick():
    chart = compiled(mission(leg("a"), Group("g", 2, (leg("b"),))))
    leaves = [leaf for r in REGIONS.values() for leaf in r]
    for leaf in [*leaves, *(s.path for s in chart.states if s.leg)]:
        for name, target in (("X", STOPPED), ("W", SURFACING), ("stick", MANUAL_DRIVING)):
            if (name, leaf) == ("stick", MANUAL_DRIVING):
                continue
            machine = Machine(chart)
            machine.restore(leaf)
            machine.move(name, target)
            assert machine.active == target


def test_there_is_no_way_out_of_an_emergency_but_r7s():
    machine = Machine(compiled(mission(leg("a"))))
    for leaf in (STOPPED, SURFACING, SURFACED):
        machine.restore(leaf)
        for name, target in (("start", "autonomous/a"), ("end", IDLE_READY)):
            with pytest.raises(NoSuchEdge):
                machine.move(name, target)
    machine.restore(SURFACING)
    for name, target in (("clear", IDLE_EMPTY), ("limit", SURFACING)):
        with pytest.raises(NoSuchEdge):
            machine.move(name, target)


def test_what_is_not_there_is_told_and_changes_nothing():
    machine = Machine()
    with pytest.raises(NoSuchEdge):
        machine.fire("nonsense")
    with pytest.raises(ValueError, match="nowhere"):
        machine.restore("nowhere/at_all")
    assert machine.active == IDLE_EMPTY


def test_a_snapshot_brings_the_machine_back():
    chart = compiled(mission(leg("a", when("depth", ">", 1)), leg("b")))
    machine = Machine(chart)
    machine.move("load", IDLE_READY)
    machine.move("start", chart.initial)
    kept = machine.snapshot()
    machine.fire("autonomous/a:until1")
    machine.restore(kept)
    assert machine.active == chart.initial
    assert machine.fire("autonomous/a:until1")[1] == ("autonomous/b",)


def test_an_edge_of_another_state_is_an_error_and_changes_nothing():
    machine = Machine(compiled(mission(leg("a", when("depth", ">", 1)), leg("b"))))
    machine.move("load", IDLE_READY)
    with pytest.raises(MachineError):
        machine.fire("autonomous/a:until1")
    assert machine.active == IDLE_READY


def test_a_start_leads_into_a_leg_and_nowhere_else():
    machine = Machine(compiled(mission(leg("a"))))
    machine.move("load", IDLE_READY)
    for elsewhere in (STOPPED, "autonomous", "autonomous/nowhere"):
        with pytest.raises(NoSuchEdge):
            machine.move("start", elsewhere)
    assert machine.active == IDLE_READY
