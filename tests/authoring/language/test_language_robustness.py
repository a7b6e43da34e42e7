"""Whatever stands in a file: a mission, or errors with places; never anything else."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from mission.authoring.language import MissionErrors, layout, parse, to_lines, to_yaml
from mission.model.diagnostics import Diagnostic

MISSIONS = Path(__file__).resolve().parents[3] / "missions"
FRAGMENTS = """-> ( ) not and until held sure % 1e999 1e-999 - -- 9999999999999999999999 ZAA5;-3 ZAH
+ # { } [ ] : ' " &a *a << é \t \0 @ $ end repeat group param here home 1:30 !!python/object | > ? ~
null nan inf"""


def mutated(rng: random.Random, texts: list[str]) -> str:
    text = rng.choice(texts)
    for _ in range(rng.randint(1, 4)):
        start = rng.randrange(len(text) + 1)
        end = min(len(text), start + rng.randint(0, 20))
        other = rng.choice(texts)
        at = rng.randrange(len(other))
        pieces = (
            "",
            rng.choice(re.split("[ \n]", FRAGMENTS)),
            other[at : at + rng.randint(1, 40)],
            "\n",
        )
        text = text[:start] + rng.choice(pieces) + text[rng.choice([start, end]) :]
    return text


def problems_of(text: str) -> tuple[Diagnostic, ...]:
    try:
        parse(text)
    except MissionErrors as errors:
        return errors.diagnostics
    return ()


@pytest.mark.parametrize("seed", range(4))
def test_a_damaged_mission_is_read_or_refused_with_places_and_hints(seed: int) -> None:
    paths = sorted(p for p in MISSIONS.iterdir() if p.suffix in (".yaml", ".mission"))
    texts = [path.read_text("utf-8") for path in paths]
    texts += [to_lines(parse(text)) for text in texts]
    rng = random.Random(seed)
    for _ in range(40):
        text = mutated(rng, texts)
        refused = problems_of(text)
        assert all(p.message and p.hint for p in refused)
        assert all(1 <= p.where.line <= text.count("\n") + 1 for p in refused)
        if not refused:
            mission = parse(text)
            assert parse(to_lines(mission)) == parse(to_yaml(mission)) == mission
            assert parse(layout.formatted(text)) == mission
