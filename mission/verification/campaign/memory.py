"""The memory of a soak: what is alive after each mission, and whether that grows.

It is measured as what is in use: the objects that the garbage collector knows, the blocks that
Python has allocated (strings and numbers too), and the bytes that C has allocated (by glibc's
malloc: libraries, and what Python has above 512 bytes). Growth counts in two stretches:

    the whole soak   what the process keeps, from program to program
    one life         what one program keeps: of those that lived through missions in a row, the one
                     that lived through most. A fault that kills the program frees all of it, so
                     the whole soak would not show it.

The resident memory of the process is told and not judged. It follows the longest missions: the
campaign keeps the trace of a flight until it is judged, and the allocator gives the room of a long
one back slowly, or not at all where something small lives in it.

What does not live here: the missions (soak).
"""

from __future__ import annotations

import ctypes
import gc
import resource
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

FLAT = 0.02  # share by which what is in use may grow
SETTLED = 50  # missions of a process until everything that is kept once exists
SETTLED_ALIVE = 5  # the same of one program in a settled process
LAST = 5  # missions, of which the least memory counts: a large mission is no growth
_MEGABYTE = 1 << 20
_STATM = Path("/proc/self/statm")


class _MallInfo(ctypes.Structure):
    """struct mallinfo2 of glibc: ten sizes."""

    _fields_ = (("sizes", ctypes.c_size_t * 10),)


_HBLKHD, _UORDBLKS = 4, 7  # of its sizes: bytes in maps of their own, and in the heap


def allocated() -> float | None:
    """Return the bytes that malloc has given out and not got back. None: the C library, or one
    older than glibc 2.33, does not tell."""
    ask = getattr(ctypes.CDLL(None), "mallinfo2", None)
    if ask is None:
        return None
    ask.restype = _MallInfo
    sizes = ask().sizes
    return float(sizes[_HBLKHD] + sizes[_UORDBLKS])


@dataclass(slots=True)
class Memory:
    objects: list[float] = field(default_factory=list)  # alive after each mission
    blocks: list[float] = field(default_factory=list)
    malloc: list[float] = field(default_factory=list)  # bytes; empty where nobody tells
    resident: list[float] = field(default_factory=list)  # MB; empty where nobody tells
    lives: list[int] = field(default_factory=list)  # which start of the program it ended in

    def look(self, life: int) -> None:
        gc.collect()
        self.objects.append(float(len(gc.get_objects())))
        self.blocks.append(float(sys.getallocatedblocks()))
        self.lives.append(life)
        if (bytes_ := allocated()) is not None:
            self.malloc.append(bytes_)
        if _STATM.exists():
            pages = int(_STATM.read_text().split()[1])
            self.resident.append(pages * resource.getpagesize() / _MEGABYTE)

    def __str__(self) -> str:
        found = [f"{name} {share:+.1%}" for name, share in self.growth.items() if share is not None]
        return f"growth: {', '.join(found) or 'not judged yet'}"

    @property
    def growth(self) -> dict[str, float | None]:
        """Return the growth over the whole soak, as shares."""
        return {name: grown(values, SETTLED) for name, values in self._series().items()}

    @property
    def longest_life(self) -> slice:
        """Return the missions of the longest life, from when the process has settled on."""
        counted = Counter(self.lives[SETTLED:])
        if not counted:
            return slice(0, 0)
        life, missions = counted.most_common(1)[0]
        first = self.lives.index(life, SETTLED)
        return slice(first, first + missions)

    @property
    def growth_alive(self) -> dict[str, float | None]:
        """Return the growth in the longest life, as shares."""
        life = self.longest_life
        return {name: grown(v[life], SETTLED_ALIVE) for name, v in self._series().items()}

    @property
    def flat(self) -> bool | None:
        """None: the soak was too short to tell."""
        if self.growth["blocks"] is None:
            return None
        return not any(self._grew())

    def as_json(self) -> dict[str, object]:
        life = self.longest_life
        return {
            "growth": self.growth,
            "one_life": {"missions": life.stop - life.start} | self.growth_alive,
            "resident_mb": round(self.resident[-1], 1) if self.resident else None,
            "resident_most_mb": round(max(self.resident), 1) if self.resident else None,
            "flat": self.flat,
        }

    def in_words(self) -> Iterator[str]:
        """Yield what an operator must be told: what has grown, and what could not be judged."""
        if self.flat is None:
            least = 2 * SETTLED + LAST
            yield f"memory: not judged, for want of missions ({len(self.lives)} of {least})"
            return
        yield from self._grew()
        if self.growth_alive["blocks"] is None:
            life, least = self.longest_life, 2 * SETTLED_ALIVE + LAST
            lived = f"lived through {life.stop - life.start} of {least} missions"
            yield f"memory of one program: not judged, since none {lived}"

    def _series(self) -> dict[str, list[float]]:
        return {"objects": self.objects, "blocks": self.blocks, "malloc": self.malloc}

    def _grew(self) -> Iterator[str]:
        life = self.longest_life
        alive = f"in one life of the program, of {life.stop - life.start} missions"
        for stretch, found in (("", self.growth), (f" {alive}", self.growth_alive)):
            for name, share in found.items():
                if share is not None and share >= FLAT:
                    yield f"memory grew: {name} by {share:.1%}{stretch}, allowed {FLAT:.0%}"


def grown(values: Sequence[float], settled: int) -> float | None:
    """Return the least of the last few values over the greatest of the second tenth, less one.

    So a leak shows, and a mission that is larger than the others does not. ``settled``: values that
    a tenth has at least. None: too few values to tell.
    """
    tenth = max(len(values) // 10, settled)
    if len(values) < 2 * tenth + LAST:
        return None
    return round(min(values[-LAST:]) / max(values[tenth : 2 * tenth]) - 1.0, 4)
