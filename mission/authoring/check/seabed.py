"""The shallowest and deepest sea floor under each leg, from a file of depths.

A leg sweeps the hull of its intended positions, widened by its error (fenced.py). Every cell of the
file that this area touches counts. Where the file has no depth, the assumed floor counts.

    grounding   a leg that may be deeper than the shallowest floor below it; a leg that keeps an
                altitude, if the floor leaves no depth to hold
    floor       a floor deeper than the one that the mission assumes

What does not live here: the formats (authoring.bathymetry), the simulated sea (links).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mission.authoring.bathymetry import Depths
from mission.authoring.bathymetry.grid import Numbers
from mission.authoring.check.fenced import Swept
from mission.legs.pattern import Point
from mission.model import AUTONOMOUS, Chart, Position
from mission.model.diagnostics import Diagnostic, Stage
from mission.model.units import number_text
from mission.navigation.geodesy import LocalFrame
from mission.navigation.polygons import edges, hull, signed_area

_STEP = 1e-6  # rad, step for the scale of the local plane
_WHOLE = 0.995  # known share that counts as all, since the edge cuts cells


@dataclass(frozen=True, slots=True)
class Over:
    """All that one leg sweeps, over all its entries. ``blind``: its greatest depth in m if the
    sensor of a hold fails. ``holds_depth``: it goes down without regard to the floor."""

    swept: Swept
    blind: float
    holds_depth: bool
    least: float = 0.0  # m of water that it needs, if it keeps an altitude

    def joined(self, other: Over) -> Over:
        one, two = self.swept, other.swept
        depth = (min(one.depth[0], two.depth[0]), max(one.depth[1], two.depth[1]))
        body = hull((*one.body, *two.body))
        swept = Swept(body, max(one.margin, two.margin), depth)
        return Over(swept, max(self.blind, other.blind), self.holds_depth, self.least)


@dataclass(frozen=True, slots=True)
class Ground:
    """The sea floor under one leg, m; None if the file has no depth there. ``place``: where it is
    shallowest. ``known``: the share of the area for which the file has depths."""

    leg: str
    shallowest: float | None
    deepest: float | None
    place: Position | None
    known: float

    @property
    def at(self) -> str:
        place = self.place
        return "" if place is None else f"{place.latitude_deg:.6f} {place.longitude_deg:.6f}"


def grounds(over: Mapping[str, Over], depths: Depths, home: Position) -> dict[str, Ground]:
    frame = LocalFrame(home)
    return {
        path: _under(path.removeprefix(f"{AUTONOMOUS}/"), one.swept, depths, frame)
        for path, one in over.items()
    }


def _under(path: str, swept: Swept, depths: Depths, frame: LocalFrame) -> Ground:
    box = _box(swept, depths, frame)
    lat, lon = depths.middles(box)
    low, high = depths.shallow[box], depths.deep[box]
    if not low.size:
        return Ground(path, None, None, None, 0.0)
    (north, east), (high_m, wide_m) = _plane(frame, float(lat[0]), float(lon[0]))
    n = north + (lat - lat[0])[:, None] * high_m
    e = east + (lon - lon[0])[None, :] * wide_m
    half = math.hypot(depths.step[0] * high_m, depths.step[1] * wide_m) / 2.0
    touched = _distance(swept.body, n, e) <= swept.margin + half
    cells, known = int(touched.sum()), touched & np.isfinite(low)
    if not known.any():
        return Ground(path, None, None, None, 0.0)
    row, column = np.unravel_index(int(np.where(known, low, np.inf).argmin()), low.shape)
    place = Position(float(lat[row]), float(lon[column]))
    share = float(known.sum()) / max(cells, _cells_of(swept, half))
    return Ground(path, float(low[row, column]), float(high[known].max()), place, min(share, 1.0))


def _box(swept: Swept, depths: Depths, frame: LocalFrame) -> tuple[slice, slice]:
    """The rows and columns of the file that contain the swept body with its margin."""
    norths, easts = zip(*swept.body, strict=True)
    corners = [
        frame.to_geodetic(n + i * swept.margin, e + j * swept.margin)
        for n in (min(norths), max(norths))
        for e in (min(easts), max(easts))
        for i in (-1.0, 1.0)
        for j in (-1.0, 1.0)
    ]
    lats = [math.degrees(lat) for lat, _ in corners]
    first = math.degrees(corners[0][1])  # the reference, since the antimeridian may be near
    lons = [first + math.remainder(math.degrees(lon) - first, 360.0) for _, lon in corners]
    return depths.box(min(lats), max(lats), min(lons), max(lons))


def _cells_of(swept: Swept, half: float) -> int:
    """The least number of cells that the swept area covers, in the file or not."""
    area = abs(signed_area(swept.body))
    around = sum(math.dist(a, b) for a, b in edges(swept.body)) * swept.margin
    return int((area + around + math.pi * swept.margin**2) / max(2.0 * half * half, 1e-9))


def _plane(frame: LocalFrame, latitude: float, longitude: float) -> tuple[Point, Point]:
    """A place given in degrees, in m from home; and the m of one degree there, north and east."""
    lat, lon = math.radians(latitude), math.radians(longitude)
    here = frame.to_local(lat, lon)
    up, aside = frame.to_local(lat + _STEP, lon), frame.to_local(lat, lon + _STEP)
    scale = math.radians(1.0) / _STEP
    return here, ((up[0] - here[0]) * scale, (aside[1] - here[1]) * scale)


def _distance(body: tuple[Point, ...], north: Numbers, east: Numbers) -> Numbers:
    """The distance in m of each cell from a hull (or point, or line); 0 within."""
    nearest = np.full(np.broadcast_shapes(north.shape, east.shape), np.inf)
    within = np.full(nearest.shape, len(body) > 2)
    turn = math.copysign(1.0, signed_area(body))
    for a, b in edges(body):
        dn, de = b[0] - a[0], b[1] - a[1]
        length = dn * dn + de * de
        share = ((north - a[0]) * dn + (east - a[1]) * de) / length if length else 0.0 * nearest
        share = np.clip(share, 0.0, 1.0)
        off = np.hypot(north - a[0] - share * dn, east - a[1] - share * de)
        nearest = np.minimum(nearest, off)
        within &= turn * (dn * (east - a[1]) - de * (north - a[0])) >= 0.0
    return np.where(within, 0.0, nearest)


# --- refusals and report ----------------------------------------------------------------------


def refusals(
    found: Mapping[str, Ground], over: Mapping[str, Over], chart: Chart
) -> Iterator[Diagnostic]:
    """The refusals; the same one for several legs stands once, at the first leg and its place."""
    said: dict[tuple[str, str, str], list[str]] = {}
    for path in found:
        for one in _refused(path, found[path], over[path], chart):
            said.setdefault(one, []).append(path)
    for (code, message, hint), paths in said.items():
        legs = ", ".join(found[path].leg for path in paths)
        leg = chart.state(paths[0]).leg
        assert leg is not None
        yield Diagnostic(
            Stage.CHECK, code, leg.where, message.format(legs=legs, at=found[paths[0]].at), hint
        )


def _refused(path: str, ground: Ground, over: Over, chart: Chart) -> Iterator[tuple[str, str, str]]:
    """For one leg: code, message (with fields for the legs and the place), hint."""
    if ground.shallowest is None or ground.deepest is None or chart.state(path).leg is None:
        return
    assumed, deep = dict(chart.mission.assume).get("floor"), over.swept.depth[1]
    wet, off = ground.shallowest > 0.0, "lead it farther off"
    what = f"a sea floor at {ground.shallowest:.1f} m ({{at}})" if wet else "land ({at})"
    if over.holds_depth and deep > ground.shallowest:
        instead = "stay shallower or farther off, keep an altitude" if wet else off
        message = f"{{legs}} may be {deep:.1f} m deep over {what}"
        yield "grounding", message, f"{instead}, or take fixes on the way"
    elif over.least and over.least > ground.shallowest:
        instead = off + ", keep less altitude" * wet
        message = f"{{legs}} may be over {what}: kept above the floor, no depth is left to hold"
        yield "grounding", message, f"{instead}, or take fixes on the way"
    if assumed is not None and ground.deepest > assumed:
        yield (
            "floor",
            f"under {{legs}} the sea floor is down to {ground.deepest:.1f} m; the "
            f"mission assumes none deeper than {number_text(assumed)} m",
            f"write assume floor {math.ceil(ground.deepest)}",
        )


def blind(found: Mapping[str, Ground], over: Mapping[str, Over]) -> float:
    """Greatest depth in m if the sensor of a hold fails; not below the floor where the file has all
    depths under the leg."""
    return max((_above(found[path], one.blind) for path, one in over.items()), default=0.0)


def _above(ground: Ground, deep: float) -> float:
    whole = ground.deepest is not None and ground.known >= _WHOLE
    return min(deep, ground.deepest) if whole and ground.deepest is not None else deep


def told(ground: Ground) -> str:
    """The sea floor as text for people."""
    if ground.shallowest is None or ground.deepest is None:
        return "not known: the floor that is assumed"
    part = f", {1.0 - ground.known:.0%} of it not known" if ground.known < _WHOLE else ""
    return f"{ground.shallowest:.1f} to {ground.deepest:.1f} m, shallowest at {ground.at}{part}"
