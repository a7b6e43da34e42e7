"""All scenes."""

from __future__ import annotations

from tests.sea import (
    afloat,
    aids,
    ascents,
    boards,
    channels,
    doubts,
    habits,
    leftovers,
    mixtures,
    nuisances,
    overlooked,
    pairs,
    people,
    promises,
    relapses,
    ruins,
    senses,
    slaves,
    storms,
    trials,
    unplaced,
    wrecks,
)
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
    *doubts.SCENES,
    *relapses.SCENES,
    *ruins.SCENES,
    *channels.SCENES,
    *slaves.SCENES,
    *storms.SCENES,
    *promises.SCENES,
    *habits.SCENES,
)

# Flown by `make check`; draws are from the scenes above.
PAIRS = (
    *pairs.SCENES,
    *leftovers.SCENES,
    *afloat.SCENES,
    *aids.SCENES,
    *overlooked.SCENES,
    *unplaced.SCENES,
)
