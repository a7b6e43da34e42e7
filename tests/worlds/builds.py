"""Where the compiled build is, for the tests that compare both builds."""

from __future__ import annotations

import os
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = runpy.run_path(str(ROOT / "hatch_build.py"))
TREE = ROOT / "build" / "compiled"
PYTHON = TREE / ".venv" / "bin" / "python"
PACKAGES: tuple[str, ...] = BUILD["PACKAGES"]


def is_made() -> None:
    """Skip the test if the build is missing or old; fail it if AUVMISSION_COMPILED asks for it."""
    if why := BUILD["outdated"](ROOT, TREE):
        if os.environ.get(BUILD["WANTED"]):
            pytest.fail(why)
        pytest.skip(why)
