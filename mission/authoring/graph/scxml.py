"""The chart as SCXML that another engine can run (W3C SCXML 1.0, ecmascript datamodel).

- A guard is an event. ``events(chart)`` has the event of each trigger of the chart
  ("rows.turn.until1": the first ``until`` of that leg has become true).
- Edges that differ only by the rounds of repeated groups share one event. The engine that runs the
  file selects among them by the counters ``round1`` .. ``roundN`` of the datamodel. They count as
  Edge's docstring describes, in expressions that mean the same in ECMAScript and in Python.
- ``event_of`` names the events that all missions share (load, clear, start, stick, X, W, limit,
  ...). ``start`` begins with the first leg; ``resume`` leads from manual back into the interrupted
  leg, by a deep history.
- A handler (``on``) leaves the active leg up to the innermost group that also contains the target.
  So it stands once in each group between its own and the target's, and the innermost active one
  acts. Its target leg and the implicit leg ignore its event. The second time it leads to the
  implicit leg: ``acted1`` .. ``actedN`` record the first time.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from mission.authoring.graph import words
from mission.authoring.graph.canvas import element
from mission.authoring.graph.regions import REGIONS, SUBSTATES, region
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, By, Chart, Edge, Loop, State
from mission.model.regions import LEG, MANUAL, REGION_EDGES, RegionEdge

HISTORY = "autonomous.history"
RESUME = "resume"


def events(chart: Chart) -> Mapping[str, str]:
    """The event of each trigger, unique per guard (or timer) of a source."""
    names: dict[str, str] = {}
    counts: dict[str, int] = {}
    previous: Edge | None = None
    for edge in chart.edges:
        same = previous is not None and bool(edge.loops) and _alike(previous, edge)
        if previous is not None and same:
            names[edge.trigger] = names[previous.trigger]
        else:
            stem = f"{identifier(edge.source).removeprefix(AUTONOMOUS + '.')}.{edge.by.value}"
            counts[stem] = counts.get(stem, 0) + 1
            names[edge.trigger] = f"{stem}{counts[stem]}"
        previous = edge
    return names


def event_of(row: RegionEdge) -> str:
    """The event of a row of the region table; with the target if a name has several."""
    several = {r.target for r in REGION_EDGES if (r.name, r.source) == (row.name, row.source)}
    name = row.name.replace(" ", "_")
    return name if len(several) == 1 else f"{name}.{row.target.rpartition('/')[2]}"


def _alike(one: Edge, other: Edge) -> bool:
    """Whether two edges are of the same exit. Exits of a leg with equal guards differ by their
    places in the text."""
    return all(getattr(one, n) == getattr(other, n) for n in ("source", "by", "guard", "where"))


def identifier(path: str) -> str:
    """The path as XML name; characters other than letters, digits and ``_`` become their codes."""
    return re.sub(r"[^A-Za-z0-9_.]", lambda m: f"-{ord(m[0]):x}-", path.replace("/", "."))


def scxml(chart: Chart) -> str:
    return _Writer(chart).document()


class _Writer:
    def __init__(self, chart: Chart) -> None:
        self.chart = chart
        self.events = events(chart)
        groups = [state.path for state in chart.states if state.group is not None]
        handled = [e for e in chart.edges if e.by in (By.ON, By.UNCERTAIN)]
        named = dict.fromkeys(self.events[e.trigger] for e in handled)
        self.acted = {event: f"acted{i}" for i, event in enumerate(named, 1)}
        self.rounds = {path: f"round{i}" for i, path in enumerate(groups, 1)}
        self.repeats = {s.path: s.group.repeat for s in chart.states if s.group is not None}
        self.children: dict[str, list[State]] = {}
        for state in chart.states:
            if state.path != AUTONOMOUS:
                self.children.setdefault(state.parent, []).append(state)
        self.legs = {s.path: s.leg for s in chart.states}

    def document(self) -> str:
        mission = self.chart.mission
        data = "".join(element("data", id=name, expr="1") for name in self.rounds.values())
        data += "".join(element("data", id=name, expr="0") for name in self.acted.values())
        body = [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f"<!-- mission {_comment(mission.name)}, digest {self.chart.digest} -->",
            '<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" '
            'datamodel="ecmascript" initial="idle.ready">',
            f"  <datamodel>{data}</datamodel>" if data else "",
        ]
        for name in REGIONS:
            body += self._autonomous() if name == AUTONOMOUS else self._region(name)
        return "\n".join(line for line in [*body, "</scxml>", ""] if line or line == "")

    def _region(self, name: str) -> list[str]:
        states = [path for path in SUBSTATES if region(path) == name]
        body = [f'  <state id="{name}" initial="{identifier(states[0])}">']
        body += [self._shared(row, 4) for row in REGION_EDGES if row.source == name]
        for path in states:
            body.append(f'    <state id="{identifier(path)}">')
            body += [self._shared(row, 6) for row in REGION_EDGES if row.source == path]
            body.append("    </state>")
        return [*body, "  </state>"]

    def _shared(self, row: RegionEdge, pad: int) -> str:
        event, space = event_of(row), " " * pad
        if row.target != LEG:
            return space + element("transition", event=event, target=identifier(row.target))
        content = self._entering(AUTONOMOUS, self.chart.initial)
        content += "".join(element("assign", location=n, expr="0") for n in self.acted.values())
        target = identifier(self.chart.initial)
        start = space + element("transition", content, event=event, target=target)
        if region(row.source) != MANUAL:
            return start
        resume = element("transition", event=RESUME, target=HISTORY)
        return f"{start}\n{space}{resume}"

    def _autonomous(self) -> list[str]:
        initial = identifier(self.chart.initial)
        body = [f'  <state id="{AUTONOMOUS}" initial="{initial}">']
        body.append(
            f'    <history id="{HISTORY}" type="deep"><transition target="{initial}"/></history>'
        )
        body += [self._shared(row, 4) for row in REGION_EDGES if row.source == AUTONOMOUS]
        body += self._handlers(AUTONOMOUS, 4)
        for child in self.children.get(AUTONOMOUS, []):
            body += self._state(child, 4)
        return [*body, "  </state>"]

    def _state(self, state: State, pad: int) -> list[str]:
        space = " " * pad
        inner = self.children.get(state.path, [])
        if inner:
            body = [
                f'{space}<state id="{identifier(state.path)}" '
                f'initial="{identifier(self._first(state.path))}">'
            ]
            body += self._handlers(state.path, pad + 2)
            for child in inner:
                body += self._state(child, pad + 2)
            return [*body, f"{space}</state>"]
        body = [f'{space}<state id="{identifier(state.path)}">']
        body += [
            self._edge(edge, pad + 2) for edge in self.chart.edges if edge.source == state.path
        ]
        body += [
            f"{space}  {element('transition', event=self.events[edge.trigger])}"
            for edge in self._above(state.path)
            if state.path in (edge.target, IMPLICIT_SURFACE)
        ]
        return [*body, f"{space}</state>"]

    def _first(self, path: str) -> str:
        while inner := self.children.get(path):
            path = inner[0].path
        return path

    def _above(self, leg: str) -> list[Edge]:
        """The edges of the groups around a leg: their handlers."""
        return [e for e in self.chart.edges if leg.startswith(f"{e.source}/")]

    def _handlers(self, path: str, pad: int) -> list[str]:
        """The handlers of the group, and those of outer groups whose target is in this group."""
        rows: list[str] = []
        for edge in self.chart.edges:
            holds = edge.target.startswith(f"{path}/") and path.startswith(f"{edge.source}/")
            if edge.source == path or holds:
                rows += [self._again(edge, pad), self._edge(edge, pad, inside=path)]
        return rows

    def _again(self, edge: Edge, pad: int) -> str:
        """The transition for the second time of a handler; it is tested before the first one's."""
        event = self.events[edge.trigger]
        target, cond = identifier(IMPLICIT_SURFACE), f"{self.acted[event]} > 0"
        return " " * pad + element("transition", event=event, cond=cond, target=target)

    def _edge(self, edge: Edge, pad: int, inside: str | None = None) -> str:
        """The transition of an edge. ``inside``: the group of a handler; the transition does not
        leave this group if the target is in it."""
        event = self.events[edge.trigger]
        attributes: dict[str, object] = {"event": event}
        if edge.loops:
            attributes["cond"] = " && ".join(self._condition(loop) for loop in edge.loops)
        attributes["target"] = identifier(edge.target)
        held = inside is not None and edge.target.startswith(f"{inside}/")
        if held:
            attributes["type"] = "internal"
        top = inside if inside is not None else edge.source.rpartition("/")[0]
        content = self._entering(_common(top, edge.target), edge.target)
        content += "".join(self._count(loop) for loop in edge.loops)
        if inside is not None:
            content += element("assign", location=self.acted[event], expr="1")
        note = _comment(words.edge(edge, self.legs.get(edge.source)))
        return f"{' ' * pad}<!-- {note} -->{element('transition', content, **attributes)}"

    def _condition(self, loop: Loop) -> str:
        sign = "<" if loop.again else ">="
        return f"{self.rounds[loop.group]} {sign} {self.repeats[loop.group]}"

    def _count(self, loop: Loop) -> str:
        name = self.rounds[loop.group]
        return element("assign", location=name, expr=f"{name} + 1" if loop.again else "1")

    def _entering(self, above: str, target: str) -> str:
        """Start the rounds at 1 of the groups that are entered between ``above`` and the target."""
        parts = target.split("/")
        entered = ["/".join(parts[:n]) for n in range(above.count("/") + 2, len(parts))]
        return "".join(element("assign", location=self.rounds[path], expr="1") for path in entered)


def _common(one: str, other: str) -> str:
    """The innermost state that contains both (``one`` itself counts)."""
    while not other.startswith(f"{one}/"):
        one = one.rpartition("/")[0]
        if not one:
            return other.split("/")[0]
    return one


def _comment(text: str) -> str:
    return text.replace("--", "- -")
