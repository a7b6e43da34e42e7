"""The law of the mission's areas: no vehicle stays autonomous where its estimate breaks one (R5).

    breached   the estimate is in a keep-out area, or outside all keep-in areas, for more reports
               than the limit takes: an emergency must follow
    doubted    the 95 % ellipse of the estimate reaches an edge: another leg must follow, unless
               the vehicle is on its way up

The law uses another geometry than the engine: winding angles and sampled ellipses.

What does not live here: the radius (limit_laws, laws), what is proved before the dive (check).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from mission.authoring.check.fenced import fenced
from mission.engine.areas import Fence
from mission.model import Estimate
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.limit_laws import UNANSWERED
from mission.verification.campaign.story import Stay, Story

_REPORTS = 4  # two samples, and two that noise may cost
_SPARE = 1.0  # m of depth: sensor error, and motion between two reports
_RING = 24  # points that are sampled on the ellipse
_CLEAR = 2.0  # sigmas: 95 % are 2.45; an edge within 2 is certainly not clear
Point = tuple[float, float]


def area_laws(story: Story) -> Iterator[Violation]:
    fences = fenced(story.mission)
    for stay in story.stays if fences else ():
        if stay.autonomous:
            yield from _answers(story, stay, fences)


def _answers(story: Story, stay: Stay, fences: Sequence[Fence]) -> Iterator[Violation]:
    goes_on = not (stay.ascends or stay.state.endswith("/surface"))
    in_breach = in_doubt = 0
    surely = False
    for told in story.samples_in(stay.begin, stay.end):
        e, depth = told.estimate, story.depth(told.t)
        in_breach = in_breach + 1 if against(fences, (e.north, e.east), depth, _SPARE) else 0
        doubt = any(against(fences, point, depth, _SPARE) for point in _ring(e))
        surely = surely or not doubt
        in_doubt = in_doubt + 1 if doubt and surely and goes_on else 0
        if max(in_breach, in_doubt) > _REPORTS and not story.hindered(told.t - 10.0, told.t):
            how = "against" if in_breach > _REPORTS else "not clear of"
            says = f"north {e.north:.0f} east {e.east:.0f} {how} an area: still {stay.state}"
            yield Violation(UNANSWERED, told.t, says)
            return


def against(fences: Sequence[Fence], here: Point, depth: float, spare: float = 0.0) -> bool:
    """Whether a place (m north, m east of home) breaks a fence by at least ``spare`` m of depth."""
    counting = [f for f in fences if _counts(f, depth, spare)]
    if any(f.area.out and _winds(f.polygon, here) for f in counting):
        return True
    inner = [f for f in counting if not f.area.out]
    open_to = [f for f in fences if not f.area.out and _winds(f.polygon, here)]
    return bool(inner) and not open_to


def _counts(fence: Fence, depth: float, spare: float) -> bool:
    area = fence.area
    return not area.limited or area.top + spare <= depth <= area.bottom - spare


def _winds(polygon: Sequence[Point], here: Point) -> bool:
    """Whether the polygon encloses a place, by the angle that its corners turn about the place."""
    turned = 0.0
    for a, b in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        one = math.atan2(a[1] - here[1], a[0] - here[0])
        other = math.atan2(b[1] - here[1], b[0] - here[0])
        turned += math.remainder(other - one, math.tau)
    return abs(turned) > math.pi


def _ring(e: Estimate) -> Iterator[Point]:
    nn, ne, ee = e.covariance
    spread = math.sqrt(max(nn, 1e-9))
    across = math.sqrt(max(ee - (ne / spread) ** 2, 0.0))
    for i in range(_RING):
        a = math.tau * i / _RING
        north = _CLEAR * spread * math.cos(a)
        yield (
            e.north + north,
            e.east + north * ne / spread**2 + _CLEAR * across * math.sin(a),
        )
