"""Laws of the compiled build: it is of modules that exist, says that it is one, and does the same to
the bit. Flights need what `make compiled` makes."""

from __future__ import annotations

import hashlib
import importlib.machinery
import importlib.util
import os
import pickle
import re
import runpy
import shutil
import subprocess
import sys
import threading
import typing
from pathlib import Path
from typing import Any, NoReturn

import pytest
from click.testing import CliRunner
from served import PATIENCE

from mission.cli import main
from mission.model import compiled
from mission.onboard.doctor import doctor
from mission.onboard.runtime.operator_channels import operator_channels
from mission.verification.exhaustive.fork import Fork
from protocol.tolerances import Tolerances

ROOT = Path(__file__).resolve().parents[2]
TREE = ROOT / "build" / "compiled"
PYTHON = TREE / ".venv" / "bin" / "python"
PACKAGES = ("mission", "links", "protocol")


def sources(tree: Path) -> dict[Path, bytes]:
    return {p.relative_to(tree): p.read_bytes() for n in PACKAGES for p in (tree / n).rglob("*.py")}


def both(
    *arguments: str, folder: Path | None = None, of: tuple[str, ...] = ("-m", "mission")
) -> tuple[str, str]:
    """What the program prints and, with a folder, the digests of the files that it leaves there;
    ``of``: what Python is told to run."""
    if not PYTHON.exists():
        missing("no compiled build: make compiled")
    if sources(TREE) != sources(ROOT):
        missing("the compiled build is of other sources: make compiled")
    words = (*of, *arguments)
    return _run(sys.executable, ROOT, words, folder), _run(PYTHON, TREE, words, folder)


def missing(why: str) -> NoReturn:
    """A reason to look away, unless somebody has asked for both builds."""
    if os.environ.get("AUVMISSION_COMPILED"):
        pytest.fail(why)
    pytest.skip(why)


def _run(python: str | Path, tree: Path, arguments: tuple[str, ...], folder: Path | None) -> str:
    if folder is not None:
        arguments = (*arguments, "--report", str(folder))
    command = [str(python), *arguments]
    told = subprocess.run(command, cwd=tree, capture_output=True, text=True, check=False)
    left = sorted(folder.iterdir()) if folder else []
    return "\n".join(
        [
            f"exit {told.returncode}",
            told.stdout,
            *(f"{p.name} {hashlib.sha256(p.read_bytes()).hexdigest()}" for p in left),
        ]
    )


@pytest.mark.parametrize("name", compiled.MODULES)
def test_a_module_that_is_to_be_compiled_exists(name: str) -> None:
    assert importlib.util.find_spec(name) is not None


def test_the_list_of_modules_is_in_order() -> None:
    assert len(set(compiled.MODULES)) == len(compiled.MODULES)
    for package in PACKAGES:
        of_it = [name for name in compiled.MODULES if name.startswith(f"{package}.")]
        assert of_it == sorted(of_it)


def test_a_module_counts_as_compiled_when_its_extension_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiled, "_ROOT", tmp_path)
    assert compiled.compiled() == []
    assert compiled.build() == "pure Python"
    name = compiled.MODULES[0]
    path = tmp_path.joinpath(*name.split("."))
    path.parent.mkdir(parents=True)
    path.with_name(path.name + importlib.machinery.EXTENSION_SUFFIXES[0]).touch()
    assert compiled.compiled() == [name]
    assert compiled.build() == f"1 of {len(compiled.MODULES)} modules compiled"


def test_the_version_says_which_build_it_is() -> None:
    assert compiled.build() in CliRunner().invoke(main, ["--version"]).stdout


def test_a_rule_cannot_be_broken_in_compiled_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "compiled", lambda: ["mission.engine.core"])
    told = CliRunner().invoke(main, ["faults", "--broken", "latch", "--flights", "1"])
    assert told.exit_code == 2
    assert "pure build" in told.output


class Native:
    """As mypyc makes them: the attributes have neither a dictionary nor the name of slots."""

    __slots__ = ("depth", "never_set")

    def __init__(self, depth: float) -> None:
        self.depth = depth


del Native.__slots__
Native.__mypyc_attrs__ = ("depth", "never_set")  # type: ignore[attr-defined]


def test_a_copy_has_what_a_compiled_class_holds() -> None:
    assert Fork(Native(3.0)).copy().depth == 3.0


FORESEEN = """
import copy
from mission.onboard.runtime.operator_channels import operator_channels
from protocol.tolerances import Tolerances
channel = operator_channels(Tolerances())("{link}")
channel.receive(b"@AD,DU$@D", 0.0)
print(copy.deepcopy(channel).receive(b"U$", 0.0), channel.receive(b"U$", 0.0))
"""
LINKS = ("topside", "modem")


@pytest.mark.parametrize("link", LINKS)
def test_an_operators_channel_holds_no_function_that_only_the_interpreter_can_copy(
    link: str,
) -> None:
    pickle.dumps(operator_channels(Tolerances())(link))  # refuses closures, which mypyc's are


@pytest.mark.parametrize("link", LINKS)
def test_a_compiled_serve_foresees_what_an_upload_will_make_whole(link: str) -> None:
    pure, quick = both(of=("-c", FORESEEN.format(link=link)))
    assert pure == quick
    assert pure.startswith("exit 0")


SOURCE = """from __future__ import annotations
from dataclasses import dataclass
@dataclass(frozen=True, slots=True)
class Curve:
    at: tuple[float, ...]
    named: dict[str, int] | None = None
class Plain:
    at: int
"""


