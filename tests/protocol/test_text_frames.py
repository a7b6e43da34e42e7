"""Strict grammar (E-F6, G4): each wrong form has its kind of fault; encoding refuses in words."""

from __future__ import annotations

from typing import Any

import pytest
from canonical_auv import AUV, VS

from protocol.codec import CannotEncode
from protocol.framing import Frame
from protocol.messages import FrameFault
from protocol.motion_frame import AS_BUILT, parse_z
from protocol.text import Refused, format_decimal, text_length
from protocol.tolerances import Tolerances, UnknownTolerance
from protocol.vehicles import frame_types, link

LONG = b"@MT1," + b"1" * 70


@pytest.mark.parametrize(
    ("raw", "kind"),
    [
        (b"@NX$", "bad_header"),
        (b"@NIx$", "bad_length"),
        (b"@NSCOOCC$", "bad_length"),
        (b"@NSCOOCCCC$", "bad_length"),
        (b"@NSCOOCCx$", "bad_enum"),
        (b"@NS$", "empty_field"),
        (b"@AC\x01$", "bad_char"),
        (b"@AA\x80$", "bad_char"),
        (b"@ACK_ZFY$", "bad_enum"),
        (b"@ACK_NSS!", "bad_tail"),
        (b"@ACK_XXX$", "bad_enum"),
        (b"@ACK_RSN$", "bad_enum"),
        (b"@ACK_NSX$", "bad_enum"),
        (LONG, "bad_length"),
        (b"@MT6,1$", "out_of_range"),
        (b"@MT1,13$", "out_of_range"),
        (b"@MT1,123456$", "out_of_range"),
        (b"@MT1,+1$", "non_numeric"),
        (b"@MT1, 1$", "non_numeric"),
        (b"@MT1,1.5$", "non_numeric"),
        (b"@MT1,$", "empty_field"),
        (b"@MT1$", "field_count"),
        (b"@MT1,2,3$", "field_count"),
        (b"@MMX1$", "bad_enum"),
        (b"@MMF$", "empty_field"),
        (b"@MMF1,2$", "field_count"),
        (b"@MMF13$", "out_of_range"),
        (b"@MRL6$", "out_of_range"),
        (b"@MDS1,23$", "out_of_range"),
        (b"@MDA4,1$", "bad_enum"),
        (b"@MDA12,1$", "bad_length"),
        (b"@MDA1,38$", "out_of_range"),
        (b"@DS1,-16$", "out_of_range"),
        (b"@DX1,1$", "bad_enum"),
        (b"@MS0,1$", "out_of_range"),
        (b"@MP1,181$", "out_of_range"),
        (b"@ZA$", "empty_field"),
        (b"@ZAQ1$", "bad_enum"),
        (b"@ZAX1$", "bad_enum"),
        (b"@ZAW0$", "bad_enum"),
        (b"@ZAF13$", "out_of_range"),
        (b"@ZAF-1$", "out_of_range"),
        (b"@ZAH-20,4$", "field_count"),
        (b"@ZAH181$", "out_of_range"),
        (b"@ZAA1,2$", "field_count"),
        (b"@ZAS1.5$", "non_numeric"),
        (b"@ST,2025/13/11 16:56:06,$", "out_of_range"),
        (b"@ST,2025/01/11 16:56:60,$", "out_of_range"),
        (b"@ST,2025/01/11 24:00:00,$", "out_of_range"),
        (b"@ST,2025-01-11 16:56:06,$", "non_numeric"),
        (b"@ST,20250111165606,$", "non_numeric"),
        (b"@ST,,$", "empty_field"),
        (b"@ST,x$", "field_count"),
        (b"@ST,2025,1,11,16,56,x,$", "non_numeric"),
        (b"@SP,1,2,3,$", "field_count"),
        (b"@SP1,2,3,4,$", "field_count"),
        (b"@AW\x01\x00\x01\x00$", "empty_field"),
        (b"@AW\x01\x00\x02\x00x$", "out_of_range"),
        (b"@AW\x01\x00\x00\x00x$", "out_of_range"),
        (b"@AW\x10\x27\x01\x00x$", "out_of_range"),
        (b"@AW0208x$", "out_of_range"),
        (b"@AW\x01\x00\x01\x00x\x07$", "bad_char"),
        (b"@AW\x01\x00\x01\x00@ZAF5$$", "bad_char"),
        (b"@AW\x01\x00\x01\x00" + b"x" * 201 + b"$", "bad_length"),
        (VS.replace(b"VS", b""), "bad_header"),
        (VS.replace(b"@VS", b"@VS,"), "field_count"),
        (VS.replace(b"36,360", b"36"), "field_count"),
        (VS.replace(b"36,360", b"36,36O"), "non_numeric"),
        (VS.replace(b"2025-01-19-", b"2025-01-19T"), "non_numeric"),
        (b"@AR,odd,1,1,,,,$", "bad_enum"),
        (b"@AR,ready,1,2,,,,$", "out_of_range"),
        (b"@AR,ready,2,1,x,,,$", "non_numeric"),
        (b"@AR,ready,2,1,,,$", "field_count"),
        (b"@AR,ready,2,1,,," + b"x" * 201 + b",$", "bad_length"),
        (b"@D", "truncated"),
        (b"@MMF1", "truncated"),
        (b"@AW\x01\x00", "truncated"),
    ],
)
def test_a_wrong_frame_is_one_fault_of_its_kind(raw: bytes, kind: str) -> None:
    by_link = b"@ACK_Z" in raw and "auv.to_topside"
    framer = link(by_link or "auv.any").framer()
    items = framer.receive(raw, 0.0) + framer.flush(1e9)
    assert items[0] == FrameFault(
        0, kind, items[0].length if isinstance(items[0], FrameFault) else 0
    )
    assert not any(isinstance(i, Frame) and i.raw == raw for i in items)


