"""The table of ``@VS``, the Pi's status report to topside (document 000, table 2.1.2).

    @VS time,longitude,latitude,...,servo 2 $      30 fields

Numbers are ``-?digits[.digits]``, longitude and latitude with 7 decimals. A number out of range is
kept and named in ``flags``. The example of the document has 29 fields and no ``VS`` (E-S1).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from protocol import clocktime
from protocol.codec import CannotEncode
from protocol.fields import FaultKind, FrameType, Values, required
from protocol.text import Refused, format_decimal, parse_decimal, text_length
from protocol.tolerances import Tolerances
from protocol.topside_frames import LONG


@dataclass(frozen=True, slots=True)
class Item:
    """One field; ``places``: decimals that are always written (None: as many as needed)."""

    name: str
    low: float = -math.inf
    high: float = math.inf
    places: int | None = None


TABLE = (
    Item("time"),
    Item("lon_deg", -180, 180, 7),
    Item("lat_deg", -90, 90, 7),
    Item("elevation_m"),
    Item("ground_speed", 0),  # cm/s (E-V18)
    Item("ground_course_deg", 0, 360),
    Item("heading_deg", -180, 180),  # the yaw of @SD (E-V10)
    Item("pitch_deg", -180, 180),
    Item("roll_deg", -90, 90),
    Item("temperature_c"),
    Item("depth_m"),
    Item("altitude_m"),
    Item("battery_control"),  # V (E-V17)
    Item("battery_power"),
    *(
        Item(f"mag_{place}_{axis}", -100_000, 100_000)  # nT (E-V16)
        for place in ("front", "left", "right")
        for axis in "xyz"
    ),
    *(
        Item(f"pwm_{place}", 0, 65535)
        for place in (
            *("left_main", "right_main", "rear_vert", "left_vert", "right_vert"),
            *("servo_left", "servo_right"),
        )
    ),
)
NAMES = tuple(item.name for item in TABLE)
_UNTOLD = slice(5, 12)  # course to altitude: the 29-field form lacks one of these


class StatusFrame(FrameType):
    name, title, lead = "auv.VS", "000 table 2.1.2", b"@VS"

    def __init__(self, tolerances: Tolerances, *, bare: bool = False) -> None:
        """``bare``: the form without the letters VS (tolerance vs_no_vs)."""
        self._empty, self._short = tolerances.on("vs_empty"), tolerances.on("vs_29")
        self._separated = tolerances.on("vs_sep")
        if bare:
            self.lead = b"@2"  # the first digit of the year: no other frame of this link begins so
        self._skip = 1 if bare else 3

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        return text_length(data, at, at + len(self.lead), end, LONG)

    def check(self, raw: bytes) -> FaultKind | None:
        try:
            self.decode(raw)
        except Refused as refusal:
            return refusal.kind
        return None

    def decode(self, raw: bytes) -> Values:
        parts = raw[self._skip : -1].decode("ascii").split(",")
        if self._separated and not parts[0]:
            del parts[0]
        unknown: tuple[str, ...] = ()
        if self._short and len(parts) == len(TABLE) - 1:
            parts[_UNTOLD.start : _UNTOLD.stop - 1] = [""] * 7
            unknown = NAMES[_UNTOLD]
        if len(parts) != len(TABLE):
            raise Refused(FaultKind.FIELD_COUNT)
        values: Values = {}
        flags: list[str] = []
        for item, text in zip(TABLE, parts, strict=True):
            known = item.name not in unknown
            values[item.name], doubt = self._read(item, text) if known else (None, "unknown")
            if doubt:
                flags.append(f"{item.name}:{doubt}")
        values["flags"] = flags
        return values

    def _read(self, item: Item, text: str) -> tuple[Any, str]:
        if not text:
            if not self._empty:
                raise Refused(FaultKind.EMPTY_FIELD)
            return None, "empty"
        if item.name == "time":
            clock = clocktime.split(text, clocktime.DASHES)
            return clocktime.iso(clock), "" if clocktime.real(clock) else "out_of_range"
        value = parse_decimal(text)
        return value, "" if item.low <= value <= item.high else "out_of_range"

    def encode(self, values: Mapping[str, Any]) -> bytes:
        texts = [self._text(item, required(values, item.name, self.name)) for item in TABLE]
        return b"@VS" + ",".join(texts).encode("ascii") + b"$"

    def _text(self, item: Item, value: Any) -> str:
        if value is None:
            return ""
        if item.name == "time":
            year, month, day, *clock = clocktime.encodable({"time": value}, self.name)
            hour, minute, second = clock
            return f"{year:04}-{month:02}-{day:02}-{hour:02}:{minute:02}:{second:02}"
        text = format_decimal(item.name, value, item.places)
        if not item.low <= value <= item.high:
            raise CannotEncode(f"{item.name}: {value} is outside {item.low}..{item.high}")
        return text
