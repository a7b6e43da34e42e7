"""One good frame of every type under the normative readings, for the reference and for tests.

The bytes are those that the documents print; where a document is wrong, they are computed.
"""

from __future__ import annotations

from dataclasses import dataclass

from protocol.operator_words import WORDS
from protocol.tables import derived
from protocol.vehicles import VEHICLES

_ANGLES = "A8 02 93 C1 81 24 6E 41 DC 0D 18 C2"
_PLACE = "AD 6C 1F F2 96 49 3E 40 C9 3B 87 32 D4 09 5E 40"
_PHASES = "00 7D FF 83 00 01 FF FF 07 07 F8 F8"

SD = bytes.fromhex(f"40 53 44 {'00' * 60} {'DC 05' * 7} 0C 00 30 00 F0 5C 93 75 24")
VS = (
    b"@VS2025-01-19-23:26:25,120.1535765,30.2874595,20,100,0,0,0,0,0,0,0,36,360,"
    + b"53191," * 9
    + b",".join([b"1200"] * 7)
    + b"$"
)
MAIN_TO_PC = bytes.fromhex(
    f"FE EF {_ANGLES} {_PLACE} 00 00 48 41 00 00 50 C0 00 00 20 41 00 00 20 40 00 00 F8 40"
    f"{'00' * 12} 01 0E D8 04 D2 12 B6 00 {_PHASES} 01 00 00 00 00 E5 FA AF"
)
PC_TO_MAIN = bytes.fromhex(
    f"FE EF {_PLACE} 00 00 A0 40 00 00 A0 C0 00 00 28 41 00 00 B4 42 01 96 32 64 64 64 6E"
    "01 01 01 01 00 1E FD 01 02 03 04 05 06 07 08 09 0A 0B 4B FA AF"
)
MAIN_TO_SENSOR = bytes.fromhex(f"FE EF 00 01 {'00' * 30} 10 FD DF")
SENSOR_TO_MAIN = bytes.fromhex(
    f"FE EF 0E D8 00 01 00 02 00 03 FF FF 00 00 00 00 48 41 00 00 00 00 00 01 {_ANGLES}"
    "94 48 9C 3E 1B 31 D6 3D 2F 65 A1 3C 00 00 00 3F 00 00 E0 3F 00 00 40 40"
    "00 00 88 40 00 00 B0 40 00 00 D8 40 00 00 00 41 00 00 14 41 00 00 28 41"
    f"{_PLACE} 00 00 00 3F 00 00 C0 3F 00 00 20 40 00 00 60 40 00 00 90 40 00 00 B0 40"
    "00 00 00 0E D8 04 D2 12 B6 00 00 0F FF F1 00 00 03 84 FC 7C 00 01 01 01 02 03 04 1F F3 FA AF"
)
ROV_UP = bytes.fromhex(
    "55 AA 01 40 01 01 00 8E AC DA BB 6D C6 E2 3D 6B 41 7B BF 70 30 BB BB B4 61 07 BC 40 93 68 BA"
    f"E8 44 CE C0 B4 4E A9 BE 12 9A 95 3C 56 55 D5 40 {'00' * 21} 4C 0D 0A"
)
ROV_DOWN = bytes.fromhex(f"55 AA 11 17 01 01 {'00' * 21} 02 0D 0A")


@dataclass(frozen=True, slots=True)
class Example:
    type: str
    raw: bytes


_ROWS: tuple[tuple[str, bytes], ...] = (
    ("auv.AR", b"@AR,staging,9,5,3-5.9,0123456789abcdef,line 3: no bound,$"),
    ("auv.AES", b"@AE,1,AU,Y,1,423,38,-120,45,7,860,31,1.9,0,F50%H90S3,row,$"),
    ("auv.RS", b"@RSCOOCCCO$"),
    ("auv.RI", b"@RI$"),
    ("auv.MT", b"@MT1,-10$"),
    ("auv.MD", b"@MDA2,-2$"),
    ("auv.D", b"@DA2,-2$"),
    ("auv.MM", b"@MMF12$"),
    ("auv.MR", b"@MRL5$"),
    ("auv.MS", b"@MS120,-90$"),
    ("auv.MP", b"@MP120,-90$"),
    ("auv.ACK", b"@ACK_NSS$"),
    ("auv.ACK", b"@ACK_NI1$"),  # Pi, CAMERA, AUTO
    ("auv.ACK", b"@ACK_RIQ$"),  # CTD, radio, light
    ("auv.ACK", b"@ACK_ZFY$"),
    ("auv.VS", VS),
    ("auv.ZA", b"@ZAF5$"),
    ("auv.ZA", b"@ZAS30$"),
    ("auv.ZA", b"@ZAX0$"),
    ("auv.SD", SD),
    ("auv.MODEM", bytes.fromhex("23 02 04 00 01 40 44 55 24 14 86")),
    ("coreboard.MAIN_TO_PC", MAIN_TO_PC),
    ("coreboard.PC_TO_MAIN", PC_TO_MAIN),
    ("coreboard.MAIN_TO_SENSOR", MAIN_TO_SENSOR),
    ("coreboard.SENSOR_TO_MAIN", SENSOR_TO_MAIN),
    ("coreboard.CAN_FORCE", bytes.fromhex("FF 00 10 00 20 00 30")),
    ("coreboard.CAN_TORQUE", bytes.fromhex("FE 00 10 00 20 00 30")),
    ("rov.UP", ROV_UP),
    ("rov.DOWN", ROV_DOWN),
    ("robot.DOWN", bytes.fromhex("AA 01 00 00 00 00 00 00 00 00 AB DD")),
    ("robot.DOWN", bytes.fromhex("AA 02 00 00 00 00 00 00 00 00 AC DD")),
    ("robot.DOWN", bytes.fromhex("AA 04 00 00 00 00 00 00 00 00 AE DD")),
    ("robot.UP", bytes.fromhex("AA 00 00 00 00 AA DD")),
)


@derived(WORDS, VEHICLES)
def examples() -> tuple[Example, ...]:
    words = (Example(word.name, raw) for word in WORDS.values() for raw in word.examples)
    boards = (row for vehicle in VEHICLES.values() for row in vehicle.examples)
    return (*words, *(Example(*row) for row in (*_ROWS, *boards)))
