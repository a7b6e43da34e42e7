"""Imports in a thread, before anybody waits for it, what a mission needs and takes long to import.

It stays for ever, and with it some hundred thousand objects of the libraries. The collector would
look through all of them now and then, for 60 ms on a fast machine: between a report and the command
that answers it. So they are taken out of its sight.
"""

from __future__ import annotations

import contextlib
import gc
from typing import TYPE_CHECKING

from mission.onboard.runtime.command_target import MissionRefused
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.uncollected import uncollected

if TYPE_CHECKING:
    from mission.navigation import Navigation


def prepare(runtime: Runtime) -> Navigation:
    with uncollected():
        import _strptime  # type: ignore[import-not-found]  # noqa: F401  # of the first fix

        import mission.authoring.check
        import mission.authoring.language.assembly
        import mission.authoring.language.lines  # noqa: F401
        from mission.navigation.declination import EPOCHS, table

        navigation = runtime.make_navigation()
        for epoch in EPOCHS:
            with contextlib.suppress(OSError):  # it is told by nobody, and counts as 0
                table(epoch)
        if runtime.state.startswith("idle"):  # no ascent waits for it
            judge_ahead(runtime)
        if not gc.get_freeze_count():  # a further runtime: its predecessor may be garbage by now
            gc.freeze()
        return navigation


def judge_ahead(runtime: Runtime) -> None:
    """The kept mission, so that its verdict is ready when it is asked for, in idle, and holds up
    neither an X nor an operator then."""
    if lines := runtime.unjudged:
        with uncollected(), contextlib.suppress(MissionRefused):
            runtime.judge(lines)
