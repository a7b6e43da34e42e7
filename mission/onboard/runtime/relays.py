"""Relayed commands of operators that wait for the line: R, rudders, M (R14, R6).

    M before R and rudders; commands for the same thruster or servo in the order they came
    a newer command replaces those that set nothing else    @DS1,10  @DS1,12  ->  @DS1,12
    an increment is never replaced                          @DA1,2   @DA1,2   ->  both
    more than 8 increments at a time are refused

So the queue is bounded by the number of thrusters and servos, however fast a slider moves, and the
last command for each of them is the last that leaves.

What does not live here: when the line is free for them (frontseat), what the commands mean.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from protocol.vehicles.auv_outputs import POWER

INCREMENTS = 8  # that may wait: a quarter of a second at 9600 bit/s

_MAINS = frozenset({"thruster 1", "thruster 2"})
_VERTICALS = frozenset({"thruster 3", "thruster 4", "thruster 5"})
_SETS = {
    **{f"@MM{way}": _MAINS if way in "FB" else _VERTICALS for way in "FBUD"},
    **{f"@MR{way}": _MAINS if way in "LR" else _VERTICALS for way in "LRFBUD"},
    "@MS": _MAINS,
    "@MP": _VERTICALS,
}
_CHANNELS = {
    "servo 1": ("rudder_left_deg",),
    "servo 2": ("rudder_right_deg",),
    "@RS": ("power", *POWER),
}
_SERVO = re.compile(rb"@M?D([AS])(-?\d+)")
_THRUSTER = re.compile(rb"@MT(-?\d+)")


@dataclass(frozen=True, slots=True)
class _Word:
    data: bytes
    reason: str
    manual: bool
    sets: frozenset[str]
    adds: bool  # to what was set before

    def replaces(self, other: _Word) -> bool:
        return not other.adds and other.sets <= self.sets and other.manual <= self.manual


def word(data: bytes, reason: str, manual: bool) -> _Word:
    """What a frame of tables 1.2.1 and 1.2.2 sets; for another kind of frame, the frame itself."""
    if servo := _SERVO.match(data):
        both = {"servo 1", "servo 2"}
        sets = frozenset({f"servo {int(servo[2])}"} if int(servo[2]) < 3 else both)
        return _Word(data, reason, manual, sets, servo[1] == b"A")
    if thruster := _THRUSTER.match(data):
        sets = frozenset({f"thruster {int(thruster[1])}"})
        return _Word(data, reason, manual, sets, False)
    text = data.decode("ascii", "replace")
    sets = _SETS.get(text[:4]) or _SETS.get(text[:3]) or frozenset({text[:3]})
    return _Word(data, reason, manual, sets, False)


def channels_of(data: bytes) -> frozenset[str]:
    """The AUV's outputs that a frame sets, and the keys of their frames (vehicles.auv_outputs)."""
    sets = word(data, "", False).sets
    return frozenset(channel for one in sets for channel in _CHANNELS.get(one, ()))


class Relays:
    def __init__(self) -> None:
        self.waiting: list[_Word] = []  # for reading alone

    def __len__(self) -> int:
        return len(self.waiting)

    def clear(self) -> None:
        self.waiting.clear()

    def add(self, data: bytes, reason: str, manual: bool) -> str:
        """Queue a frame; why it is refused, "" if it is not."""
        new, waiting = word(data, reason, manual), self.waiting
        if new.adds and sum(old.adds for old in waiting) >= INCREMENTS:
            return f"{INCREMENTS} increments wait for the line: set the angle (@DS, @MDS) instead"
        replaced = [] if new.adds else [old for old in waiting if new.replaces(old)]
        place = waiting.index(replaced[0]) if replaced else len(waiting)
        behind = [old for old in waiting[place:] if old not in replaced]
        if any(old.sets & new.sets for old in behind):
            place = len(waiting)
        before = [old for old in waiting[:place] if old not in replaced]
        after = [old for old in waiting[place:] if old not in replaced]
        self.waiting = [*before, new, *after]
        return ""

    def take(self) -> tuple[bytes, str]:
        """Remove and return the next to leave, with its reason. Raises IndexError if none waits."""
        first = next((w for w in self.waiting if w.manual), self.waiting[0])
        next_ = next(w for w in self.waiting if w.sets & first.sets)
        self.waiting.remove(next_)
        return next_.data, next_.reason
