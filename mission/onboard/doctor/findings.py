"""Findings of `doctor`: lines on which a person can act. What does not live here: the checks."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Condition(enum.Enum):
    OK = "ok"
    WARNING = "warning"
    FAULT = "fault"


@dataclass(frozen=True, slots=True)
class Finding:
    """``todo`` says what to do; it is empty only if the condition is OK."""

    what: str
    condition: Condition
    says: str
    todo: str = ""


def ok(what: str, says: str, todo: str = "") -> Finding:
    return Finding(what, Condition.OK, says, todo)


def warning(what: str, says: str, todo: str) -> Finding:
    return Finding(what, Condition.WARNING, says, todo)


def fault(what: str, says: str, todo: str) -> Finding:
    return Finding(what, Condition.FAULT, says, todo)
