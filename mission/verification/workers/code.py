"""Identify the program: two processes with the same ``code()`` give the same results.

It covers the sources, vehicles and missions on the disk, the build, and the libraries below. Their
versions are not enough: numpy's matrix products use the instructions of the processor, which
changes their last bits. So the result of some arithmetic is compared, too.
"""

from __future__ import annotations

import functools
import hashlib
import math
import platform
import struct
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path

import numpy as np

import mission
from mission import __version__
from mission.model.compiled import build
from mission.model.shipped import load_vehicle, missions_folder
from mission.navigation.filter import Filter, Motion
from mission.navigation.model import figures

_PACKAGES = ("mission", "links", "protocol")
_BENEATH = ("numpy", "scipy", "filterpy", "transitions")
_FUNCTIONS = (math.sin, math.cos, math.tan, math.atan, math.exp, math.log, math.sqrt)
_UNREAD = {".pyc", ".so", ".pyd"}


@functools.cache
def code() -> Mapping[str, str]:
    return {
        "auvmission": __version__,
        "sources": _digest(),
        "build": build(),
        "python": platform.python_version(),
        "machine": f"{platform.machine()} {' '.join(platform.libc_ver())}".strip(),
        "arithmetic": _arithmetic(),
        **{name: version(name) for name in _BENEATH},
    }


def difference(theirs: Mapping[str, str], ours: Mapping[str, str]) -> str:
    """Describe the difference between two programs; "" if there is none."""
    found = [
        f"{name} {theirs.get(name, 'unknown')}, here {ours.get(name, 'unknown')}"
        for name in {**ours, **theirs}
        if theirs.get(name) != ours.get(name)
    ]
    return "; ".join(found)


def _arithmetic() -> str:
    """Return a digest of some steps of the filter, with matrices as large as in flight, and of
    functions of ``math``."""
    own = Filter(figures(load_vehicle("auv")))
    for n in range(1, 30):
        run = Motion(heading=0.3 * n, expected=1.0, sway=0.01 * n, turned=0.1)
        own.predict(0.1 * n, run)
        own.vertical(0.17 * n, 20.0 - 0.31 * n)
        own.fix(1.1 * n, 0.7 * n, 6.0 + n)
        own.velocity(0.13 * n, 0.11, run, 0.01 * np.eye(2))
    values = [f(0.37 * n) for f in _FUNCTIONS for n in range(1, 100)]
    bits = own.x.tobytes() + own.covariance.tobytes() + struct.pack(f"{len(values)}d", *values)
    return hashlib.sha256(bits).hexdigest()[:8]


def _digest() -> str:
    found = hashlib.sha256()
    for name, path in sorted(_files()):
        content = path.read_bytes()
        found.update(f"{name} {len(content)}\n".encode() + content)
    return found.hexdigest()[:16]


def _files() -> Iterator[tuple[str, Path]]:
    """Yield each file with a name that is the same in a checkout and in a wheel."""
    root, missions = Path(mission.__file__).resolve().parents[1], missions_folder().resolve()
    for package in _PACKAGES:
        for path in (root / package).rglob("*"):
            shipped = missions in path.parents
            if path.is_file() and path.suffix not in _UNREAD and not shipped:
                yield path.relative_to(root).as_posix(), path
    for path in missions.rglob("*"):
        if path.is_file():
            yield f"missions/{path.relative_to(missions).as_posix()}", path
