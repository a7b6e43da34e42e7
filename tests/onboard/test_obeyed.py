"""The laws of X and W by modem: found in whatever comes, at once, and obeyed once (R7, G3)."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.onboard.runtime.command_target import MODEM
from mission.onboard.runtime.obeyed import HELD_UP_S
from mission.onboard.runtime.operator_channels import OperatorChannel, operator_channels
from protocol.messages import ClearMission, DataQuery, Emergency, Order, StartMission
from protocol.modem import MOST, ModemCodec, Sender, wrap
from protocol.tolerances import Tolerances
from protocol.topside import EMERGENCIES, encode

X, W = EMERGENCIES[Order.STOP], EMERGENCIES[Order.SURFACE]
STOP, SURFACE = Emergency(Order.STOP), Emergency(Order.SURFACE)
FALSE_HEAD = b"#\x02\x80\x0c\x01"


def modem(**tolerances: str) -> OperatorChannel:
    return operator_channels(Tolerances.parse(tolerances))(MODEM)


def commands(heard: list[object]) -> list[object]:
    known = Emergency | ClearMission | StartMission | DataQuery
    return [item for item in heard if isinstance(item, known)]


@pytest.mark.parametrize("order", list(Order))
@pytest.mark.parametrize(
    "around",
    [
        lambda frame: frame,
        lambda frame: wrap(frame, Sender.TOPSIDE),
        lambda frame: FALSE_HEAD + frame,
        lambda frame: FALSE_HEAD + wrap(frame, Sender.TOPSIDE),
        lambda frame: wrap(frame, Sender.TOPSIDE)[:-1] + b"\0",  # a damaged checksum
        lambda frame: b"@AW\x01\x00" + frame,
        lambda frame: b"@SP,100,@" + frame + b"@AA",
        lambda frame: b"\xff" * 500 + frame + FALSE_HEAD,
    ],
)
def test_x_and_w_are_heard_at_once_whatever_stands_around_them(order: Order, around) -> None:
    data = around(EMERGENCIES[order])
    for size in (1, 2, 5, len(data)):
        path, heard = modem(), []
        last = data.index(EMERGENCIES[order]) + len(EMERGENCIES[order])
        for at in range(0, len(data), size):
            heard += commands(path.receive(data[at : at + size], at * 1e-4))
            assert (Emergency(order) in heard) == (at + size >= last)
        while (due := path.next_timer()) is not None and due < 10.0:
            heard += commands(path.handle_timer(due))
        assert heard == [Emergency(order)]


def test_noise_at_the_pace_of_bytes_keeps_no_order_out() -> None:
    path, heard = modem(), commands(modem().receive(FALSE_HEAD, 0.0))
    path.receive(FALSE_HEAD, 0.0)
    for i in range(1, 2600):  # half an hour
        heard += commands(path.receive(b"\xff", i * 0.7))
        if i % 100 == 0:
            for at, byte in enumerate(wrap(W, Sender.TOPSIDE)):
                heard += commands(path.receive(bytes([byte]), i * 0.7 + at * 1e-4))
            assert heard == [SURFACE] * (i // 100)


def test_what_stood_before_an_order_in_its_content_was_overtaken_by_it() -> None:
    """An @AC that came before an X must not clear the stop that it led to."""
    raw = wrap(encode(ClearMission()) + X + encode(DataQuery()), Sender.TOPSIDE)
    whole, cut = modem(), modem()
    assert commands(whole.receive(raw, 0.0)) == [ClearMission(), STOP, DataQuery()]
    assert commands(cut.receive(raw[:-3], 0.0)) == [STOP]
    assert commands(cut.receive(raw[-3:], 0.01)) == [DataQuery()]


def test_an_order_said_again_is_obeyed_again() -> None:
    path, raw = modem(), wrap(X, Sender.TOPSIDE)
    heard = []
    for now in (0.0, 0.1, 0.2):
        heard += commands(path.receive(raw[:9], now)) + commands(path.receive(raw[9:], now + 0.01))
        heard += commands(path.receive(X, now + 0.02))  # bare, which no content will hold
        heard += commands(path.receive(raw, now + 0.03))
    assert heard == [STOP] * 9


def test_an_order_within_a_content_and_one_beside_it_are_two() -> None:
    raw = wrap(encode(DataQuery()) + X, Sender.TOPSIDE)
    assert commands(modem().receive(raw + X, 0.0)) == [STOP, DataQuery(), STOP]


def test_what_an_order_overtook_is_overtaken_in_its_own_content_alone() -> None:
    raw = wrap(encode(DataQuery()) + X, Sender.TOPSIDE)
    path = modem()
    assert commands(path.receive(raw[:-1], 0.0)) == [STOP]
    assert commands(path.receive(raw[-1:], 0.01)) == []
    assert commands(path.receive(raw, 0.02)) == [DataQuery(), STOP]
    assert commands(path.receive(X, 1.0)) == [STOP]  # bare: no content will come
    late = ModemCodec().framer.patience + HELD_UP_S
    assert commands(path.receive(raw, 1.0 + late)) == [DataQuery(), STOP]


@pytest.mark.parametrize("baud", [115200, 9600, 1200, 300])
def test_an_order_in_the_longest_content_is_obeyed_once_by_a_line_of_any_rate(baud: int) -> None:
    """And the @AC that stood before it, not at all: at 1200 baud the rest takes 26 s."""
    path = operator_channels(Tolerances(), f"serial:///dev/ttyUSB0?baud={baud}")(MODEM)
    head, tail = encode(ClearMission()) + X, encode(DataQuery())
    filler = tail * ((MOST - len(head)) // len(tail))
    heard = []
    for at, byte in enumerate(wrap(head + filler, Sender.TOPSIDE), 1):
        heard += commands(path.receive(bytes([byte]), at * 10 / baud))
    assert [h for h in heard if h != DataQuery()] == [STOP]
    assert DataQuery() in heard


def test_an_order_behind_a_false_head_is_obeyed_once_when_that_is_given_up_late() -> None:
    path = modem()
    heard = commands(path.receive(FALSE_HEAD + wrap(encode(ClearMission()) + X, 1), 0.0))
    heard += commands(path.handle_timer(ModemCodec().framer.patience + 5.0))
    assert heard == [STOP]


def test_a_nested_mission_line_is_no_order() -> None:
    line = b"@AW\x02\x00\x02\x00" + W + b"$"
    path, heard = modem(aw_nested="on"), []
    for byte in wrap(line, Sender.TOPSIDE):
        heard += commands(path.receive(bytes([byte]), 0.0))
    assert heard == []
    assert commands(path.receive(W, 0.1)) == [SURFACE]


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=40), st.binary(max_size=40), st.integers(1, 20), st.booleans())
def test_between_any_bytes_every_order_is_heard_once(before, after, size: int, framed) -> None:
    order = wrap(X, Sender.TOPSIDE) if framed else X
    data, path, heard = before + order + after, modem(), []
    for at in range(0, len(data), size):
        heard += commands(path.receive(data[at : at + size], at * 1e-4))
    while (due := path.next_timer()) is not None and due < 10.0:
        heard += commands(path.handle_timer(due))
    assert [h for h in heard if h == STOP] == [STOP] * data.count(X)


def test_the_order_of_orders_is_kept() -> None:
    assert commands(modem().receive(W + b"\xff" + X + W, 0.0)) == [SURFACE, STOP, SURFACE]


# --- by the network -----------------------------------------------------------------------------

BEGUN = (
    *(b"@", b"@A", b"@AW", b"@AW\x01", b"@AW\x01\x00", b"@AW\x01\x00\x01", b"@AW\x02\x00\x01\x00"),
    *(b"@AW\x02\x00\x01\x00ZAF5 and on", b"@SP,", b"@SP,100,20", b"@ST,2025/01/11 16:56", b"@NSOO"),
    *(b"@MS120,", b"@MDA", b"@DS1", b"@RSOOO", b"@ZA", b"@ZAX", b"@ZAWF", b"@AQ", b"#\x02\x80\x0c\x01"),
)  # fmt: skip


@pytest.mark.parametrize("order", list(Order))
@pytest.mark.parametrize("begun", BEGUN)
def test_no_frame_that_has_begun_keeps_an_order_of_its_connection_back(begun, order) -> None:
    path, heard = operator_channels(Tolerances())("topside"), []
    for at, byte in enumerate(begun + EMERGENCIES[order]):
        heard += commands(path.receive(bytes([byte]), at * 0.04))
    assert heard == [Emergency(order)]


def test_by_the_network_too_a_frame_that_drips_is_given_up_after_a_second() -> None:
    path = operator_channels(Tolerances.parse({"aw_nested": "on"}))("topside")
    path.receive(b"@AW\x02\x00\x01\x00", 0.0)
    path.receive(X, 0.01)  # its payload, perhaps
    heard, now = [], 0.01
    while now < 2.0 and not heard:
        due = path.next_timer()
        now += 0.04
        if due is not None and due <= now:
            heard += commands(path.handle_timer(due))
        heard += commands(path.receive(b"a", now)) if not heard else []
    assert heard == [STOP]
    assert now <= 1.05