def test_the_pi_takes_no_motion_from_topside_but_the_two_emergencies() -> None:
    framer = link("auv.to_pi").framer()
    items = framer.receive(b"@ZAX0$@ZAF5$@ZAWF$", 0.0)
    assert [i.kind if isinstance(i, FrameFault) else i.raw for i in items] == [
        b"@ZAX0$",
        "bad_enum",
        b"@ZAWF$",
    ]


def decoded(raw: bytes, **options: str) -> dict[str, Any] | str:
    framer = link("auv.any").framer(Tolerances.parse(options))
    items = framer.receive(raw, 0.0) + framer.flush(1e9)
    first = items[0]
    return first.kind if isinstance(first, FrameFault) else first.values()


LINE = b"@AW\x00\x02\x00\x01x$"


@pytest.mark.parametrize(
    ("raw", "options", "without", "expected"),
    [
        (LINE, {"order_aw": "big"}, 512, {"total": 2, "current": 1}),
        (b"@AW\x02\x00\x01\x00@ZAF5$$", {"aw_nested": "on"}, "bad_char", {"payload": "ZAF5"}),
        (b"@AW\x02\x00\x00\x00x$", {"aw_zero_based": "on"}, "out_of_range", {"current": 1}),
        (b"@AW0802x$", {"aw_decimal": "off"}, 8, "out_of_range"),
        (b"@ST,20250111165606,$", {"st_compact": "on"}, "non_numeric", {"time": "2025-01-11T16:56:06"}),
        (b"@ST,2025,1,11,16,56,6,$", {"st_commas": "off"}, "2025-01-11T16:56:06", "field_count"),
        (b"@MS0,5$", {"ms_zero": "on"}, "out_of_range", {"speed": 0}),
        (b"@MP0,5$", {"ms_zero": "on"}, "out_of_range", {"force": 0}),
        (b"@ZAA1,2$", {"zaa_comma": "on"}, "field_count", {"pitch_deg": 1, "roll_deg": 2}),
        (b"@ZAH-20,4$", {"zah_gear": "on"}, "field_count", {"heading_deg": -20, "gear": 4}),
        (b"@ZAH-20$", {"zah_gear": "on"}, -20, {"heading_deg": -20}),
        (b"@ACK_RSY$", {"rs_yn": "on"}, "bad_enum", {"ok": True}),
        (b"@ACK_RSN$", {"rs_yn": "on"}, "bad_enum", {"ok": False}),
        (VS.replace(b"VS", b""), {"vs_no_vs": "on"}, "bad_header", {"battery_power": 360}),
        (VS.replace(b"@VS", b"@VS,"), {"vs_sep": "on"}, "field_count", {"battery_power": 360}),
        (VS.replace(b"0,0,0,36", b"0,0,36"), {"vs_29": "on"}, "field_count", {"depth_m": None, "battery_control": 36}),
        (VS.replace(b"20,100", b"20,"), {"vs_empty": "off"}, None, "empty_field"),
    ],
)  # fmt: skip
def test_a_tolerance_accepts_what_is_refused_without_it_and_back(
    raw: bytes, options: dict[str, str], without: object, expected: dict[str, Any] | str
) -> None:
    plain, tolerant = decoded(raw), decoded(raw, **options)
    if isinstance(plain, dict):
        assert without in plain.values()
    else:
        assert plain == without
    if isinstance(expected, dict):
        assert isinstance(tolerant, dict)
        assert {key: tolerant[key] for key in expected} == expected
    else:
        assert tolerant == expected


