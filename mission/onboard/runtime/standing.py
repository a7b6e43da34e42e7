"""Values that stay in force until one of them changes: each change is recorded.

What does not live here: which values these are (records), who decides them (engine, commander).
"""

from __future__ import annotations

from mission.engine.engine import Engine
from mission.onboard.runtime.command_target import Peer
from mission.onboard.runtime.records import Recorder, Standing, standing_record


class StandingChanges:
    """Records the changes. It is cheap, because it runs after every input of the runtime."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._seen: tuple[object, ...] = ()

    def follow(self, now: float, engine: Engine, commander: Peer | None, digest: str) -> None:
        navigation = engine.core.vehicle_state.navigation
        frame = navigation.frame if navigation else None
        seen = (frame, engine.bounds, engine.breaches, commander, digest)
        if seen == self._seen:
            return
        self._seen, bounds = seen, engine.bounds
        standing = Standing(
            None if frame is None else frame.origin,
            bounds.radius,
            bounds.time,
            bounds.depth,
            bounds.voltage,
            tuple(row.name for row in engine.breaches),
            str(commander or ""),
            digest,
        )
        self._recorder.record(standing_record(now, standing))
