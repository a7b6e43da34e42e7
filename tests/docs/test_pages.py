"""Every code block of every page is carried out; what a page names is followed by test_documents.

The lessons and the guides fly missions and change copies of the tree, and the page of commands runs
each of them: they are among the long proofs.
"""

from __future__ import annotations

from pathlib import Path
from subprocess import CalledProcessError

import pytest
from _pytest.mark import ParameterSet
from blocks import ROOT, Page

LONG = frozenset({"tutorial", "how-to", "commands.md", "black-box.md"})
LONGEST = frozenset({"commands.md", "calibration.md", "first-recording.md", "campaign.md"})
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]


def row(page: Path) -> ParameterSet:
    marks = [pytest.mark.proof] if LONG & {page.parent.name, page.name} else []
    marks += [pytest.mark.minutes] if page.name in LONGEST else []
    return pytest.param(page, marks=marks, id=str(page.relative_to(ROOT)))


@pytest.mark.parametrize("page", [row(page) for page in PAGES])
def test_every_block_of_a_page_runs_as_the_page_says(page: Path, tmp_path: Path) -> None:
    Page(page, tmp_path).run()


WRONG = {
    "another output": "```console\n$ echo yes\nno\n```\n",
    "a command that fails": "```console\n$ false\n```\n",
    "a mission that is refused": "```yaml\nmission: a\nlegs:\n  - out: {gear: 6}\n```\n",
    "a line script that is none": "```mission\nmission a\nout: gier 6 for 10\n```\n",
    "a guard that is none": "```guard\ndepht > 3\n```\n",
    "a key that serve does not have": "```yaml\nfolders: /tmp\n```\n",
    "python that raises": "```python\nassert False\n```\n",
    "shell that does not compile": "```sh\nfor\n```\n",
    "a change that does not fit": "```{code-block} diff\n:caption: mission/model/units.py\n-never\n```\n",
    "a language that nobody knows": "```cobol\nSTOP RUN.\n```\n",
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_page_that_is_wrong_is_noticed(wrong: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"# Page\n\n{WRONG[wrong]}", encoding="utf-8")
    (tmp_path / "work").mkdir()
    with pytest.raises((AssertionError, AttributeError, ValueError, CalledProcessError)):
        Page(page, tmp_path / "work").run()


def test_a_page_may_leave_out_what_a_command_prints(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    shown = "$ echo one; echo two; echo three\none\n...\nthree\n$ echo \\\n  four\n"
    page.write_text(f"```console\n{shown}```\n", encoding="utf-8")
    (tmp_path / "work").mkdir()
    Page(page, tmp_path / "work").run()


@pytest.mark.parametrize("wing", ["mission", "links", "protocol"])
def test_a_module_has_at_most_the_lines_that_contributors_are_told(wing: str) -> None:
    modules = list((ROOT / wing).rglob("*.py"))
    long = [path for path in modules if len(path.read_text().splitlines()) > 400]
    assert modules
    assert not long, "part them"
