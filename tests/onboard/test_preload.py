"""What a mission needs is loaded beside everything else, and then costs nobody any time."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest

from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.preload import prepare
from mission.onboard.store import MemoryStore


@pytest.fixture(autouse=True)
def _as_it_was() -> Iterator[None]:
    gc.unfreeze()
    yield
    gc.freeze()  # as it is in a run of the tests


def runtime() -> Runtime:
    return Runtime(Configuration(), load_vehicle("auv"), MemoryStore())


def test_the_collector_does_not_look_through_what_is_there_for_good() -> None:
    gc.collect()  # what nobody holds any more is thrown away, not frozen
    before = len(gc.get_objects())
    assert prepare(runtime()).estimate(0.0) is None
    assert gc.isenabled()
    assert gc.get_freeze_count() >= before
    assert len(gc.get_objects()) < 0.1 * gc.get_freeze_count()


def test_a_further_drive_leaves_its_predecessor_to_the_collector() -> None:
    prepare(runtime())
    frozen = gc.get_freeze_count()
    prepare(runtime())
    assert gc.get_freeze_count() <= frozen


def test_a_filter_that_cannot_be_loaded_leaves_the_collector_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def absent(self: Runtime) -> None:
        raise ImportError("no filterpy")

    monkeypatch.setattr(Runtime, "make_navigation", absent)
    with pytest.raises(ImportError, match="no filterpy"):
        prepare(runtime())
    assert gc.isenabled()
