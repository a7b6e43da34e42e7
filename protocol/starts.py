"""Where frames can begin in a stream, by their first bytes alone.

What does not live here: whether a frame is really there (framing).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial

from protocol.fields import FrameType


def by_start(types: Sequence[FrameType], torn: bytes) -> dict[bytes, tuple[FrameType, ...]]:
    """Map two bytes, or the buffer's last single byte, to the frames that may begin with them.
    ``torn``: two bytes of a host with a guest directly behind its first byte; b"" for none."""
    starts = {t.lead[:size] for t in types for size in (1, 2)}
    for short in (t.lead for t in types if len(t.lead) == 1):
        starts |= {short + bytes([second]) for second in range(256)}
    if torn:
        starts.add(torn)
    return {
        start: tuple(t for t in types if t.lead.startswith(start) or start.startswith(t.lead))
        for start in starts
    }


def finder(firsts: set[bytes]) -> Callable[[bytes], Callable[[int], int]]:
    """Return a function of the data. It returns a function of an offset, and that one returns
    where the next frame can begin from there on, -1 for nowhere."""
    if len(firsts) == 1:
        (first,) = firsts
        return partial(_byte_in, first)
    return partial(_pattern_in, re.compile(b"[" + b"".join(map(re.escape, sorted(firsts))) + b"]"))


# No closures: a framer is copied, and mypyc's closures cannot be copied.


def _byte_in(first: bytes, data: bytes) -> Callable[[int], int]:
    return partial(data.find, first)


def _pattern_in(pattern: re.Pattern[bytes], data: bytes) -> Callable[[int], int]:
    return partial(_start, pattern, data)


def _start(pattern: re.Pattern[bytes], data: bytes, at: int) -> int:
    found = pattern.search(data, at)
    return -1 if found is None else found.start()
