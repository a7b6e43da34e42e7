"""The stick of a page, on its way to the helm: old values move nothing.

    axes of a page, with the time of the hand --> Push, while they are fresh, ours and answered
    none for ``FRESH_S``, let go, refused      --> None: the helm ends, and the vehicle's 2 s (R6)

A reason to refuse lasts until the hand is let go. A page that was silent for a while, and continues
with the hand where it was, has not let go. Only one page has the stick at a time.
"""

from __future__ import annotations

from typing import Any

from mission.console.line import Line
from mission.topside.helm import Push

FRESH_S = 0.5
ANSWERED_S = 2.0
OURS = ("asker", "nobody")


class Steering:
    """``line``: the line of commands. Times are of the monotonic clock."""

    def __init__(self, line: Line) -> None:
        self._line = line
        self._push: Push | None = None
        self._moved = 0.0
        self.holder = ""
        self._why = ""

    def axes(self, page: str, push: Push | None, moved: float, now: float) -> None:
        """``moved``: when the hand was there. None: it is let go."""
        if push is None:
            self.let_go(page)
            return
        if self.holder not in ("", page):
            return
        self.holder = page
        self._push, self._moved = push, max(moved, self._moved)
        self.hold(now)

    def let_go(self, page: str) -> None:
        if page == self.holder:
            self._push, self.holder, self._why = None, "", ""
            self._line.helm.hold(None)
            self._line.stir()

    def drop(self) -> None:
        """After X or W: be silent at once, until the hand is let go."""
        if self._push is not None:
            self._why = self._why or "an order was given"
        self._line.helm.drop()

    def hold(self, now: float) -> None:
        """Call it regularly: it passes the push to the helm, or ends it."""
        if self._push is None:
            return
        if now - self._moved > FRESH_S and not self._why:
            self.let_go(self.holder)
            return
        self._why = self._why or self._refusal(now)
        if self._why:
            self._line.helm.drop()
        else:
            self._line.helm.hold(self._push)
        self._line.stir()

    def _refusal(self, now: float) -> str:
        line = self._line
        if line.acoustics is not None:
            return "the stick does not work by modem"
        silence = line.silence(now)
        if silence is None or silence > ANSWERED_S:
            return "the vehicle does not answer"
        if line.is_uploading:
            return "an upload is under way"
        if line.state is None:
            return "it is not known who commands: the vehicle tells no state"
        if line.state.commander not in OURS:
            return f"another commands ({line.state.commander})"
        if line.helm.is_locked:
            return "an order was given, or the connection was lost"
        return ""

    def told(self, page: str, now: float) -> dict[str, Any]:
        """Return the state of the stick for a page."""
        line = self._line
        silence = line.silence(now)
        age = None if silence is None else round(silence, 1)
        if self.holder not in ("", page):
            return {"is": "refused", "says": "another page has the stick", "sent": "", "age": age}
        if self._why:
            return {"is": "refused", "says": f"{self._why}; let go first", "sent": "", "age": age}
        if self._push is None or self.holder != page:
            return {"is": "ready", "says": "", "sent": "", "age": age}
        driving = "ready" if line.helm.is_silent else "driving"
        return {"is": driving, "says": "", "sent": line.sent.decode("ascii"), "age": age}
