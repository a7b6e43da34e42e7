"""Which program this is: two that say the same give the same results.

Sources, vehicles and missions as they lie on the disk, the build, and what computes beneath them.
"""

from __future__ import annotations

import functools
import hashlib
import platform
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path

import mission
from mission import __version__
from mission.model.compiled import build
from mission.model.shipped import missions_folder

_PACKAGES = ("mission", "links", "protocol")
_BENEATH = ("numpy", "scipy", "filterpy", "transitions")
_UNREAD = {".pyc", ".so", ".pyd"}


@functools.cache
def code() -> Mapping[str, str]:
    return {
        "auvmission": __version__,
        "sources": _digest(),
        "build": build(),
        "python": platform.python_version(),
        "machine": f"{platform.machine()} {' '.join(platform.libc_ver())}".strip(),
        **{name: version(name) for name in _BENEATH},
    }


def difference(theirs: Mapping[str, str], ours: Mapping[str, str]) -> str:
    """In words; "" if there is none."""
    found = [
        f"{name} {theirs.get(name, 'unknown')}, here {ours.get(name, 'unknown')}"
        for name in {**ours, **theirs}
        if theirs.get(name) != ours.get(name)
    ]
    return "; ".join(found)


def _digest() -> str:
    found = hashlib.sha256()
    for name, path in sorted(_files()):
        content = path.read_bytes()
        found.update(f"{name} {len(content)}\n".encode() + content)
    return found.hexdigest()[:16]


def _files() -> Iterator[tuple[str, Path]]:
    """Each with its name, which is the same in a checkout and in a wheel."""
    root, missions = Path(mission.__file__).resolve().parents[1], missions_folder().resolve()
    for package in _PACKAGES:
        for path in (root / package).rglob("*"):
            shipped = missions in path.parents
            if path.is_file() and path.suffix not in _UNREAD and not shipped:
                yield path.relative_to(root).as_posix(), path
    for path in missions.iterdir():
        if path.is_file():
            yield f"missions/{path.name}", path
