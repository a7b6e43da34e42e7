"""Times at which somebody has something to do; None: not before another has.

What does not live here: whose they are (runtime).
"""

from __future__ import annotations


def earliest(*timers: float | None) -> float | None:
    first = None
    for due in timers:
        if due is not None and (first is None or due < first):
            first = due
    return first


def is_due(timer: float | None, now: float) -> bool:
    return timer is not None and timer <= now
