"""The leg that holds what is set already, for a time or until an exit: wait 30s [until ...]."""

from __future__ import annotations

from mission.legs.base import LegType
from mission.model import Wait

TYPE = LegType(name="wait", kind=Wait)
