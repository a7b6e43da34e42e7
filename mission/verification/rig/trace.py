"""What a rig saw, in order: the trace that laws judge.

What does not live here: the laws (campaign: laws, audit, whole_flight).
"""

from __future__ import annotations

from dataclasses import dataclass

from links.simulated.geodesy import local
from links.simulated.link import Truth
from mission.model import Estimate, Mission, Step, Tx
from mission.verification.rig.acts import Act


@dataclass(frozen=True, slots=True)
class Said:
    """Bytes that reached the program from outside."""

    t: float
    link: str
    address: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Heard:
    """Bytes from the vehicle that reached the program."""

    t: float
    data: bytes


@dataclass(frozen=True, slots=True)
class Located:
    """Bytes from a GPS receiver that reached the program."""

    t: float
    link: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Told:
    """The estimate after a report that the program accepted."""

    t: float
    estimate: Estimate


@dataclass(frozen=True, slots=True)
class Done:
    """A disturbance other than bytes."""

    t: float
    act: Act


Event = Said | Heard | Located | Told | Done | Step | Tx


@dataclass(frozen=True, slots=True)
class Trace:
    """``raised``: the traceback of an error in the program, "" without one."""

    events: tuple[Event, ...]
    track: tuple[Truth, ...]  # one a second
    home: tuple[float, float]  # rad
    truth: Truth  # at the end
    state: str
    failure: str  # why the operator could not start the mission, ""
    started: float | None
    raised: str
    turning: bool  # a thruster is on at the end
    mission: Mission  # the one that was flown first


def from_home(trace: Trace, place: Truth) -> tuple[float, float]:
    """Return the place in m north and east of home, by the simulator's own geodesy."""
    return local(trace.home, place.latitude, place.longitude)
