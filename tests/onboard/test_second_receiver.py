"""Two GPS receivers: the second takes over, and nothing is made surer by two that disagree."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import UTC, datetime
from random import Random

import pytest

from links.base import Rx
from links.simulated.firmware.gps import GpsReceiver, sentence
from links.simulated.sensors import SensorErrors
from links.simulated.settings import parse_settings
from mission.analysis.replay.replay import replay
from mission.authoring.language import parse
from mission.model.alarms import standing
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration, parse_configuration
from mission.onboard.rates import rated
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.receivers import FAILOVER, GPS, GPS2, Receivers
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore
from mission.verification.simulation.flight import fly
from protocol.messages import Fix

AUV = load_vehicle("auv")
PLACE = math.radians(30.29), math.radians(120.15)
Change = Callable[[float, dict[str, GpsReceiver]], None]


def counted(
    change: Change, seconds: int = 40, both: bool = True, used: Receivers | None = None
) -> list[tuple[float, str, Fix]]:
    """What counts of two receivers that lie still, when and of which."""
    start, out, used = datetime(2026, 6, 1, tzinfo=UTC), [], used or Receivers()
    made = {
        name: GpsReceiver(SensorErrors(first_fix=0.0), Random(name), start)
        for name in ((GPS, GPS2) if both else (GPS,))
    }
    for second in range(1, seconds):
        change(second, made)
        for name, receiver in made.items():
            receiver.report(second, 0.0, PLACE, (0.0, 0.0))
            for chunk in receiver.take(second + 0.9):
                found = used.receive(Rx(chunk.start, name, chunk.data))
                out += [(float(second), name, one) for one in found if isinstance(one, Fix)]
    return out


def unchanged(now: float, made: dict[str, GpsReceiver]) -> None:
    """Both are well."""


def apart_from_10(now: float, made: dict[str, GpsReceiver]) -> None:
    made[GPS].offset = (400.0, 0.0) if now >= 10 else (0.0, 0.0)


def test_beside_a_first_receiver_that_is_well_the_second_counts_for_nothing() -> None:
    alone, beside = counted(unchanged, both=False), counted(unchanged)
    assert beside == alone
    assert len(alone) > 35


def test_the_second_takes_over_within_seconds_of_silence_and_hands_back() -> None:
    def silent(now: float, made: dict[str, GpsReceiver]) -> None:
        made[GPS].silent = 10 <= now < 25

    names = {second: name for second, name, _ in counted(silent)}
    assert {names[s] for s in range(10 + int(FAILOVER) + 1, 25)} == {GPS2}
    assert {names[s] for s in (*range(2, 10), *range(26, 39))} == {GPS}


def test_the_second_takes_over_from_one_that_is_stuck() -> None:
    def stuck(now: float, made: dict[str, GpsReceiver]) -> None:
        made[GPS].stuck = now >= 10

    found = counted(stuck)
    assert {name for second, name, _ in found if second >= 16} == {GPS2}


def test_two_that_disagree_are_believed_no_better_than_they_are_apart() -> None:
    found = counted(apart_from_10)
    assert all(fix.accuracy < 20.0 for second, _, fix in found if second < 10)
    doubted = [fix.accuracy for second, _, fix in found if second > 10]
    assert all(apart > 380.0 for apart in doubted)
    assert all(
        380.0 < apart / n < 420.0 for n, apart in enumerate(doubted, round(doubted[0] / 400))
    )


def test_however_long_two_disagree_they_teach_no_more_than_two_fixes_would() -> None:
    found = counted(apart_from_10, seconds=600)
    doubted = [fix.accuracy for second, _, fix in found if second >= 10]
    assert len(doubted) > 500
    taught = sum(1.0 / accuracy**2 for accuracy in doubted)
    assert 1.0 / 400.0**2 < taught < 2.0 / 380.0**2


def test_while_two_disagree_neither_teaches_how_fast_it_moves() -> None:
    found = [fix for second, _, fix in counted(apart_from_10) if second > 10]
    assert {(fix.speed, fix.course) for fix in found} == {(None, None)}
    assert all(fix.speed is not None for second, _, fix in counted(unchanged) if second > 10)


@pytest.mark.parametrize("every", [1, 3, 4])
def test_a_second_that_speaks_seldom_is_compared_as_long_as_it_counts_as_speaking(
    every: int,
) -> None:
    def seldom(now: float, made: dict[str, GpsReceiver]) -> None:
        apart_from_10(now, made)
        made[GPS2].silent = bool(now % every)

    doubted = [fix.accuracy for second, _, fix in counted(seldom, 60) if second >= 10 + every]
    assert min(doubted) > 380.0


def test_what_the_other_said_long_ago_casts_no_doubt() -> None:
    """The vehicle has gone elsewhere since."""

    def ended(now: float, made: dict[str, GpsReceiver]) -> None:
        made[GPS2].silent = now >= 10
        made[GPS].offset = (400.0, 0.0) if now >= 30 else (0.0, 0.0)

    assert all(fix.accuracy < 20.0 for _, _, fix in counted(ended, 60))


def test_two_that_agree_again_are_believed_as_before() -> None:
    def jumped(now: float, made: dict[str, GpsReceiver]) -> None:
        made[GPS].offset = (400.0, 0.0) if 10 <= now < 20 or now >= 30 else (0.0, 0.0)

    found = {second: fix.accuracy for second, _, fix in counted(jumped)}
    assert all(found[second] < 20.0 for second in range(22, 30))
    assert found[32.0] < 1500.0, "it is doubted from the first again"


def said(*sentences: tuple[float, str, float]) -> list[tuple[float, str]]:
    """What counts, when and of which, of places so many m north that two receivers said."""
    used, out = Receivers(), list[tuple[float, str]]()
    for t, name, north in sentences:
        minutes = 17.4 + north / 1852.0
        clock = f"12{int(t) // 60:02}{int(t) % 60:02}.{int(t * 10) % 10}0"
        text = sentence(f"GPGGA,{clock},30{minutes:09.6f},N,12009.000000,E,1,09,0.9,3.0,M,,M,,")
        heard = [*used.receive(Rx(t, name, text)), *(x for _, y in used.flush(t + 0.3) for x in y)]
        out += [(t, name) for one in heard if isinstance(one, Fix)]
    return out


def at_surface(t: float, north: float) -> list[tuple[float, str, float]]:
    return [(t, GPS2, north), (t + 0.5, GPS, north + 1.0)]


def test_what_either_says_again_after_a_dive_does_not_count_whichever_counted_before() -> None:
    before = [one for t in range(30) for one in at_surface(t, t / 10.0)]
    again = [one for t in range(1830, 1850) for one in at_surface(t, 2.9)]
    new = [one for t in range(1850, 1855) for one in at_surface(t, 900.0 + t)]
    counts = said(*before, *again, *new)
    assert {name for t, name in counts if 1.0 < t < 1800.0} == {GPS}
    assert [t for t, _ in counts if 1800.0 < t < 1850.0] == []
    assert len([t for t, _ in counts if t >= 1850.0]) >= 5


def test_while_the_first_says_places_of_before_a_dive_in_turn_the_second_counts() -> None:
    before = [one for t in range(30) for one in at_surface(t, t / 10.0)]
    again = [(t + 0.5, GPS, 1.0 + (t % 10) / 10.0) for t in range(1830, 1850)]
    new = [(float(t), GPS2, 900.0 + t) for t in range(1830, 1850)]
    counts = [one for one in said(*before, *sorted(again + new)) if one[0] > 1800.0]
    assert counts == [(float(t), GPS2) for t in range(1830, 1850)]


def test_of_the_second_only_news_counts_and_without_it_all_that_the_first_says() -> None:
    stuck = [(float(t), GPS2, float(t % 3)) for t in range(30)]
    assert [t for t, _ in said(*stuck)] == [0.0, 1.0, 2.0]
    alone = [(float(t), GPS, 5.0) for t in (*range(30), *range(1830, 1850))]
    assert len(said(*alone)) == 50


def trouble(change: Change, until: int = 60) -> list[str]:
    """What is told of the receivers, after each second."""
    told = list[str]()
    used = Receivers()

    def listening(now: float, made: dict[str, GpsReceiver]) -> None:
        change(now, made)
        told.append(used.trouble)

    counted(listening, seconds=until, used=used)
    return told


def test_a_second_receiver_that_stands_in_is_told_until_the_first_counts_again() -> None:
    def silent(now: float, made: dict[str, GpsReceiver]) -> None:
        made[GPS].silent = 10 <= now < 40

    told = trouble(silent)
    words = "the first receiver says no fix: the second counts"
    assert set(told[:24]) == {""}, "a few seconds are no trouble"
    assert set(told[28:40]) == {words}
    assert set(told[43:]) == {""}


def test_what_is_told_of_a_receiver_says_whether_it_is_stuck_or_the_two_disagree() -> None:
    def stuck(now: float, made: dict[str, GpsReceiver]) -> None:
        made[GPS].stuck = now >= 10

    assert trouble(stuck)[-1] == "the first receiver is stuck: the second counts"
    assert "the two receivers say places 4" in trouble(apart_from_10)[-1]
    assert set(trouble(unchanged)) == {""}


def test_the_runtimes_alarm_says_that_the_second_stands_in() -> None:
    runtime = Runtime(Configuration(), AUV, MemoryStore())
    receiver = GpsReceiver(SensorErrors(first_fix=0.0), Random(2), datetime(2026, 6, 1, tzinfo=UTC))
    stood = list[bool]()
    for second in range(1, 25):
        receiver.report(second, 0.0, PLACE, (0.0, 0.0))
        for chunk in receiver.take(second + 0.9):
            runtime.receive(Rx(chunk.start, GPS2, chunk.data))
        alarms = standing(runtime.condition(second + 0.9))
        stood.append("receiver: the first receiver says no fix" in " ".join(map(str, alarms)))
    assert not any(stood[:8])
    assert all(stood[14:])


DIVE = """mission dive vehicle auv
home 30.2874595 120.1535765
safety radius 800 time 30min depth 15
down: depth 5 heading 40 gear 6 until depth >= 4 timeout 2min
a: gear 8 for 40
up: surface until fix timeout 4min
"""


@pytest.mark.parametrize(
    ("settings", "leaves"),
    [(("second_gps=2.5",), "end"), ((), "timeout")],
)
def test_a_mission_that_ends_with_a_fix_ends_by_the_second_receiver(
    settings: tuple[str, ...], leaves: str
) -> None:
    recorder = rec.ListRecorder()
    given = parse_settings([*settings, "fault=gps_lost@60+3000"])
    fly(parse(DIVE), AUV, "as-built", 2, given, recorder)
    left = [rec.step_of(r.payload) for r in recorder.records if r.kind == rec.STEP]
    last = next(step for step in reversed(left) if step.exited == ("autonomous/up",))
    assert last.by is not None
    assert last.by.value == leaves
    assert replay(recorder.records).identical


def test_its_line_is_a_link_like_that_of_the_first() -> None:
    given = parse_configuration("links: {gps2: serial:///dev/ttyUSB2}")
    assert rated(given, AUV).links.gps2 == "serial:///dev/ttyUSB2?baud=9600"
    assert parse_configuration("").links.gps2 is None
