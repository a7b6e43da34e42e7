"""Polygons in a local plane, m: what is inside, how near the edge is, and what is no polygon.

    inside     even-odd; a point on the edge counts as inside
    sigmas     the least Mahalanobis distance from a position to the edge; at PLANE_95 or less its
               95 % ellipse touches the edge
    hull, gap  the convex hull of points, and its distance from a polygon

What does not live here: what an area is for (mission.model), what a breach leads to (engine).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence

from mission.navigation.distribution import Covariance

Point = tuple[float, float]  # m north and east
Polygon = Sequence[Point]

SMALLEST = 1.0  # m^2: a smaller area is a mistake
_SHORTEST = 0.01  # m between two corners
_FINE = 1e-9


def edges(polygon: Polygon) -> Iterator[tuple[Point, Point]]:
    return zip(polygon, (*polygon[1:], polygon[0]), strict=True)


def signed_area(polygon: Polygon) -> float:
    """m^2; positive where the corners go clockwise, as a compass does."""
    return 0.5 * sum(a[0] * b[1] - b[0] * a[1] for a, b in edges(polygon))


def fault(polygon: Polygon) -> str:
    """Return why these corners are no polygon; "" if they are one, in either direction."""
    if len(polygon) < 3:
        return "an area has at least three corners"
    for number, (a, b) in enumerate(edges(polygon), 1):
        if math.dist(a, b) < _SHORTEST:
            return f"corners {number} and {number % len(polygon) + 1} are the same place"
    crossed = _crossing(polygon)
    if crossed:
        return f"its edges cross: those from corners {crossed[0]} and {crossed[1]}"
    if abs(signed_area(polygon)) < SMALLEST:
        return f"it has {abs(signed_area(polygon)):.2g} m2: less than {SMALLEST:g}"
    return ""


def _crossing(polygon: Polygon) -> tuple[int, int] | None:
    """The first two edges (counted from 1) that meet elsewhere than at a shared corner."""
    sides = list(edges(polygon))
    for (i, one), (j, other) in itertools.combinations(enumerate(sides), 2):
        if j == i + 1 or (i == 0 and j == len(sides) - 1):
            shared, free = (one, other[1]) if j == i + 1 else (other, one[1])
            meets = (
                to_segment(free, *shared) < _FINE
                or to_segment(shared[0], *(other if j == i + 1 else one)) < _FINE
            )
        else:
            meets = between(one, other) < _FINE
        if meets:
            return i + 1, j + 1
    return None


def inside(polygon: Polygon, point: Point) -> bool:
    """Whether a point is inside or on the edge."""
    north, east = point
    odd = False
    for (an, ae), (bn, be) in edges(polygon):
        if (ae > east) != (be > east) and north < an + (east - ae) * (bn - an) / (be - ae):
            odd = not odd
    return odd or to_edge(polygon, point) < _FINE


def to_segment(point: Point, a: Point, b: Point) -> float:
    """Distance in m from a point to a segment."""
    dn, de = b[0] - a[0], b[1] - a[1]
    length = dn * dn + de * de
    share = ((point[0] - a[0]) * dn + (point[1] - a[1]) * de) / length if length > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.hypot(point[0] - a[0] - share * dn, point[1] - a[1] - share * de)


def to_edge(polygon: Polygon, point: Point) -> float:
    """Distance in m from a point, inside or outside, to the edge."""
    return min(to_segment(point, a, b) for a, b in edges(polygon))


def sigmas(polygon: Polygon, point: Point, covariance: Covariance) -> float:
    """Distance of the edge in sigmas of an uncertain position. Of a certain one: inf, or 0 on the
    edge."""
    nn, ne, ee = covariance
    spread = math.sqrt(max(nn, 0.0))
    across = math.sqrt(max(ee - (ne / spread) ** 2, 0.0)) if spread > 0.0 else math.sqrt(ee)
    if spread <= _FINE or across <= _FINE:
        far = to_edge(polygon, point)
        most = math.sqrt(max(nn, ee, 0.0))
        return far / most if most > _FINE else (math.inf if far > 0.0 else 0.0)

    def white(corner: Point) -> Point:
        """The corner in whitened coordinates (Cholesky factor of the covariance): there the ellipse
        is a circle with a sigma of 1."""
        north = (corner[0] - point[0]) / spread
        return north, (corner[1] - point[1] - ne / spread * north) / across

    return to_edge([white(corner) for corner in polygon], (0.0, 0.0))


def between(one: tuple[Point, Point], other: tuple[Point, Point]) -> float:
    """Distance in m between two segments; 0 where they cross."""
    (a, b), (c, d) = one, other
    if _turn(a, b, c) * _turn(a, b, d) < 0.0 and _turn(c, d, a) * _turn(c, d, b) < 0.0:
        return 0.0
    ends = ((a, c, d), (b, c, d), (c, a, b), (d, a, b))
    return min(to_segment(*each) for each in ends)


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def hull(points: Iterable[Point]) -> tuple[Point, ...]:
    """The convex hull, in one direction (Andrew 1979); two points or one if all are in line."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return tuple(ordered)
    low, high = _chain(ordered), _chain(ordered[::-1])
    return tuple(low[:-1] + high[:-1])


def _chain(ordered: Sequence[Point]) -> list[Point]:
    chain: list[Point] = []
    for point in ordered:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0.0:
            chain.pop()
        chain.append(point)
    return chain


def gap(body: Polygon, polygon: Polygon) -> float:
    """Distance in m between the edges of a hull (or point, or line) and a polygon; 0: they meet."""
    sides = list(edges(body)) if len(body) > 1 else [(body[0], body[0])]
    return min(between(side, edge) for side in sides for edge in edges(polygon))
