"""Every type's canonical frame is accepted by its link, and comes out of its values again."""

from __future__ import annotations

import pytest
from canonical_auv import AUV

from protocol.framing import Frame
from protocol.vehicles import frame_types, link

IDS = [raw[:8].decode("latin-1") for _, _, raw in AUV]


@pytest.mark.parametrize(("name", "link_name", "raw"), AUV, ids=IDS)
@pytest.mark.parametrize("everywhere", [False, True])
def test_a_canonical_frame_is_one_frame_of_its_type(
    name: str, link_name: str, raw: bytes, everywhere: bool
) -> None:
    framer = link("auv.any" if everywhere else link_name).framer()
    (frame,) = framer.receive(raw, 4.0)
    assert isinstance(frame, Frame)
    assert (frame.type.name, frame.raw, frame.offset, frame.t) == (name, raw, 0, 4.0)
    assert framer.next_timer() is None


@pytest.mark.parametrize(("name", "raw"), [(n, r) for n, _, r in AUV], ids=IDS)
def test_encoding_the_decoded_values_gives_the_same_bytes(name: str, raw: bytes) -> None:
    frame = frame_types()[name]
    assert frame.check(raw) is None
    assert frame.encode(frame.decode(raw)) == raw


@pytest.mark.parametrize(
    ("raw", "values"),
    [
        (b"@NSCOOCCC$", {"switches": "COOCCC"}),
        (b"@RSCOOCCCO$", {"switches": "COOCCCO", "effective": "OOOCOCO"}),
        (b"@AW\x01\x00\x01\x00ZAF5$", {"total": 1, "current": 1, "payload": "ZAF5"}),
        (b"@AW0802ZAF6$", {"total": 8, "current": 2, "payload": "ZAF6"}),
        (b"@AW\x00\x24\x24\x00a b$", {"total": 0x2400, "current": 0x24, "payload": "a b"}),
        (b"@ST,2025/01/11 16:56:06,$", {"time": "2025-01-11T16:56:06"}),
        (b"@ST,2025,1,11,16,56,6,$", {"time": "2025-01-11T16:56:06"}),
        (
            b"@SP,,x,-3,10.5,$",
            {
                "radius_m": None,
                "minutes": None,
                "depth_m": None,
                "low_voltage_v": 10.5,
                "flags": ["radius_m:empty", "minutes:non_numeric", "depth_m:out_of_range"],
            },
        ),
        (b"@MDS3,20$", {"mode": "S", "servo": 3, "angle": 20}),
        (b"@ZAA-5;3$", {"code": "A", "pitch_deg": -5, "roll_deg": 3, "flags": []}),
        (b"@ZAV2$", {"code": "V", "speed_mps": 2, "flags": ["not_implementable"]}),
        (b"@ACK_AWN$", {"class": "A", "func": "W", "ok": False, "flags": []}),
        (b"@ACK_ZAY$", {"class": "Z", "func": "A", "code": "A", "ok": True, "flags": []}),
        (
            b"@ACK_NI$$",
            {"class": "N", "func": "I", "mask": 0x24, "nodes": "CCOCCO", "flags": []},
        ),
        (
            b"@ACK_RI\x90$",
            {
                "class": "R",
                "func": "I",
                "mask": 0x90,
                "sensors": "CCCCOCC",
                "flags": ["mask:out_of_range", "CTD:off"],
            },
        ),
    ],
)
def test_values_are_those_of_the_document(raw: bytes, values: dict[str, object]) -> None:
    (frame,) = link("auv.any").framer().receive(raw, 0.0)
    assert isinstance(frame, Frame)
    assert frame.values() == values
