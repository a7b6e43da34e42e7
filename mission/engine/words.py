"""Texts of events, commands and legs, for Steps and journals.

What does not live here: the reasons themselves; each verb gives its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from mission.model import AutoNode, Ending, LineOpened, Loaded, Outcome, Restarted
from protocol.messages import (
    Aid,
    Emergency,
    Fix,
    Manual,
    Order,
    Outputs,
    Setpoint,
    Telemetry,
)
from protocol.operator_words import WORDS

_EVENTS: Mapping[type, str] = MappingProxyType(
    {
        Telemetry: "telemetry",
        Fix: "fix",
        Aid: "aid",
        Manual: "operator M",
        Loaded: "store",
        AutoNode: "node AUTO",
        LineOpened: "the line is back",
        Restarted: "restart",
        Ending: "the end of the program",
    }
)


def event_of(inputs: Sequence[object]) -> str:
    """Name the inputs that caused a step."""
    if len(inputs) == 1:
        return _event(inputs[0])
    return ", ".join(map(_event, inputs)) or "timer"


def _event(one: object) -> str:
    known = _EVENTS.get(type(one))
    if known is not None:
        return known
    if (word := WORDS.get(type(one))) is not None:
        return f"operator @{word.code}"
    if isinstance(one, Emergency):
        return "operator X" if one.order is Order.STOP else "operator W"
    if isinstance(one, Outcome):
        return f"{one.result.value} {one.frame.decode('ascii', 'replace')}"
    return type(one).__name__


def in_words(command: Setpoint | Order | Outputs) -> str:
    if isinstance(command, Outputs):
        return " ".join(["output", *(f"{name} {level:.9g}" for name, level in command.levels)])
    if isinstance(command, Order):
        return "everything stopped" if command is Order.STOP else "emergency surfacing"
    parts = []
    for name in ("surge", "turn", "heave", "heading", "depth", "altitude", "pitch", "roll"):
        value = getattr(command, name)
        if value is None or (value == 0.0 and name == "turn"):
            continue
        angle = name in ("heading", "pitch", "roll")
        parts.append(f"{name} {math.degrees(value) if angle else value:.4g}")
    return " ".join(parts)


def short(path: str) -> str:
    """The path of a leg without its region."""
    return path.partition("/")[2] or path
