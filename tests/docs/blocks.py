"""The code blocks of a page, found by Sybil and carried out in their order, as a reader would.

    ```console             after `$ ` a shell command, then what it prints; `...` stands for any text
    ```yaml                a mission that the check proves, a vehicle file, or a serve.yaml
    ```mission             a line script that the check proves
    ```guard               a guard a line
    ```python              runs
    ```sh                  shell that compiles; test_documents looks up its commands and options
    ```{code-block} LANGUAGE     with :caption: PATH is written to that file first; with the language
                                 diff the file there is changed as the hunks say

Blocks without a language, and `text`, are pictures made of characters. A page works in a folder
of its own, where `missions` is the tree's; one that writes into the tree gets a copy of it there.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from sybil import Document, Example, Region
from sybil.parsers.markdown.lexers import FencedCodeBlockLexer
from sybil.parsers.myst.lexers import DirectiveLexer

from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.model.shipped import load_vehicle
from mission.model.vehicle_file import read_vehicle
from mission.onboard.configuration import parse_configuration

ROOT = Path(__file__).resolve().parents[2]
TREE = ("docs", "links", "mission", "missions", "protocol", "tests")
PICTURES = frozenset({"", "text"})
LONGEST_S = 1800  # of a command: no law, but a page that hangs must end


class Page:
    """Runs the blocks of one page in ``folder``."""

    def __init__(self, path: Path, folder: Path) -> None:
        self._path, self._folder = path, folder
        self._root = ROOT
        self._bin = folder / ".bin"
        self.ran: list[str] = []  # the languages of the blocks that were carried out

    def run(self) -> None:
        self._bin.mkdir(parents=True)
        shim = self._bin / "auvmission"
        shim.write_text(f'#!/bin/sh\nexec {sys.executable} -m mission "$@"\n')
        shim.chmod(0o755)
        (self._folder / "missions").symlink_to(ROOT / "missions")
        for example in Document.parse(str(self._path), self._blocks).examples():
            example.evaluate()

    def _blocks(self, document: Document) -> Iterable[Region]:
        plain = FencedCodeBlockLexer(r"[a-z]+", {"language": "arguments", "source": "source"})
        for lexer in (plain, DirectiveLexer("code-block")):
            for block in lexer(document):
                language = block.lexemes["arguments"]
                if language not in PICTURES or _caption(block.lexemes):
                    yield Region(block.start, block.end, block.lexemes, self._evaluate)

    def _evaluate(self, example: Example) -> None:
        block: dict[str, Any] = example.parsed
        language, source = block["arguments"], str(block["source"])
        caption = _caption(block)
        where = f"{self._path.name}:{example.line}"
        try:
            if caption:
                self._write(caption, source, language == "diff")
            if not caption or language == "yaml":
                getattr(self, f"_{language}")(source)
        except Exception as error:
            error.add_note(f"at {where}")
            raise
        self.ran.append(language)

    # --- files ------------------------------------------------------------------------------

    def _write(self, name: str, source: str, changes: bool) -> None:
        if name.split("/")[0] in TREE and self._root is ROOT:
            self._copy_tree()
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(_changed(path.read_text(), source) if changes else source)

    def _copy_tree(self) -> None:
        (self._folder / "missions").unlink()
        # what is compiled comes along, for each command reads it; not what another process compiles
        ignored = shutil.ignore_patterns("build", "*.pyc.*")
        for name in TREE:
            shutil.copytree(ROOT / name, self._folder / name, ignore=ignored)
        for name in ("pyproject.toml", "README.md", "CHANGELOG.md", ".importlinter"):
            shutil.copy(ROOT / name, self._folder)
        self._root = self._folder

    # --- languages ----------------------------------------------------------------------------

    def _console(self, source: str) -> None:
        for step in re.split(r"^\$ ", source, flags=re.MULTILINE)[1:]:
            command, wanted = _parted(step)
            ran = self._shell(command)
            assert ran.returncode == 0, f"{command}\n{ran.stdout}"
            pattern = ".*".join(map(re.escape, wanted.strip().split("...")))
            said = re.sub(r"[ \t]+\n", "\n", ran.stdout).strip()
            assert not wanted.strip() or re.fullmatch(pattern, said, re.DOTALL), (
                f"{command}\n--- the page says\n{wanted}\n--- it says\n{said}"
            )

    def _python(self, source: str) -> None:
        (self._folder / ".block.py").write_text(source)
        self._console("$ python .block.py\n")

    def _shell(self, command: str) -> subprocess.CompletedProcess[str]:
        path = f"{self._bin}:{Path(sys.executable).parent}:{os.environ['PATH']}"
        here = {"PATH": path, "PYTHONPATH": str(self._root), "PYTHONDONTWRITEBYTECODE": "1"}
        return subprocess.run(
            ["/bin/sh", "-c", command],
            cwd=self._folder,
            env=os.environ | here | {"COLUMNS": "100"},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LONGEST_S,
            check=False,
        )

    def _yaml(self, source: str) -> None:
        if re.search(r"^mission:", source, re.MULTILINE):
            self._mission(source)
        elif re.search(r"^codec:", source, re.MULTILINE):
            read_vehicle(source, self._path.name)
        else:
            parse_configuration(source, self._path.name)

    def _mission(self, source: str) -> None:
        if self._root is not ROOT:
            return  # of a leg that this process has not: the page's own commands check it
        mission = parse(source, self._path.name)
        vehicle = load_vehicle(mission.vehicle)
        report = check_mission(compile_mission(mission, vehicle, digest(mission)), vehicle)
        assert report.ok, report.refusals

    def _guard(self, source: str) -> None:
        for guard in source.splitlines():
            parse(f"mission a\nhome 0 0\nhome_run: gear 4 until {guard} timeout 60", "guard")

    def _sh(self, source: str) -> None:
        subprocess.run(["/bin/sh", "-n"], input=source, text=True, check=True)


def _caption(block: dict[str, Any]) -> str:
    return str(block.get("options", {}).get("caption", ""))


def _parted(step: str) -> tuple[str, str]:
    """The command with its continued lines, and what follows."""
    lines = step.split("\n")
    last = next(n for n, line in enumerate(lines) if not line.endswith("\\"))
    return "\n".join(lines[: last + 1]), "\n".join(lines[last + 1 :])


def _changed(text: str, hunks: str) -> str:
    """``text`` with each hunk's lines exchanged; what a hunk takes away or keeps must stand there
    once. Hunks are parted by lines that begin with @@."""
    for hunk in re.split(r"^@@.*\n", hunks, flags=re.MULTILINE):
        lines = hunk.splitlines(keepends=True)
        if not lines:
            continue
        before = "".join(line[1:] for line in lines if line[0] != "+")
        after = "".join(line[1:] for line in lines if line[0] != "-")
        assert text.count(before) == 1, f"stands {text.count(before)} times:\n{before}"
        text = text.replace(before, after)
    return text
