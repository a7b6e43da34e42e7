"""A server in the foreground of this process, until a signal ends it.

What does not live here: what a signal means (serve, leaving).
"""

from __future__ import annotations

import asyncio
import signal
import sys

from mission.onboard.serve.serve import Server

# s: the disk's and the judge's threads give way to the loop so soon, and not after Python's 5 ms.
# Beside a busy thread half of all timers are two to five times as late without (bench_tricks.py).
SWITCH_S = 0.0005


def run(server: Server) -> None:
    """In the foreground, until SIGINT or SIGTERM."""

    async def main() -> None:
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(number, server.stop)
        if hasattr(signal, "SIGHUP"):  # the terminal may be at the other end of a radio
            loop.add_signal_handler(signal.SIGHUP, server.hang_up)
        await server.run()

    sys.setswitchinterval(SWITCH_S)
    asyncio.run(main())
