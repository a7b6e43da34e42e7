"""The simulated AUV as a process of its own, behind pseudo-terminals.

    python -m links.simulated [--profile as-built] [--seed 0] [--speed 1] [--set KEY=VALUE ...]
                              [--position LAT,LON] [--track FILE]

When it is ready it prints one JSON object: the paths of its pseudo-terminals, and the wall clock
(s since 1970 UTC) at its time 0. It runs until it gets SIGTERM or SIGINT (process.py).
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from links.simulated.link import PROFILES, SimulatedVehicle
from links.simulated.process import position, serve
from links.simulated.pty import ports
from links.simulated.settings import SettingError, parse_settings


def main() -> int:
    options = _options().parse_args()
    try:
        settings = parse_settings(options.set)
        place = position(options.position)
    except (SettingError, ValueError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    vehicle = SimulatedVehicle(options.profile, options.seed, settings, position=place)

    def ready(*paths: str) -> None:
        said = {**dict(zip(ports(vehicle), paths, strict=True)), "wall": time.time()}
        sys.stdout.write(json.dumps(said) + "\n")
        sys.stdout.flush()

    serve(vehicle, options.speed, ready, options.track)
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


if __name__ == "__main__":
    sys.exit(main())
