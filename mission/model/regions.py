"""The regions that every mission shares, and the edges between them: one table of rows.

    idle        empty | ready
    autonomous  the mission's own tree, from its Chart
    manual      driving | waiting
    emergency   stopped | surfacing | surfaced

What does not live here: when an edge is taken (engine), the mission's own edges (Chart).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
)

IDLE, MANUAL, EMERGENCY = "idle", "manual", "emergency"
REGIONS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        IDLE: (IDLE_EMPTY, IDLE_READY),
        AUTONOMOUS: (),
        MANUAL: (MANUAL_DRIVING, MANUAL_WAITING),
        EMERGENCY: (STOPPED, SURFACING, SURFACED),
    }
)
AGAIN = "autonomous:again"  # to the implicit leg: a handler's guard became true a second time
LEG = ""  # as a target: the leg that the mission starts with, or in which it was interrupted


@dataclass(frozen=True, slots=True)
class RegionEdge:
    """``source`` is a state or a whole region."""

    name: str
    source: str
    target: str
    meaning: str


# fmt: off
REGION_EDGES = (
    RegionEdge("load", IDLE_EMPTY, IDLE_READY, "a mission was stored"),
    RegionEdge("clear", IDLE_READY, IDLE_EMPTY, "@AC"),
    RegionEdge("clear", STOPPED, IDLE_EMPTY, "@AC"),
    RegionEdge("clear", SURFACED, IDLE_EMPTY, "@AC"),
    RegionEdge("start", IDLE_READY, LEG, "@AA"),
    RegionEdge("start", MANUAL, LEG, "@AA, 2 s after the stick: the interrupted leg, or the start"),
    RegionEdge("auto off", AUTONOMOUS, IDLE_READY, "node AUTO closed"),
    RegionEdge("stick", IDLE, MANUAL_DRIVING, "any M"),
    RegionEdge("stick", AUTONOMOUS, MANUAL_DRIVING, "any M"),
    RegionEdge("stick", MANUAL_WAITING, MANUAL_DRIVING, "any M"),
    RegionEdge("stick", EMERGENCY, MANUAL_DRIVING, "a push of the stick, 2 s after any M"),
    RegionEdge("silent", MANUAL_DRIVING, MANUAL_WAITING, "2 s without M"),
    RegionEdge("forgotten", MANUAL, IDLE_READY, "60 s without M, at the surface"),
    RegionEdge("forgotten", MANUAL, IDLE_EMPTY, "60 s without M, at the surface"),
    RegionEdge("forgotten", MANUAL, SURFACING, "60 s without M, deep or depth unknown"),
    RegionEdge("X", IDLE, STOPPED, "@ZAX0"),
    RegionEdge("X", AUTONOMOUS, STOPPED, "@ZAX0"),
    RegionEdge("X", MANUAL, STOPPED, "@ZAX0"),
    RegionEdge("X", EMERGENCY, STOPPED, "@ZAX0"),
    RegionEdge("W", IDLE, SURFACING, "@ZAWF"),
    RegionEdge("W", AUTONOMOUS, SURFACING, "@ZAWF"),
    RegionEdge("W", MANUAL, SURFACING, "@ZAWF"),
    RegionEdge("W", EMERGENCY, SURFACING, "@ZAWF"),
    RegionEdge("limit", IDLE, SURFACING, "hard depth, unexplained descent, it sinks"),
    RegionEdge("limit", AUTONOMOUS, SURFACING, "any limit"),
    RegionEdge("limit", MANUAL_WAITING, SURFACING, "as in idle"),
    RegionEdge("limit", STOPPED, SURFACING, "hard depth, unexplained descent, it does not rise"),
    RegionEdge("limit", SURFACED, SURFACING, "hard depth, unexplained descent, it sinks again"),
    RegionEdge("restart", IDLE, SURFACING, "the program restarted during a mission or an ascent"),
    RegionEdge("restart", IDLE, STOPPED, "the same in stopped, or nobody knows in what"),
    RegionEdge("restart", IDLE, SURFACED, "the same in surfaced"),
    RegionEdge("restart", STOPPED, SURFACING, "nobody knows in what, and it is deep"),
    RegionEdge("end", AUTONOMOUS, SURFACING, "the program is to end"),
    RegionEdge("end", AUTONOMOUS, SURFACED, "the program is to end, at a proved surface"),
    RegionEdge("end", MANUAL, SURFACING, "the program is to end, the stick is silent"),
    RegionEdge("end", MANUAL, SURFACED, "the same, at a proved surface"),
    RegionEdge("end", SURFACED, SURFACING, "the program has to end, and it has sunk again"),
    RegionEdge("surfaced", SURFACING, SURFACED, "the surface is reached"),
)
# fmt: on
