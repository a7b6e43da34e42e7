"""Run a server in the foreground of this process until a signal ends it.

What does not live here: what a signal means (serve, leaving).
"""

from __future__ import annotations

import asyncio
import signal
import sys

from mission.onboard.serve.serve import Server

# s until the threads of disk and check yield to the event loop, instead of Python's 5 ms. Without
# it half of all timers are two to five times as late beside a busy thread (bench_tricks.py).
SWITCH_S = 0.0005


def run(server: Server) -> None:
    """Run the server until SIGINT or SIGTERM."""

    async def main() -> None:
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(number, server.stop)
        if hasattr(signal, "SIGHUP"):  # the terminal may be at the other end of a radio
            loop.add_signal_handler(signal.SIGHUP, server.hang_up)
        await server.run()

    sys.setswitchinterval(SWITCH_S)
    asyncio.run(main())
