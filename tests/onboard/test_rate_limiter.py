"""A flood is dropped, an X or W in it never; nothing is ever joined that was not sent so."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from links.base import Rx
from mission.onboard.serve.rate_limiter import FRAMES, FRAMES_A_SECOND, SAME_ORDER_S, RateLimiter
from protocol.messages import Command, Emergency, FrameFault, Manual, Order
from protocol.tolerances import Tolerances
from protocol.topside import TopsideCodec

FLOOD = b"@DU$" * 2000
BOAT = "10.0.0.1:4000"


def rx(data: bytes, address: str = BOAT) -> Rx:
    return Rx(0.0, "topside", data, address)


def commands(data: bytes) -> list[Command]:
    codec = TopsideCodec(Tolerances.parse({}))
    found = [*codec.receive(data, 0.0), *codec.flush(60.0)]
    return [one for one in found if not isinstance(one, FrameFault)]


def orders(data: bytes) -> list[Order]:
    return [one.order for one in commands(data) if isinstance(one, Emergency)]


def flooded(limiter: RateLimiter, with_bytes: bytes = FLOOD) -> None:
    for _ in range(40):
        limiter.passes(rx(with_bytes), 0.0)


def test_an_ordinary_operator_loses_not_a_byte() -> None:
    limiter = RateLimiter(0.0)
    for second in range(100):
        for frame in (b"@DU$", b"@AQ$", b"@AW\x05\x00\x01\x00" + b"x" * 190 + b"$") * 20:
            assert limiter.passes(rx(frame), float(second)) == (frame, 0)


def test_a_flood_passes_as_far_as_its_allowance_and_in_whole_frames() -> None:
    limiter = RateLimiter(0.0)
    passed, dropped = limiter.passes(rx(FLOOD), 0.0)
    assert passed == b"@DU$" * int(FRAMES)
    assert dropped == len(FLOOD) - len(passed)
    assert len(commands(limiter.passes(rx(FLOOD), 1.0)[0])) == int(FRAMES_A_SECOND)


def test_x_and_w_pass_a_flood_at_once_and_another_address_is_not_touched() -> None:
    limiter = RateLimiter(0.0)
    flooded(limiter)
    assert orders(limiter.passes(rx(FLOOD + b"@ZAX0$" + FLOOD), 0.0)[0]) == [Order.STOP]
    assert orders(limiter.passes(rx(FLOOD + b"@ZAWF$" + FLOOD), 0.0)[0]) == [Order.SURFACE]
    assert limiter.passes(rx(b"@AQ$", "10.0.0.2:1"), 0.0) == (b"@AQ$", 0)


def test_new_connections_of_the_same_address_bring_no_new_allowance() -> None:
    limiter = RateLimiter(0.0)
    flooded(limiter)
    limiter.forget(BOAT)
    assert limiter.passes(rx(b"@DU$", "10.0.0.1:4001"), 0.0) == (b"", 4)


def test_many_addresses_together_have_a_limit_too() -> None:
    limiter = RateLimiter(0.0)
    passed = sum(limiter.passes(rx(FLOOD, f"10.0.1.{i}:1"), 0.0)[0].count(b"@") for i in range(20))
    assert passed == 4 * FRAMES
    assert orders(limiter.passes(rx(b"@ZAX0$", "10.0.2.1:1"), 0.0)[0]) == [Order.STOP]


def test_a_flood_of_orders_is_one_at_a_time_and_the_last_wins() -> None:
    limiter = RateLimiter(0.0)
    flooded(limiter)
    many = b"@ZAX0$@ZAWF$" * 5000
    assert orders(limiter.passes(rx(many), 0.0)[0]) == [Order.SURFACE]
    assert orders(limiter.passes(rx(many), 0.001)[0]) == []
    assert orders(limiter.passes(rx(many), 2 * SAME_ORDER_S)[0])[-1] == Order.SURFACE


def test_the_ends_of_two_frames_never_join_to_a_third() -> None:
    limiter = RateLimiter(0.0)
    flooded(limiter)
    first = limiter.passes(rx(b"@MMF1"), 1.0 / FRAMES_A_SECOND)[0]
    lost = limiter.passes(rx(FLOOD), 1.0 / FRAMES_A_SECOND)[0]
    last = limiter.passes(rx(b"2$"), 10.0)[0]
    assert first.endswith(b"@MMF1")
    assert lost == b""
    found = commands(first + lost + last)
    assert not any(isinstance(one, Manual) and b"F12" in one.frame for one in found)


@pytest.mark.proof
@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.integers(1, 40), max_size=30),
    st.sampled_from([b"@ZAX0$", b"@ZAWF$"]),
    st.integers(0, 300),
    st.floats(0.0, 0.01),
    st.sampled_from([FLOOD, bytes(8192)]),
)
@example([1, 3], b"@ZAX0$", 0, 0.0, bytes(8192))
def test_an_order_passes_wherever_the_stream_is_cut(
    cuts: Sequence[int], order: bytes, before: int, pause: float, flood: bytes
) -> None:
    limiter = RateLimiter(0.0)
    flooded(limiter, flood)
    stream = b"@DU$" * before + order + b"@DU$" * 20
    out, at, now = bytearray(), 0, 0.0
    for cut in [*cuts, len(stream)]:
        out += limiter.passes(rx(stream[at : at + cut]), now)[0]
        at, now = at + cut, now + pause
    wanted = Order.STOP if order == b"@ZAX0$" else Order.SURFACE
    assert wanted in orders(bytes(out))


def test_what_holds_an_order_goes_first() -> None:
    limiter = RateLimiter(0.0)
    heard = [rx(b"@DU$", "a:1"), rx(b"@AQ$@ZAX0$", "b:1"), rx(b"@DU$", "c:1")]
    told: list[str] = []
    assert [one.address for one in limiter.sift(heard, 0.0, told.append)] == ["b:1", "a:1", "c:1"]
    assert told == []
    limiter.sift([rx(FLOOD)], 0.0, told.append)
    assert told == ["10.0.0.1"]
    assert limiter.dropped == len(FLOOD) - 4 * FRAMES