@pytest.mark.proof
def test_a_tolerance_refuses_nothing_that_is_right_without_it() -> None:
    """Those that accept more; the others say which of two readings holds."""
    more = (
        "aw_nested",
        "aw_decimal",
        "st_compact",
        "st_commas",
        "ms_zero",
        "zaa_comma",
        "zah_gear",
    )
    more += ("rs_yn", "vs_no_vs", "vs_sep", "vs_29", "vs_empty")
    right = [raw for _, _, raw in AUV] + [b"@ZAA5;-10$", b"@ZAH90$", b"@ST,2025,1,11,16,56,6,$"]
    for raw in right:
        for name in more:
            assert decoded(raw, **{name: "on"}) == decoded(raw), (raw, name)
        assert decoded(raw, **dict.fromkeys(more, "on")) == decoded(raw)


def test_as_built_pitch_and_roll_are_sent_with_a_comma() -> None:
    values = {"code": "A", "pitch_deg": 5, "roll_deg": -10}
    assert frame_types(AS_BUILT)["auv.ZA"].encode(values) == b"@ZAA5,-10$"
    assert frame_types()["auv.ZA"].encode(values) == b"@ZAA5;-10$"


def test_the_documents_own_status_example_is_read_with_its_three_tolerances() -> None:
    raw = VS.replace(b"@VS", b"@").replace(b",100,0,0,0,0,0,0,0,", b",100,0,0,0,0,0,0,")
    values = decoded(raw, vs_no_vs="on", vs_29="on")
    assert isinstance(values, dict)
    unknown = [flag for flag in values["flags"] if flag.endswith(":unknown")]
    assert len(unknown) == 7
    assert (values["ground_speed"], values["battery_control"]) == (100, 36)


def test_a_status_out_of_range_is_kept_and_named() -> None:
    values = decoded(VS.replace(b"120.1535765", b"190.0").replace(b"01-19", b"13-19"))
    assert isinstance(values, dict)
    assert values["lon_deg"] == 190.0
    assert values["flags"] == ["time:out_of_range", "lon_deg:out_of_range"]


def test_a_nested_line_is_waited_for_and_must_end_twice() -> None:
    row, options = link("auv.to_pi"), Tolerances.parse({"aw_nested": "on"})
    framer = row.framer(options)
    head = b"@AW\x01\x00\x01\x00@ZAF5$"
    assert framer.receive(head[:9], 0.0) == framer.receive(head[9:], 0.0) == []
    assert len(framer.receive(b"$", 0.0)) == 1
    framer = row.framer(options)
    (fault, *_) = framer.receive(head + b"x", 0.0) + framer.flush(1e9)
    assert fault == FrameFault(0, "bad_tail", 14)
    nested = frame_types(options)["auv.AW"]
    assert nested.encode({"total": 1, "current": 1, "payload": "ZAF5"}) == head + b"$"


@pytest.mark.parametrize(
    ("name", "value"), [("nothing", "on"), ("st_compact", "maybe"), ("can_id", "x")]
)
def test_an_unknown_tolerance_is_named_with_what_there_is(name: str, value: str) -> None:
    with pytest.raises(UnknownTolerance, match=name):
        Tolerances.parse({name: value})


def test_tolerances_take_the_words_of_yaml() -> None:
    chosen = Tolerances.parse({"aw_decimal": "False", "order_aw": "BE", "can_id": "0x12"})
    assert (chosen["aw_decimal"], chosen["order_aw"], chosen["can_id"]) == ("off", "high", "0x12")
    assert Tolerances()["can_id"] == ""


def test_a_text_frame_has_at_most_its_limit_and_is_not_waited_for_beyond_it() -> None:
    text = b"@" + b"x" * 62
    assert text_length(text, 0, 1, 63, 64) == 0
    assert text_length(text + b"$", 0, 1, 64, 64) == 64
    assert text_length(text + b"x", 0, 1, 64, 64) == "bad_length"


