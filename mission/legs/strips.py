"""Divides a polygon into strips: its rows, the parts of each that are inside, and their order.

    strips    as many as are needed for the spacing that is asked for, all equally wide
    pieces    the parts of a strip's middle line that are inside; several if the polygon is concave
    cells     pieces that follow each other from strip to strip without a fork; each cell is flown
              up and down, then the one that begins nearest

All in a frame: m along the rows, and m across them. Source of the cells: H. Choset, Coverage of
known spaces: the boustrophedon cellular decomposition, Autonomous Robots 9 (2000).
What does not live here: whether it is a polygon (mission.navigation.polygons).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from mission.legs.pattern import Point, Span

Piece = tuple[Point, Point]  # from its lesser to its greater end
_SHORTEST = 1.0  # m: a shorter piece is no row
_ALIKE = 1e-3  # share by which widths may differ and still count as equal


def edges(outline: Sequence[Point]) -> Iterator[Piece]:
    return zip(outline, (*outline[1:], outline[0]), strict=True)


def narrowest(outline: Sequence[Point]) -> float:
    """The direction, rad, of the (first) edge across which the polygon is narrowest."""
    best, least = 0.0, math.inf
    for a, b in edges(outline):
        bearing = math.atan2(b[1] - a[1], b[0] - a[0])
        low, high = _extent(across(outline, bearing))
        if high - low < least * (1.0 - _ALIKE):
            best, least = bearing, high - low
    return best % math.tau


def across(outline: Sequence[Point], bearing: float) -> list[float]:
    """The distance of each corner to starboard of a bearing, m."""
    c, s = math.cos(bearing), math.sin(bearing)
    return [east * c - north * s for north, east in outline]


def _extent(values: Sequence[float]) -> Span:
    return min(values), max(values)


def strips(width: float, spacing: float) -> int:
    """How many strips leave none wider than ``spacing``; a share ``_ALIKE`` more is allowed, since
    no position is known so well."""
    return max(1, math.ceil(width / spacing * (1.0 - _ALIKE)))


def pieces(outline: Sequence[Point], low: float, wide: float, count: int) -> list[list[Piece]]:
    """The pieces of each strip. Strips are ``wide`` m wide, the first begins at ``low`` m;
    ``outline`` is in the frame."""
    found = []
    for strip in range(count):
        middle = low + (strip + 0.5) * wide
        ends = sorted(
            a[0] + (middle - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
            for a, b in edges(outline)
            if (a[1] > middle) != (b[1] > middle)
        )
        pairs = zip(ends[::2], ends[1::2], strict=True)
        found.append([((a, middle), (b, middle)) for a, b in pairs if b - a >= _SHORTEST])
    return found


def flown(rows: Sequence[Sequence[Piece]], start: Point) -> list[Piece]:
    """All pieces in the order and direction of flight, from the end nearest to ``start`` on."""
    cells, way = _cells(rows), []
    while cells:
        ways = [(cell, list(_up_and_down(cell, way_in))) for cell in cells for way_in in _WAYS]
        cell, nearest = min(ways, key=lambda each: math.dist(start, each[1][0][0]))
        cells.remove(cell)
        way += nearest
        start = nearest[-1][1]
    return way


# into a cell: whether from its last row; whether from that row's greater end
_WAYS = ((False, False), (False, True), (True, False), (True, True))


def _up_and_down(cell: list[Piece], way_in: tuple[bool, bool]) -> Iterator[Piece]:
    last_first, back = way_in
    for piece in reversed(cell) if last_first else cell:
        yield piece[::-1] if back else piece
        back = not back


def _cells(rows: Sequence[Sequence[Piece]]) -> list[list[Piece]]:
    cells: list[list[Piece]] = []
    before: list[list[Piece]] = []
    for row in rows:
        now = []
        for piece in row:
            beside = [cell for cell in before if _beside(cell[-1], piece)]
            if len(beside) == 1 and sum(_beside(beside[0][-1], other) for other in row) == 1:
                cell = beside[0]
                cell.append(piece)
            else:
                cell = [piece]
                cells.append(cell)
            now.append(cell)
        before = now
    return cells


def _beside(one: Piece, other: Piece) -> bool:
    return max(one[0][0], other[0][0]) < min(one[1][0], other[1][0])
