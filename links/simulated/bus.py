"""A simulated vehicle in real time, or a multiple of it, on a CAN bus (links.can).

    MotorBoards <-- records of CAN frames -- can://GROUP?interface=udp_multicast, or socketcan
    SensorBoard <-- pty ------------------->                       (of the mainboard alone)

Its motor boards hear the bus and say nothing on it; the sensor board has a line of its own.

What does not live here: the boards (firmware/motors.py), vehicles on serial lines (pty.py).
"""

from __future__ import annotations

import select
import time
from collections.abc import Callable

from links import open_link
from links.simulated.boards import SimulatedBoard
from links.simulated.firmware.sensor_board import SensorBoard
from links.simulated.pty import PtyVehicle

LOOK_S = 0.01  # real, between two looks at the bus


def run_on_bus(
    vehicle: SimulatedBoard,
    url: str,
    speed: float,
    *,
    ready: Callable[..., None],
    stop: Callable[[], bool],
) -> None:
    """Until ``stop`` says so. Raises LinkError."""
    bus = open_link("vehicle", url)
    try:
        with PtyVehicle(vehicle, speed) as line:
            ready(*(line.paths if isinstance(vehicle.board, SensorBoard) else ()))
            zero = time.monotonic()
            while not stop():
                now = (time.monotonic() - zero) * speed
                line.step(now)
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
