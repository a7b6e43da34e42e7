"""Output files of commands: their format by suffix, and files that cannot be written."""

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
    """Turn a write error into a message and exit 2. ``path``: used if the error names no file."""
    try:
        yield
    except OSError as error:
        said = f"{error.filename or path}: cannot be written: {error.strerror or error}"
        click.echo(said, err=True)
        raise SystemExit(2) from None


def refuse_unwritable(file: Path) -> None:
    """Exit 2 if the file cannot be written. Call this before long work whose result it gets. The
    file's content does not change, and a missing file is not created."""
    there = file.exists()
    with writing(file):
        file.open("ab").close()
        if not there:
            file.unlink()


def make_folder(folder: Path) -> None:
    """Create the folder before the work that fills it. Exit 2 if it cannot be written."""
    import tempfile

    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()


def write(output: Path | None, made: str | bytes) -> None:
    """Write to the file, or to standard output if none is given. Text is UTF-8. Exit 2 if the file
    cannot be written."""
    if output is None:
        click.echo(made, nl=False)
        return
    with writing(output):
        output.write_bytes(made.encode() if isinstance(made, str) else made)
