"""Files that commands are asked to write: by their suffix, and what cannot be written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol, TypeVar

import click


class _Format(Protocol):
    @property
    def suffix(self) -> str: ...
    @property
    def what(self) -> str: ...


Format = TypeVar("Format", bound=_Format)


def by_suffix(output: Path, formats: Mapping[str, Format]) -> Format:
    """The format of ``output``, by its suffix. Raises UsageError, which names the known ones."""
    row = formats.get(output.suffix.lower())
    if row is None:
        known = ", ".join(f"{r.suffix} ({r.what})" for r in formats.values())
        raise click.UsageError(f"{output}: the suffix says what to write; there are {known}")
    return row


@contextmanager
def writing(path: Path | None) -> Iterator[None]:
    """Tells what cannot be written within: exit 2. ``path``: the file, if the error names none."""
    try:
        yield
    except OSError as error:
        said = f"{error.filename or path}: cannot be written: {error.strerror or error}"
        click.echo(said, err=True)
        raise SystemExit(2) from None


def refuse_unwritable(file: Path) -> None:
    """Before the work whose outcome it is to have: exit 2 if it cannot be written. What is in it
    stays, and what is not there yet is not made."""
    there = file.exists()
    with writing(file):
        file.open("ab").close()
        if not there:
            file.unlink()


def make_folder(folder: Path) -> None:
    """Before the work that fills it: exit 2 if nothing can be written there."""
    import tempfile

    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()


def write(output: Path | None, made: str | bytes) -> None:
    """To the file, or to standard output where none is named. Text is UTF-8. Exit 2 if the file
    cannot be written."""
    if output is None:
        click.echo(made, nl=False)
        return
    with writing(output):
        output.write_bytes(made.encode() if isinstance(made, str) else made)
