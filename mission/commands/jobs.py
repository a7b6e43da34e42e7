"""The options of commands that run many jobs, and where the jobs run."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from mission.verification.workers.kept import Kept
    from mission.verification.workers.places import Place

_ON = click.option(
    "--on",
    metavar="PLACE",
    help="Where: local (this process), processes (of this machine), dask://HOST:PORT; "
    "processes by default.",
)
_WORKERS = click.option(
    "--workers", type=click.IntRange(1), help="Processes; a core each by default."
)
_PATIENCE = click.option(
    "--patience",
    metavar="SECONDS",
    type=click.FloatRange(0.0, min_open=True),
    help="A job that takes longer hangs: it is tried again, and then told. Not with --on local.",
)
_RESUME = click.option(
    "--resume",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Keep results there (JSON lines), and go on from those that are there.",
)


@dataclass(frozen=True, slots=True)
class Where:
    """The values of the options. ``given``: the options that were given, as written."""

    place: Place
    resume: Path | None
    given: tuple[str, ...] = ()

    def lasting(self, factor: float) -> Where:
        """The same for jobs that each last as long as ``factor`` others."""
        return replace(self, place=replace(self.place, patience=factor * self.place.patience))

    def refuse(self, why: str, instead: str = "") -> None:
        """Refuse the options, if any was given, for a call that has no use for them."""
        if self.given:
            raise click.UsageError(f"{why}: leave out {', '.join(self.given)}{instead}")

    @contextmanager
    def keeping(self, asked: Mapping[str, Any], kind: Any) -> Iterator[Kept[Any]]:
        """Keep results in the file of ``--resume``. ``asked``: all that they depend on, as plain
        values; ``kind``: their type. Exit 2 if the file or the place of the jobs is unusable."""
        from mission.verification.workers.kept import Unusable, keeping
        from mission.verification.workers.outcome import Unreachable

        try:
            with keeping(self.resume, asked, kind) as kept:
                yield kept
        except (Unusable, Unreachable) as error:
            raise _Refused(str(error)) from None


class _Refused(click.ClickException):
    exit_code = 2


def job_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add ``--on``, ``--workers``, ``--patience`` and ``--resume``; the command gets ``where``."""

    @functools.wraps(command)
    def called(
        *,
        on: str | None,
        workers: int | None,
        patience: float | None,
        resume: Path | None,
        **others: Any,
    ) -> None:
        from mission.verification.workers.places import LOCAL, PATIENCE, PROCESSES, place

        said = {"--on": on, "--workers": workers, "--patience": patience, "--resume": resume}
        given = tuple(name for name, value in said.items() if value is not None)
        if on not in (None, PROCESSES) and workers is not None:
            raise click.UsageError(f"--workers are processes of this machine: none with --on {on}")
        if on == LOCAL and patience is not None:
            raise click.UsageError("--patience ends processes: there is none with --on local")
        try:
            at = place(on or (PROCESSES if patience else None), workers, patience or PATIENCE)
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--on") from None
        command(**others, where=Where(at, resume, given))

    for option in (_RESUME, _PATIENCE, _WORKERS, _ON):
        called = option(called)
    return called
