"""What `serve` reads: one YAML file with a default for everything. An empty file is a valid one.

    ConfigurationError      (the operator must act; names file, key and remedy, all at once)

    vehicle: auv                         # a shipped vehicle file's name, or a path
    links:
      vehicle: serial:///dev/serial0     # 8N1, at the rate of its role (rates)
      gps: serial:///dev/ttyUSB0         # null: none
      topside: tcp-listen://127.0.0.1:4000  # listens; loopback unless told otherwise, e.g.
                 # tls-listen://0.0.0.0:4000?keys=/etc/auvmission/keys&allow=192.168.1.0/24
      modem: null
    folder: ~/.local/state/auvmission    # store/ and log/ below it
    time_zone: "+08:00"                  # of the topside's local time (E-V1)
    answer_no: true                      # R2; false for a topside that cannot bear N
    manual_for: 60 s                     # without an M command (R6)
    topside_silence: null                # a limit on the topside's silence (R5)
    set_system_clock: false              # @ST moves the system's clock too (R10)
    camera: null                         # command line that the node CAMERA runs (R13)
    tolerances: {}                       # of the topside codec, by the names of docs/protocol.md

What does not live here: the vehicle's own figures (vehicle), what a URL may say (links).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from reprlib import Repr
from typing import Any

from mission.model.units import UnitError, quantity, range_text
from mission.onboard.kept import default_folder
from protocol.tolerances import Tolerances, UnknownTolerance

LONGEST = 1 << 16  # characters of a configuration
_shortened = Repr()  # whatever aliases make of a value
_shortened.maxlevel = 2
shown = _shortened.repr


class ConfigurationError(ValueError):
    """The configuration cannot be used; the message lists every fault in it."""


@dataclass(frozen=True, slots=True)
class LinkUrls:
    """Where each link's bytes come from; None: the link is not there."""

    vehicle: str = "serial:///dev/serial0"
    gps: str | None = "serial:///dev/ttyUSB0"
    topside: str = "tcp-listen://127.0.0.1:4000"
    modem: str | None = None


_NO_TOLERANCES: Mapping[str, str] = {}
_LINKS = LinkUrls()


@dataclass(frozen=True, slots=True)
class Configuration:
    vehicle: str = "auv"
    links: LinkUrls = _LINKS
    folder: Path = field(default_factory=default_folder)
    time_zone: str = "+08:00"
    answer_no: bool = True
    manual_for: float = 60.0  # s
    topside_silence: float | None = None  # s
    set_system_clock: bool = False
    camera: str | None = None
    tolerances: Mapping[str, str] = field(default_factory=lambda: _NO_TOLERANCES)
    ascent_only: str = ""  # no key of the file: why nothing but an ascent is served

    @property
    def utc_offset(self) -> float:
        """s, of the topside's local time."""
        sign = -1.0 if self.time_zone[0] == "-" else 1.0
        hours, minutes = self.time_zone[1:].split(":")
        return sign * (int(hours) * 3600.0 + int(minutes) * 60.0)

    @property
    def store(self) -> Path:
        return self.folder / "store"

    @property
    def log(self) -> Path:
        return self.folder / "log"


def load_configuration(path: Path | None) -> Configuration:
    """The file's configuration, or the defaults without one. Raises ConfigurationError."""
    if path is None:
        return Configuration()
    try:
        return parse_configuration(path.read_text(encoding="utf-8"), str(path))
    except UnicodeDecodeError as error:
        raise ConfigurationError(f"{path}: cannot be read: it is not UTF-8") from error
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read: {error.strerror or error}") from error


def parse_configuration(text: str, where: str = "configuration") -> Configuration:
    from mission.model.yaml_tree import YamlFault, values  # yaml: may be missing (provision)

    if len(text) > LONGEST:
        raise ConfigurationError(f"{where}: more than {LONGEST:,} characters")
    try:
        data = values(text)
    except YamlFault as fault:
        raise ConfigurationError(f"{where}:{fault}") from None
    data = {} if data is None else data
    if not isinstance(data, dict):
        raise ConfigurationError(f"{where}: a configuration is a table of keys, not {shown(data)}")
    faults: list[str] = []
    given = _table(data, _KEYS, faults)
    if faults:
        raise ConfigurationError("\n".join(f"{where}: {fault}" for fault in faults))
    return Configuration(**given)


def _table(data: Mapping[Any, Any], keys: Mapping[str, Any], faults: list[str]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for key, value in data.items():
        if key not in keys:
            faults.append(f"unknown key {shown(key)}; there are {', '.join(keys)}")
            continue
        try:
            values[key] = keys[key](value)
        except (_Wrong, UnitError) as error:
            faults.append(f"{key}: {error}")
    return values


class _Wrong(ValueError):
    pass


def _text(value: Any) -> str:
    if not isinstance(value, str) or not value:
        raise _Wrong(f"a text is needed, not {shown(value)}")
    return value


def _text_or_none(value: Any) -> str | None:
    return None if value is None else _text(value)


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise _Wrong(f"write true or false, not {shown(value)}")
    return value


def _seconds(low: float, high: float) -> Callable[[Any], float]:
    def read(value: Any) -> float:
        seconds = quantity(value, "s")
        if not low <= seconds <= high:
            raise _Wrong(f"{shown(value)} is out of range: {range_text(low, high, 's')}")
        return seconds

    return read


def _silence(value: Any) -> float | None:
    return None if value is None else _seconds(10, 86_400)(value)


def _zone(value: Any) -> str:
    if not isinstance(value, str) or not re.fullmatch(r"[+-](0\d|1[0-4]):[0-5]\d", value):
        raise _Wrong(f'write an offset such as "+08:00", in quotes, not {shown(value)}')
    return value


def _folder(value: Any) -> Path:
    return Path(_text(value)).expanduser()


def _tolerances(value: Any) -> Mapping[str, str]:
    if not isinstance(value, dict):
        raise _Wrong(f"a table of names is needed, not {shown(value)}")
    found = {str(k): {True: "on", False: "off"}.get(v, str(v)) for k, v in value.items()}
    try:
        Tolerances.parse(found)
    except UnknownTolerance as error:
        raise _Wrong(str(error)) from None
    return found


def _links(value: Any) -> LinkUrls:
    if not isinstance(value, dict):
        raise _Wrong(f"a table is needed, not {shown(value)}")
    faults: list[str] = []
    required = {"vehicle", "topside"}
    keys = {f.name: _text if f.name in required else _text_or_none for f in fields(LinkUrls)}
    values = _table(value, keys, faults)
    if faults:
        raise _Wrong("; ".join(faults))
    return LinkUrls(**values)


_KEYS = {
    "vehicle": _text,
    "links": _links,
    "folder": _folder,
    "time_zone": _zone,
    "answer_no": _flag,
    "manual_for": _seconds(5, 3600),  # R6 stops after 2 s
    "topside_silence": _silence,
    "set_system_clock": _flag,
    "camera": _text_or_none,
    "tolerances": _tolerances,
}
