"""Smoothing of the track after the dive, and the distances of the fixes from the estimate.

Rauch, Tung and Striebel (AIAA Journal 3, 1965, 1445-1450) by filterpy, over the horizontal states.
The filter is an extended one. The part of its motion beyond F x is subtracted from the states
before the smoother and added back after it, so that the library's linear pass is exact about the
predicted track. An opened gate counts as process noise of the step before.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mission.model import Position
from mission.model.vehicle import Vehicle
from mission.navigation.filter import Array, Filter, Motion
from mission.navigation.kalman import rts_smoother
from mission.navigation.model import DEPTH, Figures, figures
from mission.navigation.navigator import Navigation
from protocol.messages import Aid, Fix, Telemetry

_PLANE = DEPTH  # the states before it move the position


@dataclass(frozen=True, slots=True)
class FixSeen:
    """A fix: its position, its residual to the estimate (m), and whether it was used."""

    t: float
    north: float
    east: float
    residual: tuple[float, float]
    nis: float
    used: bool


@dataclass(frozen=True, slots=True)
class Track:
    """The track at n instants. Positions are n x 2 (north, east), covariances n x 2 x 2.

    ``raw``: dead reckoning by compass and thrusters from the first fix on, without later fixes.
    ``states``: all smoothed states (mission.navigation.model); ``sigmas``: of these.
    """

    t: Array
    raw: Array
    filtered: Array
    filtered_covariance: Array
    smoothed: Array
    smoothed_covariance: Array
    states: Array
    sigmas: Array
    depth: Array  # NaN where not known
    depth_residual: Array
    fixes: tuple[FixSeen, ...]


@dataclass(slots=True)
class _Node:
    """A posterior, and the step from it to the next node."""

    t: float
    x: Array
    p: Array
    f: Array | None = None
    q: Array | None = None
    prior: Array | None = None  # of the next node


class TapedFilter(Filter):
    """A filter that stores every step for the backward pass."""

    def __init__(self, figures: Figures) -> None:
        super().__init__(figures)
        self.t = 0.0
        self.nodes: list[_Node] = []
        self.begins: list[int] = []  # nodes at which the position was reset
        self.innovations: list[tuple[float, float, float]] = []

    def _piece(self, dt: float, run: Motion) -> None:
        node = self._node()
        super()._piece(dt, run)
        node.f = self.kalman.F[:_PLANE, :_PLANE].copy()
        node.q = self.kalman.Q[:_PLANE, :_PLANE].copy()
        node.prior = self.kalman.x[:_PLANE].copy()
        self.nodes.append(node)
        self.t += dt

    def _node(self) -> _Node:
        return _Node(self.t, self.kalman.x[:_PLANE].copy(), self.kalman.P[:_PLANE, :_PLANE].copy())

    def place(self, north: float, east: float, variance: float) -> None:
        super().place(north, east, variance)
        self.begins.append(len(self.nodes))

    def innovation(self, north: float, east: float, variance: float) -> tuple[float, float, float]:
        found = super().innovation(north, east, variance)
        self.innovations.append(found)
        return found

    def widen(self, factor: float, *, still: bool) -> None:
        before = self.kalman.P
        super().widen(factor, still=still)
        self._account(before)

    def loosen(self, variance: float) -> None:
        before = self.kalman.P
        super().loosen(variance)
        self._account(before)

    def doubt_current(self, sigma: float) -> None:
        """Correlations of the current with other states are lost here: the backward pass stops."""
        super().doubt_current(sigma)
        if self.begins:
            self.begins.append(len(self.nodes))

    def _account(self, before: Array) -> None:
        if self.nodes and (q := self.nodes[-1].q) is not None:
            q += (self.kalman.P - before)[:_PLANE, :_PLANE]

    def finish(self) -> list[_Node]:
        return [*self.nodes, self._node()]


def smooth(
    inputs: Iterable[Telemetry | Fix | Aid],
    vehicle: Vehicle,
    origin: Position | None = None,
    date: str | None = None,
) -> Track:
    """Smooth the inputs, which may come in any order. Raises ValueError if there is no fix."""
    ordered = sorted(inputs, key=lambda item: item.t)
    first = next((i for i in ordered if isinstance(i, Fix)), None)
    if first is None:
        raise ValueError("there is no fix: a track has no place")
    nav, tape = _taped(vehicle, origin, date, ordered[0].t)
    fixes: list[FixSeen] = []
    depths: list[tuple[float, float, float]] = []
    for item in ordered:
        if isinstance(item, Fix):
            fixes += _seen(nav, tape, item)
        elif isinstance(item, Aid):
            nav.aid(item)
        else:
            depths.append(_depth(nav, item))
    nodes = tape.finish()
    begin = tape.begins[0]
    states, covariances = _backward(nodes, tape.begins)
    keep = _last_of_each_time(nodes, begin)
    t = np.array([nodes[i].t for i in keep])
    known = np.array(depths).reshape(-1, 3)
    return Track(
        t=t,
        raw=_raw(ordered, first, vehicle, origin, date, t),
        filtered=np.array([nodes[i].x[:2] for i in keep]),
        filtered_covariance=np.array([nodes[i].p[:2, :2] for i in keep]),
        smoothed=states[keep][:, :2],
        smoothed_covariance=covariances[keep][:, :2, :2],
        states=states[keep],
        sigmas=np.sqrt(np.maximum(np.diagonal(covariances[keep], axis1=1, axis2=2), 0.0)),
        depth=np.interp(t, known[:, 0], known[:, 1]) if len(known) else np.full(len(t), np.nan),
        depth_residual=known[:, [0, 2]],
        fixes=tuple(fixes),
    )


def _taped(
    vehicle: Vehicle, origin: Position | None, date: str | None, begin: float
) -> tuple[Navigation, TapedFilter]:
    nav = Navigation(vehicle, origin, date=date)
    tape = TapedFilter(figures(vehicle))
    tape.t = begin
    nav.core.filter = tape
    return nav, tape


def _seen(nav: Navigation, tape: TapedFilter, fix: Fix) -> list[FixSeen]:
    tape.innovations.clear()
    nav.fix(fix)
    assert nav.frame is not None
    north, east = nav.frame.to_local(fix.latitude, fix.longitude)
    if not tape.innovations:
        return []
    dn, de, nis = tape.innovations[0]
    return [FixSeen(fix.t, north, east, (dn, de), nis, nav.core.last_fix == fix.t)]


def _depth(nav: Navigation, report: Telemetry) -> tuple[float, float, float]:
    """Return the time, the reported depth, and its difference from the estimate."""
    nav.telemetry(report)
    known = float(nav.core.filter.x[DEPTH])
    said = np.nan if report.depth is None else report.depth
    return report.t, said, said - known


def _backward(nodes: Sequence[_Node], begins: Sequence[int]) -> tuple[Array, Array]:
    """Smooth the states and covariances of all nodes, separately between any two resets."""
    states = np.array([n.x for n in nodes])
    covariances = np.array([n.p for n in nodes])
    edges = [*begins, len(nodes)]
    for a, b in itertools.pairwise(edges):
        if b - a < 2:
            continue
        offset = np.zeros((b - a, _PLANE))
        for k, node in enumerate(nodes[a : b - 1]):
            assert node.f is not None
            assert node.prior is not None
            offset[k + 1] = node.f @ offset[k] + node.prior - node.f @ node.x
        fs = [n.f for n in nodes[a : b - 1]]
        qs = [n.q for n in nodes[a : b - 1]]
        xs, ps, _, _ = rts_smoother(states[a:b] - offset, covariances[a:b], fs, qs)
        states[a:b], covariances[a:b] = xs + offset, ps
    return states, covariances


def _last_of_each_time(nodes: Sequence[_Node], begin: int) -> list[int]:
    times = [n.t for n in nodes[begin:]] + [np.inf]
    return [begin + i for i in range(len(times) - 1) if times[i + 1] > times[i]]


def _raw(
    ordered: Sequence[Telemetry | Fix | Aid],
    first: Fix,
    vehicle: Vehicle,
    origin: Position | None,
    date: str | None,
    at: Array,
) -> Array:
    """Dead reckoning by compass and thrusters; the first fix has no speed, so it teaches
    nothing."""
    nav = Navigation(vehicle, origin, date=date)
    times, places = [], []
    for item in ordered:
        if isinstance(item, Telemetry):
            nav.telemetry(item)
        elif item is first:
            nav.fix(replace(item, speed=None, course=None))
        estimate = nav.estimate(item.t)
        if estimate is not None:
            times.append(item.t)
            places.append((estimate.north, estimate.east))
    found = np.array(places)
    return np.column_stack([np.interp(at, times, found[:, i]) for i in range(2)])
