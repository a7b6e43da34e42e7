"""A simulated vehicle in real time, or a multiple of it, on a CAN bus (links.can).

    MotorBoards <-- records of CAN frames -- can://GROUP?interface=udp_multicast, or socketcan
    SensorBoard <-- pty ------------------->                       (of the mainboard alone)

The motor boards receive frames from the bus and send none. The sensor board has a serial line.

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

LOOK_S = 0.01  # s of real time between two reads of the bus


def run_on_bus(
    vehicle: SimulatedBoard,
    url: str,
    speed: float,
    *,
    ready: Callable[..., None],
    stop: Callable[[], bool],
) -> None:
    """Run until ``stop`` returns True. Raises LinkError."""
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
    """Wait for a frame, or at most LOOK_S."""
    if fileno < 0:
        time.sleep(LOOK_S)
    else:
        select.select([fileno], [], [], LOOK_S)
