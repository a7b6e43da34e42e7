"""Shared by all rooms: where the real recordings are, if they are here."""

from __future__ import annotations

import atexit
import gc
import os
import shutil
import tempfile
from collections.abc import Generator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from mission.model import compiled

# what programs remember is neither that of whoever runs the tests nor of a worker beside this one
FONTS = Path("~/.cache/matplotlib").expanduser()  # looking for all fonts takes seconds
HOME = tempfile.mkdtemp(prefix="auvmission-tests-")
os.environ.setdefault("MPLCONFIGDIR", str(FONTS))
os.environ |= {"HOME": HOME, "XDG_STATE_HOME": f"{HOME}/state"}
atexit.register(shutil.rmtree, HOME, ignore_errors=True)

ROOT = Path(__file__).resolve().parent.parent

# how fast this machine is, and how busy, is no law
settings.register_profile("laws", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("laws")


# These fly whole missions or run the program as a user does: tracing them takes minutes, and lines
# that a flight passes by are not yet lines that a test looks at.
UNCOUNTED = ("docs", "sea", "verification")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Coverage, where it is asked for, is that of the tests of single rooms."""
    plugin = item.config.pluginmanager.get_plugin("_cov")
    controller = getattr(plugin, "cov_controller", None)
    room = item.path.relative_to(ROOT / "tests").parts[0]
    if controller is None or room not in UNCOUNTED:
        return (yield)
    controller.pause()
    try:
        return (yield)
    finally:
        controller.resume()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if compiled.compiled():
        why = pytest.mark.skip(reason="it replaces a method, and compiled code calls its own")
        for item in items:
            if item.get_closest_marker("replaces"):
                item.add_marker(why)
    items.sort(key=lambda item: item.get_closest_marker("minutes") is None)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What is imported and collected stays: the collector need not look through it. What tests
    leave is little, and looking for it every 700 objects took a fifteenth of their time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(10_000)
        gc.enable()


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of real recordings; AUVMISSION_DATA, or ../shared/data beside the project."""
    folder = Path(os.environ.get("AUVMISSION_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no recordings at {folder}: set AUVMISSION_DATA to their folder")
    return folder
