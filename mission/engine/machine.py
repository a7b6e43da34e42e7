"""The chart as a machine of the library `transitions`. No other module uses the library.

One HierarchicalMachine has the regions and the mission's tree. The library does not decorate its
model with methods, so legs may be called ``add`` or ``_func``. Each edge has a unique trigger, so
the machine decides nothing: guards, order and history are the engine's. An edge exits up to the
common ancestor of the active leg and its target, and enters down from there. This is the library's
own rule, for a group as source and for a leg.

What does not live here: when to fire (engine), what an edge means (Chart, regions).
"""

from __future__ import annotations

from typing import Any

from transitions.extensions.nesting import HierarchicalMachine, NestedState

from mission.model import AUTONOMOUS, IDLE_EMPTY, IMPLICIT_SURFACE, Chart
from mission.model.regions import AGAIN, IDLE, LEG, REGION_EDGES, REGIONS


class _State(NestedState):
    """Records the states left and entered. The library's default separator would break names."""

    separator = "/"

    def enter(self, event_data: Any) -> None:
        event_data.model.entered.append(self.name)

    def exit(self, event_data: Any) -> None:
        event_data.model.exited.append(self.name)


class _Machine(HierarchicalMachine):
    state_cls = _State


class _Configuration:
    """The library's model: it has the active state."""

    __slots__ = ("entered", "exited", "state")

    def __init__(self) -> None:
        self.state = IDLE_EMPTY
        self.exited: list[str] = []
        self.entered: list[str] = []


class NoSuchEdge(LookupError):
    """The engine asked for a transition that the design does not have."""


class Machine:
    """``chart`` None: the regions alone, without a mission."""

    def __init__(self, chart: Chart | None = None) -> None:
        self._at = _Configuration()
        self.active, self.region = IDLE_EMPTY, IDLE
        self.library = _Machine(
            [],
            states=_states(chart),
            initial=IDLE_EMPTY,
            auto_transitions=False,
            send_event=False,
            ignore_invalid_triggers=False,
        )
        self._triggers: set[str] = set()
        self._legs = {s.path for s in chart.states if s.leg} if chart else set()
        for edge in chart.edges if chart else ():
            self._add(edge.trigger, edge.source, edge.target)
        if chart is not None:
            self._add(AGAIN, AUTONOMOUS, IMPLICIT_SURFACE)
        for row in REGION_EDGES:
            if row.target != LEG:
                self._add(f"{row.name}:{row.source}>{row.target}", row.source, row.target)

    def fire(self, trigger: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Take an edge; return the states left and entered, in order. Raises NoSuchEdge."""
        if trigger not in self._triggers:
            raise NoSuchEdge(f"{trigger} from {self.active}")
        self._at.exited, self._at.entered = [], []
        self.library.trigger_event(self._at, trigger)
        self._settle()
        return tuple(self._at.exited), tuple(self._at.entered)

    def move(self, name: str, target: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Move along a row of the region table to its target, or to a leg. Raises NoSuchEdge."""
        for row in REGION_EDGES:
            if row.name == name and self._within(row.source):
                if row.target == target:
                    return self.fire(f"{name}:{row.source}>{target}")
                if row.target == LEG and target in self._legs:
                    trigger = f"{name}:{row.source}>{target}"
                    if trigger not in self._triggers:
                        self._add(trigger, row.source, target)
                    return self.fire(trigger)
        raise NoSuchEdge(f"{name} from {self.active} to {target}")

    def snapshot(self) -> str:
        return self.active

    def restore(self, snapshot: str) -> None:
        self.library.get_state(snapshot)  # raises for an unknown state
        self._at.state = snapshot
        self._settle()

    def _settle(self) -> None:
        self.active = self._at.state
        self.region = self.active.partition("/")[0]

    def _within(self, source: str) -> bool:
        return self.active == source or self.active.startswith(source + "/")

    def _add(self, trigger: str, source: str, target: str) -> None:
        self.library.add_transition(trigger, source, target)
        self._triggers.add(trigger)


def _states(chart: Chart | None) -> list[dict[str, Any]]:
    """The tree in the library's form: every state with its own name and its children."""
    regions: dict[str, dict[str, Any]] = {name: _node(name) for name in REGIONS}
    for region, leaves in REGIONS.items():
        regions[region]["children"] += [_node(leaf.partition("/")[2]) for leaf in leaves]
    places = {AUTONOMOUS: regions[AUTONOMOUS]}
    for state in chart.states if chart else ():
        node = places[state.path] = _node(state.path.rpartition("/")[2])
        places[state.parent]["children"].append(node)
    return list(regions.values())


def _node(name: str) -> dict[str, Any]:
    return {"name": name, "children": []}
