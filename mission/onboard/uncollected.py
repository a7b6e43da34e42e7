"""Stretches of work without Python's cyclic garbage collector, in as many threads as there are.

The collector would look again and again through all that such work has made, and find nothing.
What that costs is measured by tests/bench/bench_tricks.py: of judging 1,000 legs some 15 %, in
pauses in which nothing else runs.
"""

from __future__ import annotations

import contextlib
import gc
import threading
from collections.abc import Iterator

_LOCK = threading.Lock()
_inside = 0
_before = True


@contextlib.contextmanager
def uncollected() -> Iterator[None]:
    """The collector is off until the last one inside has left, then as it was before the first."""
    global _inside, _before
    with _LOCK:
        if _inside == 0:
            _before = gc.isenabled()
            gc.disable()
        _inside += 1
    try:
        yield
    finally:
        with _LOCK:
            _inside -= 1
            if _inside == 0 and _before:
                gc.enable()
