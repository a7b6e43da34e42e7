"""The state graph as a Mermaid ``stateDiagram-v2``.

Mermaid cannot link states inside different composite states, so such a way is drawn between the
two that stand side by side, and its text names the legs that are meant. Names and texts are any
characters: identifiers are generated, texts are written with entity codes where Mermaid would
read syntax.
"""

from __future__ import annotations

from mission.graph.outline import Node, Outline, Way
from mission.graph.regions import REGIONS, SUBSTATES, region, shared
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE

_PLAIN = frozenset(" .,()/_+-=\u00b0\u2265\u2264\u00b7*?!'")


def mermaid(outline: Outline, safety: bool = False) -> str:
    return "\n".join(_Diagram(outline).lines(safety)) + "\n"


def quoted(text: str) -> str:
    """Every character that could be syntax as ``#code;``."""
    return "".join(c if c.isalnum() or c in _PLAIN else f"#{ord(c)};" for c in text)


class _Diagram:
    def __init__(self, outline: Outline) -> None:
        self.outline = outline
        self.parents: dict[str, str] = {}
        for node in outline.walk():
            self.parents[node.path] = node.path.rpartition("/")[0]
        self.names = {path: f"s{i}" for i, path in enumerate(self.parents, 1)}
        self.names |= {name: name for name in REGIONS}
        self.names |= {path: path.replace("/", "_") for path in SUBSTATES}
        self.parents |= {path: region(path) for path in SUBSTATES}
        self.links: dict[str, list[str]] = {}

    def lines(self, safety: bool) -> list[str]:
        title = quoted(self.outline.chart.mission.name)
        for node in self.outline.walk():
            for way in node.ways:
                self._way(node.path, way)
        for way in self.outline.handlers:
            for node in self.outline.nodes:
                if node.path not in (way.target, IMPLICIT_SURFACE):
                    self._link(node.path, way.target, way.text)
        for row in shared(safety):
            if row.event != "end":
                self._link(row.source, row.target, row.text)
        text = ["---", f"title: {title}", "---", "stateDiagram-v2", "    direction TB"]
        text += self._region("idle")
        text += [f"    state {AUTONOMOUS} {{"]
        text += self._inside(AUTONOMOUS, self.outline.nodes, 2)
        text += ["    }", *self._region("manual"), *self._region("emergency")]
        return [*text, "    [*] --> idle", *self._drawn("", 1)]

    def _way(self, source: str, way: Way) -> None:
        if len(way.edges) > 1 and way.edges[0].loops:
            self._link(source, way.edges[0].target, f"{way.text}, again")
        self._link(source, way.target, way.text)

    def _link(self, source: str, target: str, text: str) -> None:
        """Between the ancestors of both that share a parent; legs below them go into the text."""
        above_source, above_target = self._chain(source), self._chain(target)
        common = next((path for path in above_source if path in above_target), "")
        start = above_source[above_source.index(common) - 1] if common in above_source else ""
        end = above_target[above_target.index(common) - 1] if common in above_target else ""
        if source in above_target or target in above_source:  # one holds the other
            start, end = source, target
            common = self.parents.get(source if source in above_target else target, "")
        if start != source:
            text = f"{self.outline.label(source)}: {text}"
        if end != target:
            text = f"{text} -> {self.outline.label(target)}"
        link = f"{self.names[start]} --> {self.names[end]} : {quoted(text)}"
        links = self.links.setdefault(common, [])
        if link not in links:
            links.append(link)

    def _chain(self, path: str) -> list[str]:
        chain = [path]
        while path in self.parents:
            path = self.parents[path]
            chain.append(path)
        return [*chain, ""]

    def _inside(self, path: str, nodes: tuple[Node, ...], level: int) -> list[str]:
        pad = "    " * level
        text = [f"{pad}[*] --> {self.names[nodes[0].path]}"] if nodes else []
        for node in nodes:
            times = f", {node.repeat} times" if node.repeat > 1 else ""
            label = quoted(". ".join([f"{node.number} {node.name}{times}", *node.lines]))
            text.append(f'{pad}state "{label}" as {self.names[node.path]}')
            if node.children:
                text.append(f"{pad}state {self.names[node.path]} {{")
                text += [*self._inside(node.path, node.children, level + 1), f"{pad}}}"]
        return text + self._drawn(path, level)

    def _region(self, name: str) -> list[str]:
        states = [path for path in SUBSTATES if region(path) == name]
        text = [f"    state {name} {{", f"        [*] --> {self.names[states[0]]}"]
        text += [f'        state "{p.partition("/")[2]}" as {self.names[p]}' for p in states]
        return [*text, *self._drawn(name, 2), "    }"]

    def _drawn(self, path: str, level: int) -> list[str]:
        return ["    " * level + link for link in self.links.get(path, ())]
