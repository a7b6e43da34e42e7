"""GPS: a Fix only from a valid, checked, timely sentence; every refusal counted by its reason."""

from __future__ import annotations

import math
from datetime import UTC, date, datetime, timedelta
from functools import reduce
from operator import xor
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from protocol.messages import Fix, FrameFault
from protocol.nmea import (
    IDLE,
    MAX_SENTENCE,
    UERE,
    UNKNOWN_HDOP,
    NmeaDecoder,
    Refusal,
    encode_gga,
    encode_rmc,
)

NOON = datetime(2025, 6, 1, 12, tzinfo=UTC)
LATITUDE, LONGITUDE = math.radians(30.2874595), math.radians(120.1535765)
GGA = "GPGGA,120000.00,3017.24757,N,12009.21459,E,1,09,1.2,4.5,M,0.0,M,,"
RMC = "GPRMC,120000.00,A,3017.24757,N,12009.21459,E,2.0,90.0,010625,,,A"


def sentence(body: str) -> bytes:
    return f"${body}*{reduce(xor, body.encode(), 0):02X}\r\n".encode()


def drained(data: bytes, decoder: NmeaDecoder | None = None) -> list[Fix | FrameFault]:
    decoder = decoder or NmeaDecoder()
    return decoder.receive(data, 1.0) + decoder.flush(1.0 + IDLE)


def fixes(data: bytes, decoder: NmeaDecoder | None = None) -> list[Fix]:
    return [x for x in drained(data, decoder) if isinstance(x, Fix)]


def refused(data: bytes) -> Refusal:
    """The one reason for which this gave nothing."""
    decoder = NmeaDecoder()
    assert fixes(data, decoder) == []
    (reason,) = decoder.counters.refusals
    return reason


def test_gga_and_rmc_of_one_epoch_are_one_fix_with_the_fields_of_both() -> None:
    (fix,) = fixes(sentence(RMC) + sentence(GGA))
    assert fix.t == 1.0
    assert fix.latitude == pytest.approx(LATITUDE, abs=1e-9)
    assert fix.longitude == pytest.approx(LONGITUDE, abs=1e-9)
    assert fix.accuracy == pytest.approx(1.2 * UERE / math.sqrt(2))
    assert fix.speed == pytest.approx(2 * 1852 / 3600)
    assert fix.course == pytest.approx(math.pi / 2)
    assert (fix.hdop, fix.elevation, fix.satellites) == (1.2, 4.5, 9)
    assert fix.utc == "2025-06-01T12:00:00"


def test_either_sentence_alone_is_enough_after_the_idle_time() -> None:
    decoder = NmeaDecoder()
    assert decoder.receive(sentence(GGA), 5.0) == []
    assert decoder.next_timer() == 5.0 + IDLE
    assert decoder.flush(5.0) == []
    (alone,) = decoder.flush(5.0 + IDLE)
    assert isinstance(alone, Fix)
    assert (alone.t, alone.speed, alone.utc) == (5.0, None, None)
    assert decoder.next_timer() is None
    (alone,) = fixes(sentence(RMC))
    assert alone.accuracy == pytest.approx(UNKNOWN_HDOP * UERE / math.sqrt(2))
    assert alone.hdop is None


def test_a_sentence_of_another_time_completes_the_epoch_before() -> None:
    decoder = NmeaDecoder()
    later = sentence(GGA.replace("120000", "120001"))
    (fix,) = decoder.receive(sentence(GGA) + later, 1.0)
    assert isinstance(fix, Fix)


@pytest.mark.parametrize("talker", ["GP", "GN", "GL", "GB", "BD"])
def test_every_satellite_talker_gives_fixes(talker: str) -> None:
    assert len(fixes(sentence(talker + GGA[2:]) + sentence(talker + RMC[2:]))) == 1


