"""The fields of GGA, RMC and GLL: read strictly; GGA and RMC written for the simulated receiver.

pynmea2 supplies the field tables and renders the sentences; this module checks every value.
protocol.nmea frames the bytes and merges epochs.
"""

from __future__ import annotations

import enum
import math
import re
from datetime import date, datetime, timedelta
from typing import NamedTuple

import pynmea2

TALKERS = frozenset({"GP", "GN", "GL", "GB", "BD", "GA", "GQ", "QZ", "GI"})
# GGA quality -> share of UERE: autonomous, differential, PPS, RTK fixed, RTK float
QUALITY = {"1": 1.0, "2": 0.5, "3": 0.5, "4": 0.01, "5": 0.1}
NO_QUALITY = frozenset("0678")  # none, estimated, manual, simulator
MODES = frozenset("ADFPR")
NO_MODES = frozenset("EMNS")

KNOT = 1852.0 / 3600.0
WEEK_ROLLOVER = timedelta(weeks=1024)
_NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)", re.ASCII)
_TIME = re.compile(r"(?:[01]\d|2[0-3])[0-5]\d(?:60|[0-5]\d)(?:\.\d*)?", re.ASCII)
_LATITUDE = re.compile(r"(\d\d)([0-5]\d(?:\.\d*)?)", re.ASCII)
_LONGITUDE = re.compile(r"(\d\d\d)([0-5]\d(?:\.\d*)?)", re.ASCII)


class Refusal(enum.Enum):
    """Why a sentence, or a whole epoch, gave no Fix; the second text is the FrameFault's kind."""

    GARBAGE = "bytes outside sentences", "bad_header"
    CUT = "cut sentence", "truncated"
    OVERLONG = "over-long sentence", "bad_length"
    CHARACTER = "bytes no sentence holds", "bad_char"
    NO_CHECKSUM = "missing checksum", "bad_checksum"
    CHECKSUM = "wrong checksum", "bad_checksum"
    FIELD_COUNT = "wrong number of fields", "field_count"
    EMPTY = "needed field is empty", "empty_field"
    NUMBER = "not a number", "non_numeric"
    RANGE = "out of range", "out_of_range"
    LETTER = "unknown letter or code", "bad_enum"
    NULL_POSITION = "position is exactly 0, 0", "out_of_range"
    # well-formed, so no fault of the bytes:
    NO_FIX = "receiver says: no fix", ""
    CONTRADICTION = "GGA and RMC contradict each other", ""
    REPEATED = "time already given", ""
    TIME_BACK = "time runs back", ""

    @property
    def kind(self) -> str:
        return str(self.value[1])

    __hash__ = object.__hash__  # the hash of the name is slow, and thousands are counted


class Refused(Exception):
    def __init__(self, reason: Refusal) -> None:
        self.reason = reason


class Gga(NamedTuple):
    second: float  # of the day, UTC
    position: tuple[float, float] | None  # latitude, longitude, rad; None: no fix
    share: float = 1.0
    hdop: float | None = None
    elevation: float | None = None
    satellites: int | None = None


class Rmc(NamedTuple):
    second: float
    position: tuple[float, float] | None
    speed: float | None = None
    course: float | None = None
    utc: str | None = None


_G = pynmea2.GGA.name_to_idx
_R = pynmea2.RMC.name_to_idx
_GGA_TIME, _GGA_QUALITY = _G["timestamp"], _G["gps_qual"]
_GGA_FIELDS = {len(pynmea2.GGA.fields) + n for n in range(2)}  # SiRF adds one field
_RMC_FIELDS = {len(pynmea2.RMC.fields) - n for n in range(3)}  # before NMEA 2.3, 2.3, 4.1


def read_gga(fields: list[str]) -> Gga:
    if len(fields) not in _GGA_FIELDS:
        raise Refused(Refusal.FIELD_COUNT)
    second, quality = _second(fields[_GGA_TIME]), fields[_GGA_QUALITY]
    if quality in NO_QUALITY:
        return Gga(second, None)
    share = QUALITY.get(quality)
    if share is None:
        raise Refused(Refusal.LETTER if quality else Refusal.EMPTY)
    return Gga(
        second,
        _position(fields, _G["lat"]),
        share,
        _number(fields[_G["horizontal_dil"]], 0.0, 1000.0) or None,
        _number(fields[_G["altitude"]], -12000.0, 100000.0),
        _count(fields[_G["num_sats"]]),
    )


def read_rmc(fields: list[str], not_before: date | None) -> Rmc:
    if len(fields) not in _RMC_FIELDS:
        raise Refused(Refusal.FIELD_COUNT)
    second, status = _second(fields[_R["timestamp"]]), fields[_R["status"]]
    mode = fields[_R["mode_indicator"]] if len(fields) > _R["mode_indicator"] else ""
    if status == "V" or mode in NO_MODES:
        return Rmc(second, None)
    if status != "A" or (mode and mode not in MODES):
        raise Refused(Refusal.LETTER if status else Refusal.EMPTY)
    speed = _number(fields[_R["spd_over_grnd"]], 0.0, 2000.0)
    course = _number(fields[_R["true_course"]], 0.0, 360.0)
    return Rmc(
        second,
        _position(fields, _R["lat"]),
        None if speed is None else speed * KNOT,
        None if course is None else math.radians(course % 360.0),
        _utc(fields[_R["timestamp"]], fields[_R["datestamp"]], not_before),
    )


