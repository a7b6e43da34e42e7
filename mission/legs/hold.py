"""The leg that holds its settings and nothing else: heading 90 ZAF8 until ... timeout ..."""

from __future__ import annotations

from mission.legs.base import LegType
from mission.model import Hold

TYPE = LegType(name="hold", kind=Hold)
