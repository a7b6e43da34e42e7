"""The shipped missions as the campaigns fly them, judged once for all rooms that fly them."""

from __future__ import annotations

from mission.verification.campaign.faults import shipped, subjects

KNOWN = tuple(subjects(shipped()))
