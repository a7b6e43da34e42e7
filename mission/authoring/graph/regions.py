"""The transitions that all missions share, as the pictures show them.

The table itself is mission.model.regions, from which the machine is built. This module only selects
its rows for every picture, and for pictures with all safety transitions.
"""

from __future__ import annotations

from mission.model import AUTONOMOUS, IDLE_READY, STOPPED, SURFACED
from mission.model.regions import EMERGENCY, IDLE, LEG, MANUAL, REGION_EDGES, RegionEdge
from mission.model.regions import REGIONS as _REGIONS

REGIONS = (IDLE, AUTONOMOUS, MANUAL, EMERGENCY)  # in the order of the pictures
SUBSTATES = tuple(path for name in REGIONS for path in _REGIONS[name])

_USUAL = frozenset({"load", "start", "stick", "silent", "surfaced"})
_ALSO = frozenset(
    {
        ("clear", IDLE_READY),
        ("clear", STOPPED),
        ("clear", SURFACED),
        ("X", AUTONOMOUS),
        ("W", AUTONOMOUS),
        ("limit", AUTONOMOUS),
    }
)


def region(path: str) -> str:
    return path.partition("/")[0]


def shared(safety: bool) -> tuple[RegionEdge, ...]:
    """All rows with ``safety``, else those that a reader of the mission needs."""
    return tuple(
        row
        for row in REGION_EDGES
        if safety or row.name in _USUAL or (row.name, row.source) in _ALSO
    )


def target(row: RegionEdge) -> str:
    """The target of a row; the region ``autonomous`` if any leg may be the target."""
    return AUTONOMOUS if row.target == LEG else row.target
