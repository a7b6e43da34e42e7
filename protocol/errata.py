"""Contradictions and gaps in the four documents, and the reading that the code implements.

protocol.reference prints this table; frame tables cite its rows in comments. ``tolerance``: names
of the tolerances (protocol.tolerances) and keys (protocol.vehicles.keys) that change the reading.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Erratum:
    """``frames``: names of types, or a vehicle's name for all of its frames."""

    name: str
    frames: tuple[str, ...]
    finding: str
    reading: str
    tolerance: str = ""


_ACK, _SD, _VS, _ZA, _AW = "auv.ACK", "auv.SD", "auv.VS", "auv.ZA", "auv.AW"
_MODEM, _STICKS = "auv.MODEM", ("auv.MS", "auv.MP")
_UP, _PC = "coreboard.MAIN_TO_PC", "coreboard.PC_TO_MAIN"
_SENSOR, _SWITCHES = "coreboard.SENSOR_TO_MAIN", "coreboard.MAIN_TO_SENSOR"
_CAN = ("coreboard.CAN_FORCE", "coreboard.CAN_TORQUE")
_ROV = ("rov.UP", "rov.DOWN")

# fmt: off
ERRATA = (
    Erratum("E-F1", ("auv",), "the tail is printed with a backslash before the dollar sign",
            "one byte, 24"),
    Erratum("E-F2", (_AW, _ACK, _SD, _MODEM), "binary bytes may be 24 or 40 themselves",
            "frames with binary bytes are delimited by length, text frames by the first $"),
    Erratum("E-F3", (_AW,), "byte order and first number of the counters are not given",
            "low byte first; 1 <= current <= total <= 9999, so a line cut inside its counters "
            "is always refused", "order_aw, aw_zero_based, aw_decimal"),
    Erratum("E-F4", ("auv.AA", "auv.AC", "auv.DU"), "columns for lines are printed, and empty",
            "absent: four bytes exactly"),
    Erratum("E-F5", ("auv.AC", "auv.DU", "auv.D", "auv.ST", "auv.SP", _SD, _ACK),
            "several types share their first letters", "third and fourth byte and the link decide"),
    Erratum("E-F6", ("auv",), "text frames have no checksum, M and D no answer",
            "strict grammar: integers -?[0-9]{1,5}, no blanks, no plus, bounded length"),
    Erratum("E-F7", (_AW,), "a whole @ZA frame as payload would end the frame around it",
            "the word without @ and $, printable ASCII, 1 to 200 bytes", "aw_nested"),
    Erratum("E-T1", ("auv.RS", "auv.RI", _ZA), "sender and receiver are mixed up in three headings",
            "topside, Pi, serial line, STM32, and back; the Pi relays R and its answer unchanged"),
    Erratum("E-T2", ("auv.NS", "auv.RS"), "the examples close what is said to be always on",
            "those letters are ignored; a mask that denies it is flagged"),
    Erratum("E-T3", (_ACK,), "the bit order of the node mask is not given",
            "as for the sensors: the first letter is bit 0"),
    Erratum("E-T4", (_ACK,), "a column Y/N stands beside the answer S to @RS", "S", "rs_yn"),
    Erratum("E-T5", (_ACK,), "whether a line or the file is acknowledged is not said",
            "each line; the one that completes the set only when all of it is stored"),
    Erratum("E-T6", (_SD,), "'normal case' is said, and no other follows", "the same frame always"),
    Erratum("E-V1", ("auv.ST",), "'14 characters' for an example of 19",
            "the 19 characters of the example", "st_compact, st_commas"),
    Erratum("E-V2", ("auv.SP",), "what radius, minutes, depth and voltage mean is not said",
            "from home; longest autonomous run; greatest depth; control battery; four items"),
    Erratum("E-V3", ("auv.MD", "auv.D"), "two places for the comma", "behind the servo number"),
    Erratum("E-V4", ("auv.MT", _SD, _VS), "thrusters are numbered otherwise than the PWM list",
            "@MT 1 2 3 4 5 are list places 0 1 3 4 2"),
    Erratum("E-V5", ("auv.MT", "auv.MM", "auv.MR", _ZA, *_STICKS), "five scales for effort",
            "as printed: -12..12, 0..12, 0..5, 0..12, 1..120; full speed is reached at 10"),
    Erratum("E-V6", ("auv.MR",), "B and F elsewhere mean back and forward",
            "here B is nose down, F nose up, U and D lean left and right"),
    Erratum("E-V7", ("auv.MR", _SD), "a lean to the left 'counter-clockwise from the bow' is none",
            "left lean: left side down, negative roll"),
    Erratum("E-V8", (_SD, _VS, _ZA), "roll, pitch and yaw are no right-handed triple",
            "yaw counts to port: heading = -yaw"),
    Erratum("E-V9", (_SD, _VS), "the ranges of roll and pitch look exchanged",
            "outside is flagged, never refused"),
    Erratum("E-V10", (_VS,), "the heading has no convention", "the yaw of @SD, passed through"),
    Erratum("E-V11", (_SD, _VS, _ZA), "angles and batteries stand in different orders",
            "as each table prints"),
    Erratum("E-V12", _STICKS, "an angle that is 0 in the east",
            "the stick's frame: yaw = angle - 90"),
    Erratum("E-V13", _STICKS, "no value for a released stick", "1..120; stop with @MMF0$",
            "ms_zero"),
    Erratum("E-V14", (_ZA,), "a semicolon between pitch and roll", "semicolon", "zaa_comma"),
    Erratum("E-V15", (_ZA,), "X takes 0, W takes F", "these characters and nothing else"),
    Erratum("E-V16", (_SD, _VS), "uT up to 100 in one table, 53191 in the other's example",
            "uT in @SD, nT in @VS", "vs_mag"),
    Erratum("E-V17", (_SD, _VS, "auv.SP"), "battery counts without a unit; no common factor fits",
            "1 count = 1 V in @SD, volts in @VS; the vehicle file has a factor for each"),
    Erratum("E-V18", (_VS,), "a ground speed of 100 without a unit", "cm/s",
            "vs_speed"),
    Erratum("E-V19", (_SD,), "the file that defines the CRC is missing",
            "the 78 data bytes and two zeros as 20 little-endian words, polynomial 04C11DB7, from "
            "FFFFFFFF, not reflected, not inverted; sent low byte first", "sd_crc"),
    Erratum("E-V20", (_SD,), "the byte order of floats is not given", "low byte first"),
    Erratum("E-S1", (_VS,), "the example has no letters VS, and 29 fields for a table of 30",
            "the table, the time directly behind @VS", "vs_no_vs, vs_sep, vs_29, vs_empty"),
    Erratum("E-M1", (_MODEM,), "byte order of the length is not given", "low byte first",
            "order_modem"),
    Erratum("E-M2", (_MODEM,), "what the CRC covers is not given", "all before it", "modem_crc"),
    Erratum("E-M3", (_MODEM,), "the address is called destination, against the headings",
            "1: from the topside host; 2: from the vehicle host"),
    Erratum("E-M4", (_MODEM,), "the content would include the Pi's words to the STM32",
            "chapter 1 down, chapter 2.1 up"),
    Erratum("E-B1", (_UP, _PC, _SENSOR), "'float, high byte first' gives 1e-15 for the samples",
            "floats and doubles low byte first", "float_order"),
    Erratum("E-B1a", (_SENSOR,), "the printed decimal is not that of the printed bytes",
            "the bytes: -18.376297"),
    Erratum("E-B2", (_UP, _SENSOR), "16-bit integers 'from right to left' contradict their value",
            "high byte first; temperature and phases signed"),
    Erratum("E-B3", (_PC, _SWITCHES), "an example of 8 bytes under tables of 62 and 37",
            "ignored: it belongs to no table"),
    Erratum("E-B3a", (_UP, _PC, _SWITCHES, _SENSOR), "printed checksums are copies",
            "XOR of all bytes before it, header included"),
    Erratum("E-B3b", (_UP, _PC, _SWITCHES, _SENSOR), "two tails", "as each table prints",
            "tail002"),
    Erratum("E-B4", (_SENSOR,), "the example is an older layout that passes every check",
            "the table; the older layout shows in the flags, its depth and heading are doubtful"),
    Erratum("E-B5", (_UP, _SENSOR), "leak: 1 is a leak in the tables, 0 in the text",
            "the tables; byte 23 keeps the text's sense and is only compared", "leak002, leak23"),
    Erratum("E-B6", (_UP, _PC, _SENSOR), "X, Y in two tables, latitude, longitude in the text",
            "latitude first; a first value beyond 90 is flagged", "place002"),
    Erratum("E-B6a", (_PC,), "metres and degrees for the same field",
            "degrees; metres stand in x and y"),
    Erratum("E-B7", (_UP,), "'longitude already converted by the latitude'",
            "a true longitude: not scaled again"),
    Erratum("E-B8", (_PC,), "a float in one byte", "signed byte, 1 degree",
            "angle_error_step"),
    Erratum("E-B9", (_PC,), "all zeros are full reverse on six axes",
            "neutral is 100; more than 200 is refused"),
    Erratum("E-B10", (_PC,), "'30' may be hexadecimal", "the byte is kHz"),
    Erratum("E-B11", (_UP, _PC), "codes of the modes are missing", "0 ROV, 1 DPROV"),
    Erratum("E-B12", (_SENSOR,), "the text has two axes where the table has three", "the table"),
    Erratum("E-B13", (_SWITCHES,), "four bytes, one LED", "four LEDs, 0..100 % each"),
    Erratum("E-B14", _CAN, "'broadcast' and 'to the left board'; no sign, 1 N m steps",
            "broadcast, signed, as printed", "can_id, torque_step"),
    Erratum("E-B15", ("coreboard",), "network port and CAN bit rate are missing",
            "configurable; 500 kbit/s", "baud"),
    Erratum("E-R1", _ROV, "DateLen in the examples is that of older layouts",
            "Command and Date; whole frame = DateLen + 7", "len003, layout003"),
    Erratum("E-R2", ("rov.UP",), "three lines of the examples lost a byte", "71 bytes"),
    Erratum("E-R3", _ROV, "one line of an example is high byte first", "low byte first",
            "float_order"),
    Erratum("E-R4", ("rov.UP",), "the second example's checksum is a copy", "the rule"),
    Erratum("E-R5", _ROV, "two minimum lengths", "none beyond function and reserved byte"),
    Erratum("E-R6", _ROV, "addresses are spoken of, and there are none", "types 01 and 11 only"),
    Erratum("E-R7", _ROV, "'hold tail', 'rad/m', up and down exchanged",
            "hold depth, r/min, names by the sender"),
    Erratum("E-R8", ("rov.DOWN",), "X, Z and F have no unit", "-1..1 of full effort",
            "effort003"),
    Erratum("E-P1", ("robot.DOWN",), "the example's checksum is that of an older frame", "AC"),
    Erratum("E-P2", ("robot",), "mod 255: a byte changed between 00 and FF is not seen",
            "mod 255 all the same; stop and handshake share their checksum", "mod"),
    Erratum("E-P3", ("robot.DOWN",), "length 0 although six user bytes follow",
            "number of meaningful bytes, refused below those of the value; the frame has 12"),
    Erratum("E-P4", ("robot.DOWN",), "1080.000 in six bytes", "u32 thousandths"),
    Erratum("E-P5", ("robot",), "speed, angles, current and voltage have no unit",
            "low byte first; mm/s, 0.01 deg, A, mV", "full_speed, speed_step"),
    Erratum("E-P6", ("robot.UP",), "the algorithm of the check byte is missing",
            "sum of bytes 0..4 mod 255"),
    Erratum("E-P7", ("robot.DOWN",), "some lines to the power module lack their line end",
            "every line ends with CR LF; +value, and of MODE +OVERV, +UNDERV, +OVERC, ..."),
    Erratum("E-P8", ("robot",), "answers of power module and handshake have no frame",
            "they cannot be read back; the handshake is answered by an ordinary report"),
    Erratum("E-P9", ("robot",), "AA and DD occur inside, and begin both directions",
            "direction by the link, length 12 or 7"),
)
# fmt: on


def errata_of(frame: str) -> tuple[Erratum, ...]:
    """Return the rows that concern a frame type, by its name or its vehicle's."""
    vehicle = frame.partition(".")[0]
    return tuple(row for row in ERRATA if frame in row.frames or vehicle in row.frames)
