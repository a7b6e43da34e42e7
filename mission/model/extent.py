"""How large a mission may be. A larger text is refused with the figure, before it is read further.

With these bounds, judging any text takes seconds, and neither stack nor memory can run out. An
accepted mission loads and steps in bounded time.

What does not live here: ranges of single numbers (language.words), how many legs the check walks
(check.flow).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Extent:
    most: int
    what: str

    @property
    def exceeded(self) -> str:
        return f"more than {self.most:,} {self.what}"


BYTES = Extent(4 << 20, "bytes in a file")
STATEMENTS = Extent(9_999, "statements in a mission")  # the wire's limit (E-F3)
LINES = Extent(9_999, "lines in its canonical text")
CODE = Extent(500_000, "characters in all statements, without comments")
STATEMENT = Extent(20_000, "characters in a statement or a YAML value")
NODES = Extent(120_000, "values and keys in YAML, aliases written out")
DEEPEST_YAML = Extent(100, "lists and tables in each other, in YAML")
DEEPEST_GROUP = Extent(16, "groups in each other")
DEEPEST_GUARD = Extent(20, "nots and parentheses in each other")
NAME = Extent(40, "characters in a name")
PLACES = Extent(500, "places in a follow, or corners in a cover")
CORNERS = Extent(100, "corners in an area")
AREAS = Extent(32, "areas in a mission")
HANDLERS = Extent(64, "handlers in a mission")
WATCHED = Extent(200, "comparisons watched in a leg: its own, and those of the handlers around it")
PICTURE = Extent(1_000, "legs and groups in a graph")
PROBLEMS = Extent(100, "errors told at once")

EXTENTS = (
    BYTES,
    STATEMENTS,
    LINES,
    CODE,
    STATEMENT,
    NODES,
    DEEPEST_YAML,
    DEEPEST_GROUP,
    DEEPEST_GUARD,
    NAME,
    PLACES,
    CORNERS,
    AREAS,
    HANDLERS,
    WATCHED,
    PICTURE,
    PROBLEMS,
)
