"""The health of a running serve, in a file: state, sensors, margins to the limits, links.

    <folder>/status.json    written whole once a second (temporary file, renamed), not synced: after
                            a power cut nobody needs it

The frames of the documents carry only the sensors (@VS) and the store (@AR). On the Pi,
`auvmission status --local` and `doctor` read the rest. What does not live here: the black box.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mission import __version__
from mission.engine.limits import LIMITS
from mission.engine.variables import CLOCK, VARIABLES
from mission.model import Reading
from mission.model.alarms import Alarm
from mission.model.plain import to_plain
from mission.model.vehicle import Vehicle
from mission.onboard.blackbox import BlackBox
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.ports import Port
from protocol.state_frame import setpoint_words

FILE = "status.json"
EVERY_S = 1.0
STALE_S = 10.0  # s; older: serve is not running, or hangs
_SHOWN = (
    "depth", "altitude", "heading", "pitch", "roll", "speed", "range", "uncertainty", "fix_age",
    "battery", "temperature", "leak",
)  # fmt: skip
_OF_POSITION = ("range", "uncertainty", "fix_age")  # never known without a position


@dataclass(frozen=True, slots=True)
class Sensor:
    """``why``: stale, missing, frozen, absurd, or absent if the vehicle file has no such sensor; ""
    if the value is valid."""

    value: float | None
    unit: str
    age_s: float | None
    why: str


@dataclass(frozen=True, slots=True)
class Margin:
    """The margin to a limit in force; None if the limited value is not known now."""

    bound: float
    now: float | None
    left: float | None
    unit: str


@dataclass(frozen=True, slots=True)
class LinkHealth:
    """``silent_s``: s since the last byte came; None: none ever did."""

    url: str
    open: bool
    received: int
    sent: int
    dropped: int
    faults: int
    silent_s: float | None
    peers: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Health:
    version: str
    pid: int
    wall: float  # s since 1970 UTC
    up_s: float
    state: str
    leg: str
    reason: str
    mission: str  # digest
    mission_time_s: float | None
    commander: str
    breached: tuple[str, ...]
    broken: tuple[str, ...]  # faults of configuration, vehicle file and store, as text
    ascent_only: str  # why serve only surfaces the vehicle, "" if it does more
    disarmed: Mapping[str, str]  # limit: why it can never act
    margins: Mapping[str, Margin]
    sensors: Mapping[str, Sensor]
    links: Mapping[str, LinkHealth]
    black_box: str
    black_box_failure: str
    black_box_lost: int
    setpoint: str  # in force, in words
    alarms: tuple[Alarm, ...]


def of_drive(runtime: Runtime, vehicle: Vehicle, now: float) -> dict[str, Any]:
    """The fields of Health that the runtime knows, at ``now`` (s). Readings are of the engine's
    last step, and age although no step comes."""
    engine = runtime.engine
    readings, bounds = engine.readings, engine.bounds
    late = max(0.0, now - engine.core.now)
    sensors = {name: _sensor(name, readings[name], late, vehicle) for name in _SHOWN}
    far, sure = runtime.situation.range(now), runtime.situation.uncertainty(now)
    for name, value in (("range", far), ("uncertainty", sure)):  # as of now, even without a step
        sensors[name] = replace(sensors[name], value=value)
    left, elapsed = runtime.situation.margins(now), engine.mission_time
    return {
        "version": __version__,
        "pid": os.getpid(),
        "commander": str(runtime.commander.peer or ""),
        "state": engine.state,
        "leg": engine.leg,
        "reason": engine.reason,
        "mission": engine.chart.digest if engine.chart else "",
        "mission_time_s": elapsed,
        "setpoint": setpoint_words(runtime.situation.setpoint),
        "breached": tuple(row.name for row in engine.breaches),
        "disarmed": {row.name: why for row in LIMITS.values() if (why := row.disarmed(vehicle))},
        "margins": {
            "depth": _below(bounds.depth, left["depth"], "m"),
            "radius": _below(bounds.radius, left["radius"], "m"),
            "time": _below(bounds.time, None if elapsed is None else bounds.time - elapsed, "s"),
            "voltage": _above(bounds.voltage, left["voltage"], "V"),
        },
        "sensors": sensors,
    }


def of_ports(
    ports: Mapping[str, Port], now: float, faults: Mapping[str, int], dropped: Mapping[str, int]
) -> dict[str, LinkHealth]:
    return {
        name: LinkHealth(
            url=port.url,
            open=port.link is not None,
            received=port.received,
            sent=port.sent,
            dropped=dropped.get(name, 0),
            faults=faults.get(name, 0),
            silent_s=None if port.heard is None else max(0.0, now - port.heard),
            peers=tuple(filter(None, port.peers)),
        )
        for name, port in ports.items()
    }


def of_box(box: BlackBox | None) -> dict[str, Any]:
    return {
        "black_box": str(box.path) if box else "",
        "black_box_failure": box.failure if box else "nothing is recorded",
        "black_box_lost": box.lost if box else 0,
    }


def _below(bound: float, left: float | None, unit: str) -> Margin:
    return Margin(bound, None if left is None else bound - left, left, unit)


def _above(bound: float, left: float | None, unit: str) -> Margin:
    return Margin(bound, None if left is None else bound + left, left, unit)


def _sensor(name: str, reading: Reading, late: float, vehicle: Vehicle) -> Sensor:
    """``late``: s since the reading was taken."""
    row, value = VARIABLES[name], _finite(reading.value + late * VARIABLES[name].timed)
    if row.unit == "deg" and value is not None:
        value = math.degrees(value)
    absent = reading.reason == "missing" and not _needs(name) <= vehicle.reports
    why = "absent" if absent else reading.reason
    if row.max_age == math.inf:  # estimated, so it does not age
        return Sensor(value, row.unit, None, why)
    age = reading.age + late
    why = why or ("stale" if age > vehicle.stale_after else "")
    return Sensor(value, row.unit, _finite(age), why)


def _needs(name: str) -> set[str]:
    """What the vehicle has to report for this value to be ever known."""
    return {"position"} if name in _OF_POSITION else {*VARIABLES[name].source} - {CLOCK}


def _finite(value: float) -> float | None:
    return value if abs(value) < float("inf") else None  # a NaN is not less either


def write(folder: Path, health: Health) -> None:
    """Write the file. A failing disk is ignored: the file is then old, and says when it was
    written."""
    beside = folder / f"{FILE}.new"
    with contextlib.suppress(OSError):
        beside.write_text(json.dumps(to_plain(health)) + "\n", encoding="utf-8")
        beside.replace(folder / FILE)


def read(folder: Path, wall: float) -> Mapping[str, Any] | None:
    """The health that a running serve has written; None if none runs, or none writes it."""
    found = _written(folder)
    if found is None or abs(wall - found["wall"]) > STALE_S:
        return None
    return found


def mute(folder: Path, wall: float) -> int | None:
    """The process of a serve that runs but has not written its health for long, or never: its disk
    cannot be written, or it hangs. None if there is none."""
    found = _written(folder)
    if found is not None and abs(wall - found["wall"]) <= STALE_S:
        return None
    told = None if found is None else int(found["pid"])
    return told if told is not None and _serves(told) else _locks(folder)


def _locks(folder: Path) -> int | None:
    """The process of the serve that has the folder's lock, from the kernel (Linux, proc_locks(5)):
    on a read-only disk serve has written nothing."""
    try:
        seen, told = folder.stat(), Path("/proc/locks").read_text(encoding="ascii")
    except (OSError, ValueError):
        return None
    here = f"{os.major(seen.st_dev):02x}:{os.minor(seen.st_dev):02x}:{seen.st_ino}"
    rows = (line.split() for line in told.splitlines())
    found = [int(row[4]) for row in rows if row[1:2] == ["FLOCK"] and row[5:6] == [here]]
    return next((pid for pid in found if _serves(pid)), None)


def process(folder: Path) -> int | None:
    """The process number of the serve that wrote its health last, if it lives."""
    found = _written(folder)
    return None if found is None else int(found["pid"])


def _written(folder: Path) -> dict[str, Any] | None:
    """The file's content, if a process that lives wrote it."""
    try:
        found = json.loads((folder / FILE).read_text(encoding="utf-8"))
        found["wall"] = float(found["wall"])
        os.kill(int(found["pid"]), 0)
    except PermissionError:  # it runs as another user
        return found if isinstance(found, dict) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return found if isinstance(found, dict) else None


