"""Names of recordings and of their parts: ``<start>.mcap``, ``<start>.part2.mcap``, ...

The name is the wall time of the start, so that names sort by time. Each part begins with a copy of
the ``start`` record.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime
from pathlib import Path

_PART = re.compile(r"\.part(\d+)$")


def file_name(wall: float) -> str:
    return datetime.fromtimestamp(wall, UTC).strftime("%Y%m%dT%H%M%SZ.mcap")


def free(path: Path) -> Path:
    """Return the path, with a number appended if it exists: two starts within a second (or after
    the clock was set back) have different names."""
    found, number = path, 1
    while found.exists():
        number += 1
        found = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return found


def part_path(base: Path, part: int) -> Path:
    return base if part == 1 else base.with_name(f"{base.stem}.part{part}{base.suffix}")


def first_part(path: Path) -> Path:
    return path.with_name(_PART.sub("", path.stem) + path.suffix)


def part_number(path: Path) -> int:
    found = _PART.search(path.stem)
    return int(found[1]) if found else 1


def parts_of(path: Path) -> list[Path]:
    """Return the existing parts of a recording in order, given the path of any part. If there are
    none: the path of the first part alone."""
    base = first_part(path)
    further = base.parent.glob(f"{_plain(base.stem)}.part*{base.suffix}")
    found = {part_number(p): p for p in further if _PART.search(p.stem)}
    if base.exists() or not found:
        found[1] = base
    return [found[number] for number in sorted(found)]


def _plain(name: str) -> str:
    """Escape a name for glob."""
    return re.sub(r"([\[*?])", r"[\1]", name)
