"""The acoustic envelope: length order, CRC coverage, several frames inside, addresses."""

from __future__ import annotations

import pytest

from protocol.codec import CannotEncode
from protocol.messages import FrameFault
from protocol.modem import MOST, Envelope, ModemCodec, ModemFrame, Sender, wrap
from protocol.tolerances import Tolerances

CONTENT = b"@NI$@AW\x02\x00\x01\x00ZAF5$@DU$"


def codec(**options: str) -> ModemCodec:
    return ModemCodec(Tolerances.parse(options))


def test_the_documents_frames_are_what_wrap_makes() -> None:
    assert wrap(b"@DU$", Sender.TOPSIDE).hex() == "2302040001404455241486"
    assert wrap(b"@ACK_NI$$", 2).hex() == "230209000240" + "41434b5f4e4924" + "24f3de"


@pytest.mark.parametrize("size", [1, 35, 36, 256, 0x2302, MOST])
def test_content_of_any_length_comes_through_in_pieces(size: int) -> None:
    content = (CONTENT * 200)[: min(size, MOST)]
    raw = b"#" + wrap(content, 1)
    made = codec()
    found = [e for i in range(0, len(raw), 100) for e in made.receive(raw[i : i + 100], i / 1000)]
    assert found == [FrameFault(0, "bad_header", 1), Envelope(0.0, 1, content)]


@pytest.mark.parametrize("order", ["low", "high"])
@pytest.mark.parametrize("size", [1, 4, 255, 256, 1024, 3200])
def test_the_right_order_is_found_by_the_crc(order: str, size: int) -> None:
    content = bytes(size)
    raw = ModemFrame(order).wrap(content, 2)
    assert codec(order_modem="auto").receive(raw, 1.0) == [Envelope(1.0, 2, content)]
    assert codec(order_modem=order).receive(raw, 1.0) == [Envelope(1.0, 2, content)]


def test_a_wrong_order_is_never_accepted_by_its_range_alone() -> None:
    """Four bytes read in the wrong order ask for 1024."""
    raw = ModemFrame("high").wrap(b"@NI$", 1)
    made = codec()
    assert made.receive(raw, 0.0) == []
    assert made.flush(0.9) == []
    assert made.flush(1.0) == [FrameFault(0, "truncated", len(raw))]


def test_the_crc_may_cover_the_content_alone() -> None:
    raw = ModemFrame(covers="content").wrap(CONTENT, 1)
    assert codec(modem_crc="content").receive(raw, 0.0) == [Envelope(0.0, 1, CONTENT)]
    made = codec()
    assert made.receive(raw, 0.0) + made.flush(9.0) == [FrameFault(0, "bad_checksum", len(raw))]


@pytest.mark.parametrize(
    ("raw", "kind"),
    [
        (b"#\x02\x00\x00\x01", "bad_length"),
        (b"#\x02\x81\x0c\x01", "bad_length"),
        (b"#\x02\x01\x00\x03", "bad_enum"),
        (b"#\x02\x01", "truncated"),
        (b"#\x03", "bad_header"),
    ],
)
def test_a_head_that_cannot_be_is_refused_at_once(raw: bytes, kind: str) -> None:
    made = codec()
    assert made.receive(raw, 0.0) + made.flush(9.0) == [FrameFault(0, kind, len(raw))]


def test_a_false_head_holds_back_a_good_frame_for_a_second_at_most() -> None:
    made = codec()
    good = wrap(CONTENT, 1)
    assert made.receive(b"#\x02\x80\x0c\x01" + good, 0.0) == []
    assert made.next_timer() == 1.0
    assert made.flush(1.0) == [FrameFault(0, "truncated", 5), Envelope(0.0, 1, CONTENT)]


@pytest.mark.parametrize(("content", "address"), [(b"", 1), (bytes(MOST + 1), 1), (b"x", 0)])
def test_what_no_modem_takes_is_not_wrapped(content: bytes, address: int) -> None:
    with pytest.raises(CannotEncode):
        wrap(content, address)


@pytest.mark.parametrize("baud", [9600, 115200])
def test_a_content_comes_at_the_pace_of_the_line_or_is_given_up(baud: int) -> None:
    """A false head, a good frame behind it, and a byte of noise each 0.7 s for half an hour."""
    made, good = ModemCodec(baud=baud), wrap(CONTENT, 1)
    found = made.receive(b"#\x02\x80\x0c\x01" + good, 0.0)
    assert found == []
    patience, heard = 1.0 + 2.0 * 3207 * 10 / baud, None
    for i in range(1, 2600):
        now = i * 0.7
        due = made.next_timer()
        if due is not None and due <= now:
            heard = heard or (due if Envelope(0.0, 1, CONTENT) in made.flush(due) else None)
        made.receive(b"\xff", now)
    assert heard == pytest.approx(patience)


@pytest.mark.parametrize("baud", [9600, 115200])
def test_the_longest_content_has_twice_its_time_on_the_line(baud: int) -> None:
    made, raw, now = ModemCodec(baud=baud), wrap(bytes(MOST), 1), 0.0
    found: list[object] = []
    for i in range(0, len(raw), 10):
        due = made.next_timer()
        if due is not None and due <= now:
            found += made.flush(due)
        found += made.receive(raw[i : i + 10], now)
        now += 2.0 * 100 / baud
    assert found == [Envelope(0.0, 1, bytes(MOST))]
