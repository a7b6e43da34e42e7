"""What a rig saw, in order: the trace that laws judge, whoever flew.

What does not live here: what is asked of it (campaign: laws, audit, whole_flight).
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
    """Bytes of the vehicle that reached the program."""

    t: float
    data: bytes


@dataclass(frozen=True, slots=True)
class Told:
    """A telemetry that was taken, with the estimate that came of it."""

    t: float
    estimate: Estimate


@dataclass(frozen=True, slots=True)
class Done:
    """A disturbance that is no bytes."""

    t: float
    act: Act


Event = Said | Heard | Told | Done | Step | Tx


@dataclass(frozen=True, slots=True)
class Trace:
    """``raised`` is the traceback of a fault of the program, "" if none."""

    events: tuple[Event, ...]
    track: tuple[Truth, ...]  # one a second
    home: tuple[float, float]  # rad
    truth: Truth  # at the end
    state: str
    failure: str  # why the operator could not start the mission, ""
    started: float | None
    raised: str
    turning: bool  # some thruster is on at the end
    mission: Mission  # the one that was flown first


def from_home(trace: Trace, place: Truth) -> tuple[float, float]:
    """m north and east, by the simulator's own geodesy."""
    return local(trace.home, place.latitude, place.longitude)
