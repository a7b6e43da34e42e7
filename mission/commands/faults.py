"""`auvmission faults`: seeded flights with faults of everything, judged by the laws."""

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

    Exit 0: no vehicle lost, no limit overrun, no command without a cause. Exit 1: a flight failed;
    each is printed with the command that flies it again. The last line of stdout is one JSON
    object.

    --search steers the flights to where the margins to the laws are small. They have names instead
    of numbers, and the object also says which came nearest to each law. --broken breaks one safety
    rule (or all, one after the other) in the running program, and flies until a flight notices:
    exit 0 if all are noticed, except rules with a stated reason.

    With --calm there are only currents and noise: a flight that a limit ends is a false alarm.

    --vehicle flies the missions of another vehicle, with the faults of its board. Commands, and the
    laws on what it may be sent, are those of its own document.

    `at_most` bounds the probability that a flight drawn like these breaks a law (exact binomial,
    95 %); a flight that is `undone` counts as if it had. `digest` is the same wherever the same
    flights are flown.
    """
    import json
    import sys

    from mission.commands.faults_broken import break_rules
    from mission.commands.faults_soaked import soak_here, soak_seeds
    from mission.verification.campaign.faults import Totals

    _refuse_two_kinds(rule=rule, soak=soak, flight=flight, search=search, calm=calm)
    _refuse_unused(where, flight, report, soak, soaks)
    known = _known(vehicle)
    if rule is not None:
        sys.exit(break_rules(rule, seed, flights, where, known, as_json=as_json, searched=search))
    if soak is not None and soaks is not None:
        sys.exit(soak_seeds(soak, range(seed, seed + soaks), where, known, calm, as_json=as_json))
    if soak is not None:
        sys.exit(soak_here(soak, seed, known, calm))
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


def _refuse_two_kinds(**said: object) -> None:
    """Refuse kinds of flights of which all but one would be ignored."""
    kinds = {name for name, value in said.items() if value not in (None, False)}
    together = ({"rule", "search"}, {"flight", "calm"}, {"soak", "calm"})
    if len(kinds) > 1 and kinds not in together:
        names = sorted("--broken" if kind == "rule" else f"--{kind}" for kind in kinds)
        raise click.UsageError(f"{' and '.join(names)} are kinds of flights: say one")


def _refuse_unused(
    where: Where,
    flight: str | None,
    report: Path | None,
    soak: float | None,
    soaks: int | None,
) -> None:
    if report is not None and flight is None:
        raise click.UsageError("--report needs --flight")
    if soaks is not None and soak is None:
        raise click.UsageError("--soaks needs --soak DAYS")
    if flight is not None:
        where.refuse("--flight flies here and keeps nothing")
    if soak is not None and soaks is None:
        where.refuse("--soak flies here and keeps nothing", ", or say --soaks 1")


def _known(vehicle: str) -> tuple[Subject, ...]:
    """The missions of the vehicle. Raises click.BadParameter."""
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
    """The plan of a flight. A number is a random flight, or a calm one; a name is of a search."""
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
    """Return the values beside the totals: a bound on the share of flights that break a law. A
    flight without a result counts as if it had."""
    import functools

    from mission.verification.bounds import at_most
    from mission.verification.campaign.faults import FlightResult
    from mission.verification.workers import results
    from mission.verification.workers.progress import Progress

    work = functools.partial(_fly_calmly if calm else _fly_numbered, seed, known)
    asked = {"flights": "calm" if calm else "by chance", "seed": seed}
    if known[0].vehicle != "auv":
        asked["vehicle"] = known[0].vehicle
    tell = functools.partial(click.echo, err=True)
    with where.keeping(asked, FlightResult) as kept:
        progress = Progress(flights, "flights", tell)
        found = results(work, range(flights), where.place, kept=kept, progress=progress)
        for number, result in enumerate(found):
            again = _again(seed, str(number), calm, known)
            _take(totals, result, str(number), as_json, again)
    return {"at_most": at_most(totals.broken + totals.undone, totals.flights + totals.undone)}


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
    """Return the values beside the totals: which flights came nearest to each law."""
    import functools

    from mission.verification.campaign.search import Search, Searched, flown
    from mission.verification.workers.progress import Progress

    search = Search(known)
    tell = functools.partial(click.echo, err=True)
    asked = {"flights": "searched", "seed": seed}
    if known[0].vehicle != "auv":
        asked["vehicle"] = known[0].vehicle
    with where.keeping(asked, Searched) as kept:
        progress = Progress(flights, "flights", tell)
        for name, result in flown(search, seed, flights, known, where.place, kept, progress):
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


@contextmanager
def _recorders(
    folder: Path | None, plan: Plan, name: str
) -> Iterator[Callable[[], Recorder | None]]:
    """Make a black box for each life of the program. At the end all are complete and closed, with
    notes of sea and seed. Only the story names the faults, so that a reader may judge without."""
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
