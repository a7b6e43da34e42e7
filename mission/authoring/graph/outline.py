"""The chart for a reader: legs numbered in order, each with its ways out as text.

    Chart --outline--> Outline(nodes, ways) --> svg, mermaid, dot, html

Edges that differ only by the round of a repeated group are one way. A way that leads to the next
leg ``falls``; every other way is a jump and names its target. Below ``depth`` levels a group is one
node with the ways that leave it.

What does not live here: coordinates and syntax of the formats. Nothing here runs the chart.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from mission.authoring.graph import words
from mission.legs import LEGS
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, Aims, By, Chart, Edge, State
from mission.model.extent import PICTURE

ONE_LINE = 44  # characters of a leg's details that fit in one line


@dataclass(frozen=True, slots=True)
class Way:
    """One way out of a node. ``target`` is the path of a shown node, or of another region."""

    text: str
    by: By
    target: str
    falls: bool
    again: str  # the target while a repeated group has rounds left, or ""
    edges: tuple[Edge, ...]


@dataclass(frozen=True, slots=True)
class Node:
    """A leg or group. ``numbers``: its first and last leg number. A node without children may be a
    collapsed group. ``lines``: details of a leg; the goal of an open group."""

    path: str
    name: str
    numbers: tuple[int, int]
    lines: tuple[str, ...]
    ways: tuple[Way, ...]
    children: tuple[Node, ...] = ()
    repeat: int = 1

    @property
    def number(self) -> str:
        first, last = self.numbers
        return str(first) if first == last else f"{first}-{last}"

    def walk(self) -> Iterator[Node]:
        yield self
        for child in self.children:
            yield from child.walk()


@dataclass(frozen=True, slots=True)
class Outline:
    chart: Chart
    nodes: tuple[Node, ...]
    handlers: tuple[Way, ...]  # of the whole mission

    def walk(self) -> Iterator[Node]:
        for node in self.nodes:
            yield from node.walk()

    def leaves(self) -> tuple[Node, ...]:
        return tuple(node for node in self.walk() if not node.children)

    def label(self, path: str) -> str:
        """``39 home_run`` for a leg or group shown here; the path itself for other regions."""
        for node in self.walk():
            if node.path == path:
                return node.name if path == IMPLICIT_SURFACE else f"{node.number} {node.name}"
        return path.removeprefix(f"{AUTONOMOUS}/")


def outline(chart: Chart, depth: int | None = None) -> Outline:
    """Make the outline of a chart. ``depth`` >= 1: levels of groups below ``autonomous`` that are
    drawn open; None: all. Raises TooLarge if there are too many nodes for a picture."""
    reader = _Reader(chart, depth)
    nodes = tuple(reader.node(state, 1) for state in reader.children(AUTONOMOUS))
    found = Outline(chart, nodes, reader.ways(AUTONOMOUS, AUTONOMOUS))
    if sum(1 for _ in found.walk()) > PICTURE.most:
        raise TooLarge(f"{PICTURE.exceeded}; --depth draws fewer, of a mission in groups")
    return found


class TooLarge(LookupError):
    """The picture has too many nodes; the author must draw fewer levels, or a smaller mission."""


class _Reader:
    def __init__(self, chart: Chart, depth: int | None) -> None:
        self.chart, self.depth = chart, depth
        self.states = {state.path: state for state in chart.states}
        self._children: dict[str, list[State]] = {}
        for state in chart.states:
            if state.path != AUTONOMOUS:
                self._children.setdefault(state.parent, []).append(state)
        leaves = [s.path for s in chart.states if s.path not in self._children]
        leaves = [path for path in leaves if path != AUTONOMOUS]
        self.order = {path: i for i, path in enumerate(leaves)}
        self._edges: dict[str, list[Edge]] = {}
        for edge in chart.edges:
            self._edges.setdefault(edge.source, []).append(edge)

    def children(self, path: str) -> list[State]:
        return self._children.get(path, [])

    def below(self, path: str) -> Iterator[str]:
        yield path
        for child in self.children(path):
            yield from self.below(child.path)

    def first(self, path: str) -> str:
        """The first leg of ``path``, which is entered with it."""
        while children := self.children(path):
            path = children[0].path
        return path

    def shown(self, path: str) -> str:
        """``path``, or the collapsed group that contains it."""
        parts = path.split("/")
        if self.depth is None or parts[0] != AUTONOMOUS:
            return path
        return "/".join(parts[: self.depth + 1])

    def node(self, state: State, level: int) -> Node:
        legs = [self.order[p] + 1 for p in self.below(state.path) if p in self.order]
        numbers = (legs[0], legs[-1])
        name = state.path.rpartition("/")[2]
        repeat = state.group.repeat if state.group is not None else 1
        if state.group is None:
            return Node(state.path, name, numbers, _lines(state), self.ways(state.path, state.path))
        if self.depth is not None and level >= self.depth:
            return self._collapsed(state, name, numbers, repeat)
        inner = tuple(self.node(child, level + 1) for child in self.children(state.path))
        aims = _aims(state.group.achieve)
        return Node(
            state.path, name, numbers, aims, self.ways(state.path, state.path), inner, repeat
        )

    def _collapsed(self, state: State, name: str, numbers: tuple[int, int], repeat: int) -> Node:
        ways: dict[tuple[str, str], Way] = {}
        for path in self.below(state.path):
            for way in self.ways(path, state.path):
                if way.target != state.path:
                    ways.setdefault((way.text, way.target), way)
        count = numbers[1] - numbers[0] + 1
        lines = (f"{count} leg{'s' * (count > 1)}",)
        return Node(state.path, name, numbers, lines, tuple(ways.values()), (), repeat)

    def ways(self, source: str, shown: str) -> tuple[Way, ...]:
        found: list[Way] = []
        for _, same in groupby(self._edges.get(source, ()), key=lambda e: (e.by, e.guard)):
            edges = tuple(same)
            if edges[0].loops:
                found.append(self._way(edges, shown))
            else:  # without rounds, each is a way of its own
                found += [self._way((edge,), shown) for edge in edges]
        return _joined(found)

    def _way(self, edges: tuple[Edge, ...], shown: str) -> Way:
        leaving = edges[-1]
        state = self.states.get(leaving.source)
        text = words.edge(leaving, state.leg if state is not None else None)
        falls = leaving.by is not By.ON and self._falls(leaving)
        again = self.shown(edges[0].target) if len(edges) > 1 else ""
        return Way(text, leaving.by, self.shown(leaving.target), falls, again, edges)

    def _falls(self, edge: Edge) -> bool:
        if edge.source not in self.order or edge.target.split("/")[0] != AUTONOMOUS:
            return False
        target = self.first(edge.target)
        if self.order.get(target) != self.order[edge.source] + 1:
            return False
        finished = {loop.group for loop in edge.loops}
        return all(
            path in finished or edge.target.startswith(f"{path}/")
            for path in _ancestors(edge.source)
            if (group := self.states[path].group) is not None and group.repeat > 1
        )


def _ancestors(path: str) -> Iterator[str]:
    """The groups around a leg, innermost first, without ``autonomous``."""
    while (path := path.rpartition("/")[0]) and path != AUTONOMOUS:
        yield path


def _aims(aims: Aims) -> tuple[str, ...]:
    return (f"to achieve {words.achieve(aims)}",) if aims else ()


def _lines(state: State) -> tuple[str, ...]:
    if state.leg is None:
        return ()
    if state.path == IMPLICIT_SURFACE:
        return ("ascend, proved by the depth; then idle",)
    does, holds = words.kind(state.leg), words.setpoint(state.setpoint)
    told = (*filter(None, (words.outputs(state),)), *_aims(state.leg.achieve))
    if LEGS[type(state.leg.kind)].ascends:  # in an ascent all of the set is at rest
        return (does, *told)
    whole = " \u00b7 ".join(part for part in (does, holds, *told) if part)
    return (whole,) if len(whole) <= ONE_LINE else (does, holds, *told)


def _joined(ways: list[Way]) -> tuple[Way, ...]:
    """A timeout and an else that lead to the same place are one way."""
    result: list[Way] = []
    for way in ways:
        last = next((w for w in result if {w.by, way.by} == {By.TIMEOUT, By.ELSE}), None)
        if last is not None and last.target == way.target:
            timeout = last if last.by is By.TIMEOUT else way
            # if it falls through, no target follows the text
            text = f"{timeout.text}, " + ("refused or blind" if last.falls else "or else")
            edges = last.edges + way.edges
            joined = Way(text, By.TIMEOUT, way.target, last.falls, last.again, edges)
            result[result.index(last)] = joined
        else:
            result.append(way)
    return tuple(result)
