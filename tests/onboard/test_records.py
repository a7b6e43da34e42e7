"""What goes on record comes back to the last bit."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from links.base import Rx
from mission.model import Estimate, NavigationMode, Tx
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.runtime.records import (
    CONNECTED,
    Start,
    estimate_of,
    estimate_record,
    input_record,
    read_rx,
    read_start,
    read_texts,
    read_time,
    read_tx,
    rx_record,
    start_record,
    tx_record,
)
from mission.onboard.store import Stored
from protocol.messages import SetSafety

names = st.text(st.characters(min_codepoint=1, max_codepoint=0x2FF), max_size=12)
times = st.floats(0.0, 1e9)


@given(times, times, names, st.binary(max_size=60), names)
@settings(max_examples=50)
def test_an_input_comes_back_whatever_its_bytes(
    first: float, now: float, link: str, data: bytes, address: str
) -> None:
    rx = Rx(first, link, data, address)
    record = rx_record(rx, now)
    assert (read_rx(record), read_time(record)) == (rx, now)


@given(times, names, st.binary(max_size=60), names, names)
@settings(max_examples=50)
def test_an_output_comes_back_with_its_reason(
    t: float, link: str, data: bytes, reason: str, address: str
) -> None:
    tx = Tx(t, link, data, reason, address)
    assert read_tx(tx_record(tx)) == tx


numbers = st.floats(allow_nan=False, allow_infinity=False)
readings = st.none() | numbers
estimates = st.builds(
    Estimate,
    t=times,
    depth=readings,
    depth_rate=readings,
    altitude=readings,
    heading=readings,
    **dict.fromkeys(("north", "east", "speed", "current_north", "current_east"), numbers),
    covariance=st.tuples(numbers, numbers, numbers),
    sigmas=st.dictionaries(names, numbers, max_size=3),
    nis=st.none() | st.tuples(numbers, st.integers(1, 2)),
    fix_age=readings,
    mode=st.sampled_from(NavigationMode),
)


@given(estimates)
@settings(max_examples=50)
def test_an_estimate_comes_back(estimate: Estimate) -> None:
    assert estimate_of(estimate_record(estimate).payload) == estimate


@given(times, names, names)
@settings(max_examples=20)
def test_a_connection_comes_back(t: float, link: str, address: str) -> None:
    record = input_record(t, CONNECTED, link, address)
    assert (read_time(record), read_texts(record)) == (t, (link, address))


def test_the_start_comes_back_whole() -> None:
    start = Start(
        "1.2.3",
        Configuration(
            links=LinkUrls(gps=None), tolerances={"st_commas": "off"}, manual_for=math.pi
        ),
        load_vehicle("auv"),
        Stored(
            ("mission a vehicle auv", "ZAF6"), SetSafety(radius=0.1), "autonomous", ("damaged",)
        ),
        1_700_000_000.123456,
    )
    assert read_start(start_record(start, 0.25)) == start
