"""The contents of `auvmission watch`: lines of text with a style each, from what a viewer knows.

Every value is shown with its age. A value older than its period is marked OLD, an unknown one as
not known.

What does not live here: terminals and keys (watch), where the values come from (sources).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from mission.model.alarms import DANGER, Alarm, ago
from mission.topside.contacts import SILENT_S
from mission.topside.monitor import Watched
from mission.topside.overdue import moment

PLAIN, GOOD, CAREFUL, BAD, DIM = "plain", "good", "careful", "bad", "dim"
DEEP = "deep"  # shown in reverse colours: blocks stand for the water below
REPORT_S, FIX_S = 6.0, 5.0  # older reports and older fixes are OLD
BAR, STRIP, ROWS = 20, 100, 4  # characters
LOW, LOWER = 0.25, 0.1  # shares of a margin
_BLOCKS = " ▁▂▃▄▅▆▇█"
_UNITS = {"to_depth": "m", "to_radius": "m", "to_time": "min", "to_voltage": "V"}
_REPORTED = ("to_depth", "to_voltage")  # as old as the report
_VOLTAGE = 0.2  # of the limit: a full bar is so much above it


class Line(NamedTuple):
    text: str
    style: str = PLAIN


def banner(
    watched: Watched, now: float, mine: Sequence[Alarm] = (), silent_s: float = SILENT_S
) -> Iterator[Line]:
    """Yield the alarms, worst first; ``mine`` are those of the boat. One line if nothing is
    wrong."""
    silence = watched.silence(now)
    if silence is None:
        yield Line("nothing has been heard of the vehicle since watch began", CAREFUL)
    elif silence > silent_s:
        yield Line(f"NOTHING NEW for {silence:.0f} s: all below is of that time", BAD)
    alarms = [*mine, *(Alarm(**plain) for plain in watched.state.get("alarms") or ())]
    for alarm in sorted(alarms, key=lambda a: a.level != DANGER):
        yield Line(f"ALARM {alarm}", BAD if alarm.level == DANGER else CAREFUL)
    if silence is not None and silence <= silent_s and not alarms:
        yield Line("no alarm", GOOD)


def state(watched: Watched, now: float) -> Iterator[Line]:
    known = watched.state
    path = known.get("state") or "not known"
    yield Line(path, BAD if path.startswith("emergency") else PLAIN)
    for name in ("reason", "setpoint", "commander", "mission"):
        if known.get(name):
            yield Line(f"{name:10} {known[name]}")
    if (begun := watched.age("mission_began", now)) is not None:
        yield Line(f"{'started':10} {ago(begun)}")
    lasts, most = watched.age("leg_began", now), known.get("leg_timeout")
    if known.get("leg") and lasts is not None:
        shown = (
            f"{lasts:.0f} s" if most is None else f"{bar(lasts / most)} {lasts:.0f} of {most:g} s"
        )
        yield Line(f"{'leg':10} {known['leg']}  {shown}")
    for text, values in known.get("leg_ends") or ():
        looked = ", ".join(f"{name} {_number(value)}" for name, value in values.items())
        yield Line(f"{'until':10} {text}   now {looked}")


def due(up_by: float | None, wall: float) -> Iterator[Line]:
    """``up_by``: as the boat knows it, s since 1970 UTC, like ``wall``."""
    if up_by is not None:
        yield Line(f"{'up by':10} {moment(up_by, wall)}", CAREFUL if wall > up_by else PLAIN)


def place(watched: Watched, now: float) -> Iterator[Line]:
    known = watched.state
    if known.get("latitude") is None:
        yield Line("position   not known", CAREFUL)
    else:
        what = known.get("place", "estimate")
        yield Line(f"{what:10} {known['latitude']:.6f} {known['longitude']:.6f}")
        if (ellipse := known.get("ellipse")) is not None:
            great, small, bearing = ellipse
            yield Line(
                f"{'95 % in':10} {great:g} m towards {bearing:03.0f} deg, {small:g} m across"
            )
    yield _aged("fix", watched.age("fix_at", now), FIX_S)
    yield _aged("report", watched.age("report_at", now), REPORT_S)
    old = _is_old(watched, now)
    for name, unit in (("depth", "m"), ("altitude", "m"), ("heading", "deg"), ("speed", "m/s"),
                       ("battery", "V")):  # fmt: skip
        if name not in known:
            continue
        value = known[name]
        text = f"{name:10} {_number(value)}{f' {unit}' if value is not None else ''}"
        dim = old or value is None
        yield Line(f"{text}{'   OLD' if old else ''}", DIM if dim else PLAIN)


def _is_old(watched: Watched, now: float) -> bool:
    """Whether the report is old; also if its age is not known."""
    age = watched.age("report_at", now)
    return age is None or age > REPORT_S


def _aged(name: str, age: float | None, within: float) -> Line:
    if age is None:
        return Line(f"{name:10} none so far, or of an age that is not known", CAREFUL)
    is_old = age > within
    return Line(f"{name:10} {ago(age)}{'   OLD' if is_old else ''}", CAREFUL if is_old else PLAIN)


def margins(watched: Watched, now: float) -> Iterator[Line]:
    is_old = _is_old(watched, now)
    for name, unit in _UNITS.items():
        left, limit = watched.state.get(name) or (None, None)
        what = f"{name.removeprefix('to_'):8}"
        if left is None:
            yield Line(f"{what} not known", DIM)
            continue
        if is_old and name in _REPORTED:
            yield Line(
                f"{what} {left:g} {unit} left{'' if limit is None else f' of {limit:g}'}   OLD", DIM
            )
            continue
        if limit is None:  # by @AE, which has no limit
            yield Line(f"{what} {left:g} {unit} left", BAD if left <= 0.0 else PLAIN)
            continue
        share = left / (limit * (_VOLTAGE if unit == "V" else 1.0)) if limit else 0.0
        style = BAD if share <= LOWER else CAREFUL if share <= LOW else GOOD
        yield Line(f"{what} {bar(share)} {left:g} {unit} left of {limit:g}", style)


def strip(watched: Watched, width: int = STRIP) -> Iterator[Line]:
    """Yield the depth of the newest points, a column each, with the surface at the top."""
    points = [(point[0], point[3]) for point in watched.track[-width:]]
    depths = [depth for _, depth in points if depth is not None]
    if not depths:
        yield Line("depth: not known", DIM)
        return
    deepest = max(*depths, 1.0)
    for row in range(ROWS):
        shares = (None if d is None else d / deepest * ROWS - row for _, d in points)
        yield Line("".join("?" if s is None else _block(1.0 - s) for s in shares), DEEP)
    yield Line(f"depth 0 to {deepest:.1f} m, the last {points[-1][0] - points[0][0]:.0f} s", DIM)


def _block(share: float) -> str:
    return _BLOCKS[min(max(round(share * (len(_BLOCKS) - 1)), 0), len(_BLOCKS) - 1)]


def bar(share: float) -> str:
    filled = round(min(max(share, 0.0), 1.0) * BAR)
    return "█" * filled + "░" * (BAR - filled)


def _number(value: Any) -> str:
    return (
        "not known" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
    )
