"""Laws of the lines of sensors that were added: VHW, VBW, GLL, GGA, MPR, PD6 and PD0."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.added import LONGEST, AddedDecoder
from protocol.messages import Aid, FrameFault

KNOT = 1852.0 / 3600.0


def nmea(body: str) -> bytes:
    total = 0
    for byte in body.encode():
        total ^= byte
    return f"${body}*{total:02X}\r\n".encode()


def ensemble(
    ground: tuple[int, int] = (120, -1010),
    water: tuple[int, int] = (12, -980),
    axes: int = 0b10,
    more: int = 0,
) -> bytes:
    """A whole one with ``more`` bytes of a profile; to starboard and ahead as PD0 says, mm/s."""
    leader, bottom = bytearray(59), bytearray(81)
    leader[25] = axes << 3 | 0b111
    bottom[0:2] = struct.pack("<H", 0x0600)
    bottom[24:32] = struct.pack("<4h", *ground, 0, 0)
    bottom[50:58] = struct.pack("<4h", *water, 0, 0)
    variable = struct.pack("<H", 0x0080) + bytes(63 + more)
    parts = (bytes(leader), variable, bytes(bottom))
    at, offsets = 12, list[int]()
    for part in parts:
        offsets.append(at)
        at += len(part)
    body = struct.pack("<2sHBB3H", b"\x7f\x7f", at + 2, 0, 3, *offsets) + b"".join(parts) + b"\0\0"
    return body + struct.pack("<H", sum(body) & 0xFFFF)


def heard(*data: bytes, now: float = 7.0) -> list[Aid | FrameFault]:
    decoder, out = AddedDecoder(), []
    for n, piece in enumerate(data):
        out += decoder.receive(piece, now + n / 1000)
    return out


LINES = {
    nmea("VDVHW,012.0,T,,M,2.00,N,3.70,K"): [("water", (2.0 * KNOT,))],
    nmea("VDVBW,2.00,-0.10,A,1.50,0.20,A"): [
        ("water", (2.0 * KNOT,)),
        ("ground", (1.5 * KNOT, 0.2 * KNOT)),
    ],
    nmea("VDVBW,,,V,1.50,0.20,A,,V,,V"): [("ground", (1.5 * KNOT, 0.2 * KNOT))],
    nmea("INGLL,3018.000000,N,12006.000000,W,081500.00,A"): [
        ("place", (math.radians(30.3), math.radians(-120.1)))
    ],
    nmea("GPGGA,081500.00,3018.000,S,12006.000,E,1,09,1.0,0.0,M,0.0,M,,"): [
        ("place", (math.radians(-30.3), math.radians(120.1)))
    ],
    b":BS,-00120,+01010,+00003,A\r\n": [("ground", (1.01, -0.12))],
    b":WS,   -12,   980,     3,A\r\n": [("water", (0.98,))],
    nmea("CAMPR,3,1,0.2500"): [("range", (3.0, 0.25))],
    nmea("CAMPR,3,1,0.2500,2,1"): [("range", (3.0, 0.25))],
    ensemble(): [("ground", (1.01, -0.12)), ("water", (0.98,))],
    ensemble(water=(-32768, -32768)): [("ground", (1.01, -0.12))],
}
SILENT = (
    nmea("VDVHW,012.0,T,,M,,N,,K"),
    nmea("VDVBW,2.00,-0.10,V,1.50,0.20,V"),
    nmea("INGLL,,,,,081500.00,V"),
    nmea("GPGGA,081500.00,,,,,0,00,,,M,0.0,M,,"),
    nmea("SDDBT,10.0,f,3.0,M,1.6,F"),
    b":BS,-32768,-32768,-32768,V\r\n",
    nmea("HEROT,-90.0,A"),
    nmea("CAMPR,3,1,"),
    ensemble((-32768, -32768), (-32768, -32768)),
    b":TS,25060108000000,35.0,+18.0,0010.0,1500.0,000\r\n",
    b":BI,+00012,+00980,+00003,+00001,A\r\n",
    b"\r\n",
)
FAULTY = (
    b"$VDVHW,012.0,T,,M,2.00,N,3.70,K*00\r\n",
    b"$VDVHW,012.0,T,,M,2.00,N,3.70,K\r\n",
    nmea("VDVHW,012.0,T,,M,fast,N,3.70,K"),
    nmea("VDVBW,2.00,-0.10,X,1.50,0.20,A"),
    nmea("VDVBW,99.0,-0.10,A,1.50,0.20,A"),
    nmea("INGLL,9918.0,N,12006.0,W,081500.00,A"),
    b":BS,-00120,+01010,A\r\n",
    b":BS,-00120,+0x010,+00003,A\r\n",
    b"hello\r\n",
    nmea("CAMPR,3,1,-0.2500"),
    nmea("CAMPR,3,1,25.000"),
    ensemble(axes=0b11),
    b"\x7f\x7fno ensemble\r\n",
    bytes(range(128, 160)) + b"\n",
)


@pytest.mark.parametrize("line", LINES)
def test_a_line_says_what_its_standard_means(line: bytes) -> None:
    found = heard(line)
    assert [(one.kind, one.t) for one in found] == [(kind, 7.0) for kind, _ in LINES[line]]
    for one, (_, values) in zip(found, LINES[line], strict=True):
        assert isinstance(one, Aid)
        assert one.values == pytest.approx(values, abs=1e-9)


@pytest.mark.parametrize("line", SILENT)
def test_what_a_sensor_calls_invalid_and_other_sentences_say_nothing(line: bytes) -> None:
    assert heard(line) == []


@pytest.mark.parametrize("line", FAULTY)
def test_what_is_no_line_is_a_fault_and_the_next_line_is_heard(line: bytes) -> None:
    good = next(iter(LINES))
    fault, aid = heard(line + good)
    assert (type(fault), type(aid)) == (FrameFault, Aid)


@given(st.lists(st.sampled_from([*LINES, *SILENT, *FAULTY]), max_size=6), st.data())
def test_how_the_bytes_were_cut_changes_nothing(lines: list[bytes], data: st.DataObject) -> None:
    whole = b"".join(lines)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(whole)), max_size=5)))
    pieces = [whole[a:b] for a, b in zip([0, *cuts], [*cuts, len(whole)], strict=True)]

    def told(found: list[Aid | FrameFault]) -> list[object]:
        return [(f.kind, f.values) if isinstance(f, Aid) else type(f) for f in found]

    assert told(heard(*pieces)) == told(heard(whole))


def test_a_line_bears_the_time_of_its_first_byte() -> None:
    line = next(iter(LINES))
    (aid,) = heard(line[:5], line[5:12], line[12:])
    assert isinstance(aid, Aid)
    assert aid.t == 7.0


@given(st.binary(max_size=4 * LONGEST))
def test_no_bytes_raise_and_what_never_ends_is_given_up(noise: bytes) -> None:
    decoder = AddedDecoder()
    decoder.receive(noise.replace(b"\n", b"x").replace(b"\r", b"x") + b"x" * LONGEST * 2, 0.0)
    assert [type(one) for one in decoder.receive(b"\n" + next(iter(LINES)), 1.0)] == [Aid]


def test_a_line_that_broke_off_lends_its_time_to_none_that_comes_later() -> None:
    decoder = AddedDecoder()
    assert decoder.receive(b"$VDVHW,,T,,M,2.", 7.0) == []
    cut, aid = decoder.receive(nmea("VDVHW,,T,,M,2.00,N,,K"), 500.0)
    assert cut == FrameFault(0, "truncated", 15)
    assert aid == Aid(500.0, "water", (2.0 * KNOT,))


def test_an_ensemble_bears_the_time_of_its_first_byte_wherever_it_was_cut() -> None:
    whole = ensemble()
    for cut in (1, 2, 7, 100, len(whole) - 1):
        found = heard(whole[:cut], whole[cut:])
        assert [(one.kind, one.t) for one in found] == [("ground", 7.0), ("water", 7.0)]


@pytest.mark.parametrize("at", [8, 60, 100, 160, 200])
def test_a_flipped_bit_of_an_ensemble_is_a_fault_and_the_next_line_is_heard(at: int) -> None:
    spoilt = bytearray(ensemble())
    spoilt[at] ^= 4
    *faults, aid = heard(bytes(spoilt), b"\r\n" + next(iter(LINES)))
    assert faults
    assert {type(fault) for fault in faults} == {FrameFault}
    assert isinstance(aid, Aid)


def test_an_ensemble_among_lines_takes_nothing_of_them() -> None:
    line = b":BS,-00120,+01010,+00003,A\r\n"
    found = heard(line + ensemble() + line)
    assert [one.kind for one in found] == ["ground", "ground", "water", "ground"]


MARKS = {"nothing else": b"\x7f" * 4096, "more or less": b"\x7f\x7f\x00\x10" * 1000}


@pytest.mark.parametrize("noise", MARKS.values(), ids=MARKS)
def test_marks_in_noise_are_one_fault_and_the_ensemble_behind_them_is_heard(noise: bytes) -> None:
    fault, *aids = heard(noise + ensemble())
    assert type(fault) is FrameFault
    assert [one.kind for one in aids] == ["ground", "water"]


@pytest.mark.parametrize("size", [1, 7, 90, 161])
def test_marks_that_come_in_pieces_are_two_faults_a_line_at_most(size: int) -> None:
    whole = MARKS["nothing else"] + ensemble()
    found = heard(*(whole[n : n + size] for n in range(0, len(whole), size)), now=0.0)
    faults = [one for one in found if isinstance(one, FrameFault)]
    assert len(faults) <= 2 * 4096 // LONGEST
    assert [one.kind for one in found if isinstance(one, Aid)] == ["ground", "water"]


@pytest.mark.parametrize(
    ("baud", "most"), [(9600, 950), (19200, 1900), (38400, 3800), (57600, 4096)]
)
def test_an_ensemble_as_long_as_the_manual_allows_is_heard(baud: int, most: int) -> None:
    whole, pace = ensemble(more=most - len(ensemble())), baud // 200  # bytes in 50 ms
    assert len(whole) == most
    decoder, out = AddedDecoder(), list[Aid | FrameFault]()
    for n in range(0, most, pace):
        out += decoder.receive(whole[n : n + pace], n / pace / 20.0)
    assert [one.kind for one in out] == ["ground", "water"]