def test_other_sentences_and_other_talkers_are_counted_and_give_nothing() -> None:
    decoder = NmeaDecoder()
    out = drained(sentence("GPGSV,1,1,00") + sentence("II" + RMC[2:]), decoder)
    assert out == []
    assert (decoder.counters.sentences, decoder.counters.used) == (2, 0)


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (GGA.replace(",E,1,", ",E,0,"), Refusal.NO_FIX),
        (GGA.replace(",E,1,", ",E,6,"), Refusal.NO_FIX),
        (GGA.replace(",E,1,", ",E,8,"), Refusal.NO_FIX),
        (GGA.replace(",E,1,", ",E,9,"), Refusal.LETTER),
        (GGA.replace(",E,1,", ",E,,"), Refusal.EMPTY),
        ("GPGGA,,,,,,0,,,,M,,M,,", Refusal.NO_FIX),
        (GGA.replace("3017.24757,N", ",N"), Refusal.EMPTY),
        (GGA.replace("3017.24757,N", "3017.24757,"), Refusal.EMPTY),
        (GGA.replace("120000.00", ""), Refusal.EMPTY),
        (GGA.replace("3017.24757", "9900.00000"), Refusal.RANGE),
        (GGA.replace("3017.24757", "9000.00001"), Refusal.RANGE),
        (GGA.replace("3017.24757", "3060.00000"), Refusal.RANGE),
        (GGA.replace("3017.24757", "-3017.2475"), Refusal.RANGE),
        (GGA.replace("12009.21459", "18000.00001"), Refusal.RANGE),
        (GGA.replace("3017.24757", "3O17.24757"), Refusal.NUMBER),
        (GGA.replace("3017.24757,N", "3017.24757,n"), Refusal.LETTER),
        (GGA.replace("3017.24757,N,12009.21459", "0000.0000,N,00000.0000"), Refusal.NULL_POSITION),
        (GGA.replace("120000.00", "250000.00"), Refusal.RANGE),
        (GGA.replace("120000.00", "noon"), Refusal.NUMBER),
        (GGA.replace("1.2", "nan"), Refusal.NUMBER),
        (GGA.replace("1.2", "1_0"), Refusal.NUMBER),
        (GGA.replace("1.2", "-1.2"), Refusal.RANGE),
        (GGA.replace(",09,", ",9.5,"), Refusal.NUMBER),
        (GGA + ",,", Refusal.FIELD_COUNT),
        (RMC.replace(",A,3", ",V,3"), Refusal.NO_FIX),
        (RMC[:-1] + "E", Refusal.NO_FIX),
        (RMC[:-1] + "N", Refusal.NO_FIX),
        (RMC[:-1] + "Z", Refusal.LETTER),
        (RMC.replace(",A,3", ",B,3"), Refusal.LETTER),
        (RMC.replace(",A,3", ",,3"), Refusal.EMPTY),
        (RMC.replace("90.0", "361"), Refusal.RANGE),
        (RMC.replace("010625", "310225"), Refusal.RANGE),
        (RMC.replace("010625", "1625"), Refusal.NUMBER),
        ("GPRMC,120000.00,A", Refusal.FIELD_COUNT),
    ],
)
def test_no_fix_is_invented_from_a_doubtful_sentence(body: str, reason: Refusal) -> None:
    assert refused(sentence(body)) is reason


def test_a_missing_checksum_is_refused() -> None:
    assert refused(f"${GGA}\r\n".encode()) is Refusal.NO_CHECKSUM


@pytest.mark.parametrize("tail", [b"*+7", b"*0x", b"* 7", b"*7"])
def test_a_checksum_must_be_two_hex_digits(tail: bytes) -> None:
    assert refused(b"$" + GGA.encode() + tail + b"\r\n") is Refusal.CHECKSUM


def test_no_changed_byte_passes_the_checksum() -> None:
    good = sentence(GGA)
    for i in range(1, len(good) - 2):
        for flip in (0x01, 0x10, 0x80):
            bad = good[:i] + bytes([good[i] ^ flip]) + good[i + 1 :]
            assert fixes(bad) == [], (i, flip)


def test_lower_case_checksums_and_bare_line_ends_are_read() -> None:
    body, check = sentence(GGA)[:-4], sentence(GGA)[-4:-2]
    for end in (b"\n", b"\r", b"\r\r\n", b""):
        assert len(fixes(body + check.lower() + end)) == 1, end


def test_a_cut_sentence_does_not_take_the_next_one_with_it() -> None:
    decoder = NmeaDecoder()
    out = drained(sentence(GGA)[:40] + sentence(RMC), decoder)
    assert out[0] == FrameFault(0, "truncated", 40)
    assert isinstance(out[1], Fix)
    assert decoder.counters.refusals == {Refusal.CUT: 1}


def test_a_sentence_that_lost_its_line_end_only_still_counts() -> None:
    decoder = NmeaDecoder()
    assert len(fixes(sentence(GGA)[:-2] + sentence(RMC), decoder)) == 1
    assert decoder.counters.refusals == {}


def test_longer_than_the_standard_is_read_and_far_too_long_is_one_fault() -> None:
    digits = GGA.replace("3017.24757", "3017.2475700000000").replace(".21459", ".2145900000000000")
    assert len(sentence(digits)) > 84
    assert len(fixes(sentence(digits))) == 1
    endless = b"$GPTXT," + b"A" * 3 * MAX_SENTENCE
    decoder = NmeaDecoder()
    out = [x for i in range(len(endless)) for x in decoder.receive(endless[i : i + 1], 0.0)]
    out += decoder.receive(sentence(GGA) + sentence(RMC), 0.0)
    assert out[0] == FrameFault(0, "bad_length", len(endless))
    assert isinstance(out[1], Fix)


