"""A simulated vehicle as a process: it runs until a signal, and then may write its true track.

What does not live here: command lines (__main__, the command vehicle), pseudo-terminals (pty).
"""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Sequence
from pathlib import Path

from links.simulated.boards import SimulatedBoard
from links.simulated.bus import run_on_bus
from links.simulated.link import HOME, Truth
from links.simulated.pty import Simulated, run_on_ptys


def serve(
    vehicle: Simulated, speed: float, ready: Callable[..., None], track: Path | None = None
) -> int:
    """Run until SIGTERM or SIGINT; returns which. ``ready`` gets the paths of its lines. ``track``:
    file for the true track, once a second: t (s), latitude, longitude (deg), depth (m)."""
    told = told_to_end()
    run_on_ptys(vehicle, speed, ready=ready, stop=lambda: bool(told))
    if track is not None:
        track.write_text(_text(vehicle.track), encoding="ascii")
    return told[0]


def serve_on_bus(
    vehicle: SimulatedBoard,
    url: str,
    speed: float,
    ready: Callable[..., None],
    track: Path | None = None,
) -> int:
    """The same as ``serve``, on a CAN bus. Raises LinkError."""
    told = told_to_end()
    run_on_bus(vehicle, url, speed, ready=ready, stop=lambda: bool(told))
    if track is not None:
        track.write_text(_text(vehicle.track), encoding="ascii")
    return told[0]


def told_to_end() -> list[int]:
    """Return a list that gets each SIGTERM and SIGINT of this process when it comes."""
    told: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda received, _: told.append(received))
    return told


def position(text: str | None) -> tuple[float, float]:
    """LAT,LON in deg to rad; without a text, HOME. Raises ValueError."""
    if text is None:
        return HOME
    latitude, comma, longitude = text.partition(",")
    if not comma:
        raise ValueError(f"{text!r}: write LAT,LON in degrees")
    place = math.radians(float(latitude)), math.radians(float(longitude))
    if not (abs(place[0]) <= math.pi / 2 and abs(place[1]) <= math.pi):
        raise ValueError(f"{text!r}: no place on earth")
    return place


def _text(track: Sequence[Truth]) -> str:
    rows = ["t,latitude_deg,longitude_deg,depth_m"]
    rows += [
        f"{p.t:.1f},{math.degrees(p.latitude):.8f},{math.degrees(p.longitude):.8f},{p.depth:.3f}"
        for p in track
    ]
    return "\n".join(rows) + "\n"
