"""G1 to G5, runs of faults, torn frames, time of arrival, linear time."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Sequence
from typing import Any

import pytest
from canonical_auv import AUV, SD, VS
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.fields import U8, BinaryFrame, Const, FaultKind
from protocol.framing import Frame, Framer, Shortcut, Splice, fault
from protocol.messages import FrameFault
from protocol.tolerances import Tolerances
from protocol.vehicles import link, links

Item = tuple[object, ...]


def shown(item: Frame | FrameFault) -> Item:
    if isinstance(item, FrameFault):
        return (item.offset, item.kind, item.length)
    return (item.offset, item.type.name, item.raw)


def read(framer: Framer, *chunks: bytes) -> list[Item]:
    items = [item for chunk in chunks for item in framer.receive(chunk, 0.0)]
    return [shown(item) for item in items + framer.flush(1e9)]


def on(name: str, *chunks: bytes) -> list[Item]:
    return read(link(name).framer(), *chunks)


# --- delimiting (G1, E-F2, E-F3) ---


@pytest.mark.parametrize("total", [0x24, 0x40, 0x2440, 0x1024, 9999])
def test_a_mission_line_is_delimited_behind_its_counters(total: int) -> None:
    for current in (c for c in (1, 0x24, 0x40, 0x2424, total) if c <= total):
        raw = b"@AW" + total.to_bytes(2, "little") + current.to_bytes(2, "little") + b"x$"
        assert on("auv.to_pi", raw + b"@DU$") == [(0, "auv.AW", raw), (9, "auv.DU", b"@DU$")]


def test_counters_that_spell_a_command_are_counters() -> None:
    """A line cut in its counters yields one of 16384 or more, and is refused."""
    assert on("auv.to_pi", b"@AW@NI$") == [(0, "out_of_range", 3), (3, "auv.NI", b"@NI$")]


@pytest.mark.parametrize("mask", [0x24, 0x40, 0x00, 0xFF])
def test_a_mask_may_be_any_byte(mask: int) -> None:
    raw = b"@ACK_RI" + bytes([mask]) + b"$"
    assert on("auv.from_stm32", raw + raw) == [(0, "auv.ACK", raw), (9, "auv.ACK", raw)]


# --- one byte for a failure (G2), runs ---


def test_a_failing_candidate_costs_one_byte() -> None:
    for n in range(1, 5):
        assert on("auv.to_pi", b"@" * n + b"@NI$") == [(0, "bad_header", n), (n, "auv.NI", b"@NI$")]
    assert on("auv.to_pi", b"@MMF1@MMF2$") == [(0, "bad_char", 5), (5, "auv.MM", b"@MMF2$")]


def test_a_run_is_one_fault_with_the_kind_of_its_first_candidate() -> None:
    noise = b"..@MMF13$..@MMX1$.."
    assert on("auv.to_pi", noise + b"@DU$" + b"!!") == [
        (0, "out_of_range", len(noise)),
        (len(noise), "auv.DU", b"@DU$"),
        (len(noise) + 4, "bad_header", 2),
    ]


def test_a_good_frame_behind_a_broken_one_is_not_lost() -> None:
    broken = bytearray(SD)
    broken[40] ^= 1
    found = on("auv.from_stm32", bytes(broken) + SD + b"@ACK_ZFY$")
    assert found == [
        (0, "bad_checksum", 86),
        (86, "auv.SD", SD),
        (172, "auv.ACK", b"@ACK_ZFY$"),
    ]


def test_short_frames_inside_a_cut_long_one_are_found_after_the_idle_time() -> None:
    framer = link("auv.from_stm32").framer()
    assert framer.receive(SD[:50] + b"@ACK_ZAY$", 1.0) == []
    assert framer.next_timer() == pytest.approx(1.05)
    assert framer.flush(1.04) == []
    assert [shown(i) for i in framer.flush(1.05)] == [
        (0, "truncated", 50),
        (50, "auv.ACK", b"@ACK_ZAY$"),
    ]
    assert framer.next_timer() is None
    assert framer.flush(9.0) == []


def test_the_head_alone_is_a_candidate_that_was_cut() -> None:
    for head in (b"@", b"@S", b"@SD", b"@ACK"):
        assert on("auv.from_stm32", head) == [(0, "truncated", len(head))]


def test_a_run_stays_open_until_a_frame_or_the_idle_time_ends_it() -> None:
    framer = link("auv.from_stm32").framer()
    assert framer.receive(b"abc", 0.0) == framer.receive(b"def", 0.02) == []
    assert framer.next_timer() == pytest.approx(0.07)
    assert [shown(i) for i in framer.flush(0.07)] == [(0, "bad_header", 6)]


def test_nothing_comes_of_nothing() -> None:
    framer = link("auv.any").framer()
    assert framer.receive(b"", 0.0) == []
    assert framer.next_timer() is None
    assert framer.flush(1.0) == []


def test_counters_tell_good_frames_faults_by_kind_and_skipped_bytes() -> None:
    framer = link("auv.to_pi").framer()
    read(framer, b"@DU$..@MMF13$@NI$", b"@MMX1$", b"@A")
    assert framer.counters.good == 2
    assert framer.counters.bad == {"out_of_range": 1, "bad_enum": 1}
    assert framer.counters.skipped == 9 + 8


# --- torn frames ---


@pytest.mark.parametrize("at", range(1, 86))
def test_an_acknowledgement_spliced_into_an_sd_costs_neither(at: int) -> None:
    ack = b"@ACK_ZAY$"
    torn = SD[:at] + ack + SD[at:]
    assert on("auv.from_stm32", b"xx" + torn + SD) == [
        (0, "bad_header", 2),
        (2, "auv.SD", SD),
        (2 + at, "auv.ACK", ack),
        (97, "auv.SD", SD),
    ]


def test_several_acknowledgements_in_one_sd_are_all_taken_out() -> None:
    first, second, third = b"@ACK_ZAY$", b"@ACK_ZAN$", b"@ACK_RI$$"
    torn = SD[:10] + first + second + SD[10:85] + third + SD[85:]
    assert on("auv.from_stm32", torn) == [
        (0, "auv.SD", SD),
        (10, "auv.ACK", first),
        (19, "auv.ACK", second),
        (103, "auv.ACK", third),
    ]


def test_an_acknowledgement_survives_an_sd_that_cannot_be_mended() -> None:
    broken = bytearray(SD)
    broken[80] ^= 0x10
    torn = bytes(broken[:30]) + b"@ACK_ZAY$" + bytes(broken[30:])
    assert on("auv.from_stm32", torn + b"@ACK_ZAN$") == [
        (0, "bad_tail", 30),
        (30, "auv.ACK", b"@ACK_ZAY$"),
        (39, "bad_header", 56),
        (95, "auv.ACK", b"@ACK_ZAN$"),
    ]


def test_a_torn_sd_is_waited_for_as_long_as_it_may_still_be_whole() -> None:
    torn = SD[:84] + b"@ACK_ZAY$" + SD[84:]
    framer = link("auv.from_stm32").framer()
    early = [item for i in range(94) for item in framer.receive(torn[i : i + 1], 0.0)]
    assert early == []
    assert [shown(i) for i in framer.receive(torn[94:], 0.0)] == [
        (0, "auv.SD", SD),
        (84, "auv.ACK", b"@ACK_ZAY$"),
    ]


def test_more_guests_than_a_frame_can_have_are_not_sought() -> None:
    torn = SD[:10] + b"@ACK_ZAY$" * 5 + SD[10:]
    names = [item[1] for item in on("auv.from_stm32", torn)]
    assert names.count("auv.ACK") == 5
    assert "auv.SD" not in names


# --- chunking and time of arrival ---

STREAM = b"".join(raw for _, _, raw in AUV) + SD[:20] + b"@ACK_ZBN$" + SD[20:] + b"@A" + VS


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.integers(1, 60), min_size=1, max_size=400),
    st.sampled_from([r.name for r in links()]),
)
def test_any_chunking_gives_the_same_frames(sizes: list[int], name: str) -> None:
    chunks, at = [], 0
    for size in sizes:
        chunks.append(STREAM[at : at + size])
        at += size
    assert on(name, *chunks, STREAM[at:]) == on(name, STREAM)


@pytest.mark.proof
@settings(max_examples=150, deadline=None)
@given(
    st.lists(
        st.one_of(
            st.sampled_from([raw for _, _, raw in AUV]),
            st.binary(max_size=12),
            st.builds(lambda raw, n: raw[:n], st.sampled_from([SD, VS]), st.integers(0, 90)),
            st.builds(lambda n: SD[:n] + b"@ACK_ZAY$" + SD[n:], st.integers(1, 86)),
        ),
        max_size=8,
    ),
    st.integers(1, 40),
)
def test_chunks_cover_every_byte_exactly_once(parts: list[bytes], size: int) -> None:
    data = b"".join(parts)
    chunks = [data[i : i + size] for i in range(0, len(data), size)]
    for name in ("auv.any", "auv.from_stm32", "auv.to_pi"):
        whole = on(name, data)
        assert on(name, *chunks) == whole
        used = sum(len(i[2]) if isinstance(i[2], bytes) else int(str(i[2])) for i in whole)
        assert used == len(data)


def test_a_frame_carries_the_time_of_its_first_byte() -> None:
    framer = link("auv.from_stm32").framer()
    assert framer.receive(SD[:1], 1.0) == []
    assert framer.receive(SD[1:50], 1.01) == []
    first, second = framer.receive(SD[50:] + SD, 1.02)
    assert isinstance(first, Frame)
    assert isinstance(second, Frame)
    assert (first.t, second.t) == (1.0, 1.02)


def test_times_of_chunks_that_are_gone_are_forgotten() -> None:
    framer = link("auv.from_stm32").framer()
    for i in range(5000):
        framer.receive(SD[i % 86 : i % 86 + 1], i * 0.001)
    assert len(framer.times) <= 90
    assert len(framer.buffer) <= 86


# --- the shortcut ---


def read_b(
    data: bytes, at: int, last: int, base: int, t: float
) -> tuple[Sequence[object], int, int]:
    """A reader of frames ``<b>`` which, like one, reads over full stops."""
    assert data[at] == ord("<")
    assert at <= last <= len(data) - 3
    items: list[object] = []
    gaps, stop = 0, at
    while at <= last and data.startswith(b"<b>", at):
        if at > stop:
            items.append(fault(base + stop, "bad_header", at - stop))
            gaps += 1
        items.append(("quick", base + at, t))
        at = stop = at + 3
        while at <= last and data[at] == ord("."):
            at += 1
    return items, gaps, stop


LETTER = BinaryFrame("letter", "", (Const(b"<"), U8("letter", 97, 122), Const(b">")), command=True)
B_QUICKLY = Shortcut(b"<b", 3, read_b, lambda frame: ("slow", frame.offset, frame.t))


def quickly(chunks: Sequence[bytes]) -> tuple[list[Any], Framer]:
    """Messages as offset and time, faults as they are."""
    framer = Framer((LETTER,), shortcut=B_QUICKLY)
    items: list[Any] = []
    for i, chunk in enumerate(chunks):
        items += framer.receive(chunk, float(i))
    items += framer.flush(1e9)
    return [item if isinstance(item, FrameFault) else item[1:] for item in items], framer


@pytest.mark.proof
@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.sampled_from(["<b>", "<b>", "<c>", "<B>", "<", "b>", ".", ".."]), max_size=30),
    st.lists(st.integers(1, 7), max_size=30),
)
def test_a_shortcut_changes_neither_frames_nor_faults_nor_times_nor_counters(
    parts: list[str], sizes: list[int]
) -> None:
    data, chunks = "".join(parts).encode(), []
    for size in sizes:
        chunks.append(data[:size])
        data = data[size:]
    chunks.append(data)
    plain = Framer((LETTER,))
    items = [item for i, chunk in enumerate(chunks) for item in plain.receive(chunk, float(i))]
    items += plain.flush(1e9)
    expected = [i if isinstance(i, FrameFault) else (i.offset, i.t) for i in items]
    found, framer = quickly(chunks)
    assert found == expected
    assert framer.counters == plain.counters
    assert framer.buffer == b""


def test_a_frame_behind_a_false_start_has_the_time_of_its_own_first_byte() -> None:
    for first, second in ((b"<<b", b"><b>"), (b"..<<", b"b>.<b>")):
        found, _ = quickly([first, second])
        assert [t for _, t in (item for item in found if not isinstance(item, FrameFault))] == [
            0.0,
            1.0,
        ]


def test_the_shortcut_is_taken_wherever_it_can_be() -> None:
    framer = Framer((LETTER,), shortcut=B_QUICKLY)
    assert framer.receive(b"<b>..<b><c>.<b", 1.0) == [
        ("quick", 0, 1.0),
        FrameFault(3, "bad_header", 2),
        ("quick", 5, 1.0),
        ("slow", 8, 1.0),
    ]
    assert framer.receive(b"><b><b>", 2.0) == [
        FrameFault(11, "bad_header", 1),
        ("quick", 12, 1.0),
        ("quick", 15, 2.0),
        ("quick", 18, 2.0),
    ]
    assert framer.receive(b"<b>", 3.0) == [("quick", 21, 3.0)]
    assert (framer.counters.good, framer.counters.skipped) == (7, 3)
    assert framer.counters.bad == {"bad_header": 2}


def test_what_came_with_one_chunk_is_read_in_one_go() -> None:
    asked: list[tuple[int, int]] = []

    def noted(data: bytes, at: int, last: int, base: int, t: float) -> Any:
        asked.append((base + at, base + last))
        return read_b(data, at, last, base, t)

    framer = Framer((LETTER,), shortcut=dataclasses.replace(B_QUICKLY, read=noted))
    framer.receive(b"<b>" * 5 + b"<", 0.0)
    framer.receive(b"b>" + b"<b>" * 5, 0.0)
    assert asked == [(0, 13), (15, 15), (18, 30)]


# --- candidates of several lengths, one-byte leads ---


def test_of_two_complete_candidates_the_shorter_one_counts() -> None:
    short = BinaryFrame("short", "", (Const(b"\xaa"), U8("a"), Const(b"\xdd")))
    long = BinaryFrame("long", "", (Const(b"\xaa"), U8("a"), U8("b"), Const(b"\xdd")))
    assert read(Framer((long, short)), b"\xaa\x01\xdd\xaa\x01\x02\xdd") == [
        (0, "short", b"\xaa\x01\xdd"),
        (3, "long", b"\xaa\x01\x02\xdd"),
    ]
    assert read(Framer((long, short)), b"\xaa\x01\xdd\xdd") == [
        (0, "short", b"\xaa\x01\xdd"),
        (3, "bad_header", 1),
    ]


def test_leads_of_one_and_two_bytes_live_side_by_side() -> None:
    one = BinaryFrame("one", "", (Const(b"\xaa"), U8("a"), Const(b"\xdd")))
    two = BinaryFrame("two", "", (Const(b"\xaa\xbb"), U8("a"), Const(b"\xee")))
    assert read(Framer((one, two)), b"\xaa\xbb\xdd\xaa\xbb\x01\xee\xaa\x00\xdd") == [
        (0, "one", b"\xaa\xbb\xdd"),
        (3, "two", b"\xaa\xbb\x01\xee"),
        (7, "one", b"\xaa\x00\xdd"),
    ]


def test_the_longest_lead_names_the_fault() -> None:
    one = BinaryFrame("one", "", (Const(b"\xaa"), U8("a"), Const(b"\xdd")))
    two = BinaryFrame("two", "", (Const(b"\xaa\xbb"), Const(b"\xcc", FaultKind.BAD_LENGTH)))
    for types in ((one, two), (two, one)):
        assert read(Framer(types), b"\xaa\xbb\xee") == [(0, "bad_length", 3)]


def test_part_of_a_lead_is_waited_for_and_a_whole_other_lead_is_not() -> None:
    long = BinaryFrame("long", "", (Const(b"<long>"), U8("a")))
    framer = Framer((long,))
    assert framer.receive(b"<", 0.0) == framer.receive(b"lon", 0.0) == []
    assert [shown(i) for i in framer.receive(b"d><long", 0.0)] == []
    assert [shown(i) for i in framer.receive(b">!", 0.0)] == [
        (0, "bad_header", 6),
        (6, "long", b"<long>!"),
    ]
    assert read(Framer((long,)), b"<", b"long>!") == [(0, "long", b"<long>!")]
    assert read(Framer((long,)), b"<lo") == [(0, "truncated", 3)]
    assert read(Framer((long,)), b"<loX") == [(0, "bad_header", 4)]


def test_values_of_a_frame_are_those_of_its_table() -> None:
    (frame,) = link("auv.to_pi").framer().receive(b"@MMF12$", 0.0)
    assert isinstance(frame, Frame)
    assert frame.values() == {"dir": "F", "speed": 12}


# --- times and memory ---


def test_only_the_chunks_whose_bytes_are_held_are_remembered() -> None:
    framer = link("auv.from_stm32").framer()
    framer.receive(SD[:10], 1.0)
    framer.receive(SD[10:20], 2.0)
    assert framer.times == [1.0, 2.0]
    framer.receive(SD[20:] + SD[:5], 3.0)
    assert (framer.times, framer.starts) == ([3.0], [20])
    framer.receive(SD[5:], 4.0)
    framer.receive(b"", 5.0)
    assert framer.times == [4.0]
    assert framer.next_timer() is None
    framer.receive(b"@", 6.0)
    assert framer.next_timer() == pytest.approx(6.05)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(1, 60), max_size=12), st.integers(0, 3))
def test_every_frame_has_the_time_of_the_chunk_in_which_it_began(
    sizes: list[int], noise: int
) -> None:
    data = (b"." * noise + b"@ACK_ZAY$" + SD) * 3
    cuts = [0, *(sum(sizes[: i + 1]) for i in range(len(sizes)))]
    framer = link("auv.from_stm32").framer()
    items: list[Any] = []
    for i, (begin, end) in enumerate(zip(cuts, [*cuts[1:], len(data)], strict=True)):
        items += framer.receive(data[begin:end], float(i))
    frames = [item for item in items if isinstance(item, Frame)]
    assert len(frames) == 6
    for frame in frames:
        assert frame.t == max(i for i, cut in enumerate(cuts) if cut <= frame.offset)


# --- torn frames of the smallest size ---

HOST = BinaryFrame("host", "", (Const(b"<h"), U8("a"), U8("b"), Const(b">")))
GUEST = BinaryFrame("guest", "", (Const(b"{g"), U8("a"), Const(b"}")))


def torn(*chunks: bytes) -> list[Item]:
    return read(Framer((HOST, GUEST), splice=Splice(HOST, GUEST)), *chunks)


@pytest.mark.parametrize("at", range(1, 5))
@pytest.mark.parametrize("count", [1, 2, 4])
def test_guests_are_taken_out_of_a_host_wherever_they_stand(at: int, count: int) -> None:
    host, guests = b"<h12>", [b"{g%d}" % i for i in range(count)]
    data = host[:at] + b"".join(guests) + host[at:]
    expected = [(0, "host", host)] + [(at + 4 * i, "guest", g) for i, g in enumerate(guests)]
    assert torn(data) == expected
    assert torn(*(data[i : i + 1] for i in range(len(data)))) == expected
    assert torn(b"." + data + host) == [
        (0, "bad_header", 1),
        *((offset + 1, name, raw) for offset, name, raw in expected),
        (1 + len(data), "host", host),
    ]


def test_a_guest_behind_the_host_is_no_guest_inside() -> None:
    assert torn(b"<h12>{g3}") == [(0, "host", b"<h12>"), (5, "guest", b"{g3}")]
    assert torn(b"<h12{g3}") == [(0, "bad_tail", 4), (4, "guest", b"{g3}")]
    assert torn(b"<h{g3}2>") == [
        (0, "bad_tail", 2),
        (2, "guest", b"{g3}"),
        (6, "bad_header", 2),
    ]


def test_a_torn_host_comes_as_soon_as_no_more_guests_can() -> None:
    """What stands there whole and is no guest is waited for no longer."""
    fields = (Const(b"<h"), *(U8(name) for name in "abcde"), Const(b">"))
    wide = BinaryFrame("wide", "", fields)
    framer = Framer((wide, GUEST), splice=Splice(wide, GUEST))
    assert [shown(i) for i in framer.receive(b"<{g1}ha{g3x>", 0.0)] == [
        (0, "wide", b"<ha{g3x>"),
        (1, "guest", b"{g1}"),
    ]
    assert framer.receive(b"<{g1}habc{g>", 0.0) == []
    assert [shown(i)[1:] for i in framer.receive(b".", 0.0)] == [
        ("wide", b"<habc{g>"),
        ("guest", b"{g1}"),
    ]


def test_a_host_begins_as_its_lead_does_or_it_is_none() -> None:
    assert torn(b"<{g1}x12>") == [(0, "bad_header", 1), (1, "guest", b"{g1}"), (5, "bad_header", 4)]
    assert torn(b"<{g1}h12>") == [(0, "host", b"<h12>"), (1, "guest", b"{g1}")]


# --- hostile streams ---

HOSTILE = [
    b"@",
    b"@S",
    b"@SD",
    b"@SD" + b"\0" * 82 + b"$",
    b"@S@ACK_Z",
    b"@@ACK_ZAY",
    b"@ACK_ZA",
    b"@AW\x01\x00\x01\x00",
    b"@VS1,",
    b"#\x02\x80\x0c\x01" + b"." * 40,
    b"@SD@ACK_ZAY$",
    b"@2",
]


@pytest.mark.parametrize("name", [row.name for row in links()])
def test_random_and_hostile_bytes_are_faults_and_nothing_else(name: str) -> None:
    rng = random.Random(name)
    row = link(name)
    leads = [t.lead for t in row.frames(Tolerances())]
    noise = b"".join(rng.choice(leads) + rng.randbytes(rng.randrange(30)) for _ in range(1500))
    for data in (rng.randbytes(20_000), noise, *(h * (20_000 // len(h)) for h in HOSTILE)):
        framer = row.framer()
        used = sum(
            item.length if isinstance(item, FrameFault) else len(item.raw)
            for i in range(0, len(data), 997)
            for item in framer.receive(data[i : i + 997], 0.0)
        )
        used += sum(
            item.length if isinstance(item, FrameFault) else len(item.raw)
            for item in framer.flush(1e9)
        )
        assert used == len(data)
        assert len(framer.buffer) == 0


@pytest.mark.proof
@pytest.mark.parametrize("name", [row.name for row in links()])
def test_a_million_hostile_bytes_cost_no_more_than_one_look_at_each(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Looks are counted, not seconds: a busy machine changes nothing."""
    rng = random.Random(7)
    leads = [t.lead for t in link(name).frames(Tolerances())]
    parts = [rng.choice(leads) + rng.randbytes(rng.randrange(12)) for _ in range(60_000)]
    data = b"".join((*parts, b"@SD" * 50_000, rng.randbytes(1_000_000)))[:1_000_000]
    looks = 0
    candidate = Framer.candidate

    def counted(self: Framer, data: bytes, at: int, end: int, final: bool) -> Any:
        nonlocal looks
        looks += 1
        return candidate(self, data, at, end, final)

    monkeypatch.setattr(Framer, "candidate", counted)
    framer = link(name).framer()
    chunks = [data[i : i + 4096] for i in range(0, len(data), 4096)]
    for chunk in chunks:
        framer.receive(chunk, 0.0)
        assert len(framer.buffer) < 3300
    framer.flush(1e9)
    assert looks <= len(data) + len(chunks)


