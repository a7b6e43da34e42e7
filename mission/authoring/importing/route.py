"""What a plan of somebody else's says: routes of steps, and what of the file is not among them.

Readers (one file per format) make a ``Source``; ``writing`` makes a mission of one of its routes.
What a file does not say is None here, and asked for by an option there.

    ImportErrors      (the author must act; holds everything that is wrong, by line or path)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from mission.model import Local, Position, Where
from mission.model.diagnostics import Diagnosed, Diagnostics, Stage
from mission.model.texts import NOWHERE

At = int | str  # where in a file: its line, a path such as ``items[3].type``, "" for all of it


class ImportErrors(Diagnosed):
    """A file cannot be taken over."""


class Findings:
    """Collects, while a file is read, what is wrong with it and what is left out of it."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._left_out: dict[str, tuple[At, int]] = {}
        self.read_in(b"")

    def read_in(self, data: bytes) -> None:
        """The text whose lines are shown, without control characters: anybody may have made it."""
        text = data.decode("utf-8", "replace")
        shown = "".join(c if c.isprintable() or c in "\t\n" else "?" for c in text)
        self._wrong = Diagnostics(Stage.IMPORT, shown, self._source, ImportErrors)
        self._rows = shown.split("\n")

    def refuse(self, code: str, where: At, message: str, hint: str = "") -> None:
        """Something is wrong; the reading goes on, and fails at its end."""
        self._wrong.add(code, self._place(where), _told(where, message), hint)

    def refusal(self, code: str, where: At, message: str, hint: str = "") -> Diagnosed:
        """With this one, after which there is no reading on."""
        return self._wrong.refusal(code, self._place(where), _told(where, message), hint)

    def complain(self) -> None:
        """Raises ImportErrors if anything is wrong."""
        self._wrong.complain()

    def _place(self, where: At) -> Where:
        """A line is meant whole, without what it is indented by."""
        if isinstance(where, str):
            return NOWHERE
        row = self._rows[where - 1] if 0 < where <= len(self._rows) else ""
        return Where(where, len(row) - len(row.lstrip()) + 1, len(row.strip()))

    def leave_out(self, where: At, what: str) -> None:
        """The mission will not have it; the same again is counted."""
        first, count = self._left_out.get(what, (where, 0))
        self._left_out[what] = (first, count + 1)

    @property
    def left_out(self) -> tuple[str, ...]:
        """One line for each: where it stands first, what it is, how often."""
        rows = []
        for what, (where, count) in self._left_out.items():
            more = f" (and {count - 1} more)" if count > 1 else ""
            rows.append(_told(said(where), f"{what}{more}"))
        return tuple(rows)


def said(where: At) -> str:
    return f"line {where}" if isinstance(where, int) else where


def _told(where: At, message: str) -> str:
    """Behind its path, if it has one: Diagnostics know no other place than lines."""
    return f"{where}: {message}" if isinstance(where, str) and where else message


@dataclass(frozen=True, slots=True)
class Point:
    """Where to go and how; SI. ``where`` is its place in the file. None: the file does not say."""

    place: Position | Local
    where: At
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

    where: At


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

    where: At
    seconds: float = 0.0


Step = Go | Home | Circle | Mow | Undulate | Rise


@dataclass(frozen=True, slots=True)
class Route:
    """``steps`` reads them; what is wrong with a route that nobody takes is not told."""

    name: str
    where: At
    steps: Callable[[], tuple[Step, ...]]


@dataclass(frozen=True, slots=True)
class Fence:
    """What the vehicle has to stay in, or out of (``out``), at any depth: a polygon."""

    out: bool
    corners: tuple[Position, ...]
    where: At


@dataclass(frozen=True, slots=True)
class Source:
    """``local``: its points are metres from an origin that stands elsewhere."""

    routes: tuple[Route, ...]
    home: Position | None = None
    local: bool = False
    fences: tuple[Fence, ...] = ()


def along(points: Iterable[Point | None]) -> tuple[Step, ...]:
    """Through them in turn; None stands for one that was complained of."""
    return tuple(Go(point) for point in points if point is not None)


def position(latitude: float, longitude: float, where: At, found: Findings) -> Position | None:
    """Degrees. None, with a complaint, for what is no place on earth."""
    if not (math.isfinite(latitude) and math.isfinite(longitude)):
        found.refuse("position", where, "latitude or longitude is no number")
    elif not -90.0 <= latitude <= 90.0:
        found.refuse(
            "position", where, f"latitude {latitude:g} is beyond 90 degrees", "are they exchanged?"
        )
    elif not -180.0 <= longitude <= 180.0:
        found.refuse("position", where, f"longitude {longitude:g} is beyond 180 degrees")
    else:
        return Position(latitude, longitude)
    return None


def below(height: float | None, where: At, found: Findings) -> float | None:
    """The depth of a height above the water (m); None for one that is not under it."""
    if height is not None and height > 0.0:
        found.leave_out(where, "a height above the water")
    return -height if height is not None and height < 0.0 else None


def number(text: str, what: str, where: At, found: Findings) -> float | None:
    """None, with a complaint, where ``text`` is no finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if math.isfinite(value):
        return value
    found.refuse("number", where, f"{what} is no number: {text.strip()[:40]!r}")
    return None


def text_of(data: bytes, found: Findings, encoding: str = "utf-8") -> str:
    try:
        return data.decode(encoding).removeprefix("\ufeff").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise found.refusal(
            "plan-format", "", f"it is not {encoding}: byte {error.start}"
        ) from None
