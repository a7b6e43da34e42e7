"""The shipped missions as the campaigns fly them, judged once for all rooms that fly them."""

from __future__ import annotations

import functools

from mission.verification.campaign.faults import Subject, fitting, shipped, subjects

KNOWN = tuple(subjects(shipped()))


@functools.cache
def known_on(vehicle: str) -> tuple[Subject, ...]:
    """Those that fly on it."""
    return tuple(fitting(vehicle))