def test_garbage_is_one_fault_as_long_as_can_be() -> None:
    noise = b"# comment\r\n\xff\x00 $GP\xb5b garbage\r\nmore\r\n"
    out = drained(noise + sentence(GGA))
    assert out[0] == FrameFault(0, "bad_header", len(noise) - 2)
    assert isinstance(out[1], Fix)
    assert drained(b"\r\n\r\n") == []


def test_fix_lost_and_regained() -> None:
    decoder, t = NmeaDecoder(), NOON
    seen = []
    for second in range(9):
        t = NOON + timedelta(seconds=second)
        where = (None, None) if 3 <= second < 6 else (LATITUDE, LONGITUDE)
        data = encode_gga(t, *where) + encode_rmc(t, *where)
        seen.append(len([x for x in decoder.receive(data, float(second)) if isinstance(x, Fix)]))
    assert seen == [1, 1, 1, 0, 0, 0, 1, 1, 1]
    assert decoder.counters.refusals == {Refusal.NO_FIX: 6}


def test_an_epoch_in_which_one_sentence_says_no_fix_gives_none() -> None:
    for pair in ((GGA, RMC.replace(",A,3", ",V,3")), (GGA.replace(",E,1,", ",E,0,"), RMC)):
        for order in (pair, pair[::-1]):
            assert fixes(b"".join(map(sentence, order))) == []


def test_positions_that_disagree_give_no_fix() -> None:
    decoder = NmeaDecoder()
    assert fixes(sentence(GGA) + sentence(RMC.replace("3017.2", "3018.2")), decoder) == []
    assert decoder.counters.refusals == {Refusal.CONTRADICTION: 1}


def test_positions_on_both_sides_of_the_date_line_agree() -> None:
    west = "17959.99999,W"
    east = "17959.99999,E"
    data = sentence(GGA.replace("12009.21459,E", west)) + sentence(
        RMC.replace("12009.21459,E", east)
    )
    assert len(fixes(data)) == 1


def clock(decoder: NmeaDecoder, times: list[str]) -> list[str]:
    """The times whose epochs became fixes."""
    given = []
    for n, hhmmss in enumerate(times):
        body = GGA.replace("120000", hhmmss)
        out = decoder.receive(sentence(body), float(n)) + decoder.flush(n + IDLE)
        given += [hhmmss for x in out if isinstance(x, Fix)]
    return given


def test_midnight_is_no_jump_back() -> None:
    times = ["235958", "235959", "000000", "000001"]
    assert clock(NmeaDecoder(), times) == times


def test_a_time_that_jumps_back_costs_one_epoch_and_late_sentences_move_nothing() -> None:
    decoder = NmeaDecoder()
    assert clock(decoder, ["120005", "120002", "120006"]) == ["120005", "120006"]
    assert clock(decoder, ["110000", "110001", "110002"]) == ["110001", "110002"]
    assert decoder.counters.refusals == {Refusal.TIME_BACK: 2}


def test_a_receiver_whose_time_stands_still_gives_no_more_fixes() -> None:
    decoder = NmeaDecoder()
    assert clock(decoder, ["120000", "120000", "120000"]) == ["120000"]
    assert decoder.counters.refusals == {Refusal.REPEATED: 2}


def test_dates_of_the_last_century_and_after_a_week_rollover() -> None:
    (fix,) = fixes(sentence(RMC.replace("010625", "311299")))
    assert fix.utc == "1999-12-31T12:00:00"
    rolled = date(2025, 6, 1) - timedelta(weeks=1024)
    body = RMC.replace("010625", f"{rolled:%d%m%y}")
    (fix,) = fixes(sentence(body), NmeaDecoder(not_before=date(2025, 1, 1)))
    assert fix.utc == "2025-06-01T12:00:00"
    (fix,) = fixes(sentence(RMC.replace("010625", "")))
    assert fix.utc is None


def test_rtk_is_more_accurate_than_differential_than_autonomous() -> None:
    accuracy = [fixes(sentence(GGA.replace(",E,1,", f",E,{q},")))[0].accuracy for q in (4, 5, 2, 1)]
    assert accuracy == sorted(accuracy)
    assert len(set(accuracy)) == 4


