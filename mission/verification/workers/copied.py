"""A job that is a program of its own, in a copy of a tree that travels with it.

For work on other sources than those of the worker, which may have neither them nor their tests:
mutants (tests/mutation). The program ends with its worker, however that ends.
"""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

# Waits for the program, or for the end of the worker, which closes this process's stdin.
_BESIDE = """
import os, signal, subprocess, sys, threading
program = subprocess.Popen([sys.executable, *sys.argv[1:]], stdin=subprocess.DEVNULL)
threading.Thread(target=lambda: os._exit(program.wait() and 1), daemon=True).start()
os.read(0, 1)
os.killpg(0, signal.SIGKILL)
"""


@dataclass(frozen=True, slots=True)
class Ended:
    """Whether the program ended with exit code 0, and its output."""

    well: bool
    said: str


def packed(root: Path, names: Iterable[str]) -> bytes:
    """Return a ZIP archive of files below ``root``; the same for the same contents."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name in sorted(names):
            file.writestr(zipfile.ZipInfo(name), (root / name).read_bytes(), zipfile.ZIP_DEFLATED)
    return archive.getvalue()


def run_copied(archive: bytes, call: tuple[str, ...]) -> Ended:
    """Run Python with these arguments in a folder that has the files of the archive."""
    with tempfile.TemporaryDirectory(prefix="auvmission-") as folder:
        with zipfile.ZipFile(io.BytesIO(archive)) as file:
            file.extractall(folder)
        with subprocess.Popen(
            [sys.executable, "-c", _BESIDE, *call],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        ) as process:
            assert process.stdout is not None
            said = process.stdout.read()
            return Ended(process.wait() == 0, said)
