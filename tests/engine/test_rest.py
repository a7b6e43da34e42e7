"""What is at rest and sinks, or does not rise, told from noise, jumps and silences: to the number."""

from __future__ import annotations

import math

import pytest

from mission.engine.rest import Rest

Seen = tuple[float, float | None]  # s, m


def rested(*seen: Seen, fastest: float = 0.6) -> Rest:
    rest = Rest(fastest)
    for t, depth in seen:
        rest.take(t, depth)
    return rest


@pytest.mark.parametrize(
    ("seen", "sinks"),
    [
        (
            [(0.0, 0.2), (2.0, 2.4), (3.0, 2.4)],
            True,
        ),  # within 1.5 times what it can dive, and 0.5 m
        ([(0.0, 0.2), (2.0, 2.6), (4.0, 2.6)], False),  # a jump begins anew
        ([(0.0, 0.9), (0.5, 2.7), (2.0, 2.7)], False),  # of less than a second as of one
        ([(0.0, 0.2), (2.0, 2.4), (2.5, 2.4)], False),  # not for a second yet
        ([(0.0, 0.25), (2.0, 2.0), (4.0, 2.0)], False),  # 2 m is not over 2 m
        ([(0.0, 2.0), (2.0, 2.5), (4.0, 2.5)], False),  # nor 0.5 m deeper than that
        ([(0.0, 2.0), (2.0, 2.6), (4.0, 2.6)], True),
        ([(0.0, 0.2), (2.0, 2.4), (3.0, None)], False),  # an unknown depth says nothing
    ],
)
def test_it_sinks_by_two_reports_of_what_a_body_can_do(seen: list[Seen], sinks: bool) -> None:
    assert rested(*seen).sinks == (
        f"it sinks though everything is stopped, {seen[-1][1]:.1f} m deep" if sinks else ""
    )


def test_one_wild_depth_in_seven_hides_no_vehicle_that_stays_deep_or_sinks() -> None:
    """Each one began anew what it had been before, twice."""
    stays, sinks = Rest(0.6), Rest(0.6)
    told: list[tuple[str, str]] = []
    for i in range(60):
        wild = 3.0 if i % 7 == 6 else 0.0
        stays.take(2.0 * i, 6.0 + wild)
        sinks.take(2.0 * i, 0.2 + 0.1 * i + wild)
        told.append((stays.stays_down(), sinks.sinks))
    assert any(deep for deep, _ in told[:14])
    assert any(sunk for _, sunk in told[:26])


def test_three_wild_depths_of_half_a_second_hide_none_either() -> None:
    stays, told = Rest(0.6), []
    for i in range(300):
        stays.take(0.2 * i, 6.0 + (3.0 if i % 35 > 31 else 0.0))
        told.append(stays.stays_down())
    assert any(told[:120])


def test_the_greatest_change_is_a_descent_still() -> None:
    assert rested((0.0, 0.0), (2.0, 3.5), (3.0, 3.5), fastest=1.0).sinks
    assert not rested((0.0, 0.0), (2.0, 3.6), (3.0, 3.6), fastest=1.0).sinks


@pytest.mark.parametrize(
    ("seen", "sinks"),
    [
        ([(0.0, 3.0), (2.0, 1.8), (4.0, 3.05), (6.0, 3.05)], False),  # one report that is off
        ([(0.0, 3.0), (2.0, 1.8), (4.0, 3.15), (6.0, 3.15)], True),  # a third of it counts
        ([(0.0, 3.0), (9.0, 1.8), (11.0, 2.25), (13.0, 2.25)], False),  # behind 6 s all of it
    ],
)
def test_the_shallowest_is_a_mean_of_six_seconds(seen: list[Seen], sinks: bool) -> None:
    assert bool(rested(*seen).sinks) is sinks


STAYS = "it does not rise though everything is stopped, 8.0 m deep"


def stays(*seen: Seen) -> list[str]:
    """What is said with each report."""
    rest, said = Rest(0.6), []
    for t, depth in seen:
        rest.take(t, depth)
        said.append(rest.stays_down())
    return said


def test_it_stays_down_when_twenty_seconds_have_brought_less_than_half_a_metre() -> None:
    assert stays(*((2.0 * n, 8.0) for n in range(11))) == [
        *[""] * 10,
        STAYS,
    ]
    assert stays((0.0, 8.0), (10.0, 7.7), (20.0, 7.5)) == ["", "", ""]
    assert stays((0.0, 2.0), (10.0, 2.0), (20.0, 2.0)) == ["", "", ""]


def test_ten_seconds_without_a_depth_are_borne_and_more_begin_the_twenty_anew() -> None:
    assert stays((0.0, 8.0), (10.0, 8.0), (20.0, 8.0))[-1]
    assert not stays((0.0, 8.0), (10.5, 8.0), (20.5, 8.0))[-1]
    assert stays((0.0, 8.0), (10.5, 8.0), (20.5, 8.0), (30.5, 8.0))[-1]


def test_what_is_seen_in_spells_alone_stays_down_when_they_have_lasted_twenty_seconds() -> None:
    """14 s with a depth, 12 s without one, in turn: no spell is long enough by itself."""
    spell = [(2.0 * n, 8.0) for n in range(8)]
    assert not stays(*spell)[-1]
    again = [(26.0 + t, depth) for t, depth in spell]
    assert stays(*spell, *again)[7:] == [*[""] * 4, *[STAYS] * 5]
    risen = [(26.0 + t, 7.4) for t, _ in spell]
    assert not stays(*spell, *risen)[-1]


def test_a_copy_goes_its_own_way_and_what_nobody_has_seen_says_nothing() -> None:
    rest = rested((0.0, 0.2), (2.0, 2.4))
    copy = rest.clone()
    copy.take(3.0, 2.4)
    assert (bool(copy.sinks), rest.sinks) == (True, "")
    assert (Rest(0.6).sinks, Rest(0.6).stays_down()) == ("", "")


def test_what_proved_the_surface_is_the_shallowest_that_it_was() -> None:
    rest = Rest(0.6)
    rest.begin(0.3)
    for t in (0.0, 2.0):
        rest.take(t, 5.0)
    assert rest.sinks
    rest.begin(math.nan)
    for t in (4.0, 6.0):
        rest.take(t, 5.0)
    assert not rest.sinks
