"""Random missions that the check passes, by seed: what an author might write, and worse.

A text is drawn line by line: legs of every type, as their rows draw them, in groups and rounds. A
text that cannot be read, or that the check refuses, is discarded, and another is drawn. The limits
are drawn near to what the legs need, so that the check has something to refuse.

What does not live here: the grammar (language), what is proved (check).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from mission.authoring.check import Proved, check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import MissionErrors, digest, parse
from mission.engine.variables import VARIABLES
from mission.legs import LEGS
from mission.model import Mission
from mission.model.vehicle import Vehicle

TRIES = 200
DEEPEST = (6, 10, 15, 25, 40)  # m
HOME = "30.2874595 120.1535765"
LENGTH = 6  # legs in a body, at most


class NoneFound(RuntimeError):
    """None of ``TRIES`` texts passed: the generator or the check is wrong."""


@dataclass(frozen=True, slots=True)
class Generated:
    text: str
    mission: Mission
    proved: Proved


def generate(seed: int, number: int, vehicle: Vehicle) -> Generated:
    """Return a mission by seed and number. Raises NoneFound."""
    rng = Random(f"mission {seed} {number}")
    for _ in range(TRIES):
        text = "\n".join(Writer(rng, f"generated-{number}", vehicle).lines()) + "\n"
        try:
            mission = parse(text)
            chart = compile_mission(mission, vehicle, digest(mission))
        except MissionErrors as error:
            refusals = error.diagnostics
            continue
        report = check_mission(chart, vehicle)
        if report.ok and report.proved is not None:
            return Generated(text, mission, report.proved)
        refusals = report.refusals
    last = refusals[0].message
    raise NoneFound(
        f"seed {seed}, mission {number}: none of {TRIES} texts for {vehicle.name} passed the "
        f"check, the last since {last}"
    )


class Writer:
    """Writes one text, line by line; it is the Author with which legs draw themselves."""

    def __init__(self, rng: Random, name: str, vehicle: Vehicle) -> None:
        self.rng, self.name, self._vehicle = rng, name, vehicle
        self._deepest = rng.choice([d for d in DEEPEST if d <= vehicle.limits.depth] or DEEPEST)
        self._legs = self._groups = 0
        self.floor = rng.random() < 0.5

    def lines(self) -> Iterator[str]:
        rng = self.rng
        radius, minutes = rng.randint(3, 20) * 100, rng.randint(2, 24) * 10
        yield f"mission {self.name} vehicle {self._vehicle.name}"
        yield f"home {HOME}"
        yield f"safety radius {radius} time {minutes}min depth {self._deepest} voltage 10"
        floor = f" floor {self._deepest}" if self.floor else ""
        yield f"assume current {rng.choice([0, 0.1, 0.2, 0.3])}{floor}"
        yield self._dive()
        yield from self._body(2)
        if rng.random() < 0.5:
            yield f"home_run: goto home within 15 depth 2 gear 8 timeout {rng.randint(3, 10)}min"
        if rng.random() < 0.7:
            yield f"up: surface{rng.choice(['', ' until fix'])} timeout {rng.randint(2, 5)}min"
        if rng.random() < 0.3:
            yield f"on {self.guard()} held {rng.choice([0, 4, 10])} -> surface"

    def _body(self, levels: int) -> Iterator[str]:
        for _ in range(self.rng.randint(1, LENGTH)):
            if levels and self.rng.random() < 0.25:
                yield from self._group(levels - 1)
            else:
                yield self._leg()

    def _group(self, levels: int) -> Iterator[str]:
        self._groups += 1
        name = f"g{self._groups}"
        rounds = self.rng.randint(1, 3)
        yield f"repeat {rounds} {name}:" if rounds > 1 else f"group {name}:"
        yield from self._body(levels)
        if self.rng.random() < 0.4:
            yield f"on {self.guard()} held {self.rng.choice([0, 4])} -> surface"
        yield "end"

    def _dive(self) -> str:
        depth = self.depth()
        timeout = f"timeout {self.rng.randint(30, 120)}"
        return f"dive: {self.course()} depth {depth} until depth >= {depth - 0.5} {timeout}"

    def _leg(self) -> str:
        self._legs += 1
        draws = [draw for row in LEGS.values() for draw in row.draws]
        return f"l{self._legs}: {self.rng.choice(draws)(self)}"

    # --- what legs are made of ------------------------------------------------------------

    def course(self) -> str:
        return f"heading {self.rng.randrange(0, 360, 5)} gear {self.rng.choice([3, 4, 6, 8, 10])}"

    def depth(self) -> int:
        return self.rng.randint(1, self._deepest - 1)

    def timeout(self, most: int = 300) -> str:
        otherwise = self.rng.choice(["", "", " else surface"])
        return f"timeout {self.rng.randint(20, most)}{otherwise}"

    def way(self) -> str:
        """Return no text, which keeps the depth, or another depth."""
        return self.rng.choice(["", f" depth {self.depth()}"])

    def lean(self) -> str:
        if "attitude" not in self._vehicle.follows:
            return ""
        return self.rng.choice(["", f" pitch {self.rng.randint(-70, 70)}", " pitch 0", " roll 10"])

    def place(self) -> str:
        return f"north {self.rng.randint(-200, 200)} east {self.rng.randint(-200, 200)}"

    def guard(self) -> str:
        rng = self.rng
        drawn = [row.draw for row in VARIABLES.values() if row.draw is not None]
        one, other = (draw(rng, self._deepest) for draw in rng.sample(drawn, 2))
        return rng.choice([one, one, f"{one} {rng.choice(['and', 'or'])} {other}"])
