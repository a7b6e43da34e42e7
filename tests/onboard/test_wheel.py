"""Laws of the wheel: hatchling runs the hook, the hook adds the extensions, and `make test-compiled`
runs the tests on what is installed from that wheel."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from builds import BUILD, PACKAGES, PYTHON, ROOT, TREE, is_made

from mission.model import compiled

EXTENSION = "core.cpython-311-x86_64-linux-gnu.so"
Wheel = Callable[..., Path]


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """The smallest tree that hatchling builds; pyproject.toml and hatch_build.py are ours."""
    for name in ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tmp_path)
    for name in (*PACKAGES, "missions"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text('__version__ = "0.1.0"\n')
    return tmp_path


@pytest.fixture
def wheel(project: Path, monkeypatch: pytest.MonkeyPatch) -> Wheel:
    """Builds the wheel with hatchling; a stand-in for the compiler makes two empty extensions."""
    from hatchling.builders.wheel import WheelBuilder

    def compile_in(tree: Path) -> list[Path]:
        assert sorted(path.name for path in tree.iterdir()) == sorted(PACKAGES)
        made = [Path("mission") / EXTENSION, Path(EXTENSION)]
        for file in made:
            (tree / file).touch()
        return made

    def build(compiler: bool = True) -> Path:
        builder = WheelBuilder(str(project))
        found: dict[str, Any] = builder.get_build_hooks("")
        for hook in found.values():
            own = type(hook).initialize.__globals__
            own |= {"compile_in": compile_in, "has_compiler": lambda: compiler}
        monkeypatch.setattr(builder, "get_build_hooks", lambda folder: found)
        (path,) = builder.build(directory=str(project / "dist"), versions=["standard"])
        return Path(path)

    monkeypatch.setenv(BUILD["WANTED"], "1")
    return build


def extensions(wheel: Path) -> list[str]:
    return [name for name in zipfile.ZipFile(wheel).namelist() if name.endswith(".so")]


def test_a_compiled_wheel_has_the_extensions_and_is_of_this_platform(wheel: Wheel) -> None:
    made = wheel()
    assert sorted(extensions(made)) == [EXTENSION, f"mission/{EXTENSION}"]
    *_, python, abi, platform = made.stem.split("-")
    assert python == abi == f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert platform != "any"


def test_a_wheel_is_pure_unless_somebody_asks(
    wheel: Wheel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(BUILD["WANTED"])
    made = wheel()
    assert made.name == "auvmission-0.1.0-py3-none-any.whl"
    assert extensions(made) == []


def test_without_a_compiler_the_wheel_is_pure_and_the_build_says_so(
    wheel: Wheel, capsys: pytest.CaptureFixture[str]
) -> None:
    made = wheel(compiler=False)
    assert made.name == "auvmission-0.1.0-py3-none-any.whl"
    assert extensions(made) == []
    assert BUILD["NO_COMPILER"] in "".join(capsys.readouterr())


def test_an_editable_install_compiles_nothing(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from hatchling.builders.wheel import WheelBuilder

    monkeypatch.setenv(BUILD["WANTED"], "1")
    (hook,) = WheelBuilder(str(project)).get_build_hooks("").values()
    data: dict[str, Any] = {}
    hook.initialize("editable", data)
    assert data == {}
    assert not (project / "build").exists()


def test_only_a_compiled_wheel_needs_mypyc(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from hatchling.build import get_requires_for_build_wheel

    monkeypatch.chdir(project)
    monkeypatch.delenv(BUILD["WANTED"], raising=False)
    assert not set(BUILD["NEEDED"]) & set(get_requires_for_build_wheel())
    monkeypatch.setenv(BUILD["WANTED"], "1")
    assert set(BUILD["NEEDED"]) <= set(get_requires_for_build_wheel())


def tried(**settings: str) -> str:
    words = "import hatch_build; print(hatch_build.has_compiler())"
    command = [sys.executable, "-c", words]
    told = subprocess.run(
        command, cwd=ROOT, env=os.environ | settings, capture_output=True, text=True, check=True
    )
    return told.stdout.splitlines()[-1]


def test_a_compiler_counts_if_it_makes_an_extension() -> None:
    assert tried(CC="false") == "False"
    if shutil.which("cc"):
        assert tried() == "True"


def test_the_digest_changes_with_every_source_that_changes_or_goes(project: Path) -> None:
    digests = [BUILD["digest"](project)]
    (project / "mission" / "__pycache__").mkdir()
    (project / "mission" / "__pycache__" / "core.pyc").touch()
    assert BUILD["digest"](project) == digests[0]
    for name in ("mission/core.py", "missions/dive.yaml", "hatch_build.py", "pyproject.toml"):
        (project / name).write_text("changed")
        digests.append(BUILD["digest"](project))
    (project / "mission" / "core.py").unlink()
    digests.append(BUILD["digest"](project))
    assert len(set(digests)) == len(digests)


def test_a_build_is_current_only_for_the_sources_that_it_was_made_of(
    project: Path, tmp_path: Path
) -> None:
    tree = tmp_path / "build" / "compiled"
    assert "no compiled build" in BUILD["outdated"](project, tree)
    (tree / "wheel").mkdir(parents=True)
    (tree / BUILD["MADE_OF"]).write_text(BUILD["digest"](project))
    assert BUILD["outdated"](project, tree) == ""
    (project / "links" / "__init__.py").write_text("changed")
    assert "other sources" in BUILD["outdated"](project, tree)


def test_the_tests_run_the_packages_beside_them() -> None:
    """These are the sources, or links to what is installed from the wheel."""
    for name in PACKAGES:
        (place,) = importlib.import_module(name).__path__
        assert Path(place).resolve() == (ROOT / name).resolve()
    command = [sys.executable, "-m", "mission", "--version"]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert compiled.build() in told.stdout


WHERE = """
import importlib
from importlib.metadata import distribution
from mission.model.compiled import MODULES
print(*[importlib.import_module(name).__file__ for name in MODULES], sep="\\n")
print(distribution("auvmission").read_text("WHEEL"))
"""


def test_the_compiled_tests_run_what_the_wheel_has_installed() -> None:
    is_made()
    command = [PYTHON, "-c", WHERE]
    told = subprocess.run(command, cwd=TREE, capture_output=True, text=True, check=True)
    places = [Path(line) for line in told.stdout.splitlines()[: len(compiled.MODULES)]]
    (installed,) = TREE.glob(".venv/lib/python*/site-packages")
    for name, place in zip(compiled.MODULES, places, strict=True):
        assert place.name.endswith(tuple(importlib.machinery.EXTENSION_SUFFIXES)), name
        assert place.resolve().is_relative_to(installed), name
    assert "Root-Is-Purelib: false" in told.stdout
    assert "none-any" not in told.stdout
    (made,) = TREE.glob("wheel/*.whl")
    assert len(extensions(made)) == len(compiled.MODULES) + 1  # one has the code of all
    assert {path.name: path.is_symlink() for path in map(TREE.joinpath, PACKAGES)} == dict.fromkeys(
        PACKAGES, True
    )
