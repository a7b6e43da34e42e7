"""Charts made by hand for the tests of the pictures: no language and no compiler needed."""

from __future__ import annotations

import math

from mission.legs import Goto, Hold, Surface
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    By,
    Chart,
    Comparison,
    Edge,
    Exit,
    Group,
    Guard,
    Handler,
    Leg,
    Loop,
    Mission,
    Position,
    Safety,
    State,
)
from protocol.messages import Setpoint

LOW = Guard(Comparison("battery", "<", 11.0), held=10.0)


def chart(groups: int = 10, legs: int = 3, singles: int = 10, repeat: int = 2) -> Chart:
    """``groups`` repeated groups of ``legs`` with ``singles`` plain legs between them."""
    states: list[State] = []
    edges: list[Edge] = []
    order: list[tuple[Leg, str]] = []
    bodies: list[tuple[str, int]] = []
    singles_left = singles
    for g in range(max(groups, singles)):
        if singles_left:
            singles_left -= 1
            bodies.append((f"transit_{g + 1}", 0))
        if g < groups:
            bodies.append((f"rows_{g + 1}", legs))
    for name, size in bodies:
        if size:
            path = f"{AUTONOMOUS}/{name}"
            states.append(State(path, AUTONOMOUS, group=Group(name, repeat, ())))
            for n in range(size):
                order.append((_leg(f"{['out', 'back', 'turn', 'cross'][n % 4]}{n}", n), path))
                states.append(_state(*order[-1], n))
        else:
            order.append((_leg(name, len(order)), AUTONOMOUS))
            states.append(_state(*order[-1], len(order)))
    final = State(IMPLICIT_SURFACE, AUTONOMOUS, Leg("surface", Surface()), Setpoint())
    states.append(final)
    paths = [f"{parent}/{leg.name}" for leg, parent in order] + [IMPLICIT_SURFACE]
    for i, (leg, parent) in enumerate(order):
        edges += _edges(leg, paths, i, parent, [s.path for s in states])
    edges.append(Edge("end", IMPLICIT_SURFACE, "idle/ready", By.END))
    edges.append(Edge("on/1", AUTONOMOUS, paths[-2], By.ON, LOW))
    mission = Mission(
        "harbour-survey",
        "auv",
        (),
        Position(30.2874595, 120.1535765),
        Safety(1000.0, 2400.0, 30.0, 10.0),
        (("current", 0.2),),
        (Handler(LOW, paths[-2]),),
    )
    return Chart(mission, "0123456789abcdef" * 4, tuple(states), tuple(edges), paths[0])


def _leg(name: str, n: int) -> Leg:
    until = Guard(Comparison("travelled", ">=", 200.0 + n))
    bottom = Guard(Comparison("altitude", "<", 1.5, sure=0.95))
    kind = Goto("home", 15.0) if n % 5 == 4 else Hold()
    exits = (Exit(until), Exit(bottom, "surface")) if n % 3 == 1 else (Exit(until),)
    if n % 4 == 3:
        return Leg(name, kind, duration=15.0)
    return Leg(name, kind, exits=exits, timeout=240.0)


def _state(leg: Leg, parent: str, n: int) -> State:
    heading = None if isinstance(leg.kind, Goto) else math.radians(90 * n % 360)
    setpoint = Setpoint(surge=8 / 12, heading=heading, depth=10.0)
    return State(f"{parent}/{leg.name}", parent, leg, setpoint)


def _edges(leg: Leg, paths: list[str], i: int, parent: str, all_paths: list[str]) -> list[Edge]:
    source, after = paths[i], paths[i + 1]
    last = parent != AUTONOMOUS and not after.startswith(f"{parent}/")
    first = next(p for p in all_paths if p.startswith(f"{parent}/")) if last else ""

    def onward(name: str, by: By, guard: Guard | None) -> list[Edge]:
        if not last:
            return [Edge(f"{source}/{name}", source, after, by, guard)]
        return [
            Edge(f"{source}/{name}/again", source, first, by, guard, (Loop(parent, True),)),
            Edge(f"{source}/{name}/on", source, after, by, guard, (Loop(parent, False),)),
        ]

    edges: list[Edge] = []
    for k, exit_ in enumerate(leg.exits):
        if exit_.target is None:
            edges += onward(f"until{k}", By.UNTIL, exit_.guard)
        else:
            edges.append(
                Edge(f"{source}/until{k}", source, IMPLICIT_SURFACE, By.UNTIL, exit_.guard)
            )
    if leg.duration is not None:
        edges += onward("for", By.FOR, None)
    if leg.timeout is not None:
        edges.append(Edge(f"{source}/timeout", source, IMPLICIT_SURFACE, By.TIMEOUT))
    edges.append(Edge(f"{source}/else", source, IMPLICIT_SURFACE, By.ELSE))
    return edges
