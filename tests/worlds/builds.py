"""Where the compiled build stands, for the tests that compare both."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NoReturn

import pytest

ROOT = Path(__file__).resolve().parents[2]
TREE = ROOT / "build" / "compiled"
PYTHON = TREE / ".venv" / "bin" / "python"
PACKAGES = ("mission", "links", "protocol")


def is_made() -> None:
    """Skips, or fails where somebody asked for both builds, if it is not there or is old."""
    if not PYTHON.exists():
        _missing("no compiled build: make compiled")
    if _sources(TREE) != _sources(ROOT):
        _missing("the compiled build is of other sources: make compiled")


def _sources(tree: Path) -> dict[Path, bytes]:
    return {p.relative_to(tree): p.read_bytes() for n in PACKAGES for p in (tree / n).rglob("*.py")}


def _missing(why: str) -> NoReturn:
    if os.environ.get("AUVMISSION_COMPILED"):
        pytest.fail(why)
    pytest.skip(why)
