"""The state graph in the dot language of Graphviz, with a cluster for each group.

Ways into a group end at its first leg, which is the leg that is entered. The group's own ways start
there, too, and are cut at its border (``compound``).
"""

from __future__ import annotations

from collections.abc import Iterable

from mission.authoring.graph.outline import Node, Outline, Way
from mission.authoring.graph.regions import REGIONS, SUBSTATES, region, shared, target
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, By
from mission.model.regions import RegionEdge

_COLOURS = {By.TIMEOUT: "#b45309", By.ELSE: "#b45309", By.ON: "#b91c1c", By.UNCERTAIN: "#b91c1c"}


def dot(outline: Outline, safety: bool = False) -> str:
    rows = shared(safety)
    drawing = _Drawing(outline, rows)
    text = [
        f"digraph {quoted(outline.chart.mission.name)} {{",
        '  graph [compound=true, rankdir=TB, fontname="Helvetica", fontsize=11];',
        '  node [shape=box, style="rounded,filled", fillcolor=white, '
        'fontname="Helvetica", fontsize=10];',
        '  edge [fontname="Helvetica", fontsize=9];',
    ]
    for name in REGIONS:
        states = [path for path in SUBSTATES if region(path) == name]
        text.append(f"  subgraph {quoted('cluster_' + name)} {{ label={quoted(name)};")
        text += [f"    {quoted(p)} [label={quoted(p.partition('/')[2])}];" for p in states]
        text += drawing.any_of(name, 2)
        if name == AUTONOMOUS:
            for node in outline.nodes:
                text += drawing.node(node, 2)
        text.append("  }")
    for node in outline.walk():
        for way in node.ways:
            text += drawing.way(node.path, way)
    for way in outline.handlers:
        text.append(drawing.edge(AUTONOMOUS, way.target, way.text, way.by))
    for row in rows:
        text.append(drawing.edge(row.source, target(row), row.meaning, None))
    return "\n".join([*text, "}", ""])


def quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


class _Drawing:
    def __init__(self, outline: Outline, rows: Iterable[RegionEdge]) -> None:
        self.outline = outline
        ways = [(AUTONOMOUS, way.target) for way in outline.handlers]
        ways += [(node.path, way.target) for node in outline.walk() for way in node.ways]
        ways += [(row.source, target(row)) for row in rows]
        self.inward = {source for source, end in ways if end.startswith(f"{source}/")}
        self.first = {node.path: _first(node) for node in outline.walk()}
        self.first[AUTONOMOUS] = _first(outline.nodes[0])
        for name in REGIONS:
            if name != AUTONOMOUS:
                self.first[name] = next(path for path in SUBSTATES if region(path) == name)

    def node(self, node: Node, level: int) -> list[str]:
        pad = "  " * level
        times = f", {node.repeat} times" if node.repeat > 1 else ""
        title = f"{node.number} {node.name}{times}"
        if node.children:
            title = "; ".join([title, *node.lines])
        else:
            fill = ', fillcolor="#ecfdf5"' if node.path == IMPLICIT_SURFACE else ""
            label = quoted("\n".join([title, *node.lines])).replace("\\\\n", "\\n")
            return [f"{pad}{quoted(node.path)} [label={label}{fill}];"]
        text = [f"{pad}subgraph {quoted('cluster_' + node.path)} {{ label={quoted(title)};"]
        for child in node.children:
            text += self.node(child, level + 1)
        return [*text, *self.any_of(node.path, level + 1), f"{pad}}}"]

    def any_of(self, path: str, level: int) -> list[str]:
        """A node for the begin of ways that lead from any state of a cluster into the cluster."""
        if path not in self.inward:
            return []
        return [f'{"  " * level}{quoted(path + "/*")} [label="in any", shape=plain];']

    def way(self, source: str, way: Way) -> list[str]:
        edges = [self.edge(source, way.target, way.text, way.by)]
        if way.again not in ("", source):
            edges.insert(0, self.edge(source, way.again, f"{way.text}, again", way.by))
        return edges

    def edge(self, source: str, target: str, text: str, by: By | None) -> str:
        more = f', color="{_COLOURS[by]}", fontcolor="{_COLOURS[by]}"' if by in _COLOURS else ""
        if self.first.get(source, source) != source and not target.startswith(f"{source}/"):
            more += f", ltail={quoted('cluster_' + source)}"
        if self.first.get(target, target) != target and not source.startswith(f"{target}/"):
            more += f", lhead={quoted('cluster_' + target)}"
        inward = target.startswith(f"{source}/")
        start = f"{source}/*" if inward else self.first.get(source, source)
        ends = f"{quoted(start)} -> {quoted(self.first.get(target, target))}"
        return f"  {ends} [label={quoted(text)}{more}];"


def _first(node: Node) -> str:
    while node.children:
        node = node.children[0]
    return node.path
