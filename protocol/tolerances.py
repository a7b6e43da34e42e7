"""The tolerances (T) of docs/protocol.md by name: what a decoder accepts beyond the N reading.

They come from the vehicle file and from ``--option NAME=VALUE``. Each codec reads those that
concern it. An unknown name or value raises UnknownTolerance before any byte is read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from protocol.checksum import SD_DEFAULT, SD_PROFILES


class UnknownTolerance(ValueError):
    """No such tolerance or value; the text lists those that exist."""


@dataclass(frozen=True, slots=True)
class Tolerance:
    """``values``: the first is the default; empty: any integer, default none."""

    name: str
    values: tuple[str, ...]
    meaning: str


_OFF, _ON = ("off", "on"), ("on", "off")
TOLERANCES = (
    Tolerance("order_aw", ("low", "high"), "byte order of the @AW counters: which byte is first"),
    Tolerance("aw_nested", _OFF, "payload of @AW as a whole frame: @AW....@ZAF5$$"),
    Tolerance("aw_zero_based", _OFF, "the current line of @AW counts from 0"),
    Tolerance("aw_decimal", _ON, "counters of @AW as two decimal digits each"),
    Tolerance("st_compact", _OFF, "time of @ST as 14 digits"),
    Tolerance("st_commas", _ON, "time of @ST as six numbers between commas"),
    Tolerance("ms_zero", _OFF, "speed and force 0 of @MS and @MP"),
    Tolerance("zaa_comma", _OFF, "comma between pitch and roll of @ZAA"),
    Tolerance("zah_gear", _OFF, "@ZAH with the gear behind the heading, as built: @ZAH-20,4$"),
    Tolerance("rs_yn", _OFF, "Y or N in the answer to @RS"),
    Tolerance("vs_no_vs", _OFF, "@VS without the letters VS"),
    Tolerance("vs_sep", _OFF, "a comma between @VS and the time"),
    Tolerance("vs_29", _OFF, "@VS with 29 fields: course to altitude are unknown"),
    Tolerance("vs_empty", _ON, "empty fields of @VS are unknown"),
    Tolerance("vs_speed", ("cm/s", "m/s", "km/h", "kn"), "unit of the ground speed in @VS"),
    Tolerance("vs_mag", ("nT", "uT"), "unit of the magnetometers in @VS"),
    Tolerance("order_modem", ("low", "high", "auto"), "byte order of the modem's length"),
    Tolerance("modem_crc", ("frame", "content"), "what the modem's CRC covers"),
    Tolerance("sd_crc", (SD_DEFAULT, *(p.name for p in SD_PROFILES[1:])), "CRC profile of @SD"),
    Tolerance("float_order", ("low", "high"), "byte order of floats (core board, ROV)"),
    Tolerance("place002", ("lat", "lon"), "core board: which of latitude and longitude is first"),
    Tolerance("leak002", ("1", "0"), "core board: the code of a leak in bytes 69 and 133"),
    Tolerance("leak23", ("0", "1"), "core board: the code of a leak in byte 23 of table 4-2"),
    Tolerance("tail002", ("table", "either"), "core board: FA AF and FD DF under every table"),
    Tolerance("effort003", ("1", "100"), "ROV: what X, Z and F are at full effort"),
    Tolerance("layout003", ("printed", "legacy"), "ROV: 71 and 30 bytes, or the older 50 and 28"),
    Tolerance("len003", ("strict", "loose"), "ROV: trust the length of the type, not DateLen"),
    Tolerance("mod", ("255", "256", "either"), "robot: modulus of the sum"),
    Tolerance("can_id", (), "the CAN identifier that is expected instead of the table's"),
)
_BY_NAME = {row.name: row for row in TOLERANCES}
_ALIASES = {
    **dict.fromkeys(("true", "yes", "1"), "on"),
    **dict.fromkeys(("false", "no", "0"), "off"),
    **dict.fromkeys(("le", "little", "lsb"), "low"),
    **dict.fromkeys(("be", "big", "msb"), "high"),
}


@dataclass(frozen=True, slots=True)
class Tolerances:
    """The tolerances that are set; all others have their default."""

    chosen: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def parse(cls, options: Mapping[str, str]) -> Tolerances:
        """Raises UnknownTolerance."""
        return cls({name: _value(name, str(value)) for name, value in options.items()})

    def __getitem__(self, name: str) -> str:
        values = _BY_NAME[name].values
        return self.chosen.get(name, values[0] if values else "")

    def on(self, name: str) -> bool:
        return self[name] == "on"


def _value(name: str, text: str) -> str:
    row = _BY_NAME.get(name)
    if row is None:
        raise UnknownTolerance(f"no tolerance {name!r}; there are: {', '.join(_BY_NAME)}")
    lowered = text.strip().lower()
    if text.strip() in row.values:
        return text.strip()
    if not row.values:
        try:
            int(lowered, 0)
        except ValueError:
            raise UnknownTolerance(f"{name}: an identifier is needed, not {text!r}") from None
        return lowered
    for candidate in (lowered, _ALIASES.get(lowered, "")):
        if candidate in row.values:
            return candidate
    raise UnknownTolerance(f"{name}: {text!r} is none of {', '.join(row.values)}")
