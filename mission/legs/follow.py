"""Through several places in turn; done within the arrival radius of the last one."""

from __future__ import annotations

from mission.legs.base import LegType, View
from mission.legs.guidance import GIVES, NEEDS, STEERS
from mission.legs.waypoints import Waypoints, arrival_fault
from mission.model import Follow
from protocol.messages import Setpoint


def _begin(kind: Follow, base: Setpoint, view: View) -> Waypoints:
    return Waypoints(base, tuple(view.place(p) for p in kind.places), kind.within, view)


def _fault(kind: Follow) -> str:
    return arrival_fault(kind.within) if kind.places else "follow has no points"


TYPE = LegType(
    name="follow",
    kind=Follow,
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    fault=_fault,
)
