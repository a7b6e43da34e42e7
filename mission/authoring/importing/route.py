"""What a plan of somebody else's says: routes of steps, and what of the file is not among them.

Readers (one file per format) make a ``Source``; ``writing`` makes a mission of one of its routes.
What a file does not say is None here, and asked for by an option there.

    ImportErrors      (the author must act; holds everything that is wrong, by line or path)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from mission.model import Local, Position
from mission.model.extent import PROBLEMS


class ImportErrors(ValueError):
    """A file cannot be taken over; ``str`` says each reason with its place and a remedy."""


class Findings:
    """Collects, while a file is read, what is wrong with it and what is left out of it."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._wrong: list[str] = []
        self._left_out: dict[str, tuple[str, int]] = {}

    def refuse(self, where: str, message: str, hint: str = "") -> None:
        """Something is wrong; the reading goes on, and fails at its end."""
        remedy = f"\n    {hint}" if hint else ""
        self._wrong.append(f"{self._source}: {where}: {message}{remedy}")
        if len(self._wrong) >= PROBLEMS.most:
            self.complain()

    def refusal(self, where: str, message: str, hint: str = "") -> ImportErrors:
        """With this one, after which there is no reading on."""
        self.refuse(where, message, hint)
        return ImportErrors("\n".join(self._wrong))

    def complain(self) -> None:
        """Raises ImportErrors if anything is wrong."""
        if self._wrong:
            raise ImportErrors("\n".join(self._wrong))

    def leave_out(self, where: str, what: str) -> None:
        """The mission will not have it; the same again is counted."""
        first, count = self._left_out.get(what, (where, 0))
        self._left_out[what] = (first, count + 1)

    @property
    def left_out(self) -> tuple[str, ...]:
        """One line for each: where it stands first, what it is, how often."""
        rows = []
        for what, (where, count) in self._left_out.items():
            more = f" (and {count - 1} more)" if count > 1 else ""
            rows.append(f"{where}: {what}{more}")
        return tuple(rows)


@dataclass(frozen=True, slots=True)
class Point:
    """Where to go and how; SI. ``where`` is its place in the file. None: the file does not say."""

    place: Position | Local
    where: str
    name: str = ""
    depth: float | None = None
    altitude: float | None = None
    speed: float | None = None
    within: float | None = None


@dataclass(frozen=True, slots=True)
class Go:
    point: Point


@dataclass(frozen=True, slots=True)
class Home:
    """Back to where the mission begins."""

    where: str


@dataclass(frozen=True, slots=True)
class Circle:
    """About a point: for so many seconds, or so many ``turns``; ``side`` +1 is clockwise."""

    point: Point
    radius: float
    side: int
    seconds: float = 0.0
    turns: float = 0.0


@dataclass(frozen=True, slots=True)
class Mow:
    """Rows from a point, the first along ``bearing`` (rad), the next ones to ``side``."""

    point: Point
    bearing: float
    length: float
    spacing: float
    count: int
    side: int


@dataclass(frozen=True, slots=True)
class Undulate:
    """To a point, between two depths, at a pitch (rad)."""

    point: Point
    shallow: float
    deep: float
    pitch: float


@dataclass(frozen=True, slots=True)
class Rise:
    """To the surface, and ``seconds`` there."""

    where: str
    seconds: float = 0.0


Step = Go | Home | Circle | Mow | Undulate | Rise


@dataclass(frozen=True, slots=True)
class Route:
    """``steps`` reads them; what is wrong with a route that nobody takes is not told."""

    name: str
    where: str
    steps: Callable[[], tuple[Step, ...]]


@dataclass(frozen=True, slots=True)
class Source:
    """``local``: its points are metres from an origin that stands elsewhere."""

    routes: tuple[Route, ...]
    home: Position | None = None
    local: bool = False


def along(points: Iterable[Point | None]) -> tuple[Step, ...]:
    """Through them in turn; None stands for one that was complained of."""
    return tuple(Go(point) for point in points if point is not None)


def position(latitude: float, longitude: float, where: str, found: Findings) -> Position | None:
    """Degrees. None, with a complaint, for what is no place on earth."""
    if not (math.isfinite(latitude) and math.isfinite(longitude)):
        found.refuse(where, "latitude or longitude is no number")
    elif not -90.0 <= latitude <= 90.0:
        found.refuse(where, f"latitude {latitude:g} is beyond 90 degrees", "are they exchanged?")
    elif not -180.0 <= longitude <= 180.0:
        found.refuse(where, f"longitude {longitude:g} is beyond 180 degrees")
    else:
        return Position(latitude, longitude)
    return None


def below(height: float | None, where: str, found: Findings) -> float | None:
    """The depth of a height above the water (m); None for one that is not under it."""
    if height is not None and height > 0.0:
        found.leave_out(where, "a height above the water")
    return -height if height is not None and height < 0.0 else None


def number(text: str, what: str, where: str, found: Findings) -> float | None:
    """None, with a complaint, where ``text`` is no finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if math.isfinite(value):
        return value
    found.refuse(where, f"{what} is no number: {text.strip()[:40]!r}")
    return None


def text_of(data: bytes, found: Findings, encoding: str = "utf-8") -> str:
    try:
        return data.decode(encoding).removeprefix("\ufeff").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise found.refusal("the file", f"it is not {encoding}: byte {error.start}") from None