def test_quirks_of_receivers_are_no_refusals() -> None:
    (fix,) = fixes(sentence(GGA.replace("1.2", "0.0")))  # HDOP unknown
    assert fix.hdop is None
    (fix,) = fixes(sentence(GGA.replace(",09,", ",,").replace("4.5", "")))  # not counted
    assert (fix.satellites, fix.elevation) == (None, None)
    assert len(fixes(sentence(GGA + "0000,1.8"))) == 1  # SiRF: one field more
    assert len(fixes(sentence(RMC + ",V"))) == 1  # NMEA 4.1: no navigational status
    assert len(fixes(sentence(RMC[:-2]))) == 1  # before NMEA 2.3: no mode
    (fix,) = fixes(sentence(RMC.replace("2.0,90.0", ",")))  # no course while lying still
    assert (fix.speed, fix.course) == (None, None)
    (fix,) = fixes(sentence(RMC.replace("90.0", "360.0")))
    assert fix.course == 0.0
    assert len(fixes(sentence(GGA.replace("120000.00", "235960")))) == 1  # leap second


angles = st.floats(-math.pi, math.pi)


@given(angles.map(lambda x: x / 2), angles, st.floats(0, 50), st.floats(0, 6.28))
def test_what_is_encoded_is_decoded(
    latitude: float, longitude: float, speed: float, course: float
) -> None:
    assume(max(abs(latitude), abs(longitude)) > 1e-8)  # 0, 0 is what a broken receiver says
    data = encode_gga(NOON, latitude, longitude, hdop=0.8, elevation=3.0)
    data += encode_rmc(NOON, latitude, longitude, speed=speed, course=course)
    (fix,) = fixes(data)
    assert fix.latitude == pytest.approx(latitude, abs=3e-10)
    assert fix.longitude == pytest.approx(longitude, abs=3e-10)
    assert fix.speed == pytest.approx(speed, abs=1e-3)
    assert fix.course is not None
    assert math.remainder(fix.course - course, math.tau) == pytest.approx(0, abs=1e-4)


@settings(max_examples=60)
@given(st.data())
def test_chunking_changes_nothing(data: st.DataObject) -> None:
    pieces = (
        sentence(GGA),
        sentence(RMC),
        sentence(GGA.replace("120000", "120001")),
        b"noise\xff",
        b"\r\n",
        b"$GPGGA,cut",
        b"$" + b"x" * (MAX_SENTENCE + 9),
        b"$",
        b"*",
    )
    stream = b"".join(data.draw(st.lists(st.sampled_from(pieces), max_size=12)))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    whole, parts = NmeaDecoder(), NmeaDecoder()
    expected = whole.receive(stream, 0.0) + whole.flush(IDLE)
    got = []
    for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True):
        got += parts.receive(stream[a:b], 0.0)
    assert got + parts.flush(IDLE) == expected
    assert parts.counters == whole.counters


@settings(max_examples=200)
@given(st.binary(max_size=600))
def test_random_bytes_raise_nothing_and_give_no_fix(noise: bytes) -> None:
    decoder = NmeaDecoder()
    assert [x for x in drained(noise, decoder) if isinstance(x, Fix)] == []
    assert decoder.counters.fixes == 0


# file -> sentences with a right checksum, GGA and RMC among them, fixes, refusals
RECORDED = {
    "beidou-bd.log": (79, 20, 5, {"GARBAGE": 2, "NO_CHECKSUM": 1, "NO_FIX": 10}),
    "neo-m8n.log": (293, 46, 23, {"GARBAGE": 1, "CUT": 1, "NO_CHECKSUM": 1}),
    "quectel-l76k-nmea.log": (2280, 300, 151, {"GARBAGE": 1}),
    "skytraq-dgps.log": (1024, 192, 96, {"GARBAGE": 1}),
    "telit-he910.log": (
        1558,
        448,
        186,
        {"GARBAGE": 1, "NO_FIX": 74, "TIME_BACK": 1, "REPEATED": 1},
    ),
    "usv_rtk_202412051620.txt": (14164, 7082, 3541, {"GARBAGE": 1}),
}


@pytest.mark.parametrize("name", RECORDED)
def test_recorded_receivers(recordings: Path, name: str) -> None:
    decoder = NmeaDecoder()
    out = drained((recordings / "nmea" / name).read_bytes(), decoder)
    counters = decoder.counters
    reasons = {reason.name: n for reason, n in counters.refusals.items()}
    assert (counters.sentences, counters.used, counters.fixes, reasons) == RECORDED[name]
    positions = [(x.latitude, x.longitude) for x in out if isinstance(x, Fix)]
    assert len(positions) == counters.fixes
    home = positions[-1]  # all of them within 5 km of where the recording ended
    assert all(abs(a - home[0]) < 8e-4 and abs(b - home[1]) < 1.2e-3 for a, b in positions)
