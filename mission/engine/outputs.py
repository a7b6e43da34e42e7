"""The level of each output of the vehicle file: who holds it now, and what has to be sent.

    emergency, end of the program   all outputs safe, but irreversible ones stay
    a mission under way             outputs that it names anywhere: as its active leg says
    all else                        as set by hand (@AO), safe until then; outputs that move or hold
                                    the vehicle beside its setpoint only under the stick

Outputs that a mission held are made safe when it is over. When the stick takes over, outputs that
move or hold the vehicle are made safe. The others stay until they are set by hand, or the stick is
over. An irreversible output is the operator's alone. If the vehicle file arms it, an ascent that
has gained less than 1 m in 120 s sets it once, also while the depth is unknown (R7).

Only changes are sent. At the start of the program, after the line was disconnected, and after an
operator's own command has set it (@DS, @RS), the level of an output is unknown: it is sent with the
next emergency, mission or @AO, or at the end of the program.

What does not live here: the engine's state (auxiliary), frames (protocol.vehicles), how often a
command is sent (onboard.runtime).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, Self

from mission.model import AUTONOMOUS
from mission.model.copies import copied
from mission.model.regions import EMERGENCY, MANUAL
from mission.model.vehicle import Output

GAINS, WITHIN = 1.0, 120.0  # m and s: a slower ascent needs the armed outputs (R7)

Levels = dict[str, float]


class Situation(NamedTuple):
    """What decides who holds which output. ``held``: the levels of the mission's active leg, also
    while the stick interrupts it; ``driving``: the stick is in use; ``safe``: the program is to
    end."""

    region: str
    emergency_at: float
    held: Mapping[str, float]
    driving: bool
    safe: bool


class OutputKeeper:
    """The levels of ``outputs``, which are the vehicle file's."""

    def __init__(self, outputs: tuple[Output, ...]) -> None:
        self.outputs = {output.name: output for output in outputs}
        self._by_hand: Levels = {output.name: output.safe for output in outputs}
        self.said: Levels = dict(self._by_hand)  # the level last sent to each
        # Those levels may be wrong: what an earlier program has sent is unknown.
        self.doubt()
        self._passed: set[str] = set()  # set by an operator's own command since
        self._holder: tuple[str, float, bool] | None = None
        self._found: Levels = {}  # levels of the interrupted mission, kept under the stick
        self._touched: tuple[str, ...] = ()  # set by hand since the last look
        self._mark: tuple[float, float | None] | None = None  # of an ascent: when, how deep

    def clone(self) -> Self:
        return copied(self, outputs=self.outputs)

    def doubt(self) -> None:
        """Note that the outputs may differ from what was sent. An irreversible output that was
        never set does not count: nothing is sent to it."""
        self._doubtful = {
            name
            for name, o in self.outputs.items()
            if not o.irreversible or self._by_hand[name] != o.safe
        }

    def pass_by(self, channels: Iterable[str]) -> None:
        """Note that an operator's own command sets the outputs on these channels. Its levels stay
        until the holder of the outputs changes."""
        self._passed |= {o.name for o in self.outputs.values() if o.channel in channels}

    def told(self, name: str) -> float | None:
        """The level of this output; None if it is not known."""
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
        self._doubtful.add(name)  # sent even if it has this level
        self._touched = (*self._touched, name)

    def changes(self, at: Situation) -> Levels:
        """Return the levels that have to be sent now."""
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
        """Set the armed outputs if the ascent gains too little. Return why; "" if it set none."""
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
