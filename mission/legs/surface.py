"""The leg that ascends as R7 proves it; the ascent itself is mission.engine.ascent's, shared with
the emergency. It holds every axis itself, and leaves the vehicle with everything stopped."""

from __future__ import annotations

from mission.legs.base import LegType
from mission.model import Axis, Surface

TYPE = LegType(name="surface", kind=Surface, steers=frozenset(Axis), ends=True, ascends=True)
