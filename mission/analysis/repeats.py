"""What came over and over, told once: frames that are held, ascents that go on, tries in vain."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from mission.model.shown import clock

HELD = " (held)"  # how the repeater's reason ends
_TRY = re.compile(r" \(try (\d+) of (\d+)\)$")
_MOST = 5  # frames whose tries are told


@dataclass(slots=True)
class _Run:
    """``count`` of the same, from ``begin`` to ``end``, s."""

    what: str
    why: str
    begin: float
    end: float
    count: int = 1

    def goes_on(self, t: float) -> None:
        self.end, self.count = t, self.count + 1

    @property
    def when(self) -> str:
        if self.count == 1:
            return f"at {clock(self.begin)}"
        return f"{self.count} times from {clock(self.begin)} to {clock(self.end)}"


class Commands:
    """The frames to the vehicle, in their order."""

    def __init__(self) -> None:
        self._runs: list[_Run] = []
        self._vain: dict[str, _Run] = {}

    def add(self, t: float, frame: str, why: str) -> None:
        plain = why.removesuffix(HELD)
        if self._runs and (self._runs[-1].what, self._runs[-1].why) == (frame, plain):
            self._runs[-1].goes_on(t)
        else:
            self._runs.append(_Run(frame, plain, t, t))
        tried = _TRY.search(why)
        if tried is None or tried[1] != tried[2]:
            return
        if frame in self._vain:
            self._vain[frame].goes_on(t)
        else:
            self._vain[frame] = _Run(frame, tried[2], t, t)

    def rows(self) -> list[tuple[str, ...]]:
        """When, frame and reason; what was said over and over by itself once."""
        found: list[tuple[str, ...]] = []
        for run in self._runs:
            often = f" ({run.count} times, until {clock(run.end)})" if run.count > 1 else ""
            found.append((clock(run.begin), run.what, run.why + often))
        return found

    def in_vain(self) -> Iterator[str]:
        """What the vehicle did not answer at once, the most frequent first."""
        some = sorted(self._vain.values(), key=lambda run: -run.count)
        for run in some[:_MOST]:
            yield f"{run.what} took all of its {run.why} tries {run.when}: no answer to the others."
        if len(some) > _MOST:
            yield f"So did {len(some) - _MOST} other frames."


class Again:
    """What an ascent, or a limit that acts by words alone, says while the state stays."""

    def __init__(self) -> None:
        self._run, self._said = _Run("", "", 0.0, 0.0), dict[str, None]()
        self._place: int | None = None  # of its sentence

    def end(self) -> None:
        """Another state is entered."""
        self._place = None

    def add(self, t: float, what: str, why: str, says: list[str]) -> None:
        """Adds a sentence to ``says``, or tells more in its own."""
        root = why.partition(": after ")[0]
        if self._place is not None and self._run.why == root:
            self._run.goes_on(t)
        else:
            self._run, self._said, self._place = _Run(what, root, t, t), {}, len(says)
            says.append("")
        self._said[what] = None
        says[self._place] = self._told(why)

    def _told(self, why: str) -> str:
        """``why``: the reason of the one that came last."""
        run, said = self._run, ", ".join(self._said)
        if run.count == 1:
            return f"{clock(run.begin)}: {why}; said again: {said}."
        often = f"said again {run.count} times, in turn: {said}"
        return f"{clock(run.begin)} to {clock(run.end)}: {run.why}; {often}."
