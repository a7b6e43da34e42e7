"""Somebody at the Pi's end of the simulated serial line, for the tests of both boards."""

from __future__ import annotations

import struct
from dataclasses import replace

from links.simulated.link import SimulatedVehicle, Truth
from links.simulated.sea import Sea
from links.simulated.sensors import SensorErrors
from links.simulated.settings import Settings

EXACT = replace(
    SensorErrors(),
    declination=0.0, compass_bias=0.0, compass_noise=0.0, compass_slow=0.0, deviation=0.0, depth_bias=0.0,
    depth_noise=0.0,
)  # fmt: skip


class Pi:
    """Somebody at the other end of the line, who waits between commands."""

    def __init__(self, profile: str, *, splice: float = 0.0, depth: float | None = None) -> None:
        settings = Settings(Sea(floor=60.0), EXACT, splice=splice)
        self.vehicle = SimulatedVehicle(profile, 3, settings)
        self.now = 0.0
        self.heard: list[bytes] = []
        self.wait(1.5)
        if depth is not None:
            self.vehicle.plant.depth = depth

    def wait(self, seconds: float) -> list[bytes]:
        """What was heard meanwhile."""
        self.now += seconds
        heard = [rx.data for rx in self.vehicle.vehicle_link.receive(self.now)]
        self.heard += heard
        return heard

    def say(self, data: bytes, wait: float = 0.25) -> list[bytes]:
        """The answers within ``wait``, without the telemetry."""
        self.vehicle.vehicle_link.send(data, self.now)
        return [frame for frame in self.wait(wait) if not frame.startswith(b"@SD")]

    @property
    def pwm(self) -> tuple[int, ...]:
        return self.vehicle.stm32.pwm

    @property
    def truth(self) -> Truth:
        return self.vehicle.truth()

    def report(self) -> tuple[float, ...]:
        """The fields of the next @SD."""
        self.wait(2.1)
        frame = next(frame for frame in reversed(self.heard) if frame.startswith(b"@SD"))
        return struct.unpack_from("<15f9H", frame, 3)
