"""``auvmission faults --broken``: safety rules that are broken, and the flights that notice."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import click

from mission.commands.jobs import Where

if TYPE_CHECKING:
    from mission.verification.campaign.draw import Subject
    from mission.verification.campaign.noticing import Noticed


def break_rules(
    rule: str,
    seed: int,
    flights: int,
    where: Where,
    known: tuple[Subject, ...],
    *,
    as_json: bool,
    searched: bool,
) -> int:
    """Break a rule, or "all" one after the other. Return the exit code."""
    import json
    import shlex

    from mission.verification.campaign.noticing import Noticed, in_table
    from mission.verification.workers import results
    from mission.verification.workers.outcome import Lost
    from mission.verification.workers.progress import Progress

    names = _names(rule)
    work = functools.partial(_notice, seed, flights, known, searched)
    asked: dict[str, Any] = {"flights": "broken", "seed": seed, "most": flights}
    asked["searched"] = searched
    of = known[0].vehicle
    if of != "auv":
        asked["vehicle"] = of
    options = f"--seed {seed} --flights {flights}{' --search' * searched}"
    options += "" if of == "auv" else f" --vehicle {of}"
    found: list[Noticed] = []
    undone: list[str] = []
    with where.keeping(asked, Noticed) as kept:
        progress = Progress(len(names), "rules", functools.partial(click.echo, err=True))
        place = where.lasting(flights).place
        for noticed in results(work, names, place, kept=kept, progress=progress):
            if isinstance(noticed, Lost):
                undone.append(noticed.name)
                again = f"auvmission faults --broken {shlex.quote(noticed.name)} {options}"
                click.echo(f"{noticed}\n  again: {again}", err=as_json)
            else:
                found.append(noticed)
                click.echo(in_table(noticed), err=as_json)
    blind = [n.name for n in found if n.flights is None and not n.reason]
    object_ = {"rules": len(found), "noticed": sum(n.flights is not None for n in found)}
    flown = sum(n.flights or flights for n in found if not n.reason)
    told = {"blind": blind, "undone": undone, "flights": flights, "seed": seed, "flown": flown}
    click.echo(json.dumps(object_ | told))
    return 1 if blind or undone else 0


def _names(rule: str) -> list[str]:
    from mission.model.compiled import compiled
    from mission.verification.campaign.broken import BROKEN

    if rule != "all" and rule not in BROKEN:
        raise click.BadParameter(f"no rule {rule!r}; known: {', '.join(BROKEN)}")
    if compiled():
        raise click.UsageError("compiled code cannot be broken: --broken takes the pure build")
    return list(BROKEN) if rule == "all" else [rule]


def _notice(
    seed: int, flights: int, known: tuple[Subject, ...], searched: bool, name: str
) -> Noticed:
    from mission.verification.campaign.noticing import flights_of, notice

    return notice(name, flights_of(seed, known), flights, searched=searched)
