"""Mutants are tried in other processes and on a cluster as they are here, with the tests of the tree
that they are of; and what tries them ends with its worker."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from served import soon
from test_cluster import ROOT, scheduling, worker

from mission.verification.workers.copied import Ended, packed, run_copied

pytestmark = pytest.mark.xdist_group("cluster")
TOPS = ("mission", "links", "protocol", "missions", "tests", "docs")
TEST = """
from protocol.checksum import xor8

def test_which_no_other_tree_has():
    assert xor8(b"abc") == ord("a") ^ ord("b") ^ ord("c")
"""
CALL = ("protocol/checksum.py", "tests/protocol/test_only_here.py")


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of this one, with one more test."""
    folder = tmp_path_factory.mktemp("tree")
    left = shutil.ignore_patterns("*.pyc*", "*.so", "node_modules")
    for top in TOPS:
        shutil.copytree(ROOT / top, folder / top, ignore=left)
    shutil.copy(ROOT / "pyproject.toml", folder)
    (folder / "tests" / "protocol" / "test_only_here.py").write_text(TEST)
    return folder


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with scheduling(tmp_path_factory.mktemp("scheduler")) as found, ExitStack() as workers:
        for _ in range(2):
            workers.enter_context(worker(found, tmp_path_factory.mktemp("worker")))
        yield found


def tried(tree: Path, *options: str) -> list[str]:
    run = [sys.executable, "tests/mutation/run.py", *CALL, "--only", ",".join(map(str, range(24)))]
    env = os.environ | {"PYTHONPATH": str(tree)}
    done = subprocess.run([*run, *options], cwd=tree, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return sorted(line for line in done.stdout.splitlines() if line)


@pytest.mark.proof
@pytest.mark.replaces
def test_mutants_are_noticed_alike_wherever_they_are_tried(
    tree: Path, address: str, tmp_path: Path
) -> None:
    here = tried(tree)
    assert 1 < len(here) < 24, "some survive this one test"
    kept = tmp_path / "kept.jsonl"
    assert tried(tree, "--on", "processes", "--workers", "2", "--resume", str(kept)) == here
    assert tried(tree, "--on", f"dask://{address}") == here
    rows = kept.read_text().splitlines()
    assert ["--only" in json.loads(row)["job"] for row in rows[1:]] == [True, True]
    assert tried(tree, "--on", "processes", "--workers", "2", "--resume", str(kept)) == here
    assert kept.read_text().splitlines() == rows


def test_a_program_runs_with_the_files_that_travel() -> None:
    archive = packed(ROOT, ["pyproject.toml"])
    assert archive == packed(ROOT, ["pyproject.toml"])
    said = run_copied(archive, ("-c", "import os; print(sorted(os.listdir()))"))
    assert said == Ended(True, "['pyproject.toml']\n")
    assert not run_copied(archive, ("-c", "raise SystemExit(3)")).well


@pytest.mark.proof
def test_a_program_ends_with_its_worker(tmp_path: Path) -> None:
    """The worker is killed, and can tell it nothing."""
    note = tmp_path / "note"
    hangs = f"import os, time; open({str(note)!r}, 'a').write(f'{{os.getpid()}} '); time.sleep(1e6)"
    script = (
        "import sys\nfrom mission.verification.workers.copied import packed, run_copied\n"
        f"run_copied(packed(__import__('pathlib').Path(), []), ('-c', {hangs!r}))\n"
    )
    with subprocess.Popen([sys.executable, "-c", script]) as process:
        soon(lambda: note.exists() and note.read_text().endswith(" "), "it works")
        process.send_signal(signal.SIGKILL)
    program = int(note.read_text())
    soon(lambda: not Path(f"/proc/{program}").exists(), "it has ended")
