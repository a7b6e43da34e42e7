"""A rehearsal as one HTML page, which loads nothing: the picture, and every figure in a table."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence

from mission.analysis.chapters import Chapter, Table
from mission.analysis.tell import html_body, page
from mission.verification.rehearsing.flights import Flown
from mission.verification.rehearsing.picture import draw_rehearsal
from mission.verification.rehearsing.report import Rehearsal, Spread, again


def html_page(made: Rehearsal, flown: Sequence[Flown], source: str, seed: int, title: str) -> str:
    drawn = io.BytesIO()
    draw_rehearsal(made, flown, drawn, title, "svg")
    picture = drawn.getvalue().decode()
    picture = picture[picture.index("<svg") :]
    inner = f"<figure>{picture}</figure>\n{html_body([*_chapters(made, source, seed)])}"
    return page(f"{title}, rehearsed", inner)


def _chapters(made: Rehearsal, source: str, seed: int) -> Iterator[Chapter]:
    low, high = made.chance
    done = made.outcomes.get("completed", 0)
    said = f"{done} of {made.asked} flights completed: {low:.1%} to {high:.1%} (95 %)"
    counts = made.outcomes | ({"undone": made.undone} if made.undone else {})
    outcomes = tuple((name, str(count)) for name, count in sorted(counts.items()))
    given = tuple(f"In every flight: {text}" for text in made.given)
    yield Chapter("What came of them", (said, *given), (Table(("outcome", "flights"), outcomes),))
    yield Chapter("Spreads", (), (Table(("", "5 %", "half", "95 %"), (*_spreads(made),)),))
    if made.reached:
        rows = tuple(
            (leg, f"{hits} of {made.asked}", f"{least:.1%} to {most:.1%}")
            for leg, (hits, least, most) in made.reached.items()
        )
        yield Chapter("Purpose", (), (Table(("rows", "reached it", "share, 95 %"), rows),))
    regions = tuple(
        (f"{r.share:.0%}", f"{r.north:.0f}", f"{r.east:.0f}", f"{r.axes[0]:.0f} by {r.axes[1]:.0f}")
        for r in made.regions
    )
    head = ("of the flights", "north of home, m", "east, m", "half axes, m")
    yield Chapter("Where it comes up", (), (Table(head, regions),))
    legs = tuple((leg, str(count)) for leg, count in made.legs.items())
    never = (f"Never flown: {', '.join(made.never)}",) if made.never else ()
    yield Chapter("Legs", never, (Table(("leg", "flights that came to it"), legs),))
    near = tuple((name, f"{share:.0%}") for name, share in made.near.items())
    yield Chapter("Limits", (), (Table(("limit", "used at most"), near),))
    worst = tuple(
        (f"{f.number}: {f.outcome}", f"{f.covered:.0%}", f"{f.error:.0f}", again(f, source, seed))
        for f in made.worst
    )
    head = ("flight", "coverage", "error, m", "flown again by")
    yield Chapter("The worst", (), (Table(head, worst),))


def _spreads(made: Rehearsal) -> Iterator[tuple[str, ...]]:
    yield _row("time, min", made.time, 60.0)
    yield _row("energy, Wh", made.energy, 3600.0)
    yield _row("position error, m", made.error, 1.0)
    if made.clearance is not None:
        yield _row(f"clearance, m ({made.clearance[1]} aground)", made.clearance[0], 1.0)
    for leg, (true, estimated) in made.coverage.items():
        yield _row(f"coverage of {leg}, %", true, 0.01)
        yield _row(f"coverage of {leg} by the estimate, %", estimated, 0.01)


def _row(name: str, spread: Spread, unit: float) -> tuple[str, ...]:
    return (name, *(f"{v / unit:.1f}" for v in (spread.low, spread.middle, spread.high)))
