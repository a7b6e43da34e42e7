"""Import the slow modules that a mission needs in a thread, before anything waits for them.

They stay loaded, with some hundred thousand objects of the libraries. The garbage collector would
scan all of them now and then, for 60 ms on a fast machine: between a report and the command that
answers it. So they are frozen, and it does not scan them.
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
            with contextlib.suppress(OSError):  # without its table declination counts as 0
                table(epoch)
        if runtime.state.startswith("idle"):  # otherwise an ascent would wait for it
            judge_ahead(runtime)
        if not gc.get_freeze_count():  # once: later, an earlier runtime may be garbage
            gc.freeze()
        return navigation


def judge_ahead(runtime: Runtime) -> None:
    """Judge the stored mission, so that its verdict is ready when it is needed in idle, and delays
    neither an X nor an operator then."""
    if lines := runtime.unjudged:
        with uncollected(), contextlib.suppress(MissionRefused):
            runtime.judge(lines)
