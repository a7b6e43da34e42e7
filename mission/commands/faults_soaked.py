"""``auvmission faults --soak``: missions in a row, by one program or several at once."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mission.commands.jobs import Where

if TYPE_CHECKING:
    from mission.verification.campaign.draw import Subject


def soak_here(days: float, seed: int, known: Sequence[Subject], calm: bool) -> int:
    """Fly one soak in this process. Return the exit code."""
    import json
    import tempfile

    from mission.verification.campaign.soak import Telling, soak
    from mission.verification.rig.vehicle import flown

    of = known[0].vehicle
    progress = functools.partial(click.echo, err=True)
    told = Telling(days, seed, of, calm, click.echo, progress)
    with tempfile.TemporaryDirectory(prefix="soak-") as folder:
        soaked = soak(days, seed, known, flown(of), Path(folder), told, calmly=calm)
    for line in soaked.memory.in_words():
        click.echo(line, err=True)
    click.echo(json.dumps(soaked.as_json()))
    if soaked.interrupted:
        raise KeyboardInterrupt
    return 0 if soaked.held else 1


def soak_seeds(
    days: float,
    seeds: range,
    where: Where,
    known: Sequence[Subject],
    calm: bool,
    *,
    as_json: bool,
) -> int:
    """Fly a soak of each seed, each in a process of its own, which looks at its memory. Return the
    exit code. What had ended is told by Ctrl-C, too."""
    import json

    found: dict[int, Any] = {}

    def told() -> bool:
        undone = [seed for seed in seeds if found.get(seed) is None]
        click.echo(json.dumps({"soaks": found, "undone": undone}))
        return bool(undone)

    try:
        held = _soak(days, seeds, where, known, calm, found, as_json=as_json)
    except KeyboardInterrupt:
        told()
        raise
    return 1 if told() or not held else 0


def _soak(
    days: float,
    seeds: range,
    where: Where,
    known: Sequence[Subject],
    calm: bool,
    found: dict[int, Any],
    *,
    as_json: bool,
) -> bool:
    """Put the object of each soak into ``found``, None for one without a result. Return whether all
    others held."""
    from mission.verification.campaign.soak import Summary, again, soak_alone
    from mission.verification.rig.vehicle import flown
    from mission.verification.workers import results
    from mission.verification.workers.outcome import Lost
    from mission.verification.workers.progress import Progress

    of, held = known[0].vehicle, True
    work = functools.partial(soak_alone, days, known, flown(of), calm)
    asked = {"flights": "soaked calmly" if calm else "soaked", "days": days}
    asked |= {} if of == "auv" else {"vehicle": of}
    with where.keeping(asked, Summary) as kept:
        progress = Progress(len(seeds), "soaks", functools.partial(click.echo, err=True))
        place = where.lasting(1.0 + days).place
        done = results(work, seeds, place, kept=kept, progress=progress)
        for seed, one in zip(seeds, done, strict=True):
            if isinstance(one, Lost):
                found[seed] = None
                click.echo(f"seed {one}\n{again(seed, of, calm, f'{days:g}')}", err=as_json)
                continue
            found[seed], held = one.found, held and one.held
            for line in one.stories:
                click.echo(line, err=as_json)
    return held
