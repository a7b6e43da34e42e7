"""Files with a checksum, and where they are if the configuration cannot be read.

    "sha256 <hex of the rest>\\n" and the rest; written to a temporary file, synced, renamed

This module uses the standard library alone: the lifeboat reads these files when nothing else can be
loaded. What does not live here: their contents (store, serve: working).
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
_NONE = ("~", "null", "Null", "NULL")  # the forms of null in YAML


def read_summed(path: Path) -> str:
    """Return the text. Raises OSError, or ValueError if the file is not whole."""
    head, newline, body = path.read_bytes().partition(b"\n")
    if not newline or head != _sum(body):
        raise ValueError(f"{path} is damaged")
    return body.decode()


def write_summed(path: Path, text: str) -> None:
    """Write the text completely or not at all; create the folder if absent. Raises OSError."""
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
    except RuntimeError:  # the user has no home folder
        return Path("/var/lib/auvmission")


class Homes:
    """Where the last configuration that worked may be. ``folder``: from the command line;
    ``config``: the configuration file."""

    def __init__(
        self, config: Path | None, folder: Path | None, environment: Mapping[str, str]
    ) -> None:
        self._config, self._given = config, folder
        self._state = environment.get("STATE_DIRECTORY", "").partition(":")[0]

    @property
    def folder(self) -> Path | None:
        """The folder of the store, as far as known without the whole configuration; else None."""
        if self._given is not None:
            return self._given
        said = _said_folder(self._config) or self._state
        return Path(said).expanduser() if said else None

    def paths(self) -> Iterator[Path]:
        """The paths to try, in this order."""
        if (folder := self.folder) is not None:
            yield folder / WORKING
        if self._config is not None:
            yield self._aside(self._config)
        yield default_folder() / WORKING

    def places(self, folder: Path) -> Iterator[Path]:
        """Where to write it: in ``folder``, and also in the default folder if only the
        configuration file names ``folder``."""
        yield folder / WORKING
        if self._given is None and not self._state and self._config is not None:
            yield self._aside(self._config)

    def _aside(self, config: Path) -> Path:
        name = hashlib.sha256(str(config.absolute()).encode()).hexdigest()[:8]
        return default_folder() / f"{WORKING}-{name}"


def _said_folder(config: Path | None) -> str:
    """The ``folder:`` line of a file that may be broken elsewhere; "" if it has none."""
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
    """Sync the folder, so that a rename in it survives a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
