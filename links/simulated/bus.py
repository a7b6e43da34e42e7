"""A simulated vehicle in real time, or a multiple of it, on a CAN bus (links.can).

    MotorBoards <-- records of CAN frames -- can://GROUP?interface=udp_multicast, or socketcan

Its boards hear the bus and say nothing on it.

What does not live here: the boards (firmware/motors.py), vehicles on serial lines (pty.py).
"""

from __future__ import annotations

import select
import time
from collections.abc import Callable

from links import open_link
from links.simulated.boards import SimulatedBoard

LOOK_S = 0.01  # real, between two looks at the bus


def run_on_bus(
    vehicle: SimulatedBoard,
    url: str,
    speed: float,
    *,
    ready: Callable[[], None],
    stop: Callable[[], bool],
) -> None:
    """Until ``stop`` says so. Raises LinkError."""
    bus = open_link("vehicle", url)
    try:
        ready()
        zero = time.monotonic()
        while not stop():
            now = (time.monotonic() - zero) * speed
            vehicle.advance(now)
            for rx in bus.receive(now):
                vehicle.vehicle_link.send(rx.data, now)
            _wait(bus.fileno())
    finally:
        bus.close()


def _wait(fileno: int) -> None:
    """For a frame, or until it is time to look."""
    if fileno < 0:
        time.sleep(LOOK_S)
    else:
        select.select([fileno], [], [], LOOK_S)
