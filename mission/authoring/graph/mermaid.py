"""The state graph as a Mermaid ``stateDiagram-v2``.

Mermaid cannot link states inside different composite states. Such a way is drawn between the two
composite states, and its text names the legs. Names and texts may have any characters: identifiers
are generated, and characters that Mermaid could read as syntax become entity codes.
"""

from __future__ import annotations

from mission.authoring.graph.outline import Node, Outline, Way
from mission.authoring.graph.regions import REGIONS, SUBSTATES, region, shared, target
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE

_PLAIN = frozenset(" .,()/_+-=\u00b0\u2265\u2264\u00b7*?!'")


def mermaid(outline: Outline, safety: bool = False) -> str:
    return "\n".join(_Diagram(outline).lines(safety)) + "\n"


def quoted(text: str) -> str:
    """The text with every character that could be syntax as ``#code;``."""
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
                if node.children:
                    self._spread(node.path, way.target, way.text)
                else:
                    self._way(node.path, way)
        for way in self.outline.handlers:
            self._spread(AUTONOMOUS, way.target, way.text)
        for row in shared(safety):
            self._spread(row.source, target(row), row.meaning)
        text = ["---", f"title: {title}", "---", "stateDiagram-v2", "    direction TB"]
        text += self._region("idle")
        text += [f"    state {AUTONOMOUS} {{"]
        text += self._inside(AUTONOMOUS, self.outline.nodes, 2)
        text += ["    }", *self._region("manual"), *self._region("emergency")]
        return [*text, "    [*] --> idle", *self._drawn("", 1)]

    def _way(self, source: str, way: Way) -> None:
        if way.again not in ("", source):
            self._link(source, way.again, f"{way.text}, again")
        self._link(source, way.target, way.text)

    def _spread(self, source: str, target: str, text: str) -> None:
        """Link a composite state to a target; if the target is inside it, link each of the other
        states inside instead."""
        if not target.startswith(f"{source}/"):
            self._link(source, target, text)
            return
        for path, parent in self.parents.items():
            if parent == source and path not in (target, IMPLICIT_SURFACE):
                self._spread(path, target, text)

    def _link(self, source: str, target: str, text: str) -> None:
        """Link the ancestors of both states that share a parent; the text names the legs below."""
        above_source, above_target = self._chain(source), self._chain(target)
        common = next(path for path in above_source[1:] if path in above_target[1:])
        start = above_source[above_source.index(common) - 1]
        end = above_target[above_target.index(common) - 1]
        if start != source:
            text = f"{self.outline.label(source)}: {text}"
        if end != target and self._first(end) != target:
            text = f"{text} -> {self.outline.label(target)}"
        link = f"{self.names[start]} --> {self.names[end]} : {quoted(text)}"
        links = self.links.setdefault(common, [])
        if link not in links:
            links.append(link)

    def _first(self, path: str) -> str:
        """The first leg of a node, which is entered with it."""
        node = next((n for n in self.outline.walk() if n.path == path), None)
        while node is not None and node.children:
            node = node.children[0]
        return node.path if node is not None else path

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