def test_the_types_of_fields_that_mypyc_forgets_are_told_again() -> None:
    names: dict[str, Any] = {"__name__": __name__}
    exec(SOURCE, names)
    whole = typing.get_type_hints(names["Curve"], names)
    names["Curve"].__annotations__.update(at=tuple, named=type)  # as mypyc leaves them
    exec(runpy.run_path(str(ROOT / "hatch_build.py"))["told_again"](SOURCE), names)
    assert typing.get_type_hints(names["Curve"], names) == whole


CONSTANTS = """from math import pi
LIMIT = 2.0  # m
TURN, _FULL = 2 * pi, (1, 2)
NORTH, EAST = range(2)
TABLE: dict[str, int] = {
    "a": 1,
}
TWICE = 1
TWICE = 2
COUNT = 0
FIRST, *REST = "abc"
ONE = OTHER = 3
LEFT = RIGHT = (5, 6)
UNSAID: int
BOTH, NEITHER = range(ONE - 1)
name = 4
def count(LIMIT: float) -> None:
    global COUNT
    LIMIT = 3.0
    COUNT += 1
"""


def test_constants_are_marked_and_stay_on_their_lines() -> None:
    marked = runpy.run_path(str(ROOT / "hatch_build.py"))["finals"](CONSTANTS)
    before, after = CONSTANTS.splitlines(), marked.splitlines()
    assert len(after) == len(before)
    assert [line for old, line in zip(before, after, strict=True) if line != old] == [
        "LIMIT: Final = 2.0  # m",
        "TURN: Final = 2 * pi; _FULL: Final = (1, 2)",
        "NORTH: Final = 0; EAST: Final = 1",
        "TABLE: Final[dict[str, int]] = {",
    ]
    whole: dict[str, Any] = {}
    again: dict[str, Any] = {"Final": typing.Final}
    exec("from __future__ import annotations\n" + CONSTANTS, whole)
    exec("from __future__ import annotations\n" + marked, again)
    kept = {k: v for k, v in whole.items() if k.isupper()}
    assert kept == {k: again[k] for k in kept}


def test_files_of_c_are_compiled_side_by_side_and_come_back_in_their_order() -> None:
    both_there = threading.Barrier(2, timeout=PATIENCE)

    def one(sources: list[str], folder: str) -> list[str]:
        both_there.wait()
        return [f"{folder}/{source}.o" for source in sources]

    at_once = runpy.run_path(str(ROOT / "hatch_build.py"))["at_once"]
    assert at_once(one, 2)(["a", "b", "c", "d"], folder="x") == [f"x/{name}.o" for name in "abcd"]


def test_the_doctor_says_which_build_it_is() -> None:
    assert doctor.build_of in doctor.ROWS
    (finding,) = doctor.build_of(None)  # type: ignore[arg-type]
    assert compiled.build() in str(finding)


TAKEN = re.compile(r'"(?:wall_s|real_time_factor)": [0-9.e+]+')  # which is to differ


@pytest.mark.parametrize("profile", ["as-built", "documented"])
@pytest.mark.parametrize("mission", ["first-dive", "loiter", "yoyo-profile"])
def test_a_compiled_flight_prints_and_records_the_same_bytes(
    mission: str, profile: str, tmp_path: Path
) -> None:
    path = str(ROOT / "missions" / f"{mission}.yaml")
    pure, quick = both(
        "simulate", path, "--profile", profile, "--seed", "7", "--json", folder=tmp_path
    )
    assert len(TAKEN.findall(pure)) == 2
    assert TAKEN.sub("", pure) == TAKEN.sub("", quick)
    assert pure.startswith("exit 0")


@pytest.mark.parametrize("number", range(3))
def test_a_compiled_flight_with_faults_records_the_same_bytes(number: int, tmp_path: Path) -> None:
    words = ("faults", "--seed", "3", "--flight", str(number), "--json")
    pure, quick = both(*words, folder=tmp_path)
    assert pure == quick


CELLS = """
from mission.authoring.prepare import prepare
from mission.model.shipped import missions_folder
from mission.verification.exhaustive.run import examine_ground, ground
found = examine_ground(ground(prepare(missions_folder() / "first-dive.yaml"), "as-built"), {every})
print(found.as_json(), sorted(found.asked.items()))
"""


def test_a_sample_of_cells_gives_the_same_when_compiled() -> None:
    """A world that is interpreted stands on a loop that is not: no flight does so."""
    pure, quick = both(of=("-c", CELLS.format(every=60)))
    assert pure == quick
    assert pure.startswith("exit 0")


@pytest.mark.proof
@pytest.mark.minutes  # .ci/run compiles them
def test_mypyc_takes_the_sources_as_they_are(tmp_path: Path) -> None:
    for name in PACKAGES:
        shutil.copytree(ROOT / name, tmp_path / name)
    words = "import pathlib, hatch_build; hatch_build.translate_in(pathlib.Path.cwd())"
    told = subprocess.run(
        [sys.executable, "-c", words],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert told.returncode == 0, told.stdout + told.stderr


@pytest.mark.proof
def test_a_compiled_campaign_has_the_same_verdicts() -> None:
    pure, quick = both("faults", "--seed", "3", "--flights", "100")
    assert pure == quick


@pytest.mark.proof
@pytest.mark.minutes
def test_every_cell_gives_the_same_when_compiled() -> None:
    pure, quick = both("exhaustive", str(ROOT / "missions" / "loiter.yaml"), "--json")
    assert pure == quick
