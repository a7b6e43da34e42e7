"""What `doctor` says: lines on which a person can act. What does not live here: how it is found."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Condition(enum.Enum):
    OK = "ok"
    WARNING = "warning"
    FAULT = "fault"


@dataclass(frozen=True, slots=True)
class Finding:
    """``todo`` is never empty where the condition is not OK."""

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