# --- encoding ---


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("auv.NS", {}, "switches is missing"),
        ("auv.NS", {"switches": "OO"}, "6 letters"),
        ("auv.NS", {"switches": "OOOOOX"}, "'X' is none of OC"),
        ("auv.MT", {"thruster": 6, "gear": 1}, "outside 1..5"),
        ("auv.MT", {"thruster": 1, "gear": 1.5}, "an integer is needed"),
        ("auv.MT", {"thruster": True, "gear": 1}, "an integer is needed"),
        ("auv.MT", {"thruster": float("nan"), "gear": 1}, "an integer is needed"),
        ("auv.MD", {"mode": "S", "servo": 1, "angle": -16}, "out_of_range"),
        ("auv.MD", {"mode": "S", "servo": 4, "angle": 1}, "none of 123"),
        ("auv.ZA", {"code": "Q"}, "code is one of"),
        ("auv.ZA", {"code": 7}, "code is one of"),
        ("auv.ZA", {"code": "F", "gear": -1}, "outside 0..12"),
        ("auv.ST", {"time": "2025-02-30T00:00:00"}, "real day"),
        ("auv.ST", {"time": 5}, "real day"),
        ("auv.SP", {"radius_m": 0}, "0 excluded"),
        ("auv.SP", {"radius_m": "1"}, "a number is needed"),
        ("auv.AW", {"total": 1, "current": 2, "payload": "x"}, "1 <= current"),
        ("auv.AW", {"total": "1", "current": 1, "payload": "x"}, "1 <= current"),
        ("auv.AW", {"total": 1, "current": 1, "payload": "a$"}, "printable ASCII"),
        ("auv.AW", {"total": 1, "current": 1, "payload": "x" * 201}, "printable ASCII"),
        ("auv.ACK", {"class": "Q", "func": "Q", "ok": True}, "one of"),
        ("auv.ACK", {"class": "R", "func": "S", "ok": False}, "no negative"),
        ("auv.ACK", {"class": "N", "func": "I", "mask": 256}, "a byte"),
        ("auv.AR", {"state": "a,b", "total": 0, "have": 0, "missing": "", "digest": "", "refusal": ""}, "without ,"),
        ("auv.AR", {"state": "odd", "total": 0, "have": 0, "missing": "", "digest": "", "refusal": ""}, "bad_enum"),
        ("auv.VS", {"time": None}, "lon_deg is missing"),
        ("auv.SD", {}, "roll_deg is missing"),
        ("auv.MODEM", {"address": 1, "content": "zz"}, "hexadecimal"),
        ("auv.MODEM", {"address": 1}, "content is missing"),
        ("auv.MODEM", {"address": 3, "content": "00"}, "address is 1 or 2"),
        ("auv.MODEM", {"address": 1, "content": ""}, "1..3200"),
        ("auv.MODEM", {"address": 1, "content": "00", "length": 2}, "length says 2"),
    ],
)  # fmt: skip
def test_encoding_says_what_is_wrong(name: str, values: dict[str, Any], message: str) -> None:
    with pytest.raises(CannotEncode, match=message):
        frame_types()[name].encode(values)


def test_a_status_out_of_range_is_not_sent() -> None:
    frame = frame_types()["auv.VS"]
    with pytest.raises(CannotEncode, match="lat_deg"):
        frame.encode(frame.decode(VS) | {"lat_deg": 91})


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.1, "0.1"), (-0.0, "0"), (1e-7, "0.0000001"), (1e-20, "0"), (3, "3"), (2.0, "2"), (1 / 3, "0.333333333333")],
)  # fmt: skip
def test_decimals_are_short_and_without_exponent(value: float, text: str) -> None:
    assert format_decimal("x", value) == text


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e9, True, "1"])
def test_what_is_no_decimal_is_refused(value: object) -> None:
    with pytest.raises(CannotEncode):
        format_decimal("x", value)


def test_a_motion_command_is_read_alone() -> None:
    assert parse_z(b"@ZAH-20,4$", AS_BUILT) == {
        "code": "H",
        "heading_deg": -20,
        "gear": 4,
        "flags": [],
    }
    for raw, kind in (
        (b"@ZBF5$", "bad_header"),
        (b"@ZAF5", "bad_tail"),
        (b"@ZAF99$", "out_of_range"),
    ):
        with pytest.raises(Refused) as refusal:
            parse_z(raw)
        assert refusal.value.kind == kind


def test_the_gear_behind_a_heading_is_sent_as_built_only() -> None:
    values = {"code": "H", "heading_deg": -20, "gear": 4}
    assert frame_types(AS_BUILT)["auv.ZA"].encode(values) == b"@ZAH-20,4$"
    assert frame_types()["auv.ZA"].encode(values) == b"@ZAH-20$"
