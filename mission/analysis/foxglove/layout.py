"""The layout that is shipped: which panel shows which field, in Foxglove's layout format.

Panels that plot name fields as ``topic.field``. A test checks that each topic and field exists.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mission.onboard.stream import topics

_DEPTHS = ("state.depth_m", "telemetry.depth_m", "state.altitude_m")
_MARGINS = ("state.to_depth_m", "state.to_radius_m", "state.to_time_s", "state.to_voltage_v")
_POSITION = ("state.radius_95_m", "state.fix_age_s")
_ATTITUDE = ("telemetry.heading_deg", "telemetry.pitch_deg", "telemetry.roll_deg")
_BATTERIES = ("telemetry.control_v", "telemetry.power_v")


def layout() -> Mapping[str, Any]:
    """Return the layout, which can be imported as JSON."""
    panels = {
        "Map!place": {
            "followTopic": topics.POSITION,
            "disabledTopics": [],
            "topicConfig": {n: {} for n in (topics.POSITION, topics.FIXES, topics.PLAN)},
        },
        "StateTransitions!state": {"paths": _paths(("state.state", "state.leg"))},
        "RosOut!log": {"topicToRender": topics.JOURNAL, "minLogLevel": 1, "searchTerms": []},
        "RawMessages!state": {"topicPath": topics.STATE, "diffEnabled": False},
        "Plot!depth": _plot("depth and altitude, m", _DEPTHS),
        "Plot!margins": _plot("left to the limits", _MARGINS),
        "Plot!position": _plot("95 % radius, m; age of the fix, s", _POSITION),
        "Plot!attitude": _plot("attitude, deg", _ATTITUDE),
        "Plot!batteries": _plot("batteries, V", _BATTERIES),
    }
    left = _split("column", "Map!place", "StateTransitions!state", "RosOut!log")
    right = _split("column", "Plot!depth", "Plot!margins", "Plot!position")
    more = _split("column", "RawMessages!state", "Plot!attitude", "Plot!batteries")
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split("row", left, right, more),
    }


def _plot(title: str, paths: Sequence[str]) -> Mapping[str, Any]:
    return {
        "title": title,
        "paths": _paths(paths),
        "xAxisVal": "timestamp",
        "showLegend": True,
        "isSynced": True,
    }


def _paths(names: Sequence[str]) -> list[Mapping[str, Any]]:
    return [{"value": n, "enabled": True, "timestampMethod": "receiveTime"} for n in names]


def _split(direction: str, *parts: Any) -> Any:
    """Split into parts of equal size; the format knows only two parts at a time."""
    first, *rest = parts
    if not rest:
        return first
    share = 100.0 / len(parts)
    return {
        "direction": direction,
        "first": first,
        "second": _split(direction, *rest),
        "splitPercentage": round(share, 2),
    }
