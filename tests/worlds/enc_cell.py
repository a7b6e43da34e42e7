"""A small cell of S-57 (ISO/IEC 8211), written by the standards: IHO S-57 3.1, part 3.

One square of sea with a contour, a sounding and a wreck, and a square of land beside it.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable

FT, UT = b"\x1e", b"\x1f"
NODE, JOINT, EDGE, FEATURE = 110, 120, 130, 100
FIELDS = {
    "0001": ("0500;&   ", "ISO 8211 Record Identifier", "", "(b12)"),
    "DSID": ("1600;&   ", "Data set identification",
             "RCNM!RCID!EXPP!INTU!DSNM!EDTN!UPDN!UADT!ISDT!STED!PRSP!PSDN!PRED!PROF!AGEN!COMT",
             "(b11,b14,2b11,3A,2A(8),R(4),b11,2A,b11,b12,A)"),
    "DSSI": ("1600;&   ", "Data set structure information",
             "DSTR!AALL!NALL!NOMR!NOCR!NOGR!NOLR!NOIN!NOCN!NOED!NOFA", "(3b11,8b14)"),
    "DSPM": ("1600;&   ", "Data set parameter",
             "RCNM!RCID!HDAT!VDAT!SDAT!CSCL!DUNI!HUNI!PUNI!COUN!COMF!SOMF!COMT",
             "(b11,b14,3b11,b14,4b11,2b14,A)"),
    "FRID": ("1600;&   ", "Feature record identifier",
             "RCNM!RCID!PRIM!GRUP!OBJL!RVER!RUIN", "(b11,b14,2b11,2b12,b11)"),
    "FOID": ("1600;&   ", "Feature object identifier", "AGEN!FIDN!FIDS", "(b12,b14,b12)"),
    "ATTF": ("2600;&   ", "Feature record attribute", "*ATTL!ATVL", "(b12,A)"),
    "FSPT": ("2600;&   ", "Feature record to spatial record pointer", "*NAME!ORNT!USAG!MASK",
             "(B(40),3b11)"),
    "VRID": ("1600;&   ", "Vector record identifier", "RCNM!RCID!RVER!RUIN", "(b11,b14,b12,b11)"),
    "VRPT": ("2600;&   ", "Vector record pointer", "*NAME!ORNT!USAG!TOPI!MASK", "(B(40),4b11)"),
    "SG2D": ("2600;&   ", "2-D coordinate", "*YCOO!XCOO", "(2b24)"),
    "SG3D": ("2600;&   ", "3-D coordinate", "*YCOO!XCOO!VE3D", "(3b24)"),
}  # fmt: skip
CLASSES = {"COALNE": 30, "DEPARE": 42, "DEPCNT": 43, "LNDARE": 71, "SOUNDG": 129, "WRECKS": 159}
ATTRIBUTES = {"DRVAL1": 87, "DRVAL2": 88, "OBJNAM": 116, "VALDCO": 174, "VALSOU": 179}
COMF, SOMF = 10_000_000, 10
Field = tuple[str, bytes]
Place = tuple[float, float]  # latitude, longitude


def _record(fields: Iterable[Field], leader: bytes) -> bytes:
    """Lengths and positions by five digits."""
    directory, area = b"", b""
    for tag, data in fields:
        directory += tag.encode() + b"%05d%05d" % (len(data) + 1, len(area))
        area += data + FT
    directory += FT
    base = 24 + len(directory)
    head = b"%05d" % (base + len(area)) + leader[:7] + b"%05d" % base + leader[7:] + b"5504"
    return head + directory + area


def _definition() -> bytes:
    said = [("0000", b"0000;&   cell.000" + UT + b"0001DSID")]
    for tag, (control, name, labels, formats) in FIELDS.items():
        said.append((tag, UT.join(t.encode() for t in (control + name, labels, formats))))
    return _record(said, b"3LE1 09 ! ")


def _name(kind: int, number: int) -> bytes:
    return struct.pack("<BI", kind, number)


def _vector(kind: int, number: int, *fields: Field) -> list[Field]:
    return [("VRID", struct.pack("<BIHB", kind, number, 1, 1)), *fields]


def _places(*places: Place) -> Field:
    pairs = (struct.pack("<2i", round(lat * COMF), round(lon * COMF)) for lat, lon in places)
    return "SG2D", b"".join(pairs)


def _edge(number: int, begin: int, end: int, *between: Place) -> list[Field]:
    ends = ((begin, 1), (end, 2))
    pointers = b"".join(_name(JOINT, n) + bytes([255, 255, which, 255]) for n, which in ends)
    return _vector(EDGE, number, ("VRPT", pointers), _places(*between))


def _feature(
    number: int, kind: str, primitive: int, parts: list[tuple[int, int, int]], **said: object
) -> list[Field]:
    """``parts``: kind, number and orientation of each."""
    told = b"".join(
        struct.pack("<H", ATTRIBUTES[name]) + str(value).encode() + UT
        for name, value in said.items()
    )
    usage = 1 if primitive == 3 else 255
    pointers = b"".join(_name(k, n) + bytes([way, usage, 255]) for k, n, way in parts)
    own = struct.pack("<BIBBHHB", FEATURE, number, primitive, 2, CLASSES[kind], 1, 1)
    return [
        ("FRID", own),
        ("FOID", struct.pack("<HIH", 1, number, 1)),
        *([("ATTF", told)] if told else []),
        ("FSPT", pointers),
    ]


def enc_cell(south: float, west: float, *, horizontal: int = 2, units: int = 1) -> bytes:
    """0.01 degrees of sea each way, 5 to 12 m deep; a wreck at 4.2 m, a sounding of 7.3 m, and land
    as wide again to the east of it."""
    north, middle, east = south + 0.01, west + 0.01, west + 0.02
    at = (south + 0.005, west + 0.005)
    sounding = struct.pack("<3i", round(at[0] * COMF), round(at[1] * COMF), 73)
    wreck = (south + 0.002, west + 0.003)
    about = struct.pack("<BIBB", 10, 1, 1, 5) + b"CELL.000" + UT + b"1" + UT + b"0" + UT
    about += b"2026010120260101" + b"03.1" + struct.pack("<B", 1) + UT + b"2.0" + UT
    about += struct.pack("<BH", 1, 1) + UT
    parameters = struct.pack("<BI3BI", 20, 1, horizontal, 23, 23, 12_000)
    parameters += struct.pack("<4B2I", units, 1, 1, 1, COMF, SOMF) + UT
    records: list[list[Field]] = [
        [("DSID", about), ("DSSI", struct.pack("<3B8I", 2, 1, 1, *[0] * 8))],
        [("DSPM", parameters)],
        _vector(NODE, 1, _places(wreck)),
        _vector(NODE, 2, ("SG3D", sounding)),
        _vector(JOINT, 1, _places((south, middle))),
        _vector(JOINT, 2, _places((north, middle))),
        _edge(1, 1, 2, (south + 0.005, middle)),
        _edge(2, 2, 1, (north, west), (south, west)),
        _edge(3, 2, 1, (north, east), (south, east)),
        _feature(1, "DEPARE", 3, [(EDGE, 1, 1), (EDGE, 2, 1)], DRVAL1=5, DRVAL2=12),
        _feature(2, "LNDARE", 3, [(EDGE, 1, 2), (EDGE, 3, 2)], OBJNAM="Cape"),
        _feature(3, "COALNE", 2, [(EDGE, 1, 1)]),
        _feature(4, "DEPCNT", 2, [(EDGE, 2, 1)], VALDCO=5),
        _feature(5, "SOUNDG", 1, [(NODE, 2, 255)]),
        _feature(6, "WRECKS", 1, [(NODE, 1, 255)], VALSOU=4.2),
    ]
    made = _definition()
    for number, fields in enumerate(records, 1):
        made += _record([("0001", struct.pack("<H", number)), *fields], b" D     " + b"   ")
    return made
