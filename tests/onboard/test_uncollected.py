"""Two threads that do without the collector: it is back when the last of them has left."""

from __future__ import annotations

import gc

import pytest

from mission.onboard.uncollected import uncollected


def test_the_collector_is_back_when_the_last_one_has_left() -> None:
    assert gc.isenabled()
    first, second = uncollected(), uncollected()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert not gc.isenabled(), "the second is still inside"
    second.__exit__(None, None, None)
    assert gc.isenabled()


def test_an_error_inside_brings_it_back() -> None:
    with pytest.raises(ValueError, match="x"), uncollected():
        raise ValueError("x")
    assert gc.isenabled()


def test_where_it_was_off_it_stays_off() -> None:
    gc.disable()
    try:
        with uncollected():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()
