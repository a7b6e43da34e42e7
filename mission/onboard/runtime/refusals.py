"""The last item of ``@AR``: what the vehicle refuses, and since when. Sans-IO.

    AA: no mission is stored                  just now
    AA: no mission is stored; 35 s ago        later, also to a peer that was not connected
    X: a report shows ...                     instead of others, while a stop is not obeyed

A refusal ends when the same command is accepted (of a line: when all are stored), or when a mission
is stored, started or cleared.

What does not live here: who asks (operator_server), what contradicts a stop (engine).
"""

from __future__ import annotations

from mission.onboard.runtime.command_target import REFUSAL_CHARACTERS, one_line

NEW_S = 2.0
DOUBT_S = 5.0  # s: two reports of the slowest board
LINE, ENDS_ALL = "AW", frozenset({"AA", "AC"})
UNOBEYED = "X: a report shows way after the stop; it is sent again and again"


class Refusals:
    def __init__(self) -> None:
        self._code, self._words, self._t = "", "", 0.0

    def note(self, code: str, why: str, now: float) -> None:
        self._code, self._words, self._t = code, one_line(f"{code}: {why}"), now

    def accepted(self, code: str) -> None:
        if (code == self._code and code != LINE) or code in ENDS_ALL:
            self.end()

    def end(self) -> None:
        self._code = self._words = ""

    @property
    def last(self) -> tuple[str, float]:
        """The text, and when it was noted."""
        return self._words, self._t

    def told(self, now: float, doubted_at: float) -> str:
        """The text for ``@AR``. ``doubted_at``: when a report last contradicted a stop."""
        if now - doubted_at <= DOUBT_S:
            return UNOBEYED
        age = now - self._t
        if not self._words or age < NEW_S:
            return self._words
        ago = f"; {in_words(age)} ago"
        return self._words[: REFUSAL_CHARACTERS - len(ago)] + ago


def refused_set(frame: bytes, meaning: str) -> str:
    """``frame``: the frame that the vehicle answered N, or why the set cannot be encoded."""
    text = frame.decode("ascii", "replace")
    said = f"the vehicle refused {text}" if frame.startswith(b"@") else f"no word for it: {text}"
    return f"{said}: {meaning}" if meaning else said


def in_words(seconds: float) -> str:
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200.0 else f"{seconds / 3600:.0f} h"
