"""The share of an area that rows are expected to see, from the uncertainty of their positions.

Around each row lies its own strip, as wide as the spacing. A point of it is seen with the
probability that a row passes near enough: its own or a neighbour's, with independent errors. The
part of a polygon in no strip (beyond the slanting end of a row) counts as not seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mission.legs.pattern import Pattern, Span
from mission.navigation.distribution import below
from mission.navigation.polygons import inside

PIECES = 6  # pieces of a row
_ACROSS = 9  # points sampled across the spacing
_GRID = 60  # points sampled along each side of an area that is no rectangle


@dataclass(frozen=True, slots=True)
class Row:
    """The expectation for one row. ``across``: sigma in m of the position across the row, for each
    piece from the beginning of the area on. ``ends``: m missed of its length. ``error``: radius in
    m that contains 95 % of dives at its end."""

    across: tuple[float, ...]
    ends: float
    error: float


@dataclass(frozen=True, slots=True)
class _Strip:
    """A row at its planned place, in the frame of the area."""

    span: Span
    off: float
    row: Row

    def sigma(self, along: float) -> float | None:
        """Sigma in m across the row, at ``along``; None if the row does not reach there."""
        low, high = self.span
        piece = int((along - low) / (high - low) * PIECES)
        return self.row.across[piece] if 0 <= piece < PIECES else None


def covered(pattern: Pattern, rows: Sequence[Row]) -> float:
    """The mean share of the area that is seen; ``rows`` in the order of the pattern."""
    strips = list(_strips(pattern, rows))
    seen = wide = 0.0
    for strip in strips:
        near = [s for s in strips if abs(s.off - strip.off) < 1.5 * pattern.spacing]
        low = max(-pattern.spacing / 2.0, pattern.across[0] - strip.off)
        high = min(pattern.spacing / 2.0, pattern.across[1] - strip.off)
        long = strip.span[1] - strip.span[0]
        wide += (high - low) * long
        mean = _seen_about(strip, near, (low, high), pattern.swath)
        seen += mean * (high - low) * (long - strip.row.ends)
    return seen / wide * (1.0 if pattern.whole else _in_strips(pattern, strips))


def _strips(pattern: Pattern, rows: Sequence[Row]) -> Iterator[_Strip]:
    for (begin, end), row in zip(pattern.rows, rows, strict=True):
        (a, off), (b, _) = pattern.framed(begin), pattern.framed(end)
        yield _Strip((min(a, b), max(a, b)), off, row)


def _seen_about(strip: _Strip, near: Sequence[_Strip], width: Span, swath: float) -> float:
    """The share that is seen of the part of a strip whose distance from its row is in ``width``."""
    total, (low, high), half = 0.0, width, swath / 2.0
    begin, end = strip.span
    for step in range(_ACROSS):
        y = strip.off + low + (high - low) * (step + 0.5) / _ACROSS
        for piece in range(PIECES):
            along = begin + (end - begin) * (piece + 0.5) / PIECES
            missed = 1.0
            for other in near:
                if (sigma := other.sigma(along)) is not None:
                    off = y - other.off
                    missed *= 1.0 - below(half, off, sigma) + below(-half, off, sigma)
            total += 1.0 - missed
    return total / (_ACROSS * PIECES)


def _in_strips(pattern: Pattern, strips: Sequence[_Strip]) -> float:
    """The share of the polygon that lies beside a row."""
    outline = [pattern.framed(corner) for corner in pattern.outline]
    there = beside = 0
    for a in _places(pattern.along):
        for b in _places(pattern.across):
            if inside(outline, (a, b)):
                there += 1
                beside += any(
                    abs(b - s.off) <= pattern.spacing / 2.0 and s.span[0] <= a <= s.span[1]
                    for s in strips
                )
    return beside / max(there, 1)


def _places(span: Span) -> Iterator[float]:
    return (span[0] + (span[1] - span[0]) * (k + 0.5) / _GRID for k in range(_GRID))
