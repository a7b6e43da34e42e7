"""Make the Diagnostic of a refusal by the compiler."""

from __future__ import annotations

from mission.model import Where
from mission.model.diagnostics import Diagnostic, Stage


def refused(code: str, where: Where, message: str, hint: str = "") -> Diagnostic:
    return Diagnostic(Stage.COMPILE, code, where, message, hint)
