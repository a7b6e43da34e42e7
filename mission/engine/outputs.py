"""What every output of the vehicle file shall be: who holds it now, and what is to be said.

    emergency, end of the program   all safe but what is irreversible
    a mission under way             those that it names anywhere: as its active leg says
    all else                        as set by hand (@AO), safe until then; what moves or holds
                                    the vehicle by the side of its setpoint only under the stick

What a mission held is safe when the mission is over. The stick makes safe what it finds that moves
or holds the vehicle, and keeps the others until they are overruled by hand, or it is over. An
irreversible output is the operator's; where the vehicle file arms it, an ascent that has gained
less than 1 m in 120 s sets it once, also where the depth is not known (R7).

Only what has changed is said. At the start of the program, behind a line that was away, and where
an operator's own word has set it (@DS, @RS), nobody knows what an output is: it is said with the
next emergency, mission or @AO, or the end of the program.

What does not live here: the engine's state (auxiliary), frames (protocol.vehicles), how often a
word is said (onboard.runtime).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, Self

from mission.model import AUTONOMOUS
from mission.model.copies import copied
from mission.model.regions import EMERGENCY, MANUAL
from mission.model.vehicle import Output

GAINS, WITHIN = 1.0, 120.0  # m and s: an ascent that rises slower needs help (R7)

Levels = dict[str, float]


class Situation(NamedTuple):
    """What decides who holds what. ``held``: by the mission under way in its leg, also while the
    stick interrupts it; ``driving``: the stick is in use; ``safe``: the program is to end."""

    region: str
    emergency_at: float
    held: Mapping[str, float]
    driving: bool
    safe: bool


class OutputKeeper:
    """``outputs``: the vehicle file's."""

    def __init__(self, outputs: tuple[Output, ...]) -> None:
        self.outputs = {output.name: output for output in outputs}
        self._by_hand: Levels = {output.name: output.safe for output in outputs}
        self.said: Levels = dict(self._by_hand)  # what each was told last
        # Of those, what may not be so: of a program before this one nobody knows what it said.
        self.doubt()
        self._passed: set[str] = set()  # what an operator's word has set past this since
        self._holder: tuple[str, float, bool] | None = None
        self._found: Levels = {}  # by the stick: what the mission that it interrupts had set
        self._touched: tuple[str, ...] = ()  # by hand, since the last look
        self._mark: tuple[float, float | None] | None = None  # of an ascent: when, how deep

    def clone(self) -> Self:
        return copied(self, outputs=self.outputs)

    def doubt(self) -> None:
        """Nobody knows whether the outputs are what they were told. What cannot be taken back and
        was never set is told nothing."""
        self._doubtful = {
            name
            for name, o in self.outputs.items()
            if not o.irreversible or self._by_hand[name] != o.safe
        }

    def pass_by(self, channels: Iterable[str]) -> None:
        """An operator's own word sets these; it stands until somebody else holds the outputs."""
        self._passed |= {o.name for o in self.outputs.values() if o.channel in channels}

    def told(self, name: str) -> float | None:
        """What this output is, as far as it is known."""
        unknown = name in self._doubtful or name in self._passed
        return None if unknown else self.said.get(name)

    def why_not(self, name: str, value: float, at: Situation) -> str:
        """Why ``value`` may not be set by hand now, "" if it may."""
        output = self.outputs.get(name)
        if output is None:
            there = "; ".join(self.outputs) or "none"
            return f"no output {name}; the vehicle file names: {there}"
        if fault := output.fault(value):
            return fault
        if output.irreversible:
            return ""
        if at.safe or at.region == EMERGENCY:
            return f"an emergency holds {name} at {output.safe:g}"
        if at.region == AUTONOMOUS and name in at.held:
            return f"the mission holds {name}"
        if output.excludes and not at.driving:
            return f"{name} moves or holds the vehicle: take the stick first"
        return ""

    def set_by_hand(self, name: str, value: float) -> None:
        self._by_hand[name] = value
        self._found.pop(name, None)
        self._doubtful.add(name)  # said again though it were so
        self._touched = (*self._touched, name)

    def changes(self, at: Situation) -> Levels:
        """Returns what has to be sent now."""
        self._follow(at)
        held = at.held if at.region == AUTONOMOUS else {}
        wanted = {**self._by_hand, **self._found, **held}
        asked = wanted if at.safe or at.region == EMERGENCY else {*held, *self._touched}
        again = self._doubtful & set(asked)
        news = {n: level for n, level in wanted.items() if n in again or self.said[n] != level}
        self.said |= news
        self._doubtful -= set(news)
        self._touched = ()
        return news

    def _follow(self, at: Situation) -> None:
        holder = at.region, at.emergency_at, at.safe
        if holder != self._holder:
            self._doubtful |= self._passed
            self._holder, self._passed = holder, set()
        if at.region == AUTONOMOUS:
            self._make_safe(at.held)
            self._found = {n: v for n, v in at.held.items() if not self.outputs[n].excludes}
        elif at.region != MANUAL or at.safe:
            self._found = {}
        if at.region == EMERGENCY or (at.safe and at.region != AUTONOMOUS):
            self._make_safe(o.name for o in self.outputs.values() if not o.irreversible)
        if not at.driving:
            self._make_safe(o.name for o in self.outputs.values() if o.excludes)

    def _make_safe(self, names: Iterable[str]) -> None:
        self._by_hand |= {name: self.outputs[name].safe for name in names}

    # --- what an ascent sets -----------------------------------------------------------------

    def watch_ascent(self, now: float, depth: float | None, climbing: bool) -> str:
        """Why what is armed was set just now, or ""."""
        armed = {o.name: o.ascent for o in self.outputs.values() if o.ascent is not None}
        if not armed or not climbing:
            self._mark = None
            return ""
        if self._mark is None or self._gained(depth):
            self._mark = (now, depth)
        since, start = self._mark
        if start is None and depth is not None:
            self._mark = (since, depth)
        if now - since < WITHIN or all(self._by_hand[n] == level for n, level in armed.items()):
            return ""
        for name, level in armed.items():
            self.set_by_hand(name, level)
        return f"the ascent has gained less than {GAINS:g} m in {WITHIN:g} s"

    def _gained(self, depth: float | None) -> bool:
        start = self._mark[1] if self._mark is not None else None
        return depth is not None and start is not None and start - depth >= GAINS

    def next_timer(self) -> float | None:
        return None if self._mark is None else self._mark[0] + WITHIN
