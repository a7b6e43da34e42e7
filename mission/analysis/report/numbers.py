"""Numbers of legs on a picture: numbers that would overlap are written together.

What does not live here: which leg has which number (map.marks_of).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

Point = tuple[float, float]
_DIGIT, _DISC = 0.012, 0.035  # of a map's long side: widths of a character and of a disc


def as_runs(numbers: Iterable[int]) -> str:
    """Write 1, 2, 3 and 5 as ``1–3, 5``."""
    runs: list[list[int]] = []
    for number in sorted(set(numbers)):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(_run(run) for run in runs)


def _run(run: list[int]) -> str:
    if len(run) > 2:
        return f"{run[0]}\u2013{run[-1]}"
    return ", ".join(map(str, run))


def along(places: Iterable[tuple[float, int]], apart: float) -> Iterator[tuple[float, str]]:
    """Group numbers over an axis, in order: a number nearer than ``apart`` joins the one before
    it."""
    group: list[tuple[float, int]] = []
    for place, number in places:
        if group and place - group[-1][0] >= apart:
            yield _middle(group)
            group = []
        group.append((place, number))
    if group:
        yield _middle(group)


def _middle(group: list[tuple[float, int]]) -> tuple[float, str]:
    return (group[0][0] + group[-1][0]) / 2.0, as_runs(number for _, number in group)


def around(places: Iterable[tuple[Point, int]], width: float) -> Iterator[tuple[Point, str]]:
    """Group numbers on a map with the long side ``width``: those that an earlier one would
    cover."""
    groups: list[tuple[Point, list[int]]] = []
    for (east, north), number in places:
        for (at_east, at_north), numbers in groups:
            room = _DISC + _DIGIT * (len(as_runs(numbers)) - 1)
            if abs(east - at_east) < room * width and abs(north - at_north) < _DISC * width:
                numbers.append(number)
                break
        else:
            groups.append(((east, north), [number]))
    for place, numbers in groups:
        yield place, as_runs(numbers)
