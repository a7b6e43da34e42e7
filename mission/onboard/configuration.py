"""The configuration of `serve`: a YAML file with a default for every key. An empty file is valid.

    ConfigurationError      (the operator must act; it names file, key and remedy of every fault)

    vehicle: auv                         # a shipped vehicle file's name, or a path
    links:
      vehicle: serial:///dev/serial0     # 8N1, at the rate of its role (rates)
      gps: serial:///dev/ttyUSB0         # null: no receiver
      topside: tcp-listen://127.0.0.1:4000  # listens; on loopback by default, or e.g.
                 # tls-listen://0.0.0.0:4000?keys=/etc/auvmission/keys&allow=192.168.1.0/24
      modem: null
      monitor: tcp-listen://127.0.0.1:4001  # for viewers, who cannot command; null: off
      sensors: serial:///dev/ttyUSB1     # a speed log, an acoustic position; default: none
    folder: ~/.local/state/auvmission    # store/ and log/ below it
    time_zone: "+08:00"                  # of the topside's local time (E-V1)
    answer_no: true                      # R2; false for a topside that cannot handle N
    manual_for: 60 s                     # longest time without an M command (R6)
    topside_silence: null                # a limit on the topside's silence (R5)
    set_system_clock: false              # @ST sets the system's clock, too (R10)
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

from links.base import LinkError
from mission.model.diagnostics import Diagnosed, Diagnostics, Stage, whole
from mission.model.likeness import suggestion
from mission.model.plain import UNSAID
from mission.model.texts import NOWHERE, Where
from mission.model.units import UnitError, quantity, range_text
from mission.onboard.kept import default_folder
from protocol.tolerances import Tolerances, UnknownTolerance

LONGEST = 1 << 16  # characters of a configuration
_shortened = Repr()  # bounds the text of a value that YAML aliases multiply
_shortened.maxlevel = 2
shown = _shortened.repr


class ConfigurationError(Diagnosed):
    """The configuration cannot be used."""


@dataclass(frozen=True, slots=True)
class LinkUrls:
    """The URL of each link; None: there is no such link."""

    vehicle: str = "serial:///dev/serial0"
    gps: str | None = "serial:///dev/ttyUSB0"
    topside: str = "tcp-listen://127.0.0.1:4000"
    modem: str | None = None
    monitor: str | None = "tcp-listen://127.0.0.1:4001"
    sensors: str | None = field(default=None, metadata=UNSAID)
    gps2: str | None = field(default=None, metadata=UNSAID)


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
    ascent_only: str = ""  # not a key of the file: why serve only surfaces the vehicle

    @property
    def utc_offset(self) -> float:
        """Offset of the topside's local time from UTC, s."""
        sign = -1.0 if self.time_zone[0] == "-" else 1.0
        hours, minutes = self.time_zone[1:].split(":")
        return sign * (int(hours) * 3600.0 + int(minutes) * 60.0)

    @property
    def store(self) -> Path:
        return self.folder / "store"

    @property
    def log(self) -> Path:
        return self.folder / "log"


Judge = Callable[[tuple[str, ...], Any], None]  # path of a key, and its value


def _unjudged(key: tuple[str, ...], value: Any) -> None:
    """Accept everything: who only needs the folder accepts links that cannot be opened."""


def load_configuration(path: Path | None, judge: Judge = _unjudged) -> Configuration:
    """Return the configuration in the file, or the defaults if ``path`` is None. ``judge`` raises
    LinkError for a URL that is well-formed but cannot be opened. Raises ConfigurationError."""
    if path is None:
        return Configuration()
    try:
        return parse_configuration(path.read_text(encoding="utf-8"), str(path), judge)
    except UnicodeDecodeError as error:
        raise _unreadable(path, "it is not UTF-8", "save it as UTF-8") from error
    except OSError as error:
        raise _unreadable(
            path, error.strerror or str(error), "give a file that is there"
        ) from error


def _unreadable(path: Path, why: str, hint: str) -> ConfigurationError:
    message = f"{path}: cannot be read: {why}"
    return ConfigurationError([whole("unreadable", message, hint, Stage.CONFIGURATION)])


def parse_configuration(
    text: str, where: str = "configuration", judge: Judge = _unjudged
) -> Configuration:
    """Parse the text. Raises ConfigurationError with every fault."""
    # yaml may not be installed (provision)
    from mission.model.yaml_tree import YamlFault, places, tree, values

    found = Diagnostics(Stage.CONFIGURATION, text, where, ConfigurationError)
    if len(text) > LONGEST:
        hint = "give the configuration of serve"
        raise found.refusal("too-long", NOWHERE, f"more than {LONGEST:,} characters", hint)
    try:
        root = tree(text)
        data = values(root)
    except YamlFault as fault:
        raise found.refusal(*fault.said("the configuration")) from None
    data = {} if data is None else data
    if not isinstance(data, dict):
        message = f"a configuration is a table of keys, not {shown(data)}"
        raise found.refusal("yaml-type", Where(1, 1), message, "write for instance vehicle: auv")
    given = _Tables(found, places(root), judge).read(data, _KEYS)
    found.complain()
    return Configuration(**given)


