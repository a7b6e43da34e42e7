"""Uploads, and reports of the store (R3, R4): lines come in, a whole mission is stored.

What does not live here: which lines make a set (staging), who may send them (operator_server), the
files (store).
"""

from __future__ import annotations

from collections.abc import Iterable

from mission.model import Verdict
from mission.model.regions import EMERGENCY
from mission.onboard.runtime.command_target import CommandTarget, MissionRefused
from mission.onboard.runtime.staging import Held, OutOfPlace, Staging, Whole
from mission.onboard.store import Store, StoreError
from protocol.messages import MissionLine, StoreReport


class Uploads:
    def __init__(self, target: CommandTarget, store: Store) -> None:
        self._target, self._store = target, store
        self._staging = Staging()

    @property
    def is_idle(self) -> bool:
        return self._target.state.startswith("idle")

    @property
    def total(self) -> int:
        """Number of lines of the set being uploaded, 0 if none is."""
        return self._staging.total

    @property
    def missing(self) -> str:
        return self._staging.missing

    def may_complete(self, data: bytes) -> bool:
        """A quick test: whether these bytes might complete a set of lines."""
        staged = self._staging
        may_begin = b"AW" in data or staged.total > 0
        enough = staged.have + data.count(b"@") + 1 >= staged.total  # a line may have begun before
        return b"$" in data and may_begin and enough and self.is_idle

    def foresee(self, heard: Iterable[object], now: float) -> tuple[str, ...]:
        """The set of lines that these commands would complete, () if none. Changes nothing."""
        staging = self._staging.copy()
        for item in heard:
            if isinstance(item, MissionLine):
                held = staging.offer(item, self._store.content.lines, now)
                if isinstance(held, Whole):
                    return held.lines
        return ()

    def take(self, line: MissionLine, now: float) -> tuple[Verdict, bool]:
        """Take a line. Return the verdict, and whether a whole set was stored."""
        if not self.is_idle:
            return Verdict(False, _not_idle(self._target.state)), False
        held = self._staging.offer(line, self._store.content.lines, now)
        if isinstance(held, Held):
            return Verdict(True), False
        if isinstance(held, OutOfPlace):
            return Verdict(False, held.why), False
        try:
            self._target.accept(held.lines, now)
        except (MissionRefused, StoreError) as error:
            return Verdict(False, str(error)), False
        self._staging.clear()
        return Verdict(True), True

    def holds(self, line: MissionLine) -> bool:
        """Whether it is a line of the staged or the stored mission."""
        stored = self._store.content.lines
        is_stored = len(stored) == line.total and stored[line.current - 1] == line.payload
        return is_stored or self._staging.holds(line)

    def clear(self) -> None:
        self._staging.clear()

    def incomplete(self, now: float) -> bool:
        return self._staging.incomplete(self._store.content.lines, now)

    def report(self, refusal: str, now: float) -> StoreReport:
        staging, stored = self.incomplete(now), len(self._store.content.lines)
        state = "staging" if staging else "ready" if stored else "empty"
        return StoreReport(
            state if self.is_idle else "running",
            self._staging.total if staging else stored,
            self._staging.have if staging else stored,
            self._staging.missing if staging else "",
            self._target.digest[:16],
            refusal,
        )


def _not_idle(state: str) -> str:
    """Why no line is accepted, and what leads to idle."""
    first = "" if state.startswith(EMERGENCY) else "stop the vehicle (X) and "
    then = f"{first}clear it at the surface; then upload"
    return f"a mission can be uploaded in idle only and this is {state}: {then}"