def _serves(pid: int) -> bool:
    """Whether that process is a serve: after a reboot of the Pi the number may be another
    program's."""
    try:
        return b"serve" in Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return False


def as_lines(found: Mapping[str, Any], wall: float) -> Iterator[str]:
    """Lines for people: what concerns the dive first; the age is at ``wall`` (s since 1970 UTC)."""
    yield from (f"ALARM {Alarm(**alarm)}" for alarm in found["alarms"])
    yield f"{'told':16} {max(0.0, wall - found['wall']):.0f} s ago"
    for name in ("state", "leg", "setpoint", "reason", "mission_time_s", "mission", "commander"):
        value = found[name]
        if value not in ("", None):
            yield f"{name:16} {value if isinstance(value, str) else f'{value:.1f}'}"
    for text in (found["ascent_only"], *found["broken"]):
        if text:
            yield f"{'BROKEN':16} {text}"
    for name in found["breached"]:
        yield f"{'BREACHED':16} {name}"
    for name, margin in found["margins"].items():
        left = (
            "not known now" if margin["left"] is None else f"{margin['left']:.1f} {margin['unit']}"
        )
        yield f"{'to ' + name:16} {left}, limit {margin['bound']:g} {margin['unit']}"
    for name, why in found["disarmed"].items():
        yield f"{'limit off':16} {name}: {why}"
    for name, sensor in found["sensors"].items():
        yield f"{name:16} {sensed(sensor)}".rstrip()
    for name, link in found["links"].items():
        state = "open" if link["open"] else "CLOSED"
        silent = (
            "never heard" if link["silent_s"] is None else f"heard {link['silent_s']:.1f} s ago"
        )
        peers = f", {len(link['peers'])} connected" if name == "topside" else ""
        yield (
            f"{'link ' + name:16} {state}, {silent}, {link['received']} bytes in, "
            f"{link['sent']} out, {link['faults']} faults{peers}"
        )
    yield f"{'black box':16} {found['black_box_failure'] or found['black_box']}"


def sensed(sensor: Mapping[str, Any]) -> str:
    """A sensor as text. For an invalid value: why, how old it is, and the last value."""
    if sensor["why"] == "absent":
        return "absent, as the vehicle file says"
    value = "" if sensor["value"] is None else _value(sensor["value"], sensor["unit"])
    if not sensor["why"]:
        return value if sensor["age_s"] is None else f"{value}, {sensor['age_s']:.0f} s ago"
    told = sensor["age_s"] is not None and sensor["why"] != "missing"  # it has no age: none came
    age = f", {sensor['age_s']:.0f} s old" if told else ""
    return f"{sensor['why'].upper()}{age}{': last ' if value else ''}{value}"


def _value(value: float, unit: str) -> str:
    """The value with its unit; without a unit it is the leak: yes or no."""
    return f"{value:.2f} {unit}" if unit else ("yes" if value else "no")
