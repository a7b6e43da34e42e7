"""The leg that holds its settings and nothing else: heading 90 ZAF8 until ... timeout ...

A leg that names no type is a hold: the word may be left out.
"""

from __future__ import annotations

from dataclasses import dataclass

from mission.legs.base import WAY, Author, LegType
from mission.model import LegKind


@dataclass(frozen=True, slots=True)
class Hold(LegKind):
    pass


def _straight(author: Author) -> str:
    ends = author.rng.choice([f"for {author.rng.randint(5, 200)}", ""])
    return f"{author.course()}{author.way()}{author.lean()} " + (
        ends or f"until {author.guard()} {author.timeout()}"
    )


def _bottom(author: Author) -> str:
    return f"altitude {author.rng.randint(2, 6)} {author.course()} {author.timeout(200)}"


def _thrust(author: Author) -> str:
    """Down by the thrusters alone, until a depth or a clock."""
    gear, depth = author.rng.randint(5, 10), author.depth()
    return f"gear 0 down {gear} until depth > {depth} {author.timeout(60)}"


def _astern(author: Author) -> str:
    heading, gear = author.rng.randrange(0, 360, 5), author.rng.randint(2, 10)
    return f"gear -{gear} heading {heading}{author.way()} for {author.rng.randint(5, 100)}"


def _turn(author: Author) -> str:
    side, gear = author.rng.choice(["left", "right"]), author.rng.randint(2, 8)
    return f"{side} {gear} gear {author.rng.choice([0, 0, 4])} for {author.rng.randint(5, 100)}"


def _up(author: Author) -> str:
    return f"up {author.rng.randint(2, 10)} {author.course()} for {author.rng.randint(5, 60)}"


TYPE: LegType = LegType(
    name="hold",
    kind=Hold,
    description="hold the settings; may be left out",
    draws=(_straight, _straight, _bottom, _thrust, _astern, _turn, _up),
    trials=(f"a: {WAY} for 40",),
)
