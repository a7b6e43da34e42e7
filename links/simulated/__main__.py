"""The simulated vehicle as a process of its own, behind two pseudo-terminals.

    python -m links.simulated [--profile as-built] [--seed 0] [--speed 1] [--set KEY=VALUE ...]
                              [--position LAT,LON] [--track FILE]

One JSON object on stdout when it is ready: the paths of both pseudo-terminals, and the wall clock
(s since 1970 UTC) at its time 0. It runs until it is terminated, and then writes where it truly
was, once a second, to the track file: t, latitude, longitude (deg), depth (m).
"""

from __future__ import annotations

import argparse
import json
import math
import signal
import sys
import time
from pathlib import Path

from links.simulated.link import HOME, PROFILES, SimulatedVehicle, Truth
from links.simulated.pty import run_on_ptys
from links.simulated.settings import SettingError, parse_settings


def main() -> int:
    options = _options().parse_args()
    try:
        settings = parse_settings(options.set)
        position = _position(options.position)
    except (SettingError, ValueError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    vehicle = SimulatedVehicle(options.profile, options.seed, settings, position=position)
    stopped: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda received, _: stopped.append(received))

    def ready(stm32: str, gps: str) -> None:
        said = {"vehicle": stm32, "gps": gps, "wall": time.time()}
        sys.stdout.write(json.dumps(said) + "\n")
        sys.stdout.flush()

    run_on_ptys(vehicle, options.speed, ready=ready, stop=lambda: bool(stopped))
    if options.track is not None:
        options.track.write_text(_track(vehicle.track), encoding="ascii")
    return 0


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m links.simulated", description="The simulated vehicle, in real time."
    )
    parser.add_argument("--profile", choices=sorted(PROFILES), default="as-built")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--speed", type=float, default=1.0, help="times real time")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--position", metavar="LAT,LON", help="deg; where it lies at time 0")
    parser.add_argument("--track", type=Path, metavar="FILE")
    return parser


def _position(text: str | None) -> tuple[float, float]:
    if text is None:
        return HOME
    latitude, comma, longitude = text.partition(",")
    if not comma:
        raise ValueError(f"--position {text!r}: write LAT,LON in degrees")
    return math.radians(float(latitude)), math.radians(float(longitude))


def _track(track: list[Truth]) -> str:
    rows = ["t,latitude_deg,longitude_deg,depth_m"]
    rows += [
        f"{p.t:.1f},{math.degrees(p.latitude):.8f},{math.degrees(p.longitude):.8f},{p.depth:.3f}"
        for p in track
    ]
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    sys.exit(main())