# --- no sender holds a receiver (G3) ---


def test_a_byte_now_and_then_holds_a_frame_back_for_a_second_and_no_longer() -> None:
    """A false @SD, and noise that never lets the line be idle."""
    framer = link("auv.from_stm32").framer()
    items, heard_at = framer.receive(b"@SD", 0.0), None
    sent = b"@ACK_ZAY$"
    for i in range(1, 200):
        now = i * 0.04
        due = framer.next_timer()
        if due is not None and due <= now:
            items += framer.flush(due)
            heard_at = heard_at or (due if any(isinstance(x, Frame) for x in items) else None)
        items += framer.receive(sent[i - 1 : i] or b"\xff", now)
    assert [shown(i) for i in items if isinstance(i, Frame)] == [(3, "auv.ACK", sent)]
    assert heard_at == pytest.approx(1.0)


def test_what_is_given_up_takes_nothing_along_that_began_later() -> None:
    framer = link("auv.from_stm32").framer()
    assert framer.receive(b"@SD\xff", 0.0) == []
    for i in range(1, 25):
        assert framer.receive(b"\xff", i * 0.04) == []
    assert framer.receive(SD[:40], 0.98) == []
    assert framer.next_timer() == 1.0
    assert framer.flush(1.0) == []
    assert framer.next_timer() == pytest.approx(1.03)
    found = framer.receive(SD[40:], 1.02)
    assert [shown(item) for item in found] == [(0, "truncated", 28), (28, "auv.SD", SD)]


def test_bytes_that_come_before_the_timer_complete_a_frame_however_late() -> None:
    """A program that stood still reads the rest of a frame first, and looks at its timers then."""
    framer = link("auv.from_stm32").framer()
    framer.receive(SD[:40], 0.0)
    (found,) = framer.receive(SD[40:], 8.0)
    assert isinstance(found, Frame)


@pytest.mark.proof
@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.binary(max_size=6), st.floats(0.0, 0.9)), max_size=60))
def test_the_timer_always_moves_on(chunks: list[tuple[bytes, float]]) -> None:
    framer, now = link("auv.any").framer(), 0.0
    for data, pause in chunks:
        end = now + pause
        for _ in range(200):
            due = framer.next_timer()
            if due is None or due > end:
                break
            framer.flush(due)
        else:
            raise AssertionError("the timer never moves on")
        now = end
        framer.receive(b"@S" + data, now)
