"""Files that are whole or known not to be, and where they lie when the configuration cannot say.

    "sha256 <hex of the rest>\\n" and the rest; written beside, flushed, fsynced, renamed into place

Of the standard library alone: what brings a vehicle up when nothing else can be loaded reads them
(lifeboat). What does not live here: what is in them (store, serve: working).
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

WORKING = "working"  # the last configuration that worked (serve: working)
_FOLDER = re.compile(r"^folder:[ \t]*[\"']?([^\"'#\n]+)", re.MULTILINE)
_NONE = ("~", "null", "Null", "NULL")  # as YAML says it


def read_summed(path: Path) -> str:
    """Raises OSError, or ValueError where it is not whole."""
    head, newline, body = path.read_bytes().partition(b"\n")
    if not newline or head != _sum(body):
        raise ValueError(f"{path} is damaged")
    return body.decode()


def write_summed(path: Path, text: str) -> None:
    """All of it or nothing; its folder is made where it is absent. Raises OSError."""
    body, beside = text.encode(), path.with_name(path.name + ".new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with beside.open("wb") as file:
            file.write(_sum(body) + b"\n" + body)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
        sync_folder(path.parent)
    except OSError:
        with contextlib.suppress(OSError):
            beside.unlink()
        raise


def default_folder() -> Path:
    try:
        return Path("~/.local/state/auvmission").expanduser()
    except RuntimeError:  # a user without a home
        return Path("/var/lib/auvmission")


class Homes:
    """Where the last configuration that worked may lie. ``folder`` is the command line's,
    ``config`` the configuration file."""

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

    def paths(self) -> Iterator[Path]:
        """In the order in which they count."""
        if (folder := self.folder) is not None:
            yield folder / WORKING
        if self._config is not None:
            yield self._aside(self._config)
        yield default_folder() / WORKING

    def places(self, folder: Path) -> Iterator[Path]:
        """Where it is to be kept: beside the store, and aside where nothing but the configuration
        file says which folder that is."""
        yield folder / WORKING
        if self._given is None and not self._state and self._config is not None:
            yield self._aside(self._config)

    def _aside(self, config: Path) -> Path:
        name = hashlib.sha256(str(config.absolute()).encode()).hexdigest()[:8]
        return default_folder() / f"{WORKING}-{name}"


def _said_folder(config: Path | None) -> str:
    """By the line of a file that is broken elsewhere."""
    if config is None:
        return ""
    try:
        found = _FOLDER.search(config.read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return ""
    said = found[1].strip() if found else ""
    return "" if said in _NONE else said


def _sum(body: bytes) -> bytes:
    return b"sha256 " + hashlib.sha256(body).hexdigest().encode()


def sync_folder(folder: Path) -> None:
    """So that a name that was given survives a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
