"""Resolve names to ways: the place of each node of a mission, and the legs that follow it.

    names -> places -> ways (next leg, targets, rounds)

A name without a place, or with several, is a problem of the line that uses it.

What does not live here: the edges that are made of ways (compiler), the values of each leg (axes).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from dataclasses import dataclass

from mission.authoring.compiler.axes import Unit, joined, unit_of
from mission.authoring.compiler.parts import parted
from mission.authoring.compiler.refusing import refused
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    SURFACE,
    Group,
    Leg,
    Loop,
    Mission,
    Node,
    Set,
    State,
    Where,
    legs_of,
)
from mission.model.diagnostics import Diagnostic
from mission.model.extent import DEEPEST_GROUP


@dataclass(frozen=True, slots=True)
class _Slot:
    """A place in the mission's order: ``index`` may be one beyond the group's last node."""

    group: str
    index: int


@dataclass(frozen=True, slots=True)
class Way:
    """A way to a leg, through the bare lines before it, whose joined effect is ``unit``; ``loops``:
    the rounds that the way begins or ends."""

    loops: tuple[Loop, ...]
    target: str
    unit: Unit


class Ways:
    """The ways of a mission; ``states``, ``legs`` by path and ``lines`` (legs, bare lines) are in
    the order of the text."""

    def __init__(self, mission: Mission) -> None:
        self.problems: list[Diagnostic] = []
        self.states: list[State] = []
        self.legs: dict[str, Leg] = {}
        self.lines: list[Leg | Set] = []
        self._bodies: dict[str, tuple[Node, ...]] = {AUTONOMOUS: parted(mission.body)}
        self._repeat: dict[str, int] = {AUTONOMOUS: 1}
        self._slots: dict[str, _Slot] = {}  # path -> its place
        self._named: dict[str, list[str]] = {}  # name -> paths
        self._children: dict[tuple[str, str], str] = {}
        self._found: dict[_Slot, tuple[Way, ...]] = {}
        self._index()

    @property
    def start(self) -> Way:
        return self._from(_Slot(AUTONOMOUS, 0))[0]

    def after(self, path: str) -> tuple[Way, ...]:
        """The ways to what follows in the order of the text."""
        slot = self._slots[path]
        return self._from(_Slot(slot.group, slot.index + 1))

    def group_of(self, path: str) -> str:
        return self._slots[path].group

    # --- names and places ----------------------------------------------------------------

    def _index(self) -> None:
        stack = [(AUTONOMOUS, i, node) for i, node in enumerate(self._bodies[AUTONOMOUS])][::-1]
        while stack:
            parent, i, node = stack.pop()
            path = f"{parent}/{node.name}"
            if not self._take(parent, path, i, node):
                continue
            if isinstance(node, Group):
                self.states.append(State(path, parent, group=node))
                self._bodies[path], self._repeat[path] = node.body, node.repeat
                self._check_group(path, node)
                if path.count("/") <= DEEPEST_GROUP.most:
                    stack += [(path, j, child) for j, child in enumerate(node.body)][::-1]
            else:
                self.lines.append(node)
                if isinstance(node, Leg):
                    self.states.append(State(path, parent, leg=node))
                    self.legs[path] = node

    def _take(self, parent: str, path: str, index: int, node: Node) -> bool:
        if node.name == SURFACE or "/" in node.name or not node.name:
            self._refuse(
                "name-reserved",
                node.where,
                f"{node.name!r} cannot be a name here",
                f"{SURFACE} is the leg at every mission's end; choose another name",
            )
            return False
        if path in self._slots:
            self._refuse(
                "name-twice",
                node.where,
                f"{node.name} appears twice in the same group",
                "choose another name",
            )
            return False
        self._slots[path] = _Slot(parent, index)
        self._children[parent, node.name] = path
        self._named.setdefault(node.name, []).append(path)
        return True

    def _check_group(self, path: str, group: Group) -> None:
        if group.repeat < 1:
            self._refuse("repeat", group.where, "a group has at least one round")
        elif group.repeat > 1 and not any(legs_of(group.body)):
            self._refuse(
                "loop-without-wait",
                group.where,
                f"{group.name} repeats without a leg that takes time",
                "add a wait or another leg",
            )
        if path.count("/") > DEEPEST_GROUP.most:
            self._refuse(
                "too-deep-nesting",
                group.where,
                f"groups stand inside each other more than {DEEPEST_GROUP.most} deep",
                "flatten them",
            )

    def to(self, scope: str, name: str, where: Where) -> tuple[Way, ...]:
        """The ways to a target. Its name is looked up from the innermost group outward; if it is
        not found there, anywhere, where it must be unique."""
        if name == SURFACE:
            return (Way((), IMPLICIT_SURFACE, joined(())),)
        first, *rest = name.split("/")
        found = self._lookup(scope, first)
        for part in rest:
            found = self._children.get((found or "", part))
        if found is None:
            self._unknown_target(name, where)
            return ()
        if found in self._bodies:
            return self._from(_Slot(found, 0))
        return self._from(self._slots[found])

    def _lookup(self, scope: str, name: str) -> str | None:
        while True:
            found = self._children.get((scope, name))
            if found is not None or scope == AUTONOMOUS:
                break
            scope = self._slots[scope].group
        if found is None and len(self._named.get(name, ())) == 1:
            found = self._named[name][0]
        return found

    def _unknown_target(self, name: str, where: Where) -> None:
        several = self._named.get(name, [])
        if len(several) > 1:
            places = ", ".join(p.partition("/")[2] for p in several)
            self._refuse(
                "ambiguous-target",
                where,
                f"{name} could be any of {places}",
                "write its path",
            )
            return
        near = difflib.get_close_matches(name, [*self._named, SURFACE], n=3)
        hint = f"did you mean {', '.join(near)}?" if near else f"{SURFACE} is always there"
        self._refuse("unknown-target", where, f"there is no leg {name!r}", hint)

    # --- ways ------------------------------------------------------------------------------

    def _from(self, slot: _Slot) -> tuple[Way, ...]:
        known = self._found.get(slot)
        if known is None:
            known = self._found[slot] = tuple(self._find_ways(slot))
        return known

    def _find_ways(self, slot: _Slot) -> Iterator[Way]:
        group, index = slot.group, slot.index
        loops: tuple[Loop, ...] = ()
        units: list[Unit] = []
        while True:
            target = self._first_leg(group, index, units)
            if target is not None:
                yield Way(loops, target, joined(units))
                return
            if group == AUTONOMOUS:
                yield Way(loops, IMPLICIT_SURFACE, joined(units))
                return
            if self._repeat[group] > 1:
                again = list(units)
                target = self._first_leg(group, 0, again)
                if target is not None:
                    yield Way((*loops, Loop(group, True)), target, joined(again))
                loops = (*loops, Loop(group, False))
            group, index = self._slots[group].group, self._slots[group].index + 1

    def _first_leg(self, group: str, index: int, units: list[Unit]) -> str | None:
        """The first leg from ``index`` to the end of the group; append the effects of the bare
        lines before it to ``units``."""
        body = self._bodies[group]
        for i in range(index, len(body)):  # no slice: that would be quadratic over a long mission
            node = body[i]
            path = f"{group}/{node.name}"
            if isinstance(node, Leg):
                return path
            if isinstance(node, Set):
                units.append(unit_of(node))
            elif path in self._bodies and (inner := self._first_leg(path, 0, units)):
                return inner
        return None

    def _refuse(self, code: str, where: Where, message: str, hint: str = "") -> None:
        self.problems.append(refused(code, where, message, hint))