@dataclass(frozen=True, slots=True)
class _Tables:
    """Reads tables key by key. ``places``: where key and value stand, by the path of the key."""

    found: Diagnostics
    places: Mapping[tuple[str, ...], tuple[Where, Where]]
    judge: Judge

    def read(
        self, data: Mapping[Any, Any], keys: Mapping[str, Any], above: tuple[str, ...] = ()
    ) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for key, value in data.items():
            path = (*above, str(key))
            at_key, at_value = self.places.get(path, (Where(1, 1), Where(1, 1)))
            if key not in keys:
                message = ": ".join([*above, f"unknown key {shown(key)}"])
                self.found.add("unknown-word", at_key, message, _instead(str(key), keys))
            elif isinstance(keys[key], Mapping):
                values[key] = self._table(value, keys[key], path, at_value)
            else:
                self._take(values, key, value, keys[key], path, at_value)
        return values

    def _table(
        self, value: Any, keys: Mapping[str, Any], path: tuple[str, ...], where: Where
    ) -> Any:
        if isinstance(value, dict):
            return LinkUrls(**self.read(value, keys, path))
        message = ": ".join([*path, f"a table is needed, not {shown(value)}"])
        self.found.add("yaml-type", where, message, f"write {{{', '.join(keys)}}}, each with a URL")
        return None

    def _take(
        self,
        values: dict[str, Any],
        key: str,
        value: Any,
        read: Callable[[Any], Any],
        path: tuple[str, ...],
        where: Where,
    ) -> None:
        try:
            values[key] = read(value)
            self.judge(path, values[key])
        except (_Wrong, UnitError, LinkError) as error:
            what, _, instead = str(error).partition("; ")
            hint = instead or f"default: {_default(path)}"
            self.found.add("value", where, ": ".join([*path, what]), hint)


_BROUGHT = {
    "baud": "links: {vehicle: serial:///dev/serial0?baud=9600}",
    "port": "links: {topside: tcp-listen://127.0.0.1:4000}",
}


def _instead(key: str, keys: Mapping[str, Any]) -> str:
    """The hint for an unknown key: the table where it belongs, or the most similar key."""
    above = next(
        (k for k, below in keys.items() if isinstance(below, Mapping) and key in below), ""
    )
    if above:
        return f"it stands below {above}: write {above}: {{{key}: ...}}"
    return (
        f"write {_BROUGHT[key]}" if key in _BROUGHT else suggestion(key, tuple(keys), "there are")
    )


def _default(path: tuple[str, ...]) -> str:
    value: Any = Configuration()
    for key in path:
        value = getattr(value, key)
    return "nothing" if value is None else str(value)


class _Wrong(ValueError):
    """The message says what is wrong and, after a semicolon, what to write instead."""


def _text(value: Any) -> str:
    if not isinstance(value, str) or not value:
        raise _Wrong(f"a text is needed, not {shown(value)}")
    return value


def _text_or_none(value: Any) -> str | None:
    return None if value is None else _text(value)


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise _Wrong(f"{shown(value)} is no flag; write true or false")
    return value


def _seconds(low: float, high: float) -> Callable[[Any], float]:
    def read(value: Any) -> float:
        seconds = quantity(value, "s")
        if not low <= seconds <= high:
            raise _Wrong(f"{shown(value)} is out of range; {range_text(low, high, 's')}")
        return seconds

    return read


def _silence(value: Any) -> float | None:
    return None if value is None else _seconds(10, 86_400)(value)


def _zone(value: Any) -> str:
    if not isinstance(value, str) or not re.fullmatch(r"[+-](0\d|1[0-4]):[0-5]\d", value):
        raise _Wrong(f'{shown(value)} is no offset; write one such as "+08:00", in quotes')
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


_REQUIRED = {"vehicle", "topside"}
_LINK_KEYS = {f.name: _text if f.name in _REQUIRED else _text_or_none for f in fields(LinkUrls)}
_KEYS = {
    "vehicle": _text,
    "links": _LINK_KEYS,
    "folder": _folder,
    "time_zone": _zone,
    "answer_no": _flag,
    "manual_for": _seconds(5, 3600),  # R6 stops the vehicle after 2 s
    "topside_silence": _silence,
    "set_system_clock": _flag,
    "camera": _text_or_none,
    "tolerances": _tolerances,
}
