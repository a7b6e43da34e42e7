"""To one place along the line from where the leg was entered; done within its arrival radius."""

from __future__ import annotations

from mission.legs.base import LegType, View
from mission.legs.guidance import GIVES, NEEDS, STEERS
from mission.legs.waypoints import Waypoints, arrival_fault
from mission.model import Goto
from protocol.messages import Setpoint


def _begin(kind: Goto, base: Setpoint, view: View) -> Waypoints:
    return Waypoints(base, (view.place(kind.place),), kind.within, view)


def _fault(kind: Goto) -> str:
    return arrival_fault(kind.within)


TYPE = LegType(
    name="goto",
    kind=Goto,
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    fault=_fault,
)
