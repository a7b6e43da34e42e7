"""Words of other systems, and what to write here instead: each word is a row.

    LEG       in a leg or at the start of a line      lawnmower -> rows 4 bearing 90 ...
    SAFETY    behind safety                           battery -> voltage 11
    TOP       keys of a YAML mission                  steps -> legs
    HANDLER   keys of a handler in YAML               then -> do

The right-hand texts are for lines; ``as_key`` turns one into YAML keys.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from mission.authoring.language.words import LIMITS, leg_words

_GO = "until depth > 5 -> name"
_ROWS = "rows 4 bearing 90 length 100 spacing 20"
_LOITER = "loiter home radius 20"
_KIND = "goto home or loiter home radius 20"

LEG: Mapping[str, str] = MappingProxyType(
    {
        "ahead": "gear 4",
        "ascend": "surface",
        "attitude": "pitch 5 roll -3",
        "back": "gear -4",
        "battery": "until battery < 11 -> name",
        "circle": _LOITER,
        "course": "heading 90",
        "dive": "depth 5",
        "duration": "for 60s",
        "forward": "gear 4",
        "heave": "up 4 or down 4",
        "hover": "gear 0",
        "if": _GO,
        "kind": _KIND,
        "lawnmower": _ROWS,
        "loop": "repeat 3 name:",
        "max_time": "timeout 60s",
        "mow": _ROWS,
        "orbit": _LOITER,
        "pause": "wait 30s",
        "rtl": "goto home",
        "sleep": "wait 30s",
        "station_keep": _LOITER,
        "stationkeep": _LOITER,
        "surge": "gear 4",
        "survey": _ROWS,
        "then": f"the way on behind its guard: {_GO}",
        "thrust": "gear 4",
        "track": "follow home, north 10 east 20",
        "turn": "left 4, right 4 or heading 90",
        "type": _KIND,
        "velocity": "speed 0.5",
        "waypoint": "goto north 10 east 20",
        "waypoints": "follow home, north 10 east 20",
        "when": _GO,
        "while": "until depth > 5",
        "yaw": "heading 90",
    }
)
CONTROL = frozenset({"if", "loop", "repeat", "then", "when", "while"})  # never a name
GROUP = "- name: {repeat: 3, legs: [...]}"

TREND: Mapping[str, str] = MappingProxyType(  # behind a variable
    {
        **dict.fromkeys(("decreases", "drop", "drops", "fall", "sinks"), "falls"),
        **dict.fromkeys(("climbs", "grows", "increases", "jumps", "rise"), "rises"),
    }
)
SAFETY: Mapping[str, str] = MappingProxyType(
    {
        "battery": "voltage 11",
        "distance": "radius 300",
        "duration": "time 30min",
        "max_depth": "depth 20",
        "max_distance": "radius 300",
        "max_radius": "radius 300",
        "max_range": "radius 300",
        "max_time": "time 30min",
        "min_voltage": "voltage 11",
        "range": "radius 300",
    }
)
TOP: Mapping[str, str] = MappingProxyType(
    {
        "events": "on",
        "handlers": "on",
        "limits": "safety",
        "name": "mission",
        "parameters": "param",
        "params": "param",
        "plan": "legs",
        "steps": "legs",
        "tasks": "legs",
        "waypoints": "legs",
    }
)
HANDLER: Mapping[str, str] = MappingProxyType(
    {
        "action": "do",
        "condition": "when",
        "duration": "held",
        "else": "do, in a handler of its own",
        "event": "when",
        "for": "held",
        "goto": "do",
        "guard": "when",
        "if": "when",
        "on": "when",
        "then": "do",
        "until": "when",
    }
)
PLACE: Mapping[str, str] = MappingProxyType(
    {
        "lat": "latitude",
        "lon": "longitude",
        "lng": "longitude",
        "long": "longitude",
        "n": "north",
        "e": "east",
        "x": "north",
        "y": "east",
    }
)
UNIT: Mapping[str, str] = MappingProxyType(
    {
        "deg.": "deg",
        "degree": "deg",
        "degrees": "deg",
        "feet": "m (1 ft is 0.3048 m)",
        "foot": "m (1 ft is 0.3048 m)",
        "ft": "m (1 ft is 0.3048 m)",
        "hour": "h",
        "hours": "h",
        "hr": "h",
        "kilometers": "km",
        "kilometres": "km",
        "knot": "kn",
        "knots": "kn",
        "kt": "kn",
        "kts": "kn",
        "meter": "m",
        "meters": "m",
        "metre": "m",
        "metres": "m",
        "minute": "min",
        "minutes": "min",
        "mins": "min",
        "mps": "m/s",
        "sec": "s",
        "second": "s",
        "seconds": "s",
        "secs": "s",
        "volt": "V",
        "volts": "V",
    }
)


def no_name(word: str) -> str:
    """The message for a control word in the place of a leg's name."""
    return f"{word!r} is no leg's name"


def as_key(words: str) -> str:
    """``rows 4 bearing 90`` -> ``rows: 4, bearing: 90``."""
    if words.startswith("repeat"):
        return GROUP
    if words.startswith("follow"):
        return "follow: [home, north 10 east 20]"
    known = "|".join(sorted(map(re.escape, {*leg_words(), *LIMITS}), key=len, reverse=True))
    keyed = re.sub(rf"\b({known}) (?=[-\w])", r"\1: ", words)
    return re.sub(r"(?<=[\w%]) (?=(?:" + known + r"): )", ", ", keyed).replace("or, ", "or ")
