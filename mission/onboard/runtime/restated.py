"""Commands that set an output and are not acknowledged: each is sent three times (R18).

    lamp -> word, 2 s, word, 2 s, word        a newer word for the same thing takes its place

Not among what a stop clears: an emergency says its safe outputs behind its own words. What does not
live here: when the line is free for them (frontseat, repeater).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass

from protocol.messages import Outputs

TIMES, AGAIN_S = 3, 2.0
TakeOutputs = Callable[[Outputs], Mapping[str, bytes]]  # the frames of their own, by what they set


def no_outputs(wanted: Outputs) -> Mapping[str, bytes]:
    """Of a vehicle whose file names none."""
    return {}


@dataclass(slots=True)
class _Word:
    data: bytes
    reason: str
    due: float
    said: int = 0
    times: int = TIMES


class Restated:
    def __init__(self) -> None:
        self.words: dict[str, _Word] = {}  # by what they set; to be looked at

    def add(self, frames: Mapping[str, bytes], reason: str) -> None:
        """At once; ``frames`` by what they set."""
        for sets, data in frames.items():
            self.words.pop(sets, None)  # behind the others
            self.words[sets] = _Word(data, reason, 0.0)

    def give_way(self, channels: Set[str]) -> None:
        """To a newer word for these: what has been said is said no more, the others once."""
        for sets in channels & self.words.keys():
            if self.words[sets].said:
                del self.words[sets]
            else:
                self.words[sets].times = 1

    def take(self, now: float) -> tuple[bytes, str] | None:
        """The next that is due, with its reason."""
        sets = next((s for s, word in self.words.items() if word.due <= now), None)
        if sets is None:
            return None
        word = self.words[sets]
        again = f" ({word.said + 1} of {TIMES})" if word.said else ""
        word.said, word.due = word.said + 1, now + AGAIN_S
        if word.said == word.times:
            del self.words[sets]
        return word.data, word.reason + again

    def next_timer(self) -> float | None:
        return min(word.due for word in self.words.values()) if self.words else None
