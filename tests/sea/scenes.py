"""All scenes, by part of the issue they are about."""

from __future__ import annotations

from tests.sea import ascents, boards, people, senses, trials
from tests.sea.scene import Scene

SCENES: tuple[Scene, ...] = (
    *ascents.SCENES,
    *senses.SCENES,
    *people.SCENES,
    *trials.SCENES,
    *boards.SCENES,
)
