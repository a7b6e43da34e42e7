"""The acoustic channel of links.acoustic between two processes, in real time.

    boat <-- pty --> [modem ))) water ((( modem] <-- pty --> vehicle
                      a burst ends when its writer pauses for ``PAUSE_S``

What does not live here: delay, loss, collisions (links.acoustic), the envelope (protocol).
"""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType

from links.acoustic import MTU, AcousticLink, Tally, Water, acoustic_pair
from links.simulated.pty import open_pty

PAUSE_S = 0.03
ENDS = ("boat", "vehicle")
_READ, _LONGEST_S = 4096, 0.1

Told = Callable[[str, int, float], None]  # name of the end, bytes sent, s of airtime


class _Modem:
    """One end. It gathers the bytes that its computer writes into bursts."""

    def __init__(self, link: AcousticLink, told: Told) -> None:
        self.link, self._told = link, told
        self.master, self._slave = open_pty()
        self.path = os.ttyname(self._slave)
        self._burst, self._ends = bytearray(), 0.0

    @property
    def due(self) -> float | None:
        """When its burst ends or a burst arrives, s; None: nothing is pending."""
        times = (self._ends if self._burst else None, self.link.next_event())
        return min((t for t in times if t is not None), default=None)

    def step(self, now: float) -> None:
        with suppress(BlockingIOError):
            self._burst += os.read(self.master, _READ)
            self._ends = now + PAUSE_S
        if self._burst and (now >= self._ends or len(self._burst) >= MTU):
            self._say(bytes(self._burst[:MTU]), now)
            del self._burst[:MTU]
        for rx in self.link.receive(now):
            self._write(rx.data)

    def close(self) -> None:
        os.close(self.master)
        os.close(self._slave)

    def _say(self, data: bytes, now: float) -> None:
        self.link.send(data, now)
        self._told(self.link.name, len(data), self.link.water.airtime(len(data)))

    def _write(self, data: bytes) -> None:
        with suppress(BlockingIOError):  # nobody reads: a real line would lose it too
            os.write(self.master, data)


class Channel:
    """Both modems and their pseudo-terminals. ``paths``: the boat's and the vehicle's."""

    def __init__(
        self, water: Water, seed: int = 0, told: Told = lambda name, size, airtime: None
    ) -> None:
        self._modems = [_Modem(link, told) for link in acoustic_pair(water, seed, ENDS)]
        self.paths = tuple(modem.path for modem in self._modems)

    def __enter__(self) -> Channel:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for modem in self._modems:
            modem.close()

    @property
    def tallies(self) -> dict[str, Tally]:
        return {modem.link.name: modem.link.tally for modem in self._modems}

    def run(self, stop: Callable[[], bool] = lambda: False) -> None:
        """Run until ``stop`` returns True; it is called at least ten times a second."""
        masters = [modem.master for modem in self._modems]
        while not stop():
            now = time.monotonic()
            for modem in self._modems:
                modem.step(now)
            dues = [due for modem in self._modems if (due := modem.due) is not None]
            wait = min([due - now for due in dues], default=_LONGEST_S)
            select.select(masters, [], [], min(max(wait, 0.0), _LONGEST_S))
