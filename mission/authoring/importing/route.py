"""The model of an imported plan: routes of steps, and a list of what was left out.

Readers (one file per format) make a ``Source``; ``writing`` makes a mission from one of its routes.
A value that a file does not state is None here; ``writing`` takes it from an option.

    ImportErrors      (the author must act; holds all errors, by line or path)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from mission.model import Local, Position, Where
from mission.model.diagnostics import Diagnosed, Diagnostics, Stage
from mission.model.texts import NOWHERE

At = int | str  # a place in a file: its line, a path such as ``items[3].type``, "" for the file


class ImportErrors(Diagnosed):
    """A file cannot be imported."""


class Findings:
    """Collects the errors of a file, and what is left out of it, while it is read."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._left_out: dict[str, tuple[At, int]] = {}
        self.read_in(b"")

    def read_in(self, data: bytes) -> None:
        """Set the text whose lines are shown in messages. Control characters are replaced, since
        the file may be hostile."""
        text = data.decode("utf-8", "replace")
        shown = "".join(c if c.isprintable() or c in "\t\n" else "?" for c in text)
        self._wrong = Diagnostics(Stage.IMPORT, shown, self._source, ImportErrors)
        self._rows = shown.split("\n")

    def refuse(self, code: str, where: At, message: str, hint: str = "") -> None:
        """Record an error; reading continues, and fails at its end."""
        self._wrong.add(code, self._place(where), _told(where, message), hint)

    def refusal(self, code: str, where: At, message: str, hint: str = "") -> Diagnosed:
        """The exception to raise for an error after which reading cannot continue; it holds all
        errors so far."""
        return self._wrong.refusal(code, self._place(where), _told(where, message), hint)

    def complain(self) -> None:
        """Raise ImportErrors if there are errors."""
        self._wrong.complain()

    def _place(self, where: At) -> Where:
        """The whole line, without its indentation; NOWHERE for a path."""
        if isinstance(where, str):
            return NOWHERE
        row = self._rows[where - 1] if 0 < where <= len(self._rows) else ""
        return Where(where, len(row) - len(row.lstrip()) + 1, len(row.strip()))

    def leave_out(self, where: At, what: str) -> None:
        """Record something that the mission will not have; repetitions are counted."""
        first, count = self._left_out.get(what, (where, 0))
        self._left_out[what] = (first, count + 1)

    @property
    def left_out(self) -> tuple[str, ...]:
        """One line for each thing left out: its first place, what it is, how often."""
        rows = []
        for what, (where, count) in self._left_out.items():
            more = f" (and {count - 1} more)" if count > 1 else ""
            rows.append(_told(said(where), f"{what}{more}"))
        return tuple(rows)


def said(where: At) -> str:
    return f"line {where}" if isinstance(where, int) else where


def _told(where: At, message: str) -> str:
    """The message behind its path, if there is one, since Diagnostics only have lines."""
    return f"{where}: {message}" if isinstance(where, str) and where else message


@dataclass(frozen=True, slots=True)
class Point:
    """Where to go and how; SI. ``where``: its place in the file. None: not stated in the file."""

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
    """Go back to where the mission begins."""

    where: At


@dataclass(frozen=True, slots=True)
class Circle:
    """Circle a point for ``seconds`` or for ``turns``; ``side`` +1 is clockwise."""

    point: Point
    radius: float
    side: int
    seconds: float = 0.0
    turns: float = 0.0


@dataclass(frozen=True, slots=True)
class Mow:
    """Fly rows from a point: the first along ``bearing`` (rad), the next ones to ``side``."""

    point: Point
    bearing: float
    length: float
    spacing: float
    count: int
    side: int


@dataclass(frozen=True, slots=True)
class Undulate:
    """Go to a point, up and down between two depths, at a pitch (rad)."""

    point: Point
    shallow: float
    deep: float
    pitch: float


@dataclass(frozen=True, slots=True)
class Rise:
    """Go to the surface, and stay ``seconds`` there."""

    where: At
    seconds: float = 0.0


Step = Go | Home | Circle | Mow | Undulate | Rise


@dataclass(frozen=True, slots=True)
class Route:
    """One route. ``steps`` reads its steps later: errors in routes that are not chosen do not
    count."""

    name: str
    where: At
    steps: Callable[[], tuple[Step, ...]]


@dataclass(frozen=True, slots=True)
class Fence:
    """A polygon that the vehicle must stay in, or out of (``out``), at any depth."""

    out: bool
    corners: tuple[Position, ...]
    where: At


@dataclass(frozen=True, slots=True)
class Source:
    """The content of a file. ``local``: points are in metres from an origin that the file does not
    state."""

    routes: tuple[Route, ...]
    home: Position | None = None
    local: bool = False
    fences: tuple[Fence, ...] = ()


def along(points: Iterable[Point | None]) -> tuple[Step, ...]:
    """Steps through the points in turn; None stands for a point with an error."""
    return tuple(Go(point) for point in points if point is not None)


def position(latitude: float, longitude: float, where: At, found: Findings) -> Position | None:
    """A position in degrees; None, with an error recorded, if it is not on earth."""
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
    """The depth (m) of a height above the water; None if it is not below the surface."""
    if height is not None and height > 0.0:
        found.leave_out(where, "a height above the water")
    return -height if height is not None and height < 0.0 else None


def number(text: str, what: str, where: At, found: Findings) -> float | None:
    """The number in ``text``; None, with an error recorded, if it is no finite number."""
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
