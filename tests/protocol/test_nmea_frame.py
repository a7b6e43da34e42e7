"""A receiver's sentences as frames, beside the fixes that the runtime makes of them."""

from __future__ import annotations

import json
import math
from datetime import UTC, datetime
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from mission.commands.decode import decode
from protocol.codec import CannotEncode
from protocol.framing import Frame
from protocol.messages import Fix, FrameFault
from protocol.nmea import NmeaDecoder, encode_gga, encode_rmc
from protocol.nmea_frame import NmeaFrame
from protocol.vehicles import link

WHEN = datetime(2026, 3, 1, 4, 5, 6, tzinfo=UTC)
GGA = encode_gga(WHEN, 0.5, 2.0, hdop=1.2, elevation=7.5, talker="GN")
RMC = encode_rmc(WHEN, 0.5, 2.0, speed=1.5, course=1.0, talker="GN")
OTHER = b"$GPGSV,1,1,00*79\r\n"


def frames(data: bytes, size: int = 0) -> list[Frame | FrameFault]:
    framer = link("gps.nmea").framer()
    pieces = [data[i : i + size] for i in range(0, len(data), size)] if size else [data]
    found = [item for piece in pieces for item in framer.receive(piece, 0.0)]
    return found + framer.flush(1.0)


def values(data: bytes) -> dict[str, object]:
    (item,) = frames(data)
    assert isinstance(item, Frame), item
    return item.values()


def test_a_gga_and_an_rmc_say_what_the_fix_of_both_says() -> None:
    (fix,) = [f for f in NmeaDecoder().receive(GGA + RMC, 0.0) if isinstance(f, Fix)]
    gga, rmc = values(GGA), values(RMC)
    for told in (gga, rmc):
        assert told["lat_deg"] == math.degrees(fix.latitude)
        assert told["lon_deg"] == math.degrees(fix.longitude)
        assert told["flags"] == []
    assert (gga["sentence"], rmc["sentence"]) == ("GNGGA", "GNRMC")
    assert (gga["hdop"], gga["elevation_m"], gga["satellites"]) == (1.2, 7.5, 9)
    assert rmc["speed_m_s"] == fix.speed
    assert rmc["course_deg"] == math.degrees(fix.course or 0.0)
    assert rmc["utc"] == "2026-03-01T04:05:06"


def test_a_sentence_without_a_fix_is_kept_and_says_so() -> None:
    for raw in (encode_gga(WHEN, None, None), encode_rmc(WHEN, None, None)):
        told = values(raw)
        assert (told["lat_deg"], told["flags"]) == (None, ["no_fix"])


def test_any_other_sentence_is_shown_as_it_is() -> None:
    assert values(OTHER) == {"sentence": "GPGSV", "fields": "1,1,00"}


@pytest.mark.parametrize(
    ("raw", "kind"),
    [
        (GGA.replace(b"*", b"0*"), "bad_checksum"),
        (b"$GPGSV,1,1,00\r\n", "bad_checksum"),
        (b"$GPGSV,1,\xff,00*79\r\n", "bad_char"),
        (b"$" + b"x" * 200 + b"*00\r\n", "bad_length"),
        (b"$GPGGA,1,2*55\r\n", "field_count"),
        (b"$GPGSV,1,1", "truncated"),
        (b"\xfe\xef\x00", "bad_header"),
        (b"$GPGSV,1,1$", "truncated"),
        (b"$GPGSV,1,1*0g\r\n", "bad_checksum"),
    ],
)
def test_what_is_no_sentence_is_one_fault_of_its_kind(raw: bytes, kind: str) -> None:
    found = frames(raw)
    assert isinstance(found[0], FrameFault)
    assert found[0].kind == kind


@pytest.mark.proof
@given(st.lists(st.sampled_from([GGA, RMC, OTHER]), min_size=1), st.integers(1, 200))
def test_every_sentence_is_found_whatever_the_pieces_it_comes_in(
    sentences: list[bytes], size: int
) -> None:
    found = frames(b"".join(sentences), size)
    assert [item.raw for item in found if isinstance(item, Frame)] == sentences
    assert len(found) == len(sentences)


@given(st.binary(max_size=300), st.integers(1, 40))
def test_noise_raises_nothing_and_every_byte_is_in_a_frame_or_a_fault(
    noise: bytes, size: int
) -> None:
    data = noise.replace(b"$", b"") + GGA + noise
    found = frames(data, size)
    whole = frames(data)
    assert [i.offset for i in found] == [i.offset for i in whole]
    lengths = [len(i.raw) if isinstance(i, Frame) else i.length for i in found]
    assert sum(lengths) == len(data)


def test_sentences_are_only_read() -> None:
    with pytest.raises(CannotEncode, match="only read"):
        NmeaFrame().encode({})


def test_decode_shows_a_receivers_sentences(tmp_path: Path) -> None:
    capture = tmp_path / "gps.bin"
    capture.write_bytes(GGA + b"junk" + RMC)
    ran = CliRunner().invoke(decode, ["--link", "gps.nmea", "--json", str(capture)])
    rows = [json.loads(line) for line in ran.stdout.splitlines()]
    assert [row.get("type", row.get("fault")) for row in rows] == [
        "gps.NMEA", "bad_header", "gps.NMEA"
    ]  # fmt: skip
    shown = CliRunner().invoke(decode, ["--link", "gps.nmea", str(capture)]).stdout
    assert "lat_deg" in shown
    assert "2 frames; faults: 1 bad_header; 4 bytes skipped" in shown
