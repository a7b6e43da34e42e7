"""All scenes, by part of the issue they are about."""

from __future__ import annotations

from tests.sea import ascents, boards, mixtures, nuisances, people, senses, trials, wrecks
from tests.sea.scene import Scene

SCENES: tuple[Scene, ...] = (
    *ascents.SCENES,
    *senses.SCENES,
    *people.SCENES,
    *trials.SCENES,
    *boards.SCENES,
    *wrecks.SCENES,
    *nuisances.SCENES,
    *mixtures.SCENES,
)
