"""Of all tests of the console: one Chromium for those of a module that need one."""

from __future__ import annotations

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="module")
def chromium() -> Iterator[object]:
    from browser_world import browser  # skipped where there is none

    with browser() as launched:
        yield launched
