"""`auvmission faults`: seeded flights with faults of everything, and what became of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mission.commands.jobs import Where, job_options
from mission.commands.options import VEHICLE_NAME, tell_confirmed
from mission.commands.output import make_folder

if TYPE_CHECKING:
    from mission.onboard.runtime.records import Recorder
    from mission.verification.campaign.draw import Plan, Subject
    from mission.verification.campaign.faults import FlightResult, Totals
    from mission.verification.campaign.noticing import Noticed
    from mission.verification.workers.outcome import Lost


@click.command()
@click.option("--flights", type=click.IntRange(1), default=50, show_default=True,
              help="How many flights.")  # fmt: skip
@click.option("--seed", type=int, default=0, show_default=True, help="Any; the same flights again.")
@click.option("--flight", metavar="NUMBER|NAME", help="This one alone, with its whole story.")
@click.option("--search", is_flag=True, help="Steer towards flights that nearly break a law.")
@click.option(
    "--report",
    type=click.Path(path_type=Path, file_okay=False),
    help="With --flight: folder for its black boxes, one for each life of the program.",
)
@click.option(
    "--soak",
    metavar="DAYS",
    type=click.FloatRange(0.0, min_open=True),
    help="Missions in a row instead.",
)
@click.option("--soaks", type=click.IntRange(1),
              help="With --soak: so many at once, of this seed and those behind it.")  # fmt: skip
@click.option(
    "--broken", "rule", metavar="NAME|all", help="Break this safety rule, and see who notices."
)
@click.option("--vehicle", type=VEHICLE_NAME, metavar="NAME", default="auv", show_default=True,
              help="A shipped vehicle: auv, coreboard, rov, robot, mainboard.")  # fmt: skip
@click.option("--calm", is_flag=True, help="Without any fault: no limit may act.")
@click.option("--json", "as_json", is_flag=True, help="The object alone, no story.")
@job_options
def faults(
    flights: int,
    seed: int,
    flight: str | None,
    search: bool,
    report: Path | None,
    soak: float | None,
    soaks: int | None,
    rule: str | None,
    vehicle: str,
    calm: bool,
    as_json: bool,
    where: Where,
) -> None:
    """Fly the shipped missions with faults of vehicle, links, operators and program.

    Zero vehicles lost, zero limits overrun, zero commands that nothing asked for: exit 0. Each
    flight that fails is told with the command that flies it again: exit 1. The last line of
    stdout is one JSON object.

    With --search the flights go where the margins to the laws are small; they have names instead of
    numbers, and the object also says which came nearest to each law. With --broken one safety rule
    (or all, one after the other) is broken in the running program, and flights are flown until one
    notices: exit 0 if all are noticed but those with a reason.

    With --calm nothing is disturbed but by currents and noise: what a limit ends is a false alarm.

    With --vehicle the missions that fly on another vehicle, with what can fail of its board; its
    words are those of its own document, and so are the laws of what it may be told.

    `at_most` bounds the probability that a flight drawn like these breaks a law (exact binomial,
    95 %). `digest` is the same wherever the same flights are flown.
    """
    import json
    import sys

    from mission.verification.campaign.faults import Totals

    known = _known(vehicle)
    if rule is not None:
        sys.exit(_break(rule, seed, flights, where, known, as_json, search))
    if soaks is not None:
        if soak is None:
            raise click.UsageError("--soaks needs --soak DAYS")
        sys.exit(_soak_many(soak, range(seed, seed + soaks), where, known, calm, as_json))
    if soak is not None:
        sys.exit(_soak(soak, seed, known, calm))
    totals = Totals()
    also: dict[str, Any] = {}
    if flight is not None:
        _fly_one(totals, seed, flight, known, report, calm, as_json)
    elif search:
        also = _search(totals, seed, flights, where, known, as_json)
    else:
        also = _by_chance(totals, seed, flights, where, known, calm, as_json)
    click.echo(json.dumps(totals.as_json() | also))
    sys.exit(0 if totals.clean else 1)


def _known(vehicle: str) -> tuple[Subject, ...]:
    """What flies. Raises click.BadParameter."""
    from mission.verification.campaign.faults import fitting, shipped, subjects
    from mission.verification.rig.speech import MOTION

    if vehicle == "auv":
        return tuple(subjects(shipped()))
    if vehicle not in MOTION:
        there = ", ".join(("auv", *MOTION))
        raise click.BadParameter(f"{vehicle}: flights with faults are of {there}")
    tell_confirmed(vehicle)
    return tuple(fitting(vehicle))


def _plan(flight: str, seed: int, known: Sequence[Subject], calmly: bool) -> Plan:
    """A number is a flight by chance, or without faults, a name one of a search."""
    from mission.verification.campaign.calm import calm
    from mission.verification.campaign.draw import draw
    from mission.verification.campaign.steered import plan_of

    if flight.isdecimal():
        return (calm if calmly else draw)(seed, int(flight), known)
    if calmly:
        raise click.BadParameter(f"{flight!r}: flights without faults have numbers")
    try:
        return plan_of(flight, seed, known)
    except ValueError as error:
        raise click.BadParameter(str(error)) from None


def _fly_one(
    totals: Totals,
    seed: int,
    name: str,
    known: Sequence[Subject],
    report: Path | None,
    calm: bool,
    as_json: bool,
) -> None:
    plan = _plan(name, seed, known, calm)
    with _recorders(report, plan, name) as recorder:
        result = _fly_plan(plan, recorder, calm)
    totals.add(result)
    click.echo(_story(name, result, _again(seed, name, calm, known)), err=as_json)


def _by_chance(
    totals: Totals,
    seed: int,
    flights: int,
    where: Where,
    known: Sequence[Subject],
    calm: bool,
    as_json: bool,
) -> dict[str, Any]:
    """What the object says beside the totals: how seldom a flight breaks a law."""
    import functools

    from mission.verification.bounds import at_most
    from mission.verification.campaign.faults import FlightResult
    from mission.verification.workers import results
    from mission.verification.workers.progress import with_progress

    work = functools.partial(_fly_calmly if calm else _fly_numbered, seed, known)
    asked = {"flights": "calm" if calm else "by chance", "seed": seed}
    if known[0].vehicle != "auv":
        asked["vehicle"] = known[0].vehicle
    tell = functools.partial(click.echo, err=True)
    with where.keeping(asked, FlightResult) as kept:
        found = results(work, range(flights), where.place, kept=kept)
        for number, result in enumerate(with_progress(found, flights, "flights", tell, kept.count)):
            again = _again(seed, str(number), calm, known)
            _take(totals, result, str(number), as_json, again)
    return {"at_most": at_most(totals.broken, totals.flights)}


def _take(
    totals: Totals,
    result: FlightResult | Lost,
    name: str,
    as_json: bool,
    again: str,
) -> None:
    from mission.verification.workers.outcome import Lost

    if isinstance(result, Lost):
        totals.undone += 1
        click.echo(f"flight {result}\n{again}", err=as_json)
        return
    totals.add(result)
    if result.violations:
        click.echo(_story(name, result, again), err=as_json)


def _search(
    totals: Totals,
    seed: int,
    flights: int,
    where: Where,
    known: Sequence[Subject],
    as_json: bool,
) -> dict[str, Any]:
    """What the object says beside the totals: which flights came nearest."""
    import functools

    from mission.verification.campaign.search import Search, Searched, flown
    from mission.verification.workers.progress import with_progress

    search = Search(known)
    tell = functools.partial(click.echo, err=True)
    asked = {"flights": "searched", "seed": seed}
    if known[0].vehicle != "auv":
        asked["vehicle"] = known[0].vehicle
    with where.keeping(asked, Searched) as kept:
        found = flown(search, seed, flights, known, where.place, kept)
        for name, result in with_progress(found, flights, "flights", tell, kept.count):
            _take(totals, result, name, as_json, _again(seed, name, False, known))
    nearest = sorted(search.nearest.items())
    told = {law: {"seed": seed, "flight": near.name, "left": near.left} for law, near in nearest}
    return {"nearest": told}


def _fly_numbered(seed: int, known: Sequence[Subject], number: int) -> FlightResult:
    from mission.verification.campaign.faults import fly_numbered

    return fly_numbered(seed, number, known)


def _fly_calmly(seed: int, known: Sequence[Subject], number: int) -> FlightResult:
    from mission.verification.campaign.calm import calm, fly_calmly

    return fly_calmly(calm(seed, number, known))


def _fly_plan(plan: Plan, recorder: Callable[[], Recorder | None], calmly: bool) -> FlightResult:
    from mission.verification.campaign.calm import fly_calmly
    from mission.verification.campaign.faults import fly_plan, result_of

    if calmly:
        return fly_calmly(plan, recorder)
    return result_of(plan, fly_plan(plan, plan.vehicle, recorder), plan.vehicle, plan.profile)


def _break(
    rule: str,
    seed: int,
    flights: int,
    where: Where,
    known: tuple[Subject, ...],
    as_json: bool,
    search: bool,
) -> int:
    """The exit code."""
    import functools
    import json

    from mission.model.compiled import compiled
    from mission.verification.campaign.broken import BROKEN
    from mission.verification.campaign.noticing import Noticed, in_table
    from mission.verification.workers import results
    from mission.verification.workers.outcome import Lost

    if rule != "all" and rule not in BROKEN:
        raise click.BadParameter(f"no rule {rule!r}; known: {', '.join(BROKEN)}")
    if compiled():
        raise click.UsageError("compiled code cannot be broken: --broken takes the pure build")
    names = list(BROKEN) if rule == "all" else [rule]
    found: list[Noticed] = []
    work = functools.partial(_notice, seed, flights, known, search)
    asked: dict[str, Any] = {"flights": "broken", "seed": seed, "most": flights}
    asked["searched"] = search
    if known[0].vehicle != "auv":
        asked["vehicle"] = known[0].vehicle
    undone: list[str] = []
    with where.keeping(asked, Noticed) as kept:
        for noticed in results(work, names, where.lasting(flights).place, kept=kept):
            if isinstance(noticed, Lost):
                undone.append(noticed.name)
            else:
                found.append(noticed)
            click.echo(
                str(noticed) if isinstance(noticed, Lost) else in_table(noticed), err=as_json
            )
    blind = [n.name for n in found if n.flights is None and not n.reason]
    object_ = {"rules": len(found), "noticed": sum(n.flights is not None for n in found)}
    flown = sum(n.flights or flights for n in found if not n.reason)
    told = {"blind": blind, "undone": undone, "flights": flights, "seed": seed, "flown": flown}
    click.echo(json.dumps(object_ | told))
    return 1 if blind or undone else 0


def _notice(
    seed: int, flights: int, known: tuple[Subject, ...], search: bool, name: str
) -> Noticed:
    from mission.verification.campaign.noticing import flights_of, notice

    return notice(name, flights_of(seed, known), flights, searched=search)


def _soak(days: float, seed: int, known: Sequence[Subject], calm: bool) -> int:
    """The exit code."""
    import json
    import tempfile

    from mission.verification.campaign import soak
    from mission.verification.rig.vehicle import flown

    def told(soaked: soak.Soaked, result: FlightResult) -> None:
        for line in soak.story(soaked, result, seed, known[0].vehicle, calm):
            click.echo(line)
        if soaked.missions % 20 == 0:
            words = f"{soaked.days:.2f} of {days:g} days, {soaked.missions} missions"
            click.echo(f"{words}, growth {soaked.memory.growth}", err=True)

    vehicle = flown(known[0].vehicle)
    with tempfile.TemporaryDirectory(prefix="soak-") as folder:
        soaked = soak.soak(days, seed, known, vehicle, Path(folder), told, calmly=calm)
    for line in soaked.memory.in_words():
        click.echo(line, err=True)
    click.echo(json.dumps(soaked.as_json()))
    if soaked.interrupted:
        raise KeyboardInterrupt
    return 0 if soaked.held else 1


def _soak_many(
    days: float, seeds: range, where: Where, known: Sequence[Subject], calm: bool, as_json: bool
) -> int:
    """The exit code. Each in a process of its own, which looks at its memory."""
    import functools
    import json

    from mission.verification.campaign.soak import Summary, soak_alone
    from mission.verification.rig.vehicle import flown
    from mission.verification.workers import results
    from mission.verification.workers.outcome import Lost

    work = functools.partial(soak_alone, days, known, flown(known[0].vehicle), calm)
    place = where.lasting(1.0 + days).place
    found: dict[int, Any] = {}
    held = True
    asked = {"flights": "soaked calmly" if calm else "soaked", "days": days}
    if known[0].vehicle != "auv":
        asked["vehicle"] = known[0].vehicle
    with where.keeping(asked, Summary) as kept:
        for seed, one in zip(seeds, results(work, seeds, place, kept=kept), strict=True):
            held = held and not isinstance(one, Lost) and one.held
            found[seed] = None if isinstance(one, Lost) else one.found
            for line in [f"seed {one}"] if isinstance(one, Lost) else one.stories:
                click.echo(line, err=as_json)
    click.echo(json.dumps({"soaks": found}))
    return 0 if held else 1


@contextmanager
def _recorders(
    folder: Path | None, plan: Plan, name: str
) -> Iterator[Callable[[], Recorder | None]]:
    """A black box for each life of the program, all of them whole and closed at the end, with sea
    and seed; what went wrong is told beside them, for whoever has first read what they say."""
    if folder is None:
        yield lambda: None
        return
    from mission.onboard.blackbox import BlackBox, close_recording
    from mission.verification.simulation.flown import Flown

    make_folder(folder)
    lives: list[BlackBox] = []

    def make() -> BlackBox:
        path = folder / f"life{len(lives) + 1}.mcap"
        path.unlink(missing_ok=True)
        lives.append(BlackBox(path))
        return lives[-1]

    try:
        yield make
    finally:
        of, sea = plan.subject.mission.name, plan.settings.sea
        flown = Flown(of, plan.vehicle.name, plan.profile, plan.seed, (), sea, None)
        for box in lives:
            box.close()
            close_recording(box.path, flown.as_notes() | {"seed": f"{plan.seed}, flight {name}"})


def _story(name: str, result: FlightResult, again: str) -> str:
    found = [f"  {v.kind} at {v.t:.1f} s: {v.says}" for v in result.violations]
    return "\n".join([f"flight {name}: {result.words}", *found, again])


def _again(seed: int, name: str, calm: bool, known: Sequence[Subject]) -> str:
    of = known[0].vehicle
    words = f"{' --calm' * calm}{'' if of == 'auv' else f' --vehicle {of}'}"
    return f"  again: auvmission faults{words} --seed {seed} --flight {name}"