def read_gll(fields: list[str]) -> tuple[float, float] | None:
    """Return latitude and longitude, rad; None if the sentence marks them as invalid."""
    if len(fields) not in (6, 7):  # without and with a mode
        raise Refused(Refusal.FIELD_COUNT)
    if fields[5] == "V" or (len(fields) == 7 and fields[6] in NO_MODES):
        return None
    if fields[5] != "A":
        raise Refused(Refusal.LETTER)
    return _position(fields, 0)


def _second(text: str) -> float:
    """Return the second of the day; -1 if the receiver has no time yet, and so no fix either."""
    if not text:
        return -1.0
    if _TIME.fullmatch(text) is None:
        raise Refused(Refusal.RANGE if _NUMBER.fullmatch(text) else Refusal.NUMBER)
    return int(text[:2]) * 3600 + int(text[2:4]) * 60 + float(text[4:])


def _position(fields: list[str], at: int) -> tuple[float, float]:
    """Read latitude, its letter, longitude, its letter from index ``at``; return them in rad."""
    if not fields[0]:
        raise Refused(Refusal.EMPTY)  # a fix without a time
    latitude = _angle(fields[at], fields[at + 1], _LATITUDE, "NS", 90.0)
    longitude = _angle(fields[at + 2], fields[at + 3], _LONGITUDE, "EW", 180.0)
    if latitude == 0.0 and longitude == 0.0:
        raise Refused(Refusal.NULL_POSITION)
    return latitude, longitude


def _angle(text: str, letter: str, form: re.Pattern[str], letters: str, bound: float) -> float:
    if not text or not letter:
        raise Refused(Refusal.EMPTY)
    match = form.fullmatch(text)
    if match is None:
        raise Refused(Refusal.RANGE if _NUMBER.fullmatch(text) else Refusal.NUMBER)
    if letter not in letters:
        raise Refused(Refusal.LETTER)
    degrees = int(match[1]) + float(match[2]) / 60.0
    if degrees > bound:
        raise Refused(Refusal.RANGE)
    return math.radians(degrees if letter == letters[0] else -degrees)


def _number(text: str, least: float, most: float) -> float | None:
    if not text:
        return None
    if _NUMBER.fullmatch(text) is None:
        raise Refused(Refusal.NUMBER)
    value = float(text)
    if not least <= value <= most:
        raise Refused(Refusal.RANGE)
    return value


def _count(text: str) -> int | None:
    if not text:
        return None
    if not (text.isascii() and text.isdigit()):
        raise Refused(Refusal.NUMBER)
    return int(text)


def _utc(clock: str, ddmmyy: str, not_before: date | None) -> str | None:
    if not ddmmyy:
        return None
    if len(ddmmyy) != 6 or _count(ddmmyy) is None:
        raise Refused(Refusal.NUMBER)
    year = int(ddmmyy[4:])
    try:
        day = date(year + (1900 if year >= 80 else 2000), int(ddmmyy[2:4]), int(ddmmyy[:2]))
    except ValueError:
        raise Refused(Refusal.RANGE) from None
    while not_before is not None and day < not_before:
        day += WEEK_ROLLOVER
    return f"{day.isoformat()}T{clock[:2]}:{clock[2:4]}:{clock[4:6]}"


# --- encoding, for the simulated receiver ---


def encode_gga(
    utc: datetime,
    latitude: float | None,  # rad; None: no fix, quality 0
    longitude: float | None,
    *,
    quality: int = 1,
    satellites: int = 9,
    hdop: float = 1.0,
    elevation: float = 0.0,
    talker: str = "GP",
) -> bytes:
    if latitude is None or longitude is None:
        state = ("0", "00", "", "")
    else:
        state = (str(quality), f"{satellites:02d}", f"{hdop:.1f}", f"{elevation:.1f}")
    angles = _angles(latitude, longitude)
    fields = (_clock(utc), *angles, *state, "M", "0.0", "M", "", "")
    return _line(pynmea2.GGA(talker, "GGA", fields))


def encode_rmc(
    utc: datetime,
    latitude: float | None,
    longitude: float | None,
    *,
    speed: float | None = 0.0,  # m/s
    course: float | None = None,  # rad
    talker: str = "GP",
) -> bytes:
    status, mode = ("V", "N") if latitude is None or longitude is None else ("A", "A")
    knots = "" if speed is None else f"{speed / KNOT:.3f}"
    degrees = "" if course is None else f"{math.degrees(course) % 360.0:.2f}"
    day = utc.strftime("%d%m%y")
    fields = (_clock(utc), status, *_angles(latitude, longitude), knots, degrees, day, "", "", mode)
    return _line(pynmea2.RMC(talker, "RMC", fields))


def _line(sentence: pynmea2.NMEASentence) -> bytes:
    return bytes(sentence.render(newline=True), "ascii")


def _clock(utc: datetime) -> str:
    return f"{utc:%H%M%S}.{utc.microsecond // 10000:02d}"


def _angles(latitude: float | None, longitude: float | None) -> tuple[str, str, str, str]:
    """Write degrees and minutes to 0.000001 minute (2 mm); minutes never round to 60."""
    if latitude is None or longitude is None:
        return "", "", "", ""
    south, west = latitude < 0.0, longitude < 0.0
    lat, lon = (round(abs(math.degrees(x)) * 60e6) for x in (latitude, longitude))
    return (
        f"{lat // 60_000_000:02d}{lat % 60_000_000 / 1e6:09.6f}",
        "S" if south else "N",
        f"{lon // 60_000_000:03d}{lon % 60_000_000 / 1e6:09.6f}",
        "W" if west else "E",
    )
