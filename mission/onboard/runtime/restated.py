"""Commands that set an output and are not acknowledged: each is sent three times (R18).

    lamp -> frame, 2 s, frame, 2 s, frame     a newer command for the same output replaces it

A stop does not clear them: an emergency sends the safe outputs after its own commands. What does
not live here: when the line is free for them (frontseat, repeater).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass

from protocol.messages import Outputs

TIMES, AGAIN_S = 3, 2.0
TakeOutputs = Callable[[Outputs], Mapping[str, bytes]]  # their own frames, by what they set


def no_outputs(wanted: Outputs) -> Mapping[str, bytes]:
    """For a vehicle whose file names no outputs."""
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
        self.words: dict[str, _Word] = {}  # by what they set; for reading alone

    def add(self, frames: Mapping[str, bytes], reason: str) -> None:
        """Queue frames, due at once; ``frames`` by what they set."""
        for sets, data in frames.items():
            self.words.pop(sets, None)  # behind the others
            self.words[sets] = _Word(data, reason, 0.0)

    def give_way(self, channels: Set[str]) -> None:
        """Yield to a newer command for these: frames already sent are dropped, others sent once."""
        for sets in channels & self.words.keys():
            if self.words[sets].said:
                del self.words[sets]
            else:
                self.words[sets].times = 1

    def take(self, now: float) -> tuple[bytes, str] | None:
        """The next frame that is due, with its reason; None if none is."""
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
