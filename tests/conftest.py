"""Shared by all rooms: where the real recordings are, if they are here."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# what commands of the boat remember is not that of whoever runs the tests
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="auvmission-tests-")

ROOT = Path(__file__).resolve().parent.parent

# how fast this machine is, and how busy, is no law
settings.register_profile("laws", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("laws")


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of real recordings; AUVMISSION_DATA, or ../shared/data beside the project."""
    folder = Path(os.environ.get("AUVMISSION_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no recordings at {folder}: set AUVMISSION_DATA to their folder")
    return folder
