"""`auvmission campaign`: fly missions that the check passed, to test the bounds it proved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.jobs import Where, job_options
from mission.commands.options import MISSION, SEED, VEHICLE_NAME, tell_confirmed

if TYPE_CHECKING:
    from mission.model.vehicle import Vehicle
    from mission.verification.campaign.proofs import Claim, Shown
    from mission.verification.workers.kept import Kept
    from mission.verification.workers.outcome import Lost
    from mission.verification.workers.places import Place


@dataclass(frozen=True, slots=True)
class Subject:
    """What is flown, with all that a worker needs of it. ``known`` None: the generated mission of
    this number, which the worker makes."""

    vehicle: Vehicle
    known: Claim | None
    number: int = 0

    @property
    def source(self) -> str:
        """The way to it on a command line."""
        return f"--generated {self.number}" if self.known is None else self.known.source


Job = tuple[Subject, int]  # with the number of the flight


@click.command()
@click.argument("files", metavar="[MISSION]...", nargs=-1, type=MISSION)
@click.option(
    "--missions",
    type=click.IntRange(1),
    help="So many in all: the files (the shipped ones if none is named), then generated ones.",
)
@click.option(
    "--flights",
    type=click.IntRange(1),
    default=3,
    show_default=True,
    help="Flights of each mission.",
)
@SEED
@click.option("--vehicle", type=VEHICLE_NAME, metavar="NAME", default="auv", show_default=True,
              help="A shipped vehicle; without files: the missions that fly on it.")  # fmt: skip
@click.option("--generated", type=click.IntRange(0), help="The generated mission of this number.")
@click.option(
    "--words", is_flag=True, help="Fly every word of the language, withholding what it waits for."
)
@click.option("--word", type=click.IntRange(0), help="The word's mission of this number.")
@click.option("--flight", type=click.IntRange(0), help="Fly this flight alone, and tell its story.")
@click.option("--show", is_flag=True, help="Print the generated mission, do not fly.")
@job_options
def campaign(
    files: tuple[Path, ...],
    missions: int | None,
    flights: int,
    seed: int,
    vehicle: str,
    generated: int | None,
    words: bool,
    word: int | None,
    flight: int | None,
    show: bool,
    where: Where,
) -> None:
    """Fly missions within what the check assumed, and report flights beyond what it proved.

    Current, start, compass, speed and floor are random within the assumptions; sensors fail and
    links are lost. Each counterexample is printed with the command that flies it again; exit 1 if
    there is one. The last line of stdout is one JSON object. Its `at_most` bounds the probability
    that a flight drawn like these exceeds a proved bound (exact binomial, 95 %); a flight that is
    `undone` counts as if it had.
    """
    import json
    import sys

    from mission.verification.campaign.proofs import Shown
    from mission.verification.rig.vehicle import flown
    from mission.verification.workers.contents import contents

    _refuse_unknown(vehicle)
    if show and generated is None:
        raise click.UsageError("--show prints a generated mission: say --generated NUMBER")
    if generated is not None and show:
        where.refuse("--show flies nothing")
        click.echo(_generated_text(vehicle, seed, generated), nl=False)
        return
    if vehicle != "auv" and (words or word is not None):
        raise click.UsageError("--words are of the AUV: leave --vehicle out")
    tell_confirmed(vehicle)
    if generated is None and not words and word is None:
        subjects = _subjects(files, missions, vehicle)
    else:
        subjects = [] if generated is None else [Subject(flown(vehicle), None, generated)]
        subjects += _said(word) if words or word is not None else []
    made = next((subject for subject in subjects if subject.known is None), None)
    if made is not None:  # learn here, not in each worker, whether this vehicle has missions at all
        _generated_text(vehicle, seed, made.number)
    which = range(flights) if flight is None else [flight]
    jobs: list[Job] = [(subject, number) for subject in subjects for number in which]
    asked = {"flights": "within what was proved", "seed": seed, "vehicle": contents(flown(vehicle))}
    with where.keeping(asked, Shown) as kept:
        tally = _fly(seed, jobs, where.place, kept, with_stories=flight is not None)
    tally.missions = len(subjects)
    click.echo(json.dumps(tally.as_json()))
    sys.exit(0 if tally.clean else 1)


def _subjects(files: tuple[Path, ...], missions: int | None, vehicle: str) -> list[Subject]:
    """The files (the shipped ones if none is named), and generated ones up to ``missions``. A file
    that cannot be flown ends the command with 2."""
    from mission.authoring.prepare import Unreadable
    from mission.verification.campaign.faults import fitting, shipped
    from mission.verification.rig.vehicle import flown

    known = shipped() if vehicle == "auv" else [subject.path for subject in fitting(vehicle)]
    named = list(dict.fromkeys(files)) or known
    try:
        found = [_subject(path, vehicle) for path in named[:missions]]
    except (Unreadable, ValueError) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    more = range((missions or 0) - len(found))
    if not (found or more):
        raise click.UsageError(f"no shipped mission flies on {vehicle}: name a MISSION")
    return [*found, *(Subject(flown(vehicle), None, number) for number in more)]


def _refuse_unknown(vehicle: str) -> None:
    from mission.model.likeness import suggestion
    from mission.model.shipped import shipped_vehicles

    there = shipped_vehicles()
    if vehicle not in there:
        why = f"{vehicle}: no shipped vehicle; {suggestion(vehicle, there, 'there are')}"
        raise click.BadParameter(why, param_hint="--vehicle")


def _said(number: int | None) -> list[Subject]:
    """The mission of the word with this number; None: the missions of all words."""
    from mission.model.shipped import load_vehicle
    from mission.verification.campaign.withheld import claims

    vehicle = load_vehicle("auv")
    found = [Subject(vehicle, claim) for claim in claims(vehicle)]
    if number is None:
        return found
    if number >= len(found):
        why = f"{number}: the words have the numbers 0 to {len(found) - 1}"
        raise click.BadParameter(why, param_hint="--word")
    return [found[number]]


def _generated_text(vehicle: str, seed: int, number: int) -> str:
    """The text of a generated mission. Exit 2 for a vehicle that none is found for."""
    from mission.verification.campaign.generated import NoneFound, generate
    from mission.verification.rig.vehicle import flown

    try:
        return generate(seed, number, flown(vehicle)).text
    except NoneFound as error:
        raise click.UsageError(str(error)) from error


def _fly(
    seed: int, jobs: Sequence[Job], place: Place, kept: Kept[Shown], *, with_stories: bool
) -> _Tally:
    """Fly. Print the story of each flight with a violation, of lost ones, or of all."""
    import functools

    from mission.verification.workers import results
    from mission.verification.workers.outcome import Lost
    from mission.verification.workers.progress import Progress

    tally, tell = _Tally(), functools.partial(click.echo, err=True)
    progress = Progress(len(jobs), "flights", tell)
    ended = results(functools.partial(_show, seed), jobs, place, _name, kept, progress)
    for (subject, number), shown in zip(jobs, ended, strict=True):
        tally.take(shown)
        if isinstance(shown, Lost) or shown.violations or with_stories:
            click.echo(_story(subject, shown, seed, number))
    return tally


@dataclass(slots=True)
class _Tally:
    """The totals. ``greatest_share``: the greatest share of a proved bound that a flight needed."""

    missions: int = 0
    flights: int = 0
    broken: int = 0  # flights with a violation
    undone: int = 0
    not_started: int = 0
    violations: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(
            ("time", "range", "depth", "energy", "area", "end", "raised"), 0
        )
    )
    greatest_share: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("time", "range", "depth", "energy"), 0.0)
    )

    def take(self, shown: Shown | Lost) -> None:
        from mission.verification.workers.outcome import Lost

        if isinstance(shown, Lost):
            self.undone += 1
            return
        self.flights += 1
        self.broken += bool(shown.violations)
        self.not_started += not shown.started
        for violation in shown.violations:
            self.violations[violation.kind] += 1
        for name, most in self.greatest_share.items():
            share = getattr(shown.needed, name) / getattr(shown.proved, name)
            self.greatest_share[name] = max(most, round(share, 3))

    @property
    def clean(self) -> bool:
        return not self.broken and not self.undone

    def as_json(self) -> dict[str, object]:
        from mission.verification.bounds import at_most

        bound = at_most(self.broken + self.undone, self.flights + self.undone)
        return asdict(self) | {"at_most": bound}


def _subject(path: Path, vehicle: str) -> Subject:
    """The mission of a file on ``vehicle``; ``auv`` means the mission's own. Raises Unreadable, and
    ValueError for a mission that the check refuses."""
    from dataclasses import replace

    from mission.authoring.prepare import check_prepared, prepare
    from mission.verification.campaign.proofs import Claim
    from mission.verification.rig.vehicle import flown

    prepared = prepare(path, None if vehicle == "auv" else flown(vehicle))
    report = check_prepared(prepared)
    if not report.ok or report.proved is None:
        why = report.refusals[0].message if report.refusals else "nothing is proved"
        raise ValueError(f"{path}: the check refuses it: {why}")
    mission = replace(prepared.mission, vehicle=prepared.vehicle.name)
    return Subject(prepared.vehicle, Claim(str(path), mission, report.proved))


def _show(seed: int, job: Job) -> Shown:
    from mission.verification.campaign.proofs import show
    from mission.verification.campaign.withheld import drawn_for

    subject, flight = job
    claim = subject.known or _generated(subject, seed)
    return show(claim, subject.vehicle, seed, flight, drawn_for(claim, flight))


def _generated(subject: Subject, seed: int) -> Claim:
    from mission.verification.campaign.generated import generate
    from mission.verification.campaign.proofs import Claim

    made = generate(seed, subject.number, subject.vehicle)
    return Claim(subject.source, made.mission, made.proved)


def _name(job: Job) -> str:
    """The name of a job: all that determines its flight, except the seed and the vehicle of a
    generated mission."""
    from mission.authoring.language import digest
    from mission.verification.workers.contents import contents

    subject, flight = job
    source = subject.source
    if subject.known is not None:
        source += f" {digest(subject.known.mission)[:8]} {contents(subject.vehicle)[:8]}"
    return f"{source} --flight {flight}"


def _story(subject: Subject, shown: Shown | Lost, seed: int, number: int) -> str:
    from mission.verification.workers.outcome import Lost

    of = subject.vehicle.name
    words = subject.source if of == "auv" else f"{subject.source} --vehicle {of}"
    again = f"  again: auvmission campaign {words} --seed {seed} --flight {number}"
    if isinstance(shown, Lost):
        return f"flight {shown}\n{again}"
    found = [f"  {v.kind} at {v.t:.1f} s: {v.says}" for v in shown.violations]
    return "\n".join([f"flight {number} of {shown.words}", *found, again])
