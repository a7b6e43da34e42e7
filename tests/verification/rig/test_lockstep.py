"""The one event loop: time goes from event to event, and never back."""

from __future__ import annotations

import math

import pytest

from mission.verification.rig.busy import Busy
from mission.verification.rig.lockstep import Due, LockStep


class Clocks(LockStep):
    """Parties that are due at given times, and write down when they were heard."""

    def __init__(self, **times: list[float]) -> None:
        super().__init__()
        self.times = times
        self.heard: list[tuple[float, str]] = []

    def dues(self) -> list[Due]:
        return [
            (times[0] if times else None, lambda who=who: self.hear(who))
            for who, times in self.times.items()
        ]

    def hear(self, who: str) -> None:
        self.times[who].pop(0)
        self.heard.append((self.now, who))


def test_time_goes_from_event_to_event_whoever_has_it() -> None:
    clocks = Clocks(a=[1.0, 5.0], b=[2.5])
    clocks.run_until(10.0)
    assert clocks.heard == [(1.0, "a"), (2.5, "b"), (5.0, "a")]
    assert clocks.now == 10.0


def test_of_one_instant_who_stands_first_goes_first_and_goes_again_before_the_next() -> None:
    clocks = Clocks(a=[1.0, 1.0], b=[1.0])
    clocks.run_until(1.0)
    assert clocks.heard == [(1.0, "a"), (1.0, "a"), (1.0, "b")]


def test_who_was_due_before_now_is_due_now() -> None:
    clocks = Clocks(a=[3.0], b=[1.0])
    clocks.now = 4.0
    clocks.run_until(4.0)
    assert clocks.heard == [(4.0, "a"), (4.0, "b")]


def test_what_is_due_later_than_asked_for_stays_and_no_time_passes_for_it() -> None:
    clocks = Clocks(a=[3.0])
    assert not clocks.step(2.0)
    assert (clocks.now, clocks.heard) == (0.0, [])
    assert clocks.step(3.0)
    assert not clocks.step()


def test_an_instant_that_never_ends_is_told() -> None:
    with pytest.raises(Busy):
        Clocks(a=[1.0] * 1000).run_until(math.inf)
