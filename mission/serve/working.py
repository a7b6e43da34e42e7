"""The last configuration that worked, kept beside the store: what an ascent needs when another one
cannot be read.

    <folder>/working                 as the store's files: a sum, and JSON
    ~/.local/state/auvmission/working-<8 hex of the configuration file's path>
                                     the same, where nothing but that file says which folder

It worked when the vehicle was heard with it; the very first is kept without that. Beside the
configuration and the vehicle it has the vehicle's own words for an ascent, for a program that
cannot load their codec (lifeboat). What does not live here: when it is used (provision).
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from mission.configuration import Configuration
from mission.drive.records import from_plain, to_plain
from mission.engine.ascent import UPWARD
from mission.store import read_summed, write_summed
from mission.vehicle import Vehicle
from protocol.messages import Order
from protocol.vehicles import codec

FILE = "working"
_FOLDER = re.compile(r"^folder:\s*[\"']?([^\"'#\n]+)", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Working:
    configuration: Configuration
    vehicle: Vehicle


class Homes:
    """Where it may lie. ``folder`` is the command line's, ``config`` the configuration file."""

    def __init__(
        self, config: Path | None, folder: Path | None, environment: Mapping[str, str]
    ) -> None:
        self._config, self._given = config, folder
        self._state = environment.get("STATE_DIRECTORY", "").partition(":")[0]

    @property
    def folder(self) -> Path | None:
        """The store's, as far as it is said although the configuration cannot be read."""
        if self._given is not None:
            return self._given
        said = _said_folder(self._config) or self._state
        return Path(said).expanduser() if said else None

    def find(self) -> Working | None:
        """The first that is whole."""
        for path in self._paths():
            if (found := _read(path)) is not None:
                return found
        return None

    def keep(self, working: Working) -> None:
        """Where it is not yet. Raises StoreError."""
        text = json.dumps(_plain(working), sort_keys=True)
        places = [working.configuration.folder / FILE]
        if self._given is None and not self._state and self._config is not None:
            places.append(self._aside(self._config))
        for path in places:
            if _text(path) != text:
                write_summed(path, text)

    def _paths(self) -> Iterator[Path]:
        if (folder := self.folder) is not None:
            yield folder / FILE
        if self._config is not None:
            yield self._aside(self._config)
        yield Configuration().folder / FILE

    def _aside(self, config: Path) -> Path:
        name = hashlib.sha256(str(config.absolute()).encode()).hexdigest()[:8]
        return Configuration().folder / f"{FILE}-{name}"


def _said_folder(config: Path | None) -> str:
    """By the line of a file that is broken elsewhere."""
    if config is None:
        return ""
    try:
        found = _FOLDER.search(config.read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return ""
    return found[1].strip() if found else ""


def _plain(working: Working) -> dict[str, object]:
    c, v = working.configuration, working.vehicle
    encode = codec(v.codec, v.dialect, v.tolerances, v.battery_scale).encode
    words = (("stop", Order.STOP), ("surface", Order.SURFACE), ("up", UPWARD))
    ways: dict[str, list[str]] = {}
    for name, command in words:
        with contextlib.suppress(ValueError):  # the robot on land has no word for up
            ways[name] = [frame.hex() for frame in encode(command)]
    return {"configuration": to_plain(c), "vehicle": to_plain(v), "ways": ways}


def _text(path: Path) -> str | None:
    try:
        return read_summed(path)
    except (OSError, ValueError):
        return None


def _read(path: Path) -> Working | None:
    """None for what is not whole, or of another version."""
    text = _text(path)
    try:
        return None if text is None else from_plain(Working, _known(json.loads(text)))
    except (ValueError, TypeError, KeyError):
        return None


def _known(plain: Mapping[str, object]) -> dict[str, object]:
    return {name: plain[name] for name in ("configuration", "vehicle")}
