"""Outputs beside the motion, by the engine's state: the last part of a step.

What does not live here: who holds which output, and what has to be sent (outputs).
"""

from __future__ import annotations

from mission.engine.core import Core
from mission.engine.outputs import Situation
from mission.model import MANUAL_DRIVING, Action, Verdict
from mission.model.regions import MANUAL
from protocol.messages import Outputs, SetOutput


def mind_outputs(core: Core) -> None:
    """Send the outputs that have to change. Call this after everything that moves the vehicle."""
    outputs = core.outputs
    if not outputs.outputs:
        return
    why = outputs.watch_ascent(core.now, core.vehicle_state.depth, _climbs(core))
    news = outputs.changes(_situation(core))
    if news:
        levels = tuple(sorted(news.items()))
        core.say(Action(Outputs(levels), why or f"outputs in {core.active}"))


def set_output(core: Core, command: SetOutput) -> Verdict:
    """Carry out an @AO: set an output by hand."""
    why = core.outputs.why_not(command.name, command.value, _situation(core))
    if not why:
        core.outputs.set_by_hand(command.name, command.value)
    return Verdict(not why, why)


def _situation(core: Core) -> Situation:
    run, driving = core.run, core.active == MANUAL_DRIVING
    held = {} if run is None else dict(run.chart.state(run.leaf).outputs)
    return Situation(core.region, core.emergency_at, held, driving, core.ending_since is not None)


def _climbs(core: Core) -> bool:
    if core.region == MANUAL:
        return False
    return core.ascent is not None or (core.run is not None and core.run.climbing)
