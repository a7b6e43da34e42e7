"""Whether the estimate, with its uncertainty, keeps to the mission's areas (R5).

    keep in    inside one of the areas that count at its depth; if none counts, anywhere
    keep out   outside all areas that count at its depth

    certain    the estimate itself is where it must not be   -> emergency/surfacing
    uncertain  its 95 % ellipse reaches where it must not be -> the mission's on uncertain

While the depth is not believed, every area counts. What does not live here: the polygons' geometry
(navigation.polygons), the rows of the limits (limits), what is proved before the dive (check).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from mission.legs.base import Point
from mission.model import Area, Place
from mission.navigation.distribution import PLANE_95, Covariance
from mission.navigation.polygons import inside, sigmas


@dataclass(frozen=True, slots=True)
class Fence:
    """An area with its corners in m from home."""

    area: Area
    polygon: tuple[Point, ...]

    @property
    def words(self) -> str:
        return f"keep {'out' if self.area.out else 'in'} {self.area.name}"


def fences(areas: Iterable[Area], place: Callable[[Place], Point | None]) -> tuple[Fence, ...]:
    """The areas whose corners are all known. The check passes no latitude without a home."""
    made = []
    for area in areas:
        corners = [place(corner) for corner in area.corners]
        known = tuple(corner for corner in corners if corner is not None)
        if len(known) == len(corners):
            made.append(Fence(area, known))
    return tuple(made)


def breached(all_of: Sequence[Fence], here: Point, depth: float | None) -> str:
    """The area that the estimate breaches, in words; "" for none."""
    return _broken(all_of, depth, lambda fence: inside(fence.polygon, here))


def doubted(
    all_of: Sequence[Fence], here: Point, covariance: Covariance, depth: float | None
) -> str:
    """The area that the estimate may breach, in words; "" if it surely breaches none."""

    def surely(fence: Fence) -> bool:
        """Of a keep-in area: surely inside. Of a keep-out area: not surely outside."""
        clear = sigmas(fence.polygon, here, covariance) > PLANE_95
        is_inside = inside(fence.polygon, here)
        return (is_inside or not clear) if fence.area.out else (is_inside and clear)

    return _broken(all_of, depth, surely)


def _broken(all_of: Sequence[Fence], depth: float | None, holds: Callable[[Fence], bool]) -> str:
    counting = [fence for fence in all_of if fence.area.counts_at(depth)]
    for fence in counting:
        if fence.area.out and holds(fence):
            return fence.words
    keeps_in = [fence for fence in counting if not fence.area.out]
    if keeps_in and not any(holds(fence) for fence in keeps_in):
        return ", ".join(fence.words for fence in keeps_in)
    return ""
