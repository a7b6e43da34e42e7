"""An example of every command, for the end of its ``--help``.

docs/reference/commands.md shows each. The tests run it there, or look up its options.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_BOAT = "--to tcp://vehicle:4000"

EXAMPLES: Mapping[str, str] = MappingProxyType(
    {
        "demo": "demo lawnmower --speed 8",
        "simulate": "simulate first-dive --set current=0.3@45 --report out",
        "rehearse": "rehearse first-dive --flights 4 --workers 1 -o rehearsal.png",
        "vehicle": "vehicle rov",
        "water": "water --range 500 --loss 0.1",
        "check": "check first-dive",
        "convert": "convert first-dive",
        "fmt": "fmt --check mine.yaml",
        "schema": "schema > mission.schema.json",
        "import": "import buoy.gpx --home 30.28746,120.15358 --depth 5m --gear 6 -o buoy.yaml",
        "graph": "graph first-dive -o first-dive.svg",
        "plan": "plan first-dive -o first-dive-plan.svg",
        "diff": "diff mine.yaml new.yaml",
        "serve": "serve --config /etc/auvmission/serve.yaml",
        "upload": f"upload missions/harbour-survey.yaml {_BOAT}",
        "start": f"start {_BOAT}",
        "clear": f"clear {_BOAT}",
        "status": f"status {_BOAT}",
        "stop": f"stop {_BOAT}",
        "surface": f"surface {_BOAT}",
        "limits": f"limits --depth 8 --radius 200 {_BOAT}",
        "time": f"time {_BOAT}",
        "nodes": f"nodes CAMERA=open {_BOAT}",
        "power": f"power light=on {_BOAT}",
        "rudder": f"rudder both 5 {_BOAT}",
        "output": f"output lamp 40 {_BOAT}",
        "send": f"send DU {_BOAT}",
        "stick": f"stick {_BOAT}",
        "monitor": "monitor tcp://vehicle:4001",
        "log": 'log out/flight.mcap --text "now autonomous"',
        "story": "story out/flight.mcap",
        "watch": f"watch tcp://vehicle:4001 {_BOAT}",
        "console": f"console {_BOAT}",
        "chart": "chart US5MA11M.000 -o boston.geojson",
        "foxglove": "foxglove --to 20250111T085611Z.mcap",
        "replay": "replay out/flight.mcap",
        "decode": "decode --link auv.to_stm32 -",
        "encode": """encode auv.ZA '{"code": "F", "gear": 5}'""",
        "listen": "listen serial:///dev/ttyUSB0 --link auv.from_stm32",
        "find-crc": "find-crc capture.bin",
        "report": "report 20250111T085611Z.mcap",
        "export": "export out/flight.mcap -o out/files --as csv --as gpx",
        "calibrate": "calibrate one.mcap two.mcap -o section.yaml",
        "score": "score recordings/",
        "exhaustive": "exhaustive missions/first-dive.yaml",
        "doctor": "doctor --config /etc/auvmission/serve.yaml",
        "campaign": "campaign harbour-survey --missions 1 --flights 20",
        "faults": "faults --flights 50 --seed 7",
        "keys": "keys keys --boat deck --boat tablet",
    }
)


def epilog(command: str) -> str:
    """The end of a help page. Click does not wrap it, so that it can be copied."""
    return f"\b\nExample:\n  auvmission {EXAMPLES[command]}"
