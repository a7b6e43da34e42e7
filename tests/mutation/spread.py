"""Mutants by the seam of the campaigns: parts of them, each tried by a run.py in a copy of the tree.

A copy, since a worker of a cluster has no tests, and its program is what was installed there. Real
recordings do not travel: where these are tests, the results may differ from those of --on local.
"""

from __future__ import annotations

import functools
import itertools
import re
import sys
import time
from collections.abc import Iterable, Iterator
from hashlib import sha256
from pathlib import Path

from mission.verification.workers import results
from mission.verification.workers.copied import Ended, packed, run_copied
from mission.verification.workers.kept import keeping
from mission.verification.workers.outcome import Lost
from mission.verification.workers.places import Place
from mission.verification.workers.progress import Progress

PART = 20  # mutants of a job: collecting the tests takes as long as some of them
TOPS = ("mission", "links", "protocol", "missions", "tests", "docs", "pyproject.toml")
_LEFT = {"__pycache__", "node_modules"}
_COMPILED = {".so", ".pyd", ".pyc"}
_SCORE = re.compile(r"(\d+) of (\d+) noticed, \d+ mutants in all")


def spread(
    call: tuple[str, ...], numbers: list[int], at: Place, until: float, resume: Path | None
) -> Iterator[str | tuple[int, int]]:
    """Yield a line for each survivor and for each part that could not be tried, and for each part
    how many were noticed, and of how many. ``call``: the arguments of run.py but ``--only``."""
    starts = range(0, len(numbers), PART)
    parts = [",".join(map(str, numbers[first : first + PART])) for first in starts]
    jobs = (("tests/mutation/run.py", *call, "--only", part) for part in parts)
    in_time = itertools.takewhile(lambda _: time.monotonic() < until, jobs)
    archive = packed(Path.cwd(), _files())
    work = functools.partial(run_copied, archive)
    asked = {"mutants": " ".join(call), "tree": sha256(archive).hexdigest()[:16]}
    with keeping(resume, asked, Ended) as kept:
        progress = Progress(len(parts), "parts", _say)
        for outcome in results(work, in_time, at, " ".join, kept, progress):
            yield from _told(outcome)


def _say(line: str) -> None:
    sys.stderr.write(f"{line}\n")


def _told(outcome: Ended | Lost) -> Iterator[str | tuple[int, int]]:
    if isinstance(outcome, Lost):
        yield str(outcome)
        return
    *survivors, last = outcome.said.splitlines() or [""]
    score = _SCORE.search(last)
    if score is None:
        yield outcome.said
        return
    yield from survivors
    yield int(score[1]), int(score[2])


def _files() -> Iterable[str]:
    for top in map(Path, TOPS):
        for path in [top] if top.is_file() else top.rglob("*"):
            if path.is_file() and not _LEFT & {*path.parts} and path.suffix not in _COMPILED:
                yield path.as_posix()
