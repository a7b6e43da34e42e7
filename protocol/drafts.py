"""Frozen values, made quickly: filled as a draft, which then becomes what it was a draft of.

Setting the slots of a frozen class costs more than twice as much (tests/bench/bench_tricks.py), and
noise has a fault for every few bytes. Compiled code cannot swap an object's class, so this is left
to the interpreter (``mission.model.compiled``).

What does not live here: Telemetry, for which ``protocol.vehicles.sd_stream`` does the same.
"""

from __future__ import annotations

from typing import Any, cast

from protocol.messages import FrameFault


class _Draft:
    __slots__ = FrameFault.__slots__


def fault(offset: int, kind: str, length: int) -> FrameFault:
    draft: Any = _Draft()
    draft.offset, draft.kind, draft.length = offset, kind, length
    draft.__class__ = FrameFault
    return cast("FrameFault", draft)
