"""An operator's port, shared by all of a program's requests: one conversation at a time.

    a look          breaks off for any key press, and waits until that is over
    X, W            break off all else, an older order too, and retry until the port opens
    start, clear    break off a look, and are refused while an earlier key press is being sent

What does not live here: what is sent (orders, upload, looking), sockets (console).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from mission.topside.console import BrokenOff, Occupied, converse
from mission.topside.upload import OperatorError, Script

AGAIN_S = 0.25  # retry interval while another program has the port


class Port:
    """``press`` is called by one thread, in the order of the keys; ``look`` and ``say`` by any."""

    def __init__(self, url: str) -> None:
        self.url = url
        self._turn = threading.Lock()
        self._pressed = self._over = 0  # number of the newest press

    def look(self, script: Script) -> str:
        """Raises OperatorError."""
        with self._turn:
            return converse(self.url, script, self._newer_than(self._over))

    def press(self, *, urgent: bool) -> int:
        """Return the number to send it with. Raises OperatorError."""
        if self._pressed != self._over and not urgent:
            raise OperatorError("not said: what was pressed before is still being said")
        self._pressed += 1
        return self._pressed

    def say(self, script: Script, number: int, *, urgent: bool, tell: Callable[[str], None]) -> str:
        """Raises OperatorError, BrokenOff; ``tell`` gets the reason why an urgent order is not sent
        yet."""
        newer = self._newer_than(number)
        with self._turn:
            try:
                while not newer():
                    try:
                        return converse(self.url, script, newer)
                    except Occupied as error:
                        if not urgent:
                            raise
                        tell(f"NOT sent so far, tried until the port opens: {error}")
                        time.sleep(AGAIN_S)
                raise BrokenOff
            finally:
                self._over = max(self._over, number)

    def _newer_than(self, number: int) -> Callable[[], bool]:
        return lambda: self._pressed != number
